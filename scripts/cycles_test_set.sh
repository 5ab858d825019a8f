#!/usr/bin/env bash
# Makes the Cycles test set: 18 frames of 9 scenes, rendered by Blender, none for training (docs/cycles_test_set.md):
#   scripts/cycles_test_set.sh OUT [options of scripts/peers/cycles_test_set.py]
# Finished frames and renders are kept, so it may be stopped and started again. It takes an hour and a half of one processor.
# Installs what it needs on first use: scripts/peers/setup.sh, and meshes from PyPI's pybullet (100 MB, of which 2 MB are kept).
# Needs ld_import, ld_eval and ld_inspect in build/bin (README.md).
set -euo pipefail
[ $# -gt 0 ] || { echo "usage: cycles_test_set.sh OUT [options of scripts/peers/cycles_test_set.py]" >&2; exit 2; }
out=$(realpath -m -- "$1")
shift
cd "$(dirname "$0")/.."
for program in ld_import ld_eval ld_inspect; do
  [ -x build/bin/$program ] || { echo "cycles_test_set.sh: found no build/bin/$program; build it first (README.md)" >&2; exit 1; }
done
scripts/peers/setup.sh
python=out/peers/venv/bin/python
meshes=out/peers/pybullet_data

if [ ! -d $meshes ]; then
  work=$(mktemp -d)
  trap 'rm -rf "$work"' EXIT
  $python -m pip download --quiet --disable-pip-version-check --no-deps --only-binary :all: --dest "$work" pybullet==3.2.7
  $python - "$work" "$work/meshes" <<'END'
import sys, zipfile
from pathlib import Path
wheel, out = next(Path(sys.argv[1]).glob("*.whl")), Path(sys.argv[2])
with zipfile.ZipFile(wheel) as archive:
    for name in ("duck.obj", "duckCM.png", "teddy2_VHACD_CHs.obj", "objects/mug.obj", "soccerball.obj", "bunny.obj", "lego/lego.obj",
                 "domino/domino.obj", "domino/domino.jpg", "domino/license.txt"):
        (out / name).parent.mkdir(parents=True, exist_ok=True)
        (out / name).write_bytes(archive.read(f"pybullet_data/{name}"))
END
  mv "$work/meshes" $meshes
fi

$python scripts/peers/cycles_test_set.py --out "$out" --meshes $meshes "$@"
if [[ " $* " != *" --preview "* ]]; then
  $python scripts/peers/reference_floor.py --data "$out" --out "$out.floor"
  build/bin/ld_inspect "$out" --verify
fi

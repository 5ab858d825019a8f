#!/usr/bin/env bash
# Runs what works with other renderers, small: data sets by Blender Cycles and by Mitsuba 3, trained on and evaluated, and the
# comparison of renderers at a low resolution. Installs them on first use (scripts/peers/setup.sh: 1.2 GB from PyPI and, where they are
# missing, Debian's python3-venv and libraries). scripts/test.sh does not need any of this. Everything lands in out/peers/test/.
set -euo pipefail
cd "$(dirname "$0")/.."
scripts/peers/setup.sh
export OMP_WAIT_POLICY=passive
python=out/peers/venv/bin/python
out=out/peers/test
rm -rf $out
mkdir -p $out
SECONDS=0
step() { printf '\n== %s (%d min %02d s since the start)\n' "$1" $((SECONDS / 60)) $((SECONDS % 60)); }
small=(--width 96 --height 96 --spp 4 --reference-spp 128 --train 40)

# The table must hold the trained model beside the noisy input, all finite.
check() {
  "$python" - "$1" <<'END'
import json, math, sys
folder = sys.argv[1]
manifest = json.load(open(f"{folder}/manifest.json"))
splits = {frame["split"] for frame in manifest["frames"]}
assert splits == {"train", "validation", "test"}, splits
text = open(f"{folder}.eval/metrics.csv").read()
print(text)
assert "quick" in text and "noisy" in text and "nan" not in text.lower(), "the table lacks a row or has NaN"
END
}

step "1/3 Blender Cycles: a .blend file to a data set, training, evaluation"
"$python" scripts/peers/blender_dataset.py --out $out/blender --frames 4 "${small[@]}"
check $out/blender

step "2/3 Mitsuba 3: a scene to a data set, training, evaluation"
"$python" scripts/peers/mitsuba_dataset.py --out $out/mitsuba --views 4 "${small[@]}"
check $out/mitsuba

step "3/3 The renderers compared: small and noisy, so only a gross difference shows"
"$python" scripts/peers/compare_renderers.py --out $out/compare --size 48 --spp 256 --limit 5
step "Done: both data sets and both comparisons passed"

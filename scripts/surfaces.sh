#!/usr/bin/env bash
# What a network does to surfaces that are hard for demodulation: a lamp seen directly, pixels that are half lamp and half wall, a mirror, a
# rough metal, fine textures, a surface that reflects nothing and one that reflects all (scripts/surfaces.py):
#
#   scripts/surfaces.sh OUT [NAME=MODEL...]
#
# OUT receives the scene, a frame of it with 8 samples a pixel, and eval/ with the table and the strip. Default: the released weights.
set -euo pipefail
cd "$(dirname "$0")/.."
if [ $# -lt 1 ]; then
  echo "usage: scripts/surfaces.sh OUT [NAME=MODEL...]" >&2
  exit 2
fi
out=$1 bin=${BIN:-build/bin} models=()
shift
if [ $# -eq 0 ]; then
  for name in common_fast common_fine means; do set -- "$@" "$name=models/pretrained/$name.safetensors"; done
fi
for model in "$@"; do models+=(--model "$model"); done
python3 scripts/surfaces.py "$out"
"$bin/ld_render" --scene "$out/surfaces.gltf" --out "$out/data" "resolution=[160, 160]" spp=8 reference_spp.test=1024 \
  "frames={train: 0, validation: 0, test: 1}" reference_estimator=robust reference_parts=16
"$bin/ld_eval" --data "$out/data" --split test "${models[@]}" --out "$out/eval"

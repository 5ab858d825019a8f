#!/usr/bin/env bash
# An animation of Blender Cycles, imported and denoised by EAW, SVGF, released weights frame by frame and those that remember, and Open Image
# Denoise where scripts/peers/setup.sh has installed it, with a page to look at:
#   scripts/peers/cycles_sequence.sh [OUT [FRAMES [SAMPLES [WIDTH [HEIGHT [REFERENCE]]]]]]
# (default: out/cycles_sequence, 16 frames of 160x90, 2 samples a pixel, references of 128). Needs `blender` in PATH (Debian's package or
# another) and the programs in build/bin/. Renders that are there are kept: remove OUT to render anew.
set -euo pipefail
cd "$(dirname "$0")/../.."
out=${1:-out/cycles_sequence}
[ $# -eq 0 ] || shift
command -v blender >/dev/null || { echo "cycles_sequence.sh: found no blender; apt-get install blender" >&2; exit 1; }
mkdir -p "$out"
if [ ! -e "$out/renders/mapping.txt" ]; then
  blender -b -P scripts/peers/cycles_sequence.py -- "$out/renders" "$@" > "$out/blender.log" 2>&1 ||
    { tail -n 12 "$out/blender.log" >&2; exit 1; }
fi
set=()
while read -r assignment; do set+=(--set "$assignment"); done < "$out/renders/mapping.txt"
for folder in "$out"/renders/[0-9]*; do
  name=$(basename "$folder")
  build/bin/ld_import --preset cycles "${set[@]}" --camera "$folder/camera.yaml" --reference "$folder/reference.exr" --out "$out/data" \
    --name "frame_$name" --split test --sequence 0 --position $((10#$name)) "$folder"/sample_*.exr > "$out/import.log" 2>&1 ||
    { cat "$out/import.log" >&2; exit 1; }
done
others=()
if out/peers/venv/bin/python -c 'import pyoidn' 2> /dev/null; then
  out/peers/venv/bin/python scripts/peers/oidn_denoise.py --data "$out/data" --out "$out/oidn" > "$out/oidn.log"
  others=(--images oidn="$out/oidn")
fi
build/bin/ld_eval --data "$out/data" --sequences --filter eaw --filter svgf --model common_fast=common_fast --model history_fast=history_fast \
  "${others[@]}" --report-sequences 1 --report-frames 4 --out "$out/eval"

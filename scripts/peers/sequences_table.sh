#!/usr/bin/env bash
# EAW and SVGF beside networks that see one frame at a time: ours, Open Image Denoise, and Open Image Denoise behind SVGF's temporal
# accumulation, which is how it is used for films today. One table: errors, steadiness and times, with intervals over sequences.
#   scripts/peers/sequences_table.sh [OUT [SAMPLES]]     (default: out/sequences_table, 1 sample a pixel)
# Renders the test split of data/recipes/sequence_quick.yaml (minutes; OUT/data may hold it already). Needs the programs in build/bin/ and
# out/peers/venv (scripts/peers/setup.sh).
set -euo pipefail
cd "$(dirname "$0")/../.."
out=${1:-out/sequences_table} samples=${2:-1}
python=out/peers/venv/bin/python
[ -x "$python" ] || { echo "sequences_table.sh: found no $python; scripts/peers/setup.sh makes it" >&2; exit 1; }
mkdir -p "$out/accumulated"
build/bin/ld_render --recipe data/recipes/sequence_quick.yaml --frames 108:216 --out "$out/data" reference_spp.test=48

# The accumulated light is that of each sequence and noise instance by itself.
for instance in "" _n1; do
  for ((first = 108; first < 216; first += 12)); do
    build/bin/ld_denoise --filter svgf --set svgf.levels=0 --set svgf.feedback=-1 --set svgf.antialias=1 --samples "$samples" --float \
      "$out/data/frame_######$instance.exr" --frames $first:$((first + 12)) --output "$out/accumulated/frame_######$instance.exr" \
      > "$out/accumulate.log" 2>&1 || { cat "$out/accumulate.log" >&2; exit 1; }
  done
done
"$python" scripts/peers/oidn_denoise.py --data "$out/data" --samples "$samples" --out "$out/oidn"
"$python" scripts/peers/oidn_denoise.py --data "$out/data" --samples "$samples" --colour "$out/accumulated" --out "$out/accumulated_oidn"
build/bin/ld_eval --data "$out/data" --sequences --samples "$samples" --filter eaw --filter svgf --model common_fast=common_fast \
  --images accumulated="$out/accumulated" --images oidn="$out/oidn" --images accumulated_oidn="$out/accumulated_oidn" --baseline oidn \
  --report-sequences 4 --out "$out/eval" > "$out/eval.txt"
"$python" scripts/peers/sequences_table.py "$out/eval/metrics.json" | tee "$out/table.md"

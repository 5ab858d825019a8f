#!/usr/bin/env bash
# The released networks against Open Image Denoise, from 1 to 16 samples a pixel; docs/results.md shows what this prints:
#
#   scripts/results.sh OUT NAME=DATA...
#
# Each DATA is a data set with a test split (data/recipes/benchmark.yaml, scripts/cycles_test_set.sh); OUT receives, for each, one folder
# for each number of samples (tables, strips, report.html), and results.md. Needs scripts/peers/setup.sh. Everyone gets the same samples
# and one thread. Environment:
#   SAMPLES  default "1 2 4 8 16"
#   MODELS   weights (default: those released for single frames), called by their names
#   SPLIT    default test
#   REPEATS  runs of each picture by Open Image Denoise, whose median time counts (default 3)
#   BIN      default build/bin
set -euo pipefail
cd "$(dirname "$0")/.."
if [ $# -lt 2 ]; then
  echo "usage: scripts/results.sh OUT NAME=DATA..." >&2
  exit 2
fi
out=$1 bin=${BIN:-build/bin} split=${SPLIT:-test} python=out/peers/venv/bin/python
shift
[ -x $python ] || { echo "results.sh: found no $python; run scripts/peers/setup.sh" >&2; exit 1; }
models=()
for model in ${MODELS:-models/pretrained/common_fast.safetensors models/pretrained/common_fine.safetensors models/pretrained/means.safetensors}; do models+=(--model "$(basename "$model" .safetensors)=$model"); done

for set in "$@"; do
  name=${set%%=*} data=${set#*=}
  for samples in ${SAMPLES:-1 2 4 8 16}; do
    folder=$out/$name/$samples images=()
    mkdir -p "$folder"
    for quality in fast balanced high; do
      for prefilter in "" --prefilter; do
        method=oidn_$quality${prefilter:+_prefiltered}
        [ -e "$folder/$method/cost.json" ] || $python scripts/peers/oidn_denoise.py --data "$data" --split "$split" --samples "$samples" --quality $quality $prefilter \
          --threads 1 --repeats "${REPEATS:-3}" --out "$folder/$method" > "$folder/oidn.log" ||
          { echo "results.sh: $method ended with $? at $samples samples: left out" >&2; continue; }
        images+=(--images "$method=$folder/$method")
      done
    done
    "$bin/ld_eval" --data "$data" --split "$split" --samples "$samples" "${models[@]}" "${images[@]}" --baseline oidn_high --threads 1 \
      --out "$folder" > "$folder/output"
    echo "results.sh: $name at $samples samples a pixel" >&2
  done
done
python3 scripts/results_table.py "$out" "${@%%=*}" | tee "$out/results.md"

#!/usr/bin/env bash
# Trains every network side by side at small size (configs/quick*.yaml): the same data, the same number of steps, each loss,
# several seeds; evaluates each run on the test split and prints one Markdown table (scripts/compare_networks.py).
#
#   scripts/compare_networks.sh DATA OUT
#
# DATA is a data set (a folder with manifest.json), OUT receives the runs and table.md. Safe to interrupt and run again:
# finished runs are skipped, a run that was cut off goes on from its checkpoint. Environment:
#   NETWORKS  default "layer layer_weighted sample_splat pixel_gather pixel_splat optimized"
#   LOSSES    default "smape l2_tonemapped"
#   SEEDS     default "1 2 3"
#   EPOCHS    length of the trainings, over which the learning rate falls (default: what the configurations say)
#   BIN       default build/bin
set -euo pipefail
cd "$(dirname "$0")/.."
if [ $# -ne 2 ]; then
  echo "usage: scripts/compare_networks.sh DATA OUT" >&2
  exit 2
fi
data=$1 out=$2 bin=${BIN:-build/bin}
networks=${NETWORKS:-layer layer_weighted sample_splat pixel_gather pixel_splat optimized}
losses=${LOSSES:-smape l2_tonemapped}
seeds=${SEEDS:-1 2 3}
limit=()
if [ -n "${EPOCHS:-}" ]; then limit=("epochs=$EPOCHS"); fi

config_of() {
  if [ "$1" = layer ]; then echo configs/quick.yaml; else echo "configs/quick_$1.yaml"; fi
}

for network in $networks; do
  cost=$out/cost/$network.json
  if [ ! -e "$cost" ]; then
    "$bin/ld_bench" config "$(config_of "$network")" --json "$cost" >/dev/null
  fi
done
for seed in $seeds; do  # the seeds outside: an unfinished comparison has all networks
  for loss in $losses; do
    for network in $networks; do
      run=$out/runs/$network/$loss/seed$seed
      if [ -e "$run/eval.json" ]; then continue; fi
      printf '\n== %s, %s, seed %s\n' "$network" "$loss" "$seed" >&2
      "$bin/ld_train" --config "$(config_of "$network")" --seed "$seed" --out "$run" "data.path=$data" "loss=$loss" \
        "${limit[@]}"
      "$bin/ld_eval" --data "$data" --model "$network=$run" --out "$run/eval" --json "$run/eval.json" >/dev/null
    done
  done
done
python3 scripts/compare_networks.py "$out" | tee "$out/table.md"

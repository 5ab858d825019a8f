#!/usr/bin/env bash
# How often short trainings collapse, by network, loss, rate and seed (docs/training.md#collapses):
#
#   scripts/collapse_study.sh DATA OUT
#
# DATA is a data set with a validation split (scripts/quickstart.sh renders one), OUT receives runs/ and collapses.md. The networks are
# those of configs/quick*.yaml, without the watch that would save a collapsing run. Safe to interrupt and run again: finished runs are kept.
# Environment:
#   STEPS     of each training (default 200, 32x32 crops)
#   SEEDS     default "1 2 3 4 5 6 7 8 9 10"
#   RATES     default "0.005 0.01"
#   LOSSES    default "smape l2_tonemapped"
#   NETWORKS  default: all
#   CHANGE    words for ld_train on top, such as network.logit_bound=0; they go with runs of their own: give them an OUT of their own
#   JOBS      trainings at a time, one thread each (default 1)
#   BIN       default build/bin
. "$(dirname "$0")/studies.sh"
steps=${STEPS:-200}
read -ra change <<< "${CHANGE:-}"

mkdir -p "$out"
for network in ${NETWORKS:-quick quick_layer_weighted quick_optimized quick_pixel_gather quick_pixel_splat quick_sample_splat}; do
  for loss in ${LOSSES:-smape l2_tonemapped}; do
    for rate in ${RATES:-0.005 0.01}; do
      for seed in ${SEEDS:-1 2 3 4 5 6 7 8 9 10}; do
        train "$network,$loss,$rate,$seed" --config "configs/$network.yaml" --seed "$seed" "data.path=$data" data.crop=32 "steps=$steps" \
          "loss=$loss" "optimizer.learning_rate=$rate" watch.enabled=false "run.validate_every=$((steps / 2))" \
          "run.checkpoint_every=$steps" "${change[@]}"
      done
    done
  done
done
wait_for_trainings
"$bin/ld_eval" --data "$data" --split validation --model "any=$(find "$out/runs" -maxdepth 1 -mindepth 1 | sort | head -1)" --threads 1 \
  --out "$out/inputs" --json "$out/inputs.json" > "$out/inputs.log"
python3 scripts/collapse_table.py "$out" | tee "$out/collapses.md"

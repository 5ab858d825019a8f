#!/usr/bin/env bash
# Trains the released weights further, one core at the lowest priority, so that work goes on beside it:
#
#   scripts/train_release.sh DATA [MINUTES]
#
# DATA is a data set (data/recipes/release.yaml, rendered so far as there was time for; of sequences for history_SIZE:
# data/recipes/sequence_small.yaml), MINUTES the length of one cycle (default 60).
# Each network (configs/NAME.yaml) in turn is trained for one cycle of the learning rate, from where the last cycle ended: from
# out/release/NAME/, from models/pretrained/NAME.safetensors if that is gone; the first cycle of samples_SIZE, history_SIZE and pyramid_SIZE from
# the released common_SIZE, whose features they have and others beside, which begin without effect; else from random weights. A cycle
# that was interrupted goes on bit for bit when the script is started again. After a cycle whose validation beats the released weights' (where
# there are none yet, those of common_SIZE) on the same frames, those are replaced, with their card. Environment:
#   NAMES   networks, in this order (default: common_fast common_fine means samples_fast samples_fine)
#   CYCLES  how many cycles, over all networks (default: for ever)
#   STEPS   length of a cycle in steps, in place of MINUTES, so that it does not depend on what else the machine does
#   BIN     default build/bin
set -euo pipefail
cd "$(dirname "$0")/.."
if [ $# -lt 1 ] || [ $# -gt 2 ]; then
  echo "usage: scripts/train_release.sh DATA [MINUTES]" >&2
  exit 2
fi
data=$1 minutes=${2:-60} bin=${BIN:-build/bin} out=out/release
names=${NAMES:-common_fast common_fine means samples_fast samples_fine}
cycles=${CYCLES:-0}
length=("run.minutes=$minutes")
if [ -n "${STEPS:-}" ]; then length=("steps=$STEPS"); fi
export OMP_WAIT_POLICY=passive
renice -n 19 $$ > /dev/null

# The folder of the cycle that is to be trained: the last one, unless it is done.
cycle_of() {
  local n=0
  while [ -e "$out/$1/cycle_$n/done" ]; do n=$((n + 1)); done
  echo "$n"
}

score() { # the SMAPE of a model on the validation split, as trainings validate: at 8 samples, of sequences at 2
  local how=(--samples 8)
  if [[ $name = history_* ]]; then how=(--samples 2 --sequences); fi
  "$bin/ld_eval" --data "$data" --split validation "${how[@]}" --model "model=$1" --threads 1 --out "$out/score" --json "$out/score.json" > "$out/score.log"
  python3 -c 'import json, sys
print(json.load(open(sys.argv[1]))["methods"]["model"]["mean"]["smape"])' "$out/score.json"
}

train_cycle() {
  local name=$1 n
  n=$(cycle_of "$name")
  local run=$out/$name/cycle_$n released=models/pretrained/$name.safetensors begin=() rate=()
  mkdir -p "$out/$name"
  if [ "$n" -gt 0 ]; then
    begin=("init=$out/$name/cycle_$((n - 1))")
  elif [ -e "$released" ]; then
    begin=("init=$released")
  elif [ -e "models/pretrained/common_${name#*_}.safetensors" ]; then
    begin=("init=models/pretrained/common_${name#*_}.safetensors")
    # At the full rate it forgets before it learns.
    rate=(optimizer.learning_rate=0.0008)
  fi
  # Later cycles need no long rise.
  if [ ${#begin[@]} -gt 0 ]; then rate+=(optimizer.one_cycle.rise=0.1); fi
  echo "== $name, cycle $n: ${begin[*]:-random weights}, ${length[*]}"
  "$bin/ld_train" --config "configs/$name.yaml" "data.path=$data" "${length[@]}" "${begin[@]}" "${rate[@]}" --threads 1 --out "$run"
  touch "$run/done"
  local new old=inf card=${released%.safetensors}.md hours
  hours=$(python3 scripts/release_card.py hours "$card" "$run")
  # Weights that read more and know less than the common ones help nobody.
  local rival=$released
  if [ ! -e "$rival" ]; then rival=models/pretrained/common_${name#*_}.safetensors; fi
  if [ -e "$rival" ]; then old=$(score "$rival"); fi
  # What is scored is what is released: weights in float16, whatever their rounding does.
  local candidate=$out/$name/$name.safetensors
  local mix=()
  # Sequences are few scenes: half of what is released is the network of single frames, which knows many.
  if [[ $name = history_* ]]; then mix=(--mix "common_${name#*_}"); fi
  "$bin/ld_export" --model "$run" "${mix[@]}" --format safetensors --dtype f16 --allowed 1 --card "$out/$name/$name.md" --out "$candidate"
  new=$(score "$candidate")
  echo "== $name, cycle $n: validation SMAPE $new, ${rival##*/} $old"
  if python3 -c "import sys; sys.exit(not float('$new') < float('$old'))"; then
    mv "$out/$name/$name.md" "$card"
    mv "$candidate" "$released"
    python3 scripts/release_card.py write "$card" "$name" "$data" "$out/score.json" "$hours"
  fi
}

done_cycles=0
while [ "$cycles" -eq 0 ] || [ "$done_cycles" -lt "$cycles" ]; do
  for name in $names; do
    train_cycle "$name"
    done_cycles=$((done_cycles + 1))
    if [ "$cycles" -gt 0 ] && [ "$done_cycles" -ge "$cycles" ]; then break; fi
  done
done

#!/usr/bin/env bash
# How OpenMP's threads should wait for each other: the time of a training step by waiting policy, beside none, one or two busy processes.
#
#   scripts/waiting.sh DATA [STEPS]
#
# DATA is a data set; each figure is the median of three trainings of configs/quick.yaml for so many steps (default 30) with two threads.
# GOMP_SPINCOUNT=300000 is what GCC's OpenMP does when nothing is set. Environment: BIN, default build/bin.
set -euo pipefail
cd "$(dirname "$0")/.."
if [ $# -lt 1 ] || [ $# -gt 2 ]; then
  echo "usage: scripts/waiting.sh DATA [STEPS]" >&2
  exit 2
fi
data=$1 steps=${2:-30} bin=${BIN:-build/bin}
scratch=$(mktemp -d)
busy=()
finish() {
  [ ${#busy[@]} -eq 0 ] || kill "${busy[@]}"
  rm -rf "$scratch"
}
trap finish EXIT

# Seconds a step, without the start of the program: the longer training's time less the shorter's.
seconds_of() { # VARIABLE=VALUE STEPS
  local begin
  begin=$(date +%s%N)
  env "$1" "$bin/ld_train" --config configs/quick.yaml "data.path=$data" "steps=$2" run.log_every=100000 run.validate_every=100000 \
    run.images=0 --threads 2 --out "$scratch/run" > "$scratch/log" 2>&1 || { cat "$scratch/log" >&2; exit 1; }
  rm -r "$scratch/run"
  echo $(($(date +%s%N) - begin))
}
per_step() { # VARIABLE=VALUE
  for _ in 1 2 3; do
    echo "$(seconds_of "$1" 1) $(seconds_of "$1" $((steps + 1)))" | awk -v n="$steps" '{ printf "%.3f\n", ($2 - $1) / n / 1e9 }'
  done | sort -g | sed -n 2p
}

settings=(OMP_WAIT_POLICY=active GOMP_SPINCOUNT=300000 OMP_WAIT_POLICY=passive)
declare -A times
for processes in 0 1 2; do
  if [ "$processes" -gt 0 ]; then
    while :; do :; done &
    busy+=($!)
  fi
  for setting in "${settings[@]}"; do times[$setting]+=" $(per_step "$setting") |"; done
done
echo "| waiting, seconds a step | alone | beside one busy process | beside two |"
echo "| :--- | ---: | ---: | ---: |"
for setting in "${settings[@]}"; do echo "| $setting |${times[$setting]}"; done

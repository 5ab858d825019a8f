# Sourced by the studies, which take DATA and OUT (recipe_study.sh, collapse_study.sh, equal_paths.sh, sample_counts.sh, tradeoff.sh): sets $data,
# $out, $bin and $jobs, and trains, one thread each, so many at a time. Finished runs are kept, one that was cut off goes on.
# shellcheck shell=bash
set -euo pipefail
cd "$(dirname "$0")/.."
if [ $# -ne 2 ]; then
  echo "usage: scripts/$(basename "$0") DATA OUT" >&2
  exit 2
fi
data=$1 out=$2 bin=${BIN:-build/bin} jobs=${JOBS:-1}

train_now() { # RUN WORDS...
  local run=$out/runs/$1
  shift
  "$bin/ld_train" --threads 1 --out "$run" "$@" > "$run/output" 2>&1 ||
    { echo "$(basename "$0"): the training in $run failed; see $run/output" >&2; return 1; }
  touch "$run/done"
  echo "trained $run" >&2
}

# Begins the training $out/runs/RUN with these words for ld_train as soon as fewer than $jobs are running. A failure ends the study.
train() { # RUN WORDS...
  if [ -e "$out/runs/$1/done" ]; then return; fi
  mkdir -p "$out/runs/$1"
  while [ "$(jobs -rp | wc -l)" -ge "$jobs" ]; do wait -n; done
  train_now "$@" &
}

wait_for_trainings() {
  while [ "$(jobs -p | wc -l)" -gt 0 ]; do wait -n; done
}

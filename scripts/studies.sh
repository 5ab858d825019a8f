# Sourced by the studies (recipe_study.sh, collapse_study.sh, equal_paths.sh, sample_counts.sh, tradeoff.sh): trainings of one thread each,
# so many at a time. Finished runs are kept, one that was cut off goes on. The study says where ($out) and how many ($jobs).
# shellcheck shell=bash
bin=${BIN:-build/bin}
export OMP_WAIT_POLICY=passive

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

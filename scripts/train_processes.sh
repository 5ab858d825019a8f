#!/usr/bin/env bash
# Starts N processes of ld_train on this machine that train one network together (docs/distributed.md):
#   scripts/train_processes.sh 2 --config configs/quick.yaml --out out/run data.path=out/data
# The machine's threads are divided among them, unless --threads or OMP_NUM_THREADS says otherwise. Ctrl-C (or SIGTERM) stops all after
# the same step, with a checkpoint. Ends with the exit code of rank 0 or, where that is 0, with the first one that is not.
set -euo pipefail

if [ $# -lt 2 ] || ! [[ $1 =~ ^[1-9][0-9]*$ ]]; then
  echo "usage: $0 PROCESSES ARGUMENTS_OF_LD_TRAIN..." >&2
  exit 2
fi
count=$1
shift
program=${LD_TRAIN:-"$(dirname "$0")/../build/bin/ld_train"}
[ -x "$program" ] || { echo "$0: found no $program; build it, or name it with LD_TRAIN=..." >&2; exit 2; }

export WORLD_SIZE=$count MASTER_ADDR=127.0.0.1
if [ -z "${MASTER_PORT:-}" ]; then
  # The first port above 29500, PyTorch's, that nobody listens on.
  MASTER_PORT=29500
  while (: < /dev/tcp/127.0.0.1/$MASTER_PORT) 2> /dev/null; do MASTER_PORT=$((MASTER_PORT + 1)); done
fi
export MASTER_PORT
if [ -z "${OMP_NUM_THREADS:-}" ]; then
  threads=$(($(nproc) / count))
  export OMP_NUM_THREADS=$((threads > 0 ? threads : 1))
fi

processes=()
# The terminal sends Ctrl-C to all of them itself, kill only to this shell.
trap 'kill -TERM "${processes[@]}" 2> /dev/null || true' TERM
trap : INT
for ((rank = 0; rank < count; ++rank)); do
  RANK=$rank "$program" "$@" &
  processes+=($!)
done

result=0
for process in "${processes[@]}"; do
  code=0
  wait "$process" || code=$?
  # A signal ends wait before the process: wait again.
  while kill -0 "$process" 2> /dev/null; do
    code=0
    wait "$process" || code=$?
  done
  [ "$result" -ne 0 ] || result=$code
done
exit "$result"

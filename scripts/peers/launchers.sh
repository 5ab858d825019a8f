#!/usr/bin/env bash
# Runs the commands of docs/distributed.md that start processes by other programs: mpirun, Slurm and torchrun, two processes each on this
# machine, on a data set and for steps so few that all takes two minutes. Each must give the bits that scripts/train_processes.sh gives. Then
# one process is killed: the other must say so, end with code 1 and leave a checkpoint from which the same command goes on to the same bits.
#   scripts/peers/launchers.sh                     all three
#   scripts/peers/launchers.sh mpirun|slurm|torchrun ...
# Needs build/bin. Installs on first use Debian's openmpi-bin or slurmctld, slurmd, slurm-client and munge, and PyPI's torch (scripts/peers/torch.sh).
# Slurm's daemons are this script's own: their files are in a temporary folder, and they end with it.
set -euo pipefail
cd "$(dirname "$0")/../.."
. scripts/packages.sh
launchers=("$@")
[ $# -gt 0 ] || launchers=(mpirun slurm torchrun)
out=$PWD/out/peers/launchers
page=docs/distributed.md
steps=60
fail() { echo "launchers.sh: $*" >&2; exit 1; }
say() { printf 'launchers: %s (%d s since the start)\n' "$*" "$SECONDS"; }

for launcher in "${launchers[@]}"; do
  case "$launcher" in
    mpirun) packages=(openmpi-bin openssh-client) ;; # it looks for ssh although one machine needs none
    slurm) packages=(slurmctld slurmd slurm-client munge) ;;
    torchrun) packages=() ;;
    *) echo "launchers.sh: unknown launcher '$launcher'; expected mpirun, slurm or torchrun" >&2; exit 2 ;;
  esac
  install_missing launchers "${packages[@]}"
  [ "$launcher" != torchrun ] || scripts/peers/torch.sh
done
for program in ld_render ld_train ld_inspect; do
  [ -x build/bin/$program ] || fail "found no build/bin/$program; build it with scripts/test.sh or scripts/quickstart.sh"
done

SECONDS=0
rm -rf "$out"
mkdir -p "$out"
work=$(mktemp -d)
daemons=()
end() {
  [ ${#daemons[@]} -eq 0 ] || kill "${daemons[@]}" 2> /dev/null || true
  wait
  rm -rf "$work"
}
trap end EXIT
trap 'exit 130' INT
trap 'exit 143' TERM
# One thread each, whoever starts them: the bits depend on it. A process that is gone is noticed at once; the time is for one that hangs.
export OMP_WAIT_POLICY=passive OMP_NUM_THREADS=1 LD_PEER_TIMEOUT=5 LD_START_TIMEOUT=60

build/bin/ld_render --recipe data/recipes/quick.yaml --out "$out/data" resolution=[32,32] spp=2 scenes.objects=[2,3] frames.train=4 \
  frames.validation=1 frames.test=0 reference_spp.train=8 reference_spp.validation=8 > "$out/render.log"
cat > "$out/train.yaml" << END_OF_FILE
base: $PWD/configs/quick.yaml
data: {path: $out/data, crop: 32, batch: 2}
run: {max_steps: $steps, log_every: 1, checkpoint_every: 10, images: 0}
END_OF_FILE

# Stands in for build/bin/ld_train in the commands: notes the process to be killed and the code of each.
cat > "$out/ld_train" << END_OF_FILE
#!/usr/bin/env bash
trap : TERM INT
code=0
( echo \$BASHPID > $out/process.\$RANK; exec $PWD/build/bin/ld_train "\$@" ) || code=\$?
echo \$code > $out/code.\$RANK
[ \$code -ne 137 ] || kill -KILL \$\$
exit \$code
END_OF_FILE
chmod +x "$out/ld_train"
echo "localhost slots=2" > "$out/hosts"

# The page's block that holds WORD, with this test's names, numbers and ports.
shown() { # WORD RUN
  awk -v word="$1" '/^```sh$/ { inside = 1; block = ""; next }
    /^```/ { if (inside && index(block, word)) { printf "%s", block; found = 1 } inside = 0 }
    inside { block = block $0 "\n" }
    END { exit !found }' "$page" > "$work/shown" || fail "$page shows no command with '$1'"
  sed -E -e "s#build/bin/ld_train#$out/ld_train#; s#--config train.yaml#--config $out/train.yaml#; s#--out (/shared|out)/run#--out $2#" \
    -e "s/--nodes=4 --ntasks-per-node=1 --cpus-per-task=16/--nodes=1 --ntasks-per-node=2 --cpus-per-task=1/; s/-np 4/-np 2/" \
    -e "s#--hostfile hosts#--hostfile $out/hosts#; s/MASTER_ADDR=node0/MASTER_ADDR=localhost/; s/MASTER_PORT=29500/MASTER_PORT=$(free_port 29500)/" \
    -e "s/OMP_NUM_THREADS=8/OMP_NUM_THREADS=1/" "$work/shown"
}
free_port() { # the first above START that nobody listens on
  local port=$1
  while (: < "/dev/tcp/127.0.0.1/$port") 2> /dev/null; do port=$((port + 1)); done
  echo "$port"
}

# Each runs the page's command for the folder RUN and returns its exit code; the output is RUN.log.
run_by_hand() { scripts/train_processes.sh 2 --config "$out/train.yaml" --out "$1" > "$1.log" 2>&1; }
run_mpirun() {
  shown mpirun "$1" > "$work/command"
  local as_root=()
  [ "$(id -u)" -ne 0 ] || as_root=(OMPI_ALLOW_RUN_AS_ROOT=1 OMPI_ALLOW_RUN_AS_ROOT_CONFIRM=1)
  env "${as_root[@]}" bash "$work/command" > "$1.log" 2>&1
}
run_torchrun() {
  shown "torchrun --standalone" "$1" > "$work/command"
  PATH=$PWD/out/peers/torch/bin:$PATH bash "$work/command" > "$1.log" 2>&1
}
run_restarting() {
  shown "torchrun --standalone" "$1" | sed 's/torchrun --/torchrun --max-restarts 3 --/' > "$work/command"
  PATH=$PWD/out/peers/torch/bin:$PATH bash "$work/command" > "$1.log" 2>&1
}
run_slurm() {
  shown "#SBATCH" "$1" > "$work/job.sh"
  : > "$1.log"
  sbatch --parsable --output="$1.log" "$work/job.sh" > "$work/job" || fail "sbatch refuses the page's script"
  while [ -n "$(squeue --noheader --states=PENDING,RUNNING,COMPLETING --jobs="$(cat "$work/job")")" ]; do sleep 0.2; done
  return "$(scontrol show job "$(cat "$work/job")" | sed -n 's/.* ExitCode=\([0-9]*\):.*/\1/p')"
}

# A cluster of this machine alone, which would kill the others when a process ends badly: the page's option must keep it from that.
start_slurm() {
  chmod 755 "$work" # munge's clients must reach its socket
  mkdir "$work/state" "$work/spool"
  head -c 128 /dev/urandom > "$work/key"
  chmod 600 "$work/key"
  cat > "$work/slurm.conf" << END_OF_FILE
ClusterName=launchers
SlurmctldHost=localhost
SlurmUser=$(id -un)
SlurmdUser=$(id -un)
AuthType=auth/munge
AuthInfo=socket=$work/munge
CredType=cred/munge
KillOnBadExit=1
MpiDefault=none
ProctrackType=proctrack/pgid
TaskPlugin=task/none
SwitchType=switch/none
SelectType=select/cons_tres
SlurmdParameters=config_overrides
StateSaveLocation=$work/state
SlurmdSpoolDir=$work/spool
SlurmctldPidFile=$work/slurmctld.pid
SlurmdPidFile=$work/slurmd.pid
SlurmctldPort=$(free_port 16817)
SlurmdPort=$(free_port 26818)
NodeName=localhost NodeHostname=$(hostname -s) NodeAddr=127.0.0.1 CPUs=2
PartitionName=launchers Nodes=ALL Default=YES
END_OF_FILE
  export SLURM_CONF=$work/slurm.conf
  munged --foreground --key-file="$work/key" --socket="$work/munge" --pid-file="$work/munged.pid" --log-file="$work/munged.log" \
    --seed-file="$work/seed" 2> "$out/munged.log" &
  daemons+=($!)
  until [ -S "$work/munge" ]; do kill -0 $! || fail "munged did not start; its log is $out/munged.log"; sleep 0.1; done
  slurmctld -D > "$out/slurmctld.log" 2>&1 &
  daemons+=($!)
  slurmd -D > "$out/slurmd.log" 2>&1 &
  daemons+=($!)
  until sinfo --noheader --format=%T 2> /dev/null | grep -q idle; do
    [ "$SECONDS" -lt 300 ] || fail "Slurm is not ready; its logs are $out/slurmctld.log and $out/slurmd.log"
    sleep 0.2
  done
}

expect_same_bits() { # RUN
  for file in metrics.csv checkpoints/last/{weights.safetensors,optimizer.safetensors,state.json}; do
    cmp "$out/by_hand/$file" "$1/$file" || fail "$1 differs from the run that scripts/train_processes.sh started"
  done
}
expect_end() { # RUN LAUNCHER
  "run_$2" "$1" || { cat "$1.log" >&2; fail "$2 ended with exit code $?"; }
  expect_same_bits "$1"
}
await_step() { # RUN STEP
  local latest=$((SECONDS + 60))
  until [ "$(tail -n 1 "$1/metrics.csv" 2> /dev/null | cut -d, -f1)" -ge "$2" ] 2> /dev/null; do
    [ "$SECONDS" -lt "$latest" ] || { cat "$1.log" >&2; fail "$1 has not come to step $2 after 60 s"; }
    sleep 0.02
  done
}

# Kills a process between two checkpoints. The other must save the last step.
lose() { # RUN LAUNCHER RANK
  local other=$((1 - $3)) code=0 step
  rm -f "$out"/{process,code}.*
  "run_$2" "$1" &
  local run=$!
  await_step "$1" 13
  kill -KILL "$(cat "$out/process.$3")"
  wait $run || code=$?
  [ $code -ne 0 ] || fail "$2 ended with exit code 0 although process $3 was killed"
  grep -q "rank $other of 2: lost a peer" "$1.log" || { cat "$1.log" >&2; fail "$2: process $other did not say that it lost the other"; }
  [ "$(cat "$out/code.$other")" -eq 1 ] || fail "$2: process $other ended with exit code $(cat "$out/code.$other"), expected 1"
  build/bin/ld_inspect "$1" > "$1.inspect" || { cat "$1.inspect" >&2; fail "$2 left a damaged run"; }
  step=$(readlink "$1/checkpoints/last")
  step=$((10#${step#step_}))
  say "$2: process $3 killed, the other ended with 1 and left step $step, $2 ended with $code"
  [ $step -ge 13 ] && [ $step -lt $steps ] || fail "$2: step $step was saved, expected the last one before the kill"
}

run_by_hand "$out/by_hand" || { cat "$out/by_hand.log" >&2; fail "scripts/train_processes.sh failed"; }
say "two processes by hand: done"
for launcher in "${launchers[@]}"; do
  [ "$launcher" != slurm ] || start_slurm
  expect_end "$out/$launcher" "$launcher"
  say "$launcher: the same bits"
  for rank in 1 0; do
    lose "$out/${launcher}_lost_$rank" "$launcher" $rank
    expect_end "$out/${launcher}_lost_$rank" "$launcher"
    say "$launcher: started again, the same bits"
  done
  if [ "$launcher" = torchrun ]; then
    rm -f "$out"/process.*
    run_restarting "$out/restarting" &
    await_step "$out/restarting" 13
    kill -KILL "$(cat "$out/process.1")"
    wait $! || { cat "$out/restarting.log" >&2; fail "torchrun --max-restarts ended with exit code $?"; }
    grep -q "lost a peer" "$out/restarting.log" || fail "torchrun --max-restarts: the run was over before process 1 was killed"
    expect_same_bits "$out/restarting"
    say "torchrun --max-restarts: started again by itself, the same bits"
  fi
done
say "all passed"

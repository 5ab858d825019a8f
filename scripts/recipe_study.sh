#!/usr/bin/env bash
# What a change of the training recipe is worth: every named change alone, against the same base, for the same time on one core, with
# several seeds; then the table with intervals (scripts/recipe_table.py):
#
#   scripts/recipe_study.sh DATA OUT
#
# DATA is a data set with a validation split, OUT receives runs/CHANGE_SEED/ and recipes.md. Safe to interrupt and run again: finished
# runs are kept, one that was cut off goes on. Environment:
#   MINUTES  of each training (default 5)
#   SEEDS    default "1 2 3"
#   CHANGES  default: all of those below
#   JOBS     trainings at a time, one thread each (default 1)
#   BIN      default build/bin
. "$(dirname "$0")/studies.sh"
minutes=${MINUTES:-5} seeds=${SEEDS:-1 2 3}

# The base is configs/quick.yaml. "without" changes take one of its settings back to the paper's.
arguments() {
  case "$1" in
    base) ;;
    without_he) echo network.initialisation=xavier ;;
    without_gaussian) echo network.initial_kernel=0 ;;
    without_demodulation) echo network.demodulation=none ;;
    without_bound) echo network.logit_bound=0 ;;
    without_rejection) echo network.rejection=false ;;
    without_average) echo optimizer.ema=0 ;;
    without_clipping) echo optimizer.clip_norm=0 ;;
    without_all) echo network.initialisation=xavier network.initial_kernel=0 network.demodulation=none network.logit_bound=0 network.rejection=false optimizer.beta2=0.999 optimizer.epsilon=1e-8 optimizer.ema=0 optimizer.clip_norm=0 optimizer.schedule=cosine optimizer.learning_rate=0.003 ;;
    adam_defaults) echo optimizer.beta2=0.999 optimizer.epsilon=1e-8 ;;
    cosine) echo optimizer.schedule=cosine ;;
    rate_half) echo optimizer.learning_rate=0.002 ;;
    rate_double) echo optimizer.learning_rate=0.008 ;;
    adamw) echo optimizer.name=adamw optimizer.weight_decay=0.01 ;;
    kernel_5) echo network.kernel_size=5 ;;
    kernel_13) echo network.kernel_size=13 ;;
    levels_3) echo network.name=optimized network.kernel_size=5 network.levels=3 ;;
    levels_4) echo network.name=optimized network.kernel_size=5 network.levels=4 ;;
    bound_4) echo network.logit_bound=4 ;;
    layers_1) echo network.layers=1 ;;
    layers_3) echo network.layers=3 ;;
    first_samples) echo "data.samples=[]" ;;
    samples_1_16) echo "data.samples=[1, 16]" ;;
    batch_8) echo data.batch=8 ;;
    batch_2) echo data.batch=2 ;;
    crop_96) echo data.crop=96 data.batch=2 ;;
    difficulty_4) echo data.difficulty=4 ;;
    exposure_2) echo data.exposure=2 ;;
    colours) echo data.colours=true ;;
    smape_l2) echo loss=smape_l2 ;;
    multiscale) echo loss=smape_multiscale ;;
    l2) echo loss=l2_tonemapped ;;
    relative_l2) echo loss=relative_l2 ;;
    half_width) echo "network.unet.encoder=[[8, 8], [16], [24]]" "network.unet.bottleneck=[32]" "network.unet.decoder=[[24, 24], [16, 16], [16, 16]]" ;;
    double_width) echo "network.unet.encoder=[[32, 32], [64], [96]]" "network.unet.bottleneck=[128]" "network.unet.decoder=[[96, 96], [64, 64], [64, 64]]" ;;
    pixel_gather) echo network.name=pixel_gather network.layers=2 network.rejection=false ;;
    pixel_splat) echo network.name=pixel_splat network.layers=2 ;;
    pixel_splat_multiscale) echo network.name=pixel_splat network.layers=2 loss=smape_multiscale ;;
    *) echo "recipe_study.sh: unknown change '$1'" >&2; return 2 ;;
  esac
}
all="base without_he without_gaussian without_demodulation without_bound without_rejection without_average without_clipping without_all adam_defaults cosine rate_half
rate_double adamw kernel_5 kernel_13 levels_3 levels_4 bound_4 layers_1 layers_3 first_samples samples_1_16 batch_8 batch_2 crop_96 difficulty_4 exposure_2 colours smape_l2 multiscale l2
relative_l2 half_width double_width pixel_gather pixel_splat
pixel_splat_multiscale"
changes=${CHANGES:-$all}

# `arguments` prints words that may hold blanks, in brackets: one per "key=".
split() { sed -E 's/ ([a-z0-9_.]+=)/\n\1/g' <<< "$1"; }

mkdir -p "$out"
for seed in $seeds; do
  for change in $changes; do
    words=()
    text=$(arguments "$change")
    if [ -n "$text" ]; then mapfile -t words < <(split "$text"); fi
    train "${change}_$seed" --config configs/quick.yaml --seed "$seed" "data.path=$data" data.validation_samples=8 "data.samples=[8, 8]" \
      "run.minutes=$minutes" epochs=1000 "${words[@]}"
  done
done
wait_for_trainings
python3 scripts/recipe_table.py "$out" | tee "$out/recipes.md"

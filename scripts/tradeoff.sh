#!/usr/bin/env bash
# Speed against accuracy: trains every network at small size on one data set for the same number of steps, with 2 to 5 layers and both
# losses, then measures all of them on the test split, beside Open Image Denoise where it is installed (scripts/peers/setup.sh):
#
#   scripts/tradeoff.sh DATA OUT
#
# DATA is a data set (a folder with manifest.json), OUT receives runs/, tradeoff.md, tradeoff.svg and tradeoff.json. Safe to interrupt and
# run again: finished runs are skipped, a run that was cut off goes on from its checkpoint. Environment:
#   STEPS     steps of each training, rounded up to whole epochs (default 600)
#   VARIANTS  default: all of those below; pixel_splat_l2 and optimized_l2 are understood too
#   JOBS      trainings at a time, one thread each: small networks gain little from a second (default: the CPUs of this process)
#   BIN       default build/bin
. "$(dirname "$0")/studies.sh"
steps=${STEPS:-600} jobs=${JOBS:-$(nproc)}
all="layer layer_weighted layer_3 layer_4 layer_5 optimized pixel_gather pixel_splat sample_splat"
all="$all layer_l2 pixel_gather_l2 sample_splat_l2"  # those of the paper's Table 5
variants=${VARIANTS:-$all}

# The arguments of a variant, on top of what all share.
arguments() {
  local name=${1%_l2}
  case "$name" in
    layer) echo "--config configs/quick.yaml" ;;
    layer_[3-5]) echo "--config configs/quick.yaml network.layers=${name#layer_}" ;;
    *) echo "--config configs/quick_$name.yaml" ;;
  esac
  case "$1" in *_l2) echo "loss=l2_tonemapped" ;; esac
}

frames=$(python3 -c 'import json, sys; print(sum(f["split"] == "train" for f in json.load(open(sys.argv[1]))["frames"]))' "$data/manifest.json")
mkdir -p "$out"
for variant in $variants; do
  # One learning rate for all, with a warm-up: L2 on tone-mapped values collapses without it for some seeds.
  # shellcheck disable=SC2046
  train "$variant" $(arguments "$variant") "data.path=$data" "epochs=$(((steps * 4 + frames - 1) / frames))" \
    optimizer.schedule=cosine optimizer.learning_rate=0.002 optimizer.warmup_steps=50
done
wait_for_trainings

models=()
for variant in $variants; do models+=(--model "$variant=$out/runs/$variant"); done
peer=()
if out/peers/venv/bin/python -c 'import pyoidn' 2>/dev/null; then
  out/peers/venv/bin/python scripts/peers/oidn_denoise.py --data "$data" --out "$out/oidn" --threads "$(nproc)" >&2
  peer=(--images "oidn=$out/oidn")
fi
"$bin/ld_bench" tradeoff --threads "$(nproc)" --data "$data" "${models[@]}" "${peer[@]}" --out "$out" --json "$out/tradeoff.json"

#!/usr/bin/env bash
# Error against time on one shot that nobody was trained on: three released networks in floats and in 8 bits, as they are and fitted to the shot for
# MINUTES without references (docs/training.md), the filters, and Open Image Denoise's three qualities; two sizes, 2, 8 and 32 samples a pixel.
#   scripts/peers/error_and_time.sh [OUT]     (default: out/error_and_time; docs/tradeoff.md is what it leaves)
# Renders 12 frames of 160x96, of which 4 are compared and 8 learnt from, and 8 of 480x288 (2 and 6). What is finished is kept, so it may be stopped and
# started again. Needs scripts/peers/setup.sh and the programs in build/bin/. Environment: MINUTES (default 5), THREADS (default: all), BIN.
set -euo pipefail
cd "$(dirname "$0")/../.."
out=${1:-out/error_and_time} bin=${BIN:-build/bin} threads=${THREADS:-$(nproc)} python=out/peers/venv/bin/python
[ -x $python ] || { echo "error_and_time.sh: found no $python; run scripts/peers/setup.sh" >&2; exit 1; }
mkdir -p "$out"
once() { # NAME COMMAND...: unless it has been done
  [ ! -e "$out/$1.done" ] || return 0
  "${@:2}" > "$out/$1.log" 2>&1 || { tail -n 5 "$out/$1.log" >&2; exit 1; }
  touch "$out/$1.done"
  echo "error_and_time: $1" >&2
}
shot() { # NAME WIDTH HEIGHT REFERENCE FRAMES...: of one shot, with these references
  local frame
  for frame in "${@:5}"; do
    "$bin/ld_render" --recipe data/recipes/sequence_quick.yaml --out "$out/$1" --frames "$frame:$((frame + 1))" "resolution=[$2,$3]" spp=32 \
      reference_spp.train="$4" seed=77 frames.train=12 frames.validation=0 frames.test=0 sequence.length=12 sequence.noise_instances=1 'sequence.kinds=[turn]' \
      scenes.indoor=1 scenes.defocus=1 scenes.motion_blur=1
  done
}
choose() { # NAME: two of the frames to learn from choose the fitted weights and measure 8 bits
  python3 - "$out/$1/manifest.json" <<'END'
import json, sys
manifest = json.load(open(sys.argv[1]))
for frame in manifest["frames"]:
    if frame["index"] in (3, 9):
        frame["split"] = "validation"
json.dump(manifest, open(sys.argv[1], "w"), indent=1)
END
}
once small shot small 160 96 2048 1 4 7 10
once large shot large 480 288 1024 1 7
once learnt_small shot learnt_small 160 96 64 0 2 3 5 6 8 9 11
once learnt_large shot learnt_large 480 288 8 0 2 3 5 9 11

names=(common_fast common_fine pyramid_fine)
for size in small large; do
  once "$size.chosen" choose "learnt_$size"
  mkdir -p "$out/$size.models"
  for name in "${names[@]}"; do
    # From 2 samples to all but one go in, so that what comes out is good for any number.
    once "$size.$name.fitted" "$bin/ld_train" --config configs/adapt.yaml init="$name" data.path="$out/learnt_$size" 'data.samples=[2,31]' \
      run.minutes="${MINUTES:-5}" --threads "$threads" --out "$out/$size.$name.fit"
    once "$size.$name.fitted.f16" "$bin/ld_export" --model "$out/$size.$name.fit" --format safetensors --allowed 1 \
      --out "$out/$size.models/${name}_fitted.safetensors"
    cp "models/pretrained/$name.safetensors" "$out/$size.models/"
    for weights in "$name" "${name}_fitted"; do
      once "$size.$weights.i8" "$bin/ld_export" --model "$out/$size.models/$weights.safetensors" --format safetensors --dtype i8 --allowed 1 \
        --calibrate "$out/learnt_$size" --out "$out/$size.models/${weights}_i8.safetensors"
    done
  done
done

for size in small large; do
  models=()
  for name in "${names[@]}"; do
    for weights in "$name" "${name}_i8" "${name}_fitted" "${name}_fitted_i8"; do
      models+=(--model "$weights=$out/$size.models/$weights.safetensors")
    done
  done
  for samples in 2 8 32; do
    others=()
    for quality in fast balanced high; do
      once "$size.$samples.oidn_$quality" "$python" scripts/peers/oidn_denoise.py --data "$out/$size" --split train --samples "$samples" --quality $quality \
        --threads "$threads" --repeats 5 --out "$out/$size.$samples.oidn_$quality"
      others+=(--images "oidn_$quality=$out/$size.$samples.oidn_$quality")
    done
    once "$size.$samples" "$bin/ld_bench" tradeoff --threads "$threads" --data "$out/$size" --split train --samples "$samples" "${models[@]}" --filter eaw --filter svgf \
      "${others[@]}" --out "$out/$size.$samples" --json "$out/$size.$samples.json"
  done
done
python3 scripts/peers/error_and_time.py "$out" | tee "$out/table.md"

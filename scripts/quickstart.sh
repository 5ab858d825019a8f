#!/usr/bin/env bash
# From a fresh Debian machine to a denoised image: installs, builds, renders a small data set, trains, exports,
# denoises frames whose scenes the training never saw, and prints the table. Everything lands in out/quickstart/.
# Safe to interrupt and run again: finished frames and training steps are kept.
# The Debian package has it too: there it takes the installed programs, and the folder is below the current one.
set -euo pipefail
here=$(cd "$(dirname "$0")" && pwd)
out=out/quickstart
SECONDS=0
step() { printf '\n== %s (%d min %02d s since the start)\n' "$1" $((SECONDS / 60)) $((SECONDS % 60)); }

if [ -e "$here/setup.sh" ]; then
  cd "$here/.."
  bin=build/bin/ recipes=data/recipes configs=configs
  step "1/6 Packages"
  scripts/setup.sh --no-tests
  step "2/6 Build"
  cmake --build --preset release --target ld_render ld_train ld_export ld_denoise ld_eval
else
  bin='' recipes=$here/recipes configs=$here/configs
fi
step "3/6 Render random scenes: samples and references"
"${bin}ld_render" --recipe "$recipes/quick.yaml" --out $out/data
step "4/6 Train"
"${bin}ld_train" --config "$configs/quick_pixel_splat.yaml" data.path=$out/data epochs=127 --out $out/run
step "5/6 Export weights and denoise a frame of the test split"
"${bin}ld_export" --model $out/run --format safetensors --out $out/quick.safetensors
frame=$(ls $out/data/frame_*.exr | grep -v reference | tail -n 1)
"${bin}ld_denoise" --model $out/quick.safetensors "$frame" --output $out/denoised.exr
step "6/6 Evaluate on the test split, beside released weights that were trained for longer on other scenes"
"${bin}ld_eval" --data $out/data --model trained=$out/quick.safetensors --model released=common_fine --out $out/eval --json $out/metrics.json
step "Done: table in $out/metrics.json, comparison strips in $out/eval/, weights in $out/quick.safetensors"

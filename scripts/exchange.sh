#!/usr/bin/env bash
# What one machine wrote, another reads: frames, weights, checkpoints. For two builds that differ in compiler and libraries; a few
# seconds each. scripts/test_debian13.sh runs it between Debian 12 and 13.
#   scripts/exchange.sh write FOLDER           renders frames, trains on them and exports the weights, into FOLDER
#   scripts/exchange.sh read FOLDER NAME       denoises a frame of FOLDER, continues its training, denoises again: FOLDER/NAME_*.exr
#   scripts/exchange.sh compare FOLDER A B     the pictures of two that read FOLDER; they may differ by rounding
set -euo pipefail
project=$(realpath "$(dirname "$0")/..")
usage() { echo "exchange.sh: expected write FOLDER, read FOLDER NAME or compare FOLDER NAME NAME" >&2; exit 2; }
[ $# -ge 2 ] || usage
mode=$1
[ "$mode" != write ] || mkdir -p "$2"
cd "$2"
train=("$project/build/bin/ld_train" --config config.yaml data.path=data epochs=8 data.crop=16 data.batch=1 run.images=0)
denoise=("$project/build/bin/ld_denoise" data/frame_000005.exr --float)
case "$mode $#" in
  "write 2")
    cp "$project/configs/quick.yaml" config.yaml
    "$project/build/bin/ld_render" --recipe "$project/data/recipes/quick.yaml" --out data resolution=[32,32] scenes.objects=[2,3] \
      frames.train=4 frames.validation=1 frames.test=2 reference_spp.train=16 reference_spp.validation=16 reference_spp.test=16
    "${train[@]}" run.max_steps=16 --out run
    "$project/build/bin/ld_export" --model run --format safetensors --out model.safetensors
    ;;
  "read 3")
    "$project/build/bin/ld_inspect" data
    "$project/build/bin/ld_inspect" model.safetensors
    "${denoise[@]}" --model model.safetensors --output "$3_denoised.exr"
    rm -rf "run_$3"
    cp -r run "run_$3"
    "${train[@]}" run.max_steps=32 --out "run_$3"
    "${denoise[@]}" --model "run_$3" --output "$3_continued.exr"
    ;;
  "compare 4")
    failed=0
    for picture in denoised continued; do
      idiff -v -a -fail 1e-4 -failrelative 1e-4 "$3_$picture.exr" "$4_$picture.exr" || failed=1
    done
    exit $failed
    ;;
  *) usage ;;
esac

#!/usr/bin/env bash
# From a fresh Debian machine to sequences that hold still: installs, builds, renders three short sequences with one sample a pixel, denoises
# them with the filters EAW and SVGF and frame by frame with released weights, and prints the tables: errors of frames, and how steady the
# sequences are. Everything lands in out/quickstart_sequence/, the page to look at as eval/report.html: there the sequences play side by side.
# Safe to interrupt and run again: finished frames are kept.
# The Debian package has it too: there it takes the installed programs, and the folder is below the current one.
set -euo pipefail
here=$(cd "$(dirname "$0")" && pwd)
out=out/quickstart_sequence
SECONDS=0
step() { printf '\n== %s (%d min %02d s since the start)\n' "$1" $((SECONDS / 60)) $((SECONDS % 60)); }

if [ -e "$here/setup.sh" ]; then
  cd "$here/.."
  bin=build/bin/ recipes=data/recipes
  step "1/5 Packages"
  scripts/setup.sh --no-tests
  step "2/5 Build"
  cmake --build --preset release --target ld_render ld_denoise ld_eval
else
  bin='' recipes=$here/recipes
fi
step "3/5 Render three sequences of 12 frames: one sample a pixel, references of 64"
"${bin}ld_render" --recipe "$recipes/sequence_quick.yaml" --out $out/data --seed 20 resolution='[160, 90]' spp=1 reference_spp.test=64 \
  frames='{train: 0, validation: 0, test: 36}' sequence.noise_instances=1 sequence.kinds='[still, door, dolly]'
step "4/5 Denoise the sequence of the camera that goes ahead with SVGF"
mkdir -p $out/denoised
"${bin}ld_denoise" --filter svgf "$out/data/frame_######.exr" --frames 24:36 --output "$out/denoised/frame_####.png"
step "5/5 Evaluate the filters, and released weights that denoise each frame by itself"
"${bin}ld_eval" --data $out/data --sequences --filter eaw --filter svgf --model frame_by_frame=common_fast --report-sequences 3 \
  --out $out/eval
step "Done: tables in $out/eval/, the page $out/eval/report.html, pictures in $out/denoised/"

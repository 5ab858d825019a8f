#!/usr/bin/env bash
# Builds with -DLD_TRAINING=OFF into build-no-training/, what denoises and evaluates without LibTorch, says how long that took, and denoises a frame
# there. `LD_COLD=1 scripts/test_no_training.sh` begins anew and leaves the compiler cache aside.
set -euo pipefail
cd "$(dirname "$0")/.."
build=build-no-training
[ -z "${LD_COLD:-}" ] || { rm -rf "$build"; export CCACHE_DISABLE=1; }

cmake -S . -B "$build" -G Ninja -DCMAKE_BUILD_TYPE=Release -DLD_TRAINING=OFF > "$build.log" 2>&1 || {
  tail -n 30 "$build.log" >&2
  echo "test_no_training.sh: configuring failed; the whole log is $build.log" >&2
  exit 1
}
SECONDS=0
cmake --build "$build" --parallel "${JOBS:-$(nproc)}"
echo "test_no_training: built in $SECONDS s"

out=$(mktemp -d)
trap 'rm -rf "$out"' EXIT
for program in "$build"/bin/ld_* "$build"/src/embed/liblayered_denoiser.so; do
  [ -f "$program" ] || continue
  ! ldd "$program" | grep -E 'libtorch|libc10' || { echo "test_no_training.sh: $program is linked to LibTorch" >&2; exit 1; }
done
[ ! -e "$build/bin/ld_train" ] || { echo "test_no_training.sh: ld_train was built" >&2; exit 1; }
fixture=tests/fixtures/before_simd
"$build/bin/ld_denoise" --model "$fixture/layer.safetensors" "$fixture/frame.exr" --output "$out/denoised.exr"
"$build/bin/ld_denoise" --model common_fast "$fixture/frame.exr" --output "$out/denoised.png"
"$build/bin/ld_inspect" "$fixture/layer.safetensors" > /dev/null
[ -s "$out/denoised.exr" ] && [ -s "$out/denoised.png" ]
echo "test_no_training: no program needs LibTorch; ld_denoise and ld_inspect ran"

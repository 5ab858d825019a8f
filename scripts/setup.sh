#!/usr/bin/env bash
# Installs the Debian packages that the project needs and configures the build. Safe to run twice.
#   scripts/setup.sh             what the programs and tests need
#   scripts/setup.sh --dev       also the tools of scripts/check.sh, scripts/fuzz.sh and scripts/test_debian13.sh
#   scripts/setup.sh --no-tests  configure without the tests
set -euo pipefail
cd "$(dirname "$0")/.."

packages=(
  build-essential cmake ninja-build ccache mold
  libtorch-dev
  libopenblas0-openmp        # with the reference BLAS everything is 40 times slower
  libopenblas-openmp-dev     # or others would bring the one with threads of its own, which fights with OpenMP's
  libopenexr-dev libdeflate-dev libpng-dev libopenimageio-dev openimageio-tools
  libyaml-cpp-dev nlohmann-json3-dev libcli11-dev libspdlog-dev libxxhash-dev
  libembree-dev libassimp-dev
  libhdf5-dev                # optional: without it ld_import reads and writes no HDF5
  libhwy-dev
  libgloo-dev                # headers of what LibTorch sends gradients with
  libonnx-dev libprotobuf-dev
)
test_packages=(
  libgtest-dev
  assimp-testmodels          # scenes that the tests read
  python3-skimage            # computes SSIM and PSNR once more
  chromium chromium-driver python3-selenium  # open the report
  ffmpeg                     # writes films
)
tests=ON
for argument in "$@"; do
  case "$argument" in
    --dev) packages+=(clang clang-format clang-tidy clang-tools debootstrap git libclang-rt-dev libomp-dev) ;;
    --no-tests) tests=OFF ;;
    *) echo "setup.sh: unknown option '$argument'; expected --dev or --no-tests" >&2; exit 2 ;;
  esac
done
[ $tests = OFF ] || packages+=("${test_packages[@]}")

. scripts/packages.sh
install_missing setup "${packages[@]}"
echo "setup: all ${#packages[@]} packages are installed"

blas=$(readlink -f /usr/lib/*/libblas.so.3 | head -n 1)
case "$blas" in
  *openblas-openmp*) echo "setup: BLAS is $blas" ;;
  *) echo "setup: warning: BLAS is $blas; OpenBLAS with OpenMP is up to 40 times faster: update-alternatives --config libblas.so.3-$(gcc -dumpmachine)" >&2 ;;
esac

cmake --preset release -DLD_BUILD_TESTS="$tests" > build-configure.log 2>&1 || {
  tail -n 30 build-configure.log >&2
  echo "setup.sh: configuring failed; the whole log is build-configure.log" >&2
  exit 1
}
echo "setup: configured build/ (tests $tests)"

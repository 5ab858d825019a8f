#!/usr/bin/env bash
# Builds against a LibTorch that is not Debian's, PyPI's current one (scripts/peers/torch.sh), into build-pypi/, as a user does who brings a
# LibTorch of his own. Runs the tests of operators, networks, training and inference there. All else is Debian's, as ever.
#   scripts/test_pypi_torch.sh
#   scripts/test_pypi_torch.sh TARGET...   only these, tests or programs
# Takes half an hour on two cores the first time. JOBS=N sets how many compilers run at once (default: the CPUs).
set -euo pipefail
cd "$(dirname "$0")/.."
targets=("$@")
[ $# -gt 0 ] || targets=(ld_train ld_denoise test_ops test_memory_pool test_runtime test_losses test_models test_dataset test_training test_distributed
  test_two_processes test_inference test_export)

scripts/setup.sh
scripts/peers/torch.sh
torch=$(out/peers/torch/bin/python -W ignore -c 'import torch; print(torch.utils.cmake_prefix_path)')
cmake -S . -B build-pypi -G Ninja -DCMAKE_BUILD_TYPE=Release -DCMAKE_PREFIX_PATH="$torch" > build-pypi.log 2>&1 || {
  tail -n 30 build-pypi.log >&2
  echo "test_pypi_torch.sh: configuring failed; the whole log is build-pypi.log" >&2
  exit 1
}
cmake --build build-pypi --parallel "${JOBS:-$(nproc)}" --target "${targets[@]}"

export OMP_WAIT_POLICY=passive
for target in "${targets[@]}"; do
  program=build-pypi/bin/$target
  [ -x "$program" ] || program=build-pypi/tests/$target
  linked=$(ldd "$program" | grep libtorch_cpu || true) # some tests only start programs
  [[ -z $linked || $linked == *"$PWD/out/peers/torch/"* ]] || { echo "test_pypi_torch.sh: $program is linked to another LibTorch: $linked" >&2; exit 1; }
  [[ $target == test_* ]] || continue
  "$program" --gtest_brief=1 > "$program.log" 2>&1 || { cat "$program.log" >&2; echo "test_pypi_torch.sh: $target failed" >&2; exit 1; }
  echo "$target: $(grep -a 'PASSED' "$program.log")"
done
echo "test_pypi_torch: ${targets[*]} passed with $(out/peers/torch/bin/python -W ignore -c 'import torch; print("LibTorch", torch.__version__)')"

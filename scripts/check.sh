#!/usr/bin/env bash
# Format (clang-format) and lint (clang-tidy) of every tracked C++ file; exit code 1 when something was found.
#   scripts/check.sh          everything; the first time long, then only what changed
#   scripts/check.sh --fast   lint only the files without LibTorch, whose headers alone take half a minute
#   scripts/check.sh PATH...  lint only the files below these; with or without --fast
# JOBS=N sets the number of parallel clang-tidy processes (default: the CPUs).
set -euo pipefail
cd "$(dirname "$0")/.."

for argument in "$@"; do
  [[ "$argument" == --fast || -e "$argument" ]] ||
    { echo "check.sh: '$argument' is neither --fast nor a path" >&2; exit 2; }
done
for tool in clang-format clang-tidy; do
  command -v "$tool" > /dev/null || { echo "check.sh: no $tool; run scripts/setup.sh --dev" >&2; exit 1; }
done

# Versions of clang-format disagree about details; Debian 12's counts where there is a choice.
formatter=$(command -v clang-format-14 || command -v clang-format)
git ls-files -z -- '*.h' '*.cpp' | xargs -0 "$formatter" --dry-run -Werror
echo "check: $(git ls-files -- '*.h' '*.cpp' | wc -l) files are formatted"

# A compile database of its own, only configured: clang reads neither GCC's precompiled headers nor the options that come
# with them.
cmake -S . -B build-tidy -G Ninja -DCMAKE_BUILD_TYPE=Release -DLD_BUILD_TESTS=ON -DCMAKE_DISABLE_PRECOMPILE_HEADERS=ON \
  -DLD_CCACHE=OFF -DLD_UNITY_BATCH=0 > build-tidy.log 2>&1 || { cat build-tidy.log >&2; exit 1; }
cmake --build build-tidy --target src/evaluation/report_assets.cpp > /dev/null  # made, and read with the others
scripts/lint.py build-tidy --jobs "${JOBS:-$(nproc)}" "$@"

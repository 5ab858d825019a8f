#!/usr/bin/env bash
# Format (clang-format) and lint (clang-tidy) of every tracked C++ file; fails on the first kind of finding.
#   scripts/check.sh          everything
#   scripts/check.sh --fast   lint only the files without LibTorch, whose headers take half a minute each
# JOBS=N sets the number of parallel clang-tidy processes (default: the CPUs).
set -euo pipefail
cd "$(dirname "$0")/.."

fast=0
case "${1:-}" in
  "") ;;
  --fast) fast=1 ;;
  *) echo "check: unknown option '$1'; expected nothing or --fast" >&2; exit 2 ;;
esac
# Versions of clang-format disagree about details: Debian 12's is the one that counts, where there is a choice.
formatter=$(command -v clang-format-14 || command -v clang-format) ||
  { echo "check: no clang-format; run scripts/setup.sh" >&2; exit 1; }
command -v run-clang-tidy > /dev/null || { echo "check: no clang-tidy; run scripts/setup.sh" >&2; exit 1; }

git ls-files -z -- '*.h' '*.cpp' | xargs -0 "$formatter" --dry-run -Werror
echo "check: $(git ls-files -- '*.h' '*.cpp' | wc -l) files are formatted"

# A compile database of its own, only configured: clang reads neither GCC's precompiled headers nor the options that come
# with them, and needs no compiler launcher.
cmake -S . -B build-tidy -G Ninja -DCMAKE_BUILD_TYPE=Release -DCMAKE_DISABLE_PRECOMPILE_HEADERS=ON -DLD_CCACHE=OFF \
  > build-tidy.log 2>&1 || { cat build-tidy.log >&2; exit 1; }
mv build-tidy.log build-tidy/configure.log

# Of the database, the tracked files; with --fast, those whose command names no folder of LibTorch.
mkdir -p build-tidy/selected
FAST=$fast python3 - << 'PYTHON'
import json, os, subprocess
tracked = {os.path.abspath(f) for f in subprocess.check_output(["git", "ls-files"], text=True).split("\n") if f}
database = [entry for entry in json.load(open("build-tidy/compile_commands.json"))
            if entry["file"] in tracked and not (os.environ["FAST"] == "1" and "torch/csrc" in entry["command"])]
json.dump(database, open("build-tidy/selected/compile_commands.json", "w"), indent=1)
print(f"check: clang-tidy reads {len(database)} files")
PYTHON
run-clang-tidy -quiet -j "${JOBS:-$(nproc)}" -p build-tidy/selected > build-tidy/findings.log 2>&1 || {
  grep -E -A4 "(error|warning):" build-tidy/findings.log >&2 || cat build-tidy/findings.log >&2
  echo "check: clang-tidy found the above; all of it in build-tidy/findings.log" >&2
  exit 1
}
echo "check: clang-tidy found nothing"

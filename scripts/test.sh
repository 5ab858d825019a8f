#!/usr/bin/env bash
# Installs what is missing, builds everything and runs the tests. The last lines are ctest's own count.
set -euo pipefail
cd "$(dirname "$0")/.."
scripts/setup.sh
SECONDS=0
cmake --build --preset release
echo "test: built in ${SECONDS} s"
ctest --preset release --output-on-failure

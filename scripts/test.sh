#!/usr/bin/env bash
# Installs what is missing, builds everything and runs the tests. The last lines are ctest's own count, of suites, and
# the count of the cases in them.
set -euo pipefail
cd "$(dirname "$0")/.."
scripts/setup.sh
SECONDS=0
cmake --build --preset release
echo "test: built in ${SECONDS} s"
failed=0
ctest --preset release --output-on-failure || failed=$?
cases() { grep -c "^\[ *$1 *\] [A-Za-z0-9_/]*\.[A-Za-z0-9_/]* (" build/Testing/Temporary/LastTest.log || true; }
echo "test: $(cases OK) cases passed, $(cases FAILED) failed, $(cases SKIPPED) skipped"
# A case that is skipped says why in the line behind the one that names its place.
awk '/^\/.*: Skipped$/ { getline; print "test: skipped, because " $0 }' build/Testing/Temporary/LastTest.log
exit $failed

#!/usr/bin/env bash
# The tests under sanitizers, which find what the tests do not look at:
#
#   scripts/sanitize.sh address [REGEX]   addresses and undefined behaviour: every test (or the suites that fit REGEX), in
#                                         build-asan-ubsan/
#   scripts/sanitize.sh thread            races in threads of our own: log, prefetching, the cache of frames, the embedded
#                                         library, in build-tsan/
#
# The exit code is 1 when something was found. Suppressed is what other libraries do: scripts/sanitizers/*.supp name each.
set -euo pipefail
cd "$(dirname "$0")/.."
kind=${1:-}
suppressions=$PWD/scripts/sanitizers
SECONDS=0
case "$kind" in
  address)
    cmake --preset asan-ubsan > build-asan.log
    cmake --build --preset asan-ubsan
    echo "sanitize: built in $SECONDS s"
    LSAN_OPTIONS=suppressions=$suppressions/leak.supp:print_suppressions=0 ctest --preset asan-ubsan ${2:+-R "$2"}
    ;;
  thread)
    cmake -S . -B build-tsan -G Ninja -DCMAKE_BUILD_TYPE=RelWithDebInfo -DCMAKE_CXX_FLAGS_RELWITHDEBINFO="-O1 -g1" -DLD_SANITIZE=thread > build-tsan.log
    cmake --build build-tsan --target test_core test_frame_store test_embed
    echo "sanitize: built in $SECONDS s"
    # OpenMP's own threads synchronise in ways that the sanitizer cannot see, so it gets none.
    export TSAN_OPTIONS="suppressions=$suppressions/thread.supp halt_on_error=0" OMP_NUM_THREADS=1
    build-tsan/tests/test_core --gtest_filter='Threads.*:*Log*:FileIo.*:Progress*'
    build-tsan/tests/test_frame_store
    build-tsan/tests/test_embed
    ;;
  *)
    echo "sanitize.sh: '$kind'; expected address or thread" >&2
    exit 2
    ;;
esac
echo "sanitize: $kind: nothing found, $SECONDS s in all"

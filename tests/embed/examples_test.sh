#!/usr/bin/env bash
# Installs the library from BUILD into a folder of its own, builds SOURCE/examples with find_package against that copy, and runs them:
#   examples_test.sh BUILD SOURCE
set -euo pipefail
build=$1 source=$2
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT

cmake --install "$build" --prefix "$work/prefix" --component library > "$work/log"
cp -r "$source/examples" "$work/examples"  # nothing of the project beside them
cmake -S "$work/examples" -B "$work/build" -DCMAKE_PREFIX_PATH="$work/prefix" -DCMAKE_BUILD_TYPE=Release \
  -DCMAKE_C_FLAGS="-Wall -Wextra -Werror" -DCMAKE_CXX_FLAGS="-Wall -Wextra -Werror" >> "$work/log"
cmake --build "$work/build" >> "$work/log" || { cat "$work/log"; exit 1; }
if ldd "$work/build/denoise_c" | grep -q "$build"; then
  echo "denoise_c uses the library of the build folder, not the installed one"
  exit 1
fi

weights=$source/tests/fixtures/before_simd/layer.safetensors
"$work/build/denoise_c" "$weights" "$work/picture.pfm"
"$work/build/denoise_cpp" "$weights"
[ "$(stat -c %s "$work/picture.pfm")" -gt $((96 * 64 * 12)) ]

# Errors of the library reach the user as one line.
if "$work/build/denoise_cpp" "$work/nothing.safetensors" 2> "$work/error"; then
  echo "a missing weight file was accepted"
  exit 1
fi
[ "$(wc -l < "$work/error")" -eq 1 ] && grep -q nothing.safetensors "$work/error"

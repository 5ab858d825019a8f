#!/usr/bin/env bash
# Coverage-guided fuzzing of what reads files (tests/fuzz), with address and undefined-behaviour sanitizers:
#
#   scripts/fuzz.sh [MINUTES] [TARGET...]
#
# MINUTES for each target (default 20); TARGET: exr, mapping, manifest, config, state, weights, gltf, hdf5 (default: all). Builds in build-fuzz/ with clang
# (scripts/setup.sh --dev installs it). Seeds are the fixtures of the tests and small files that the programs of build/bin make; what was found to
# reach further stays in out/fuzz/TARGET/. An input that ends a target is left in out/fuzz/TARGET.crash-*, and the exit code is 1.
set -euo pipefail
cd "$(dirname "$0")/.."
minutes=${1:-20}
shift || true
targets=("$@")
[ ${#targets[@]} -gt 0 ] || targets=(exr mapping manifest config state weights gltf hdf5)
clang=$(command -v clang++ || command -v clang++-14) || { echo "fuzz.sh: found no clang++; run scripts/setup.sh --dev" >&2; exit 1; }
cmake -S . -B build-fuzz -G Ninja -DCMAKE_BUILD_TYPE=RelWithDebInfo -DCMAKE_CXX_COMPILER="$clang" -DLD_FUZZ=ON -DLD_BUILD_TESTS=OFF > build-fuzz.log
cmake --build build-fuzz --target "${targets[@]/#/fuzz_}"

seeds() { # TARGET
  case "$1" in
    exr) find tests/fixtures -name '*.exr' -size -40k ;;
    mapping) find data/import tests/fixtures -name '*.yaml' ;;
    manifest) find tests/fixtures out -maxdepth 3 -name manifest.json -size -40k 2> /dev/null | head -5 ;;
    config) find configs data/recipes -name '*.yaml' ;;
    state) find tests/fixtures out -maxdepth 5 -name state.json 2> /dev/null | head -5 ;;
    gltf) find /usr/share/assimp/models/glTF* tests/fixtures \( -name '*.gltf' -o -name '*.glb' \) -size -40k ;;
    weights) find out/fuzz_seeds -name '*.safetensors' ;;
    hdf5) find tests/fixtures out/fuzz_seeds -name '*.h5' -not -name fault.h5 ;;
  esac
}

mkdir -p out/fuzz_seeds
cat > out/fuzz_seeds/tiny.yaml << 'END'
seed: 1
network: {name: layer, features: [radiance], kernel_size: 1, sample_reducer: [1], sample_partitioner: [], kernel_generator: [], unet: {encoder: [[1]], bottleneck: [1], decoder: [[1]], context: 1}}
END
build/bin/ld_export --untrained out/fuzz_seeds/tiny.yaml --format safetensors --out out/fuzz_seeds/tiny.safetensors > /dev/null
if [ ! -e out/fuzz_seeds/tiny.h5 ]; then
  build/bin/ld_render --recipe data/recipes/quick.yaml --out out/fuzz_seeds/data "resolution=[6, 5]" spp=2 frames.train=1 \
    frames.validation=0 frames.test=0 reference_spp.train=2 2> /dev/null
  build/bin/ld_import --out out/fuzz_seeds/data --split train --to-hdf5 out/fuzz_seeds/tiny.h5 --reference out/fuzz_seeds/tiny_reference.h5 2> /dev/null
fi

# Whose fault an input shows is told by the first function of HDF5 or of ours in its stack.
sort_faults_of_hdf5() {
  local input said
  for input in out/fuzz/hdf5.{crash,oom,timeout}-*; do
    [ -e "$input" ] || continue
    said=$(build-fuzz/bin/fuzz_hdf5 "${options[@]:0:3}" "$input" 2>&1) && continue  # mended since
    if awk '!seen && /^ *#[0-9]+ / && (/libhdf5/ || / ld::/) {seen = 1; theirs = /libhdf5/} END {exit !theirs}' <<< "$said"; then
      echo "a fault of the HDF5 library: $input"
    else
      echo "a fault of ours: $input"
      failed=1
    fi
  done
}

failed=0
for target in "${targets[@]}"; do
  mkdir -p "out/fuzz/$target"
  for seed in $(seeds "$target"); do cp "$seed" "out/fuzz/$target/seed_$(sha1sum < "$seed" | cut -c1-12)"; done
  echo "== $target: $(find "out/fuzz/$target" -type f | wc -l) inputs, $minutes minutes"
  # Assimp, which glTF goes through, and HDF5 forget some of what they have read of a damaged file. HDF5 also faults, which ld_import
  # survives (core/process/child_process.h): the fuzzer goes on after each fault, and below only those count that are not the library's.
  # HDF5 asks for as much memory as such a file says, and does without.
  leaks=$([ "$target" = gltf ] || [ "$target" = hdf5 ] && echo 0 || echo 1)
  export ASAN_OPTIONS=allocator_may_return_null=1:detect_leaks=$leaks
  options=(-detect_leaks="$leaks" -timeout=25 -rss_limit_mb=3000)
  if [ "$target" = hdf5 ]; then options+=(-fork=1 -ignore_crashes=1); fi
  build-fuzz/bin/fuzz_"$target" "${options[@]}" -max_total_time=$((minutes * 60)) -max_len=60000 -print_final_stats=1 \
    -artifact_prefix="out/fuzz/$target." "out/fuzz/$target" > "out/fuzz/$target.log" 2>&1 || [ "$target" = hdf5 ] || failed=1
  if [ "$target" = hdf5 ]; then sort_faults_of_hdf5; fi
  grep -E "^stat::number_of_executed|ERROR|SUMMARY" "out/fuzz/$target.log" || true
  grep -E "cov: [0-9]+" "out/fuzz/$target.log" | tail -1 | sed -E 's/.*(cov: [0-9]+).*/\1/'
  rm -rf /dev/shm/ld_fuzz_*
done
exit $failed

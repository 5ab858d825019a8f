#!/usr/bin/env bash
# Whether ld_tune finds what a scene requires (docs/tuning.md), on three data sets of 56 frames: without defocus and motion, with all of it, and views of
# one glTF model. Each by scripts/tuning_study.sh; then what was found for the one model beside the released networks, on views that nobody saw.
#   scripts/tuning_proof.sh [OUT [MINUTES]]     (default: out/tuning_proof, 10 minutes of searching and 30 of the exhaustive search each)
# What is finished is kept. Needs Debian's assimp-testmodels and the programs in build/bin/. Environment: BIN, THREADS (default: all), SHARE (of
# common_fine's time that a frame may take on the first two, default 1), PART (on the third, default 0.2).
set -euo pipefail
cd "$(dirname "$0")/.."
out=${1:-out/tuning_proof} minutes=${2:-10} bin=${BIN:-build/bin}
general=(--model common_fine=models/pretrained/common_fine.safetensors --model common_fast=models/pretrained/common_fast.safetensors)
mkdir -p "$out"

declare -A scene=([plain]="scenes.defocus=0 scenes.motion_blur=0" [all]="" [gltf]="scene_file.path=/usr/share/assimp/models/glTF2/2CylinderEngine-glTF-Binary/2CylinderEngine.glb")
tradeoff() { # NAME SPLIT MODELS...: into OUT/NAME/SPLIT.json
  "$bin/ld_bench" tradeoff --threads "${THREADS:-$(nproc)}" --data "$out/$1/data" --split "$2" "${@:3}" --repeats 5 --json "$out/$1/$2.json" > "$out/$1/$2.txt"
}
for name in plain all gltf; do
  mkdir -p "$out/$name"
  # shellcheck disable=SC2086  # words for ld_render
  "$bin/ld_render" --recipe data/recipes/quick.yaml --out "$out/$name/data" frames.train=40 frames.validation=8 frames.test=8 ${scene[$name]} > "$out/$name/render.log" 2>&1 ||
    { tail -n 3 "$out/$name/render.log" >&2; exit 1; }
  [ -e "$out/$name/validation.json" ] || tradeoff "$name" validation "${general[@]}"
  budget=$(python3 -c 'import json, sys
[ms] = [p["ms"] for p in json.load(open(sys.argv[1]))["points"] if p["name"] == "common_fine"]
print(round(ms * float(sys.argv[2]), 1))' "$out/$name/validation.json" "$([ "$name" = gltf ] && echo "${PART:-0.2}" || echo "${SHARE:-1}")")
  [ -e "$out/$name/found" ] || {
    scripts/tuning_study.sh "$out/$name/data" "$out/$name/study" "$minutes" "$budget" 128x128 > "$out/$name/study.log" 2>&1 || { tail -n 5 "$out/$name/study.log" >&2; exit 1; }
    echo "$name, within $budget ms: $(tail -n 1 "$out/$name/study.log")" > "$out/$name/found"
  }
  cat "$out/$name/found"
  tradeoff "$name" test "${general[@]}" --model "tuned=$out/$name/study/tuned.safetensors"
  sed -n '1,/^$/p' "$out/$name/test.txt"
done

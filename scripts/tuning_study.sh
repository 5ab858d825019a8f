#!/usr/bin/env bash
# Whether ld_tune finds what an exhaustive search over the same grid finds, at a third of its time:
#   scripts/tuning_study.sh DATA OUT MINUTES BUDGET_MS WIDTHxHEIGHT [key.sub=value ...]
# ld_tune searches for MINUTES. Then each candidate that it admitted trains by itself for an equal share of
# 3 MINUTES, with all features, and the errors on the validation split are compared. Environment: BIN, THREADS (default: all).
set -euo pipefail
cd "$(dirname "$0")/.."
[ $# -ge 5 ] || { sed -n '2,5s/^# //p' "$0" >&2; exit 2; }
data=$1 out=$2 minutes=$3 budget=$4 size=$5
bin=${BIN:-build/bin} threads=${THREADS:-$(nproc)}
mkdir -p "$out"
"$bin/ld_tune" --threads "$threads" --data "$data" --budget-ms "$budget" --at "$size" --minutes "$minutes" --out "$out/tuned.safetensors" "${@:6}"

mapfile -t grid < <(ls "$out"/tuned.safetensors.tune/trials/*_rung0.yaml)
share=$(python3 -c "print(3 * $minutes / ${#grid[@]})")
models=()
for config in "${grid[@]}"; do
  name=$(basename "$config" _rung0.yaml)
  "$bin/ld_train" --threads "$threads" --config "$config" run.minutes="$share" --out "$out/$name"
  models+=(--model "$name=$out/$name")
done
samples=$(python3 -c "import json; print(json.load(open('$out/tuned.safetensors.tune/table.json'))['spp'])")
"$bin/ld_eval" --threads "$threads" --data "$data" --split validation --samples "$samples" --report-frames 0 \
  --model "tuned=$out/tuned.safetensors" "${models[@]}" --out "$out/eval" --json "$out/eval.json"
python3 - "$out/eval/comparison.csv" "$out/eval/metrics.csv" <<'PY'
import csv, sys
rows = [row for row in csv.DictReader(open(sys.argv[2])) if row["frame"] == "mean" and row["method"] not in ("noisy", "blur")]
errors = {row["method"]: float(row["smape"]) for row in rows}
tuned = errors.pop("tuned")
best = min(errors, key=errors.get)
print(f"tuned {tuned:.5f}; best of {len(errors)} by exhaustive search, {best}: {errors[best]:.5f}; {100 * (tuned / errors[best] - 1):+.1f} %")
PY

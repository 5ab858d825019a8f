#!/usr/bin/env bash
# One network for 1 to 16 samples a pixel against networks each trained for one number of samples alone, all for the same number of steps:
#
#   scripts/sample_counts.sh DATA OUT
#
# DATA is a data set of at least 16 samples a pixel with a validation split (data/recipes/release.yaml). OUT receives runs/, one folder of
# ld_eval for each number of samples, and sample_counts.md. Safe to interrupt and run again. Environment:
#   STEPS    of each training (default 2000)
#   CONFIG   default configs/common_fast.yaml
#   SAMPLES  default "1 2 4 8 16"
#   JOBS     trainings at a time, one thread each (default 1)
#   BIN      default build/bin
. "$(dirname "$0")/studies.sh"
steps=${STEPS:-2000} config=${CONFIG:-configs/common_fast.yaml}
counts=${SAMPLES:-1 2 4 8 16}

train_for() { # NAME LEAST MOST VALIDATION
  train "$1" --config "$config" "data.path=$data" "data.samples=[$2, $3]" "data.validation_samples=$4" "steps=$steps"
}

least=${counts%% *} most=${counts##* }
train_for any "$least" "$most" 8
for n in $counts; do
  train_for "only_$n" "$n" "$n" "$n"
done
wait_for_trainings
for n in $counts; do
  "$bin/ld_eval" --data "$data" --split validation --samples "$n" --model "any=$out/runs/any" --model "only=$out/runs/only_$n" --threads 1 \
    --baseline only --out "$out/$n" > "$out/$n.log"
done
python3 - "$out" "$counts" << 'END' | tee "$out/sample_counts.md"
import json, pathlib, sys
out, counts = pathlib.Path(sys.argv[1]), sys.argv[2].split()
print("| samples a pixel | noisy | one network for all | one for this number | ratio |")
print("| ---: | ---: | ---: | ---: | ---: |")
for n in counts:
    methods = json.loads((out / n / "metrics.json").read_text(encoding="utf-8"))["methods"]
    noisy, any_, only = (methods[name]["mean"]["smape"] for name in ("noisy", "any", "only"))
    print(f"| {n} | {noisy:.4f} | {any_:.4f} | {only:.4f} | {any_ / only:.3f} |")
END

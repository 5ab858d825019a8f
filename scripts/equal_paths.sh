#!/usr/bin/env bash
# What a budget of paths should buy: converged references of few scenes or noisy ones of many. Renders training sets that cost the same,
# trains on each with two losses for the same number of steps, and scores all on frames that none of them saw:
#
#   scripts/equal_paths.sh DATA OUT
#
# DATA is a data set with a test split for the scores (scripts/quickstart.sh renders one); OUT receives the sets, runs/ and equal_paths.md.
# Every training runs to its end, whatever becomes of it. The scenes are those of data/recipes/quick.yaml with another seed, 64x64 pixels, 8 samples and the reference's a pixel. Safe to interrupt
# and run again. Environment:
#   BUDGETS     in frames of 4096-sample references (default "1 2 4")
#   REFERENCES  samples of the references (default "16 128 4096")
#   LOSSES      default "smape relative_l2"
#   STEPS       of each training, one crop each, because the smallest set has one frame (default 2400)
#   JOBS        trainings at a time, one thread each (default 1)
#   BIN         default build/bin
. "$(dirname "$0")/studies.sh"
steps=${STEPS:-2400}
budgets=${BUDGETS:-1 2 4} references=${REFERENCES:-16 128 4096} losses=${LOSSES:-smape relative_l2}
frames() { echo $(($1 * (8 + 4096) / (8 + $2))); } # BUDGET REFERENCE

for reference in $references; do
  "$bin/ld_render" --recipe data/recipes/quick.yaml --out "$out/paths_$reference" --threads "$jobs" seed=5 "resolution=[64, 64]" \
    "reference_spp.train=$reference" "frames.train=$(frames "${budgets##* }" "$reference")" frames.validation=0 frames.test=0
  for budget in $budgets; do # the first frames of the largest set
    python3 - "$out/paths_$reference" "$out/paths_${reference}_$budget" "$(frames "$budget" "$reference")" << 'END'
import json, os, pathlib, sys
whole, part, count = pathlib.Path(sys.argv[1]).resolve(), pathlib.Path(sys.argv[2]), int(sys.argv[3])
manifest = json.loads((whole / "manifest.json").read_text(encoding="utf-8"))
manifest["frames"] = manifest["frames"][:count]
part.mkdir(exist_ok=True)
for frame in manifest["frames"]:
    for file in (f"{frame['name']}.exr", f"{frame['name']}.reference.exr"):
        if not (part / file).is_symlink():
            os.symlink(whole / file, part / file)
(part / "manifest.json").write_text(json.dumps(manifest), encoding="utf-8")
END
  done
done

models=()
for reference in $references; do
  for budget in $budgets; do
    for loss in $losses; do
      train "${reference}_${budget}_$loss" --config configs/quick.yaml "data.path=$out/paths_${reference}_$budget" data.batch=1 "loss=$loss" "steps=$steps" watch.enabled=false
      models+=(--model "${reference}_${budget}_$loss=$out/runs/${reference}_${budget}_$loss")
    done
  done
done
wait_for_trainings
"$bin/ld_eval" --data "$data" --split test "${models[@]}" --threads 1 --out "$out/eval" > "$out/eval.log"
python3 - "$out" "$budgets" "$references" "$losses" << 'END' | tee "$out/equal_paths.md"
import json, pathlib, sys
out, (budgets, references, losses) = pathlib.Path(sys.argv[1]), (words.split() for words in sys.argv[2:])
methods = json.loads((out / "eval/metrics.json").read_text(encoding="utf-8"))["methods"]
print("| budget | references of | frames | " + " | ".join(f"{loss}: SMAPE | relMSE" for loss in losses) + " |")
print("| ---: | ---: | ---: |" + " ---: | ---: |" * len(losses))
for budget in budgets:
    for reference in references:
        count = int(budget) * (8 + 4096) // (8 + int(reference))
        means = [methods[f"{reference}_{budget}_{loss}"]["mean"] for loss in losses]
        print(f"| {budget} | {reference} samples | {count} | " + " | ".join(f"{m['smape']:.4f} | {m['relmse']:.4f}" for m in means) + " |")
END

#!/usr/bin/env bash
# What the recurrence and the temporal loss of the recurrent autoencoder (docs/networks.md) are worth: the same training with both, without the
# one and without the other.
#   scripts/recurrent_study.sh DATA OUT      DATA is data/recipes/sequence_quick.yaml, rendered
# Prints a table over the test sequences at one sample a pixel and writes it to OUT/table.md. Environment: CONFIG (default
# configs/quick_recurrent.yaml), SET (further settings, "key.sub=value ..."), TEST (a data set whose test split is taken, default DATA), BIN, JOBS.
. "$(dirname "$0")/studies.sh"
config=${CONFIG:-configs/quick_recurrent.yaml}
# shellcheck disable=SC2206  # words for ld_train
begin=(--config "$config" "data.path=$data" ${SET:-})
test=${TEST:-$data}
train recurrent "${begin[@]}"
train without_recurrence "${begin[@]}" network.recurrence=false
train without_temporal_loss "${begin[@]}" clip_loss.temporal=0
wait_for_trainings

models=()
for name in recurrent without_recurrence without_temporal_loss; do models+=(--model "$name=$out/runs/$name"); done
"$bin/ld_eval" --data "$test" --sequences --samples 1 "${models[@]}" --baseline recurrent --out "$out/eval" > "$out/eval.txt"
python3 - "$test" "$out/eval" <<'END' | tee "$out/table.md"
import csv, json, sys
from statistics import mean

data, folder = sys.argv[1:]
position = {f["name"]: f["position"] for f in json.load(open(f"{data}/manifest.json"))["frames"]}
rows = [row for row in csv.DictReader(open(f"{folder}/metrics.csv")) if row["frame"] in position]  # the last ones are means
sequences = [row for row in csv.DictReader(open(f"{folder}/sequences.csv")) if " + " in row["frame"]]
print("| network | PSNR | SMAPE | TE | SMAPE of the 1st frame | of the 7th | change |\n| :--- | ---: | ---: | ---: | ---: | ---: | ---: |")
for name in dict.fromkeys(row["method"] for row in rows):
    own = [row for row in rows if row["method"] == name]
    first, seventh = (mean(float(row["smape"]) for row in own if position[row["frame"]] == at) for at in (0, 6))
    psnr, smape = (mean(float(row[metric]) for row in own) for metric in ("psnr", "smape"))
    te = mean(float(row["te"]) for row in sequences if row["method"] == name)
    print(f"| {name} | {psnr:.2f} | {smape:.4f} | {te:.4f} | {first:.4f} | {seventh:.4f} | {100 * (seventh / first - 1):+.0f} % |")
END

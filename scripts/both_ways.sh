#!/usr/bin/env bash
# What ld_denoise --both-ways (docs/sequences.md) is worth to networks that remember.
#   scripts/both_ways.sh DATA OUT NAME=MODEL...      DATA is data/recipes/sequence_quick.yaml, rendered
# Denoises the test sequences at two samples a pixel forwards and both ways, prints a table and writes it to OUT/table.md.
# Environment: BIN.
set -euo pipefail
cd "$(dirname "$0")/.."
[ $# -ge 3 ] || { sed -n '2,5s/^# //p' "$0" >&2; exit 2; }
[ -e "$1/manifest.json" ] || { echo "both_ways.sh: there is no data set $1; expected a folder with manifest.json" >&2; exit 2; }
bin=${BIN:-build/bin}
data=$1 out=$2
shift 2
sequences() {  # FIRST LAST SUFFIX of the frames of each
  python3 - "$data" <<'PY'
import json, re, sys
runs = {}
for frame in json.load(open(f"{sys.argv[1]}/manifest.json"))["frames"]:
    if frame["split"] == "test" and "sequence" in frame:
        number, suffix = re.fullmatch(r"frame_(\d{6})(.*)", frame["name"]).groups()
        runs.setdefault((frame["sequence"], suffix), []).append(int(number))
for (_, suffix), numbers in runs.items():
    print(min(numbers), max(numbers) + 1, suffix)
PY
}
mkdir -p "$out"
images=()
for model in "$@"; do
  for way in forwards both_ways; do
    folder=$out/${model%%=*}_$way
    sequences | while read -r first last suffix; do
      "$bin/ld_denoise" --model "${model#*=}" "$data/frame_######$suffix.exr" --frames "$first:$last" --samples 2 --float \
        --output "$folder/frame_######$suffix.exr" $([ $way = forwards ] || echo --both-ways) > "$out/denoise.log" 2>&1 < /dev/null ||
        { cat "$out/denoise.log"; exit 1; }
    done
    images+=(--images "${model%%=*}_$way=$folder")
  done
done
"$bin/ld_eval" --data "$data" --sequences --samples 2 --report-frames 0 "${images[@]}" --out "$out/eval" > "$out/eval.txt" 2>&1
python3 - "$data" "$out/eval" <<'PY' | tee "$out/table.md"
import csv, json, sys
from statistics import mean

data, folder = sys.argv[1:]
position = {f["name"]: f["position"] for f in json.load(open(f"{data}/manifest.json"))["frames"]}
rows = [row for row in csv.DictReader(open(f"{folder}/metrics.csv")) if row["frame"] in position]  # the last ones are means
sequences = [row for row in csv.DictReader(open(f"{folder}/sequences.csv")) if " + " in row["frame"]]
print("| network | PSNR | of first frames | of second frames | SMAPE | TE | better in | TE better in |")
print("| :--- | ---: | ---: | ---: | ---: | ---: | ---: | ---: |")
for name in dict.fromkeys(row["method"] for row in rows):
    own = [row for row in rows if row["method"] == name]
    psnr, first, second = (mean(float(row["psnr"]) for row in own if at(position[row["frame"]]))
                           for at in (lambda p: True, lambda p: p == 0, lambda p: p == 1))
    smape = mean(float(row["smape"]) for row in own)
    own, other = ({row["frame"]: row for row in sequences if row["method"] == method}
                  for method in (name, name.replace("_both_ways", "_forwards")))
    wins = [""] * 2
    if name.endswith("_both_ways"):
        wins = [f"{sum(float(own[f]['psnr']) > float(other[f]['psnr']) for f in own)} of {len(own)}",
                f"{sum(float(own[f]['te']) < float(other[f]['te']) for f in own)} of {len(own)}"]
    te = mean(float(row["te"]) for row in own.values())
    print(f"| {name} | {psnr:.2f} | {first:.2f} | {second:.2f} | {smape:.4f} | {te:.4f} | {wins[0]} | {wins[1]} |")
PY

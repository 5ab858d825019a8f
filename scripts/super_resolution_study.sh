#!/usr/bin/env bash
# The four ways to train the two stages of espcn_kpcn (docs/training.md), what the first stage makes of light alone and of guides alone, and
# both without demodulation, as published: each trained for as many steps, one thread each.
#   scripts/super_resolution_study.sh DATA OUT     DATA is rendered with half_radiance=true filter_guides=true
# Prints a table over the test frames, with the mean of more samples and common_fast beside it, and writes it to OUT/table.md. Environment: STEPS
# (of a training, default 1000), CONFIG (default configs/espcn_kpcn.yaml), CROP (default 64), BIN, JOBS.
. "$(dirname "$0")/studies.sh"
begin=(--config "${CONFIG:-configs/espcn_kpcn.yaml}" "data.path=$data" "data.crop=${CROP:-64}" "steps=${STEPS:-1000}")
for scheme in end_to_end two_heads concurrent separate; do train "$scheme" "${begin[@]}" "optimizer.scheme=$scheme"; done
for reads in light guides; do train "$reads" "${begin[@]}" optimizer.scheme=two_heads "network.super_resolution.reads=$reads"; done
train plain "${begin[@]}" network.demodulation=none
wait_for_trainings

models=()
for name in end_to_end two_heads concurrent separate light guides plain; do models+=(--model "$name=$out/runs/$name"); done
evaluate() { # SAMPLES MODELS...
  "$bin/ld_eval" --data "$data" --samples "$1" "${@:2}" --baseline noisy --out "$out/eval_$1" > "$out/eval_$1.txt"
}
evaluate 1 "${models[@]}" --model common_fast=models/pretrained/common_fast.safetensors
for samples in 2 4 8; do evaluate "$samples"; done
python3 - "$out" <<'END' | tee "$out/table.md"
import csv, re, sys
from statistics import mean

out = sys.argv[1]

def scores(samples):
    rows = [row for row in csv.DictReader(open(f"{out}/eval_{samples}/metrics.csv")) if row["frame"].startswith("frame")]
    return {m: {k: mean(float(r[k]) for r in rows if r["method"] == m) for k in ("psnr", "smape", "ssim")} for m in dict.fromkeys(r["method"] for r in rows)}

def first_stage(name):
    try:
        found = re.findall(r"first stage: PSNR ([\d.]+) dB.*?noise\s+\D*([\d.]+) dB", open(f"{out}/runs/{name}/output").read())
    except FileNotFoundError:
        found = []
    return found[-1] if found else ("-", "-")

print("| picture | light traced | first stage, dB | its floor | PSNR | SMAPE | SSIM |\n| :--- | :--- | ---: | ---: | ---: | ---: | ---: |")
for name, score in scores(1).items():
    if name == "blur": continue
    traced = "1 spp" if name in ("noisy", "common_fast") else "1 spp at half the size"
    print(f"| {name} | {traced} | {' | '.join(first_stage(name))} | {score['psnr']:.2f} | {score['smape']:.4f} | {score['ssim']:.3f} |")
for samples in (2, 4, 8):
    score = scores(samples)["noisy"]
    print(f"| noisy | {samples} spp | - | - | {score['psnr']:.2f} | {score['smape']:.4f} | {score['ssim']:.3f} |")
END

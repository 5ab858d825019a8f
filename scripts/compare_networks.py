#!/usr/bin/env python3
"""Prints what scripts/compare_networks.sh trained as a Markdown table: compare_networks.py OUT.

A score is the mean over the seeds, +- its standard deviation over them (of the sample, n - 1). Seconds a step are the
median of the training's log; inference and memory come from ld_bench, 256x256 pixels at 8 spp.
"""
import csv
import json
import statistics
import sys
from pathlib import Path

METRICS = [("relmse", "relMSE", 4), ("smape", "SMAPE", 4), ("ssim", "SSIM", 3), ("psnr", "PSNR", 2)]


def spread(values, digits):
    """'mean +- deviation'; 'nan' where a picture had no score."""
    if any(value is None for value in values):
        return "nan"
    mean = f"{statistics.mean(values):.{digits}f}"
    return mean if len(values) < 2 else f"{mean} ± {statistics.stdev(values):.{digits}f}"


def seconds_a_step(run):
    with open(run / "metrics.csv", newline="") as file:
        return [float(row["seconds_per_step"]) for row in csv.DictReader(file) if row["seconds_per_step"]]


def steps_done(run):
    with open(run / "metrics.csv", newline="") as file:
        return max((int(row["step"]) for row in csv.DictReader(file)), default=0)


def evaluated_runs(folder):
    return sorted(path.parent for path in folder.glob("seed*/eval.json"))


def network_row(out, network, loss, runs):
    scores = [json.loads((run / "eval.json").read_text())["methods"][network]["mean"] for run in runs]
    cost = json.loads((out / "cost" / f"{network}.json").read_text())[0]
    times = [seconds for run in runs for seconds in seconds_a_step(run)]
    return ([network, loss, str(len(runs))]
            + [spread([score[name] for score in scores], digits) for name, _, digits in METRICS]
            + [f"{cost['parameters'] / 1e3:.0f} k", f"{cost['multiply_adds_per_pixel'] / 1e3:.1f} k",
               f"{statistics.median(times):.3f}" if times else "-", f"{cost['inference_ms']:.0f}",
               f"{cost['inference_peak_mb']:.0f}", f"{cost['training_peak_mb']:.0f}"])


def baseline_rows(runs, columns):
    """The noisy picture and the best blur: the same in every run."""
    methods = json.loads((runs[0] / "eval.json").read_text())["methods"]
    for name in ("noisy", "blur"):
        mean = methods[name]["mean"]
        cells = [name, "-", "-"] + [f"{mean[key]:.{digits}f}" for key, _, digits in METRICS]
        yield cells + ["-"] * (columns - len(cells))


def print_table(rows):
    widths = [max(len(row[c]) for row in rows) for c in range(len(rows[0]))]
    rule = ["-" * width for width in widths]
    for row in [rows[0], rule] + rows[1:]:
        print("| " + " | ".join(cell.ljust(width) for cell, width in zip(row, widths)) + " |")


def main():
    if len(sys.argv) != 2:
        sys.exit("usage: compare_networks.py OUT")
    out = Path(sys.argv[1])
    headings = (["network", "loss", "seeds"] + [title for _, title, _ in METRICS]
                + ["parameters", "multiply-adds a pixel", "s a step", "inference, ms", "its peak MB", "training, peak MB"])
    rows, steps, some_runs = [headings], set(), None
    for folder in sorted(out.glob("runs/*/*")):
        runs = evaluated_runs(folder)
        if not runs:
            continue
        rows.append(network_row(out, folder.parent.name, folder.name, runs))
        steps.update(steps_done(run) for run in runs)
        some_runs = some_runs or runs
    if not some_runs:
        sys.exit(f"{out} holds no evaluated run; expected {out}/runs/NETWORK/LOSS/seedN/eval.json from compare_networks.sh")
    rows[1:] = sorted(rows[1:], key=lambda row: (row[1], row[0]))
    rows[1:1] = baseline_rows(some_runs, len(headings))
    print_table(rows)
    print(f"\nSteps: {', '.join(str(count) for count in sorted(steps))}.")


if __name__ == "__main__":
    main()

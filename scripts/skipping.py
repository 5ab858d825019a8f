#!/usr/bin/env python3
"""What --skip-within saves: for each frame the share of the work that is left out, the time beside that of all
work (the median of the ratios of runs in turns) and the largest difference of the pictures, |a - b| / (1 + |b|).

  scripts/skipping.py [--rounds N] [--bin FOLDER] [--model NAME] [--bounds B,...] FRAME...

Prints a Markdown table. Needs oiiotool (openimageio-tools)."""

import argparse
import json
import re
import statistics
import subprocess
import tempfile
from pathlib import Path


def denoise(options, frame, within, folder):
    """Seconds and shares of one run, and its picture."""
    picture, report = folder / f"{within}.exr", folder / "report.json"
    done = subprocess.run(
        [f"{options.bin}/ld_denoise", "--model", options.model, "--skip-within", within, "--float",
         "--json", report, "--output", picture, frame],
        capture_output=True, text=True)
    if done.returncode:
        raise SystemExit(f"skipping.py: {done.stderr.strip().splitlines()[-1]}")
    (one,) = json.loads(report.read_text())
    return one["seconds"], one["skipped"], picture


def largest_difference(a, b):
    """Of two pictures, over all channels: |a - b| / (1 + |b|)."""
    text = subprocess.run(
        ["oiiotool", a, b, "--absdiff", b, "--abs", "--addc", "1", "--div",
         "--mulc", "1e9", "--printstats"],  # statistics have six digits behind the point
        check=True, capture_output=True, text=True).stdout
    return 1e-9 * max(float(number) for number in re.search(r"Stats Max: (.*?) \(float\)", text)[1].split())


def measure(options, frame, folder):
    bounds = ["off", *options.bounds.split(",")]
    seconds = {within: [] for within in bounds}
    last = {}
    for i in range(options.rounds):
        turn = i % len(bounds)
        for within in bounds[turn:] + bounds[:turn]:
            took, skipped, picture = denoise(options, frame, within, folder)
            seconds[within].append(took)
            last[within] = skipped, picture
    for within in bounds[1:]:
        skipped, picture = last[within]
        ratio = statistics.median(a / b for a, b in zip(seconds[within], seconds["off"]))
        shares = " | ".join(f"{100 * skipped[kind]:.1f} %" for kind in ("pixels", "samples", "layers"))
        difference = largest_difference(last["off"][1], picture)
        print(f"| {frame} | {within} | {shares} | {ratio:.2f} | {difference:.1e} |", flush=True)


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("frames", nargs="+", metavar="FRAME")
    parser.add_argument("--rounds", type=int, default=5)
    parser.add_argument("--bin", default="build/bin")
    parser.add_argument("--model", default="common_fast")
    parser.add_argument("--bounds", default="0,1e-4,1e-2")
    options = parser.parse_args()
    print("| frame | bound | pixels | samples | layers | time | largest difference |")
    print("| :--- | ---: | ---: | ---: | ---: | ---: | ---: |")
    with tempfile.TemporaryDirectory() as folder:
        for frame in options.frames:
            measure(options, frame, Path(folder))


if __name__ == "__main__":
    main()

#!/usr/bin/env python3
"""One table of what `ld_eval --sequences` measured: sequences_table.py METRICS.JSON. Each cell is a mean over sequences and half the width
of its 95 % interval. For sequences_table.sh."""
import json
import sys
from pathlib import Path

COLUMNS = ("relmse", "smape", "ssim", "psnr", "te", "steadier", "ghosting", "trail", "detail")


def cell(scores, name, digits):
    mean, interval = scores["mean"].get(name), scores["interval"].get(name)
    if mean is None:
        return "-"
    if not interval or interval[0] is None:
        return f"{mean:.{digits}f}"
    return f"{mean:.{digits}f} ± {(interval[1] - interval[0]) / 2:.{digits}f}"


def main():
    metrics = json.loads(Path(sys.argv[1]).read_text())
    sequences = metrics["sequences"]
    digits = {**{name: about["digits"] for name, about in sequences["metrics"].items()}, "relmse": 2, "smape": 3, "ssim": 3, "te": 4}
    titles = [sequences["metrics"][name]["title"] for name in COLUMNS]
    print("| method | " + " | ".join(titles) + " | ms a frame |")
    print("| :--- |" + " ---: |" * (len(COLUMNS) + 1))
    for method, scores in sequences["methods"].items():
        seconds = metrics["methods"][method].get("seconds")
        row = [cell(scores, name, digits[name]) for name in COLUMNS]
        print(f"| {method} | " + " | ".join(row) + f" | {'-' if seconds is None else format(1000 * seconds, '.1f')} |")
    print(f"\n{sequences['frame_count']} sequences, {metrics['frame_count']} frames, {metrics.get('samples') or 'all'} samples a pixel.")


if __name__ == "__main__":
    main()

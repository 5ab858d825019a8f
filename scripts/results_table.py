"""The tables of scripts/results.sh.

    results_table.py OUT NAME...

Reads OUT/NAME/SAMPLES/metrics.csv and metrics.json, which ld_eval wrote. An interval is that of the ratio of two means over the frames, by
10,000 bootstrap resamples of the frames (percentiles 2.5 and 97.5, seed 1).
"""
import csv
import json
import pathlib
import random
import sys

METRICS = {"relmse": ("relMSE", 4), "smape": ("SMAPE", 4), "ssim": ("SSIM", 4), "psnr": ("PSNR", 2)}
PEER = "oidn_high"
LENS = ("defocus", "motion")  # first words of the names of frames whose lens or shutter is open
RESAMPLES = 10000


def read(folder: pathlib.Path) -> dict:
    """method -> frame -> metric -> value, methods in the order of the table."""
    scores = {}
    with open(folder / "metrics.csv", newline="", encoding="utf-8") as file:
        for row in csv.DictReader(file):
            if row["frame"] not in ("mean", "ci95_low", "ci95_high"):
                scores.setdefault(row["method"], {})[row["frame"]] = {
                    key: float(row[key]) for key in (*METRICS, "seconds") if row[key]
                }
    return scores


def mean(values) -> float:
    values = list(values)
    return sum(values) / len(values)


def ratio(ours: list, theirs: list) -> str:
    """mean(ours) / mean(theirs) and its interval."""
    stream = random.Random(1)
    found = []
    for _ in range(RESAMPLES):
        drawn = [stream.randrange(len(ours)) for _ in ours]
        found.append(sum(ours[i] for i in drawn) / sum(theirs[i] for i in drawn))
    found.sort()
    low, high = found[int(0.025 * RESAMPLES)], found[int(0.975 * RESAMPLES)]
    return f"{mean(ours) / mean(theirs):.2f} ({low:.2f} .. {high:.2f})"


def by_samples(name: str, folders: dict, metric: str) -> None:
    title, digits = METRICS[metric]
    print(f"\n{title} on {name}, by samples a pixel:\n")
    print("| method | " + " | ".join(str(n) for n in folders) + " |")
    print("| :--- |" + " ---: |" * len(folders))
    for method in next(iter(folders.values())):
        # A program that ended without its pictures (results.sh says so) has none there.
        cells = [f"{mean(f[metric] for f in scores[method].values()):.{digits}f}" if method in scores else "-"
                 for scores in folders.values()]
        print(f"| {method} | " + " | ".join(cells) + " |")


def details(name: str, scores: dict, floor: dict) -> None:
    """All metrics at one number of samples, and the ratios to the peer."""
    frames = list(scores[PEER])
    lens = [f for f in frames if f.startswith(LENS)]
    print(f"\n{name}, 8 samples a pixel, {len(frames)} frames; ratios to `{PEER}` with 95 % intervals:\n")
    columns = ["relMSE", "SMAPE", "SSIM", "PSNR", "ms", "relMSE ratio", "SMAPE ratio"]
    if lens and len(lens) < len(frames):
        columns += [f"relMSE ratio, {' and '.join(LENS)}"]
    print("| method | " + " | ".join(columns) + " |")
    print("| :--- |" + " ---: |" * len(columns))
    for method, of in scores.items():
        cells = [f"{mean(f[m] for f in of.values()):.{digits}f}" for m, (_, digits) in METRICS.items()]
        timed = [f["seconds"] for f in of.values() if "seconds" in f]
        cells.append(f"{1000 * mean(timed):.0f}" if timed else "")
        sets = [(frames, "relmse"), (frames, "smape")] + ([(lens, "relmse")] if len(columns) > 7 else [])
        for some, metric in sets:
            cells.append("1" if method == PEER else ratio([of[f][metric] for f in some], [scores[PEER][f][metric] for f in some]))
        print(f"| {method} | " + " | ".join(cells) + " |")
    if floor:
        print("\nFloor (how far the references are from their own limit): " + ", ".join(f"{METRICS[m][0]} {v:.4f}" for m, v in floor.items()) + ".")
    for method in scores:
        if method.startswith("oidn") or method in ("noisy", "blur"):
            continue
        worst = sorted(frames, key=lambda f: scores[PEER][f]["smape"] / scores[method][f]["smape"])[:3]
        text = ", ".join(f"`{f}` ({scores[method][f]['smape']:.4f} against {scores[PEER][f]['smape']:.4f})" for f in worst)
        print(f"\nWorst frames of {method} (SMAPE, against `{PEER}`): {text}.")


def main() -> None:
    if len(sys.argv) < 3:
        sys.exit("usage: results_table.py OUT NAME...")
    for name in sys.argv[2:]:
        folder = pathlib.Path(sys.argv[1], name)
        counts = sorted((int(f.name) for f in folder.iterdir() if f.is_dir()))
        folders = {n: read(folder / str(n)) for n in counts}
        for metric in ("smape", "relmse"):
            by_samples(name, folders, metric)
        if 8 in folders:
            document = json.loads((folder / "8/metrics.json").read_text(encoding="utf-8"))
            details(name, folders[8], document.get("floor", {}).get("mean", {}))


if __name__ == "__main__":
    main()

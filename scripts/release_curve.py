"""Error against hours of scripts/train_release.sh's trainings:

    release_curve.py RUNS NAME...

reads RUNS/NAME/cycle_*/metrics.csv and timing.csv and prints, for each network, the validation errors at the middle and the end of each
cycle. Hours are those of steps alone, by the clock. The last line fits SMAPE = a hours^-b to the ends of the cycles, where the learning
rate is low, and says which hours it would take to a tenth less: a guess from few points, which ends where the network or the data do.
"""
import csv
import math
import pathlib
import sys


def rows(path: pathlib.Path) -> list:
    with open(path, newline="", encoding="utf-8") as file:
        return list(csv.DictReader(file))


def points(run: pathlib.Path, hours_before: float) -> list:
    """[step, hours in all, row] of each validation."""
    times, hours, before = {}, hours_before, 0
    for row in rows(run / "timing.csv"):
        step = int(row["step"])
        hours += (step - before) * float(row["seconds_per_step"]) / 3600
        times[step], before = hours, step
    return [(int(row["step"]), times[int(row["step"])], row) for row in rows(run / "metrics.csv")
            if row["validation_loss"] and int(row["step"]) in times]


def fit(ends: list) -> str:
    x = [math.log(hours) for _, hours, _ in ends]
    y = [math.log(float(row["smape"])) for _, _, row in ends]
    mean_x, mean_y = sum(x) / len(x), sum(y) / len(y)
    slope = sum((a - mean_x) * (b - mean_y) for a, b in zip(x, y)) / sum((a - mean_x) ** 2 for a in x)
    return f"SMAPE falls as hours^{slope:.3f}: a tenth less after {ends[-1][1] * 0.9 ** (1 / slope):.0f} hours in all."


def curve(folder: pathlib.Path) -> None:
    print(f"\n{folder.name}:\n\n| cycle | step | hours | relMSE | SMAPE | SSIM | PSNR |\n| ---: | ---: | ---: | ---: | ---: | ---: | ---: |")
    hours, ends = 0.0, []
    for n, run in enumerate(sorted(folder.glob("cycle_*"), key=lambda f: int(f.name[6:]))):
        if not (run / "done").exists():
            continue
        found = points(run, hours)
        for step, at, row in (found[len(found) // 2], found[-1]):
            values = " | ".join(f"{float(row[m]):.4f}" for m in ("relmse", "smape", "ssim"))
            print(f"| {n} | {step} | {at:.2f} | {values} | {float(row['psnr']):.2f} |")
        ends.append(found[-1])
        hours = found[-1][1]
    if len(ends) > 1:
        print("\n" + fit(ends))


def main() -> None:
    if len(sys.argv) < 3:
        sys.exit(__doc__)
    for name in sys.argv[2:]:
        curve(pathlib.Path(sys.argv[1], name))


if __name__ == "__main__":
    main()

"""The table of scripts/recipe_study.sh: what each change gave, from the runs' metrics.csv.

    recipe_table.py OUT

Reads OUT/runs/CHANGE_SEED/metrics.csv: the best validation of each run by SMAPE, which is what a run's `best` checkpoint is.
"""
import csv
import math
import pathlib
import sys

METRICS = ("smape", "relmse", "ssim", "psnr")
# Student's t for a two-sided 95 % interval, by degrees of freedom.
T95 = {1: 12.71, 2: 4.30, 3: 3.18, 4: 2.78, 5: 2.57, 6: 2.45, 7: 2.36, 8: 2.31, 9: 2.26}


def best_of(run: pathlib.Path) -> dict:
    """The validation with the least SMAPE, and the number of steps that the time was enough for."""
    # A run whose columns changed has older tables beside the newest one.
    tables = sorted(run.glob("metrics*.csv"))
    rows = []
    for table in tables:
        with open(table, newline="", encoding="utf-8") as file:
            rows += [row for row in csv.DictReader(file) if row.get("step")]
    validated = [row for row in rows if row.get("smape")]
    if not validated:
        sys.exit(f"recipe_table.py: {run} has no validation; its data set needs a validation split, or it was cut off")
    best = dict(min(validated, key=lambda row: float(row["smape"])))
    best["steps"] = max(int(row["step"]) for row in rows)
    return best


def interval(values: list) -> str:
    """Mean and half the 95 % interval; one seed says so."""
    mean = sum(values) / len(values)
    if len(values) == 1:
        return f"{mean:.4f} (one seed)"
    deviation = math.sqrt(sum((v - mean) ** 2 for v in values) / (len(values) - 1))
    return f"{mean:.4f} ± {T95.get(len(values) - 1, 1.96) * deviation / math.sqrt(len(values)):.4f}"


def main() -> None:
    if len(sys.argv) != 2:
        sys.exit("usage: recipe_table.py OUT")
    runs = {}
    for run in sorted(pathlib.Path(sys.argv[1], "runs").iterdir()):
        if not (run / "done").exists():
            continue
        change, seed = run.name.rsplit("_", 1)
        runs.setdefault(change, {})[seed] = best_of(run)
    if "base" not in runs:
        sys.exit("recipe_table.py: no finished run of 'base' to compare with")

    def against_base(change: str) -> str:
        """Differences seed by seed: what the seeds share cancels."""
        seeds = sorted(set(runs[change]) & set(runs["base"]))
        return interval([float(runs[change][s]["smape"]) / float(runs["base"][s]["smape"]) - 1 for s in seeds])

    print("| change | seeds | steps | SMAPE | relative to base | relMSE | SSIM | PSNR |")
    print("| :--- | ---: | ---: | ---: | ---: | ---: | ---: | ---: |")
    order = sorted(runs, key=lambda c: sum(float(r["smape"]) for r in runs[c].values()) / len(runs[c]))
    for change in order:
        of = list(runs[change].values())
        cells = {m: interval([float(r[m]) for r in of]) for m in METRICS}
        steps = sum(r["steps"] for r in of) // len(of)
        relative = "0" if change == "base" else against_base(change)
        print(f"| `{change}` | {len(of)} | {steps} | {cells['smape']} | {relative} | {cells['relmse']} | {cells['ssim']} | {cells['psnr']} |")


if __name__ == "__main__":
    main()

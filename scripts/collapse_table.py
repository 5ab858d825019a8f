"""The table of scripts/collapse_study.sh: which trainings collapsed.

    collapse_table.py OUT

Reads OUT/runs/NETWORK,LOSS,RATE,SEED/metrics.csv and OUT/inputs.json, in which ld_eval says how far the noisy input is off.
"""
import csv
import json
import pathlib
import sys


def validations(run: pathlib.Path) -> list:
    """The SMAPE of all validations, the last one last."""
    with open(run / "metrics.csv", newline="", encoding="utf-8") as file:
        values = [float(row["smape"]) for row in csv.DictReader(file) if row.get("smape")]
    if len(values) < 2:
        sys.exit(f"collapse_table.py: {run} has fewer than two validations; its data set needs a validation split")
    return values


def main() -> None:
    if len(sys.argv) != 2:
        sys.exit("usage: collapse_table.py OUT")
    out = pathlib.Path(sys.argv[1])
    methods = json.loads((out / "inputs.json").read_text(encoding="utf-8"))["methods"]
    noisy, blur = (methods[name]["mean"]["smape"] for name in ("noisy", "blur"))
    groups = {}
    for run in sorted((out / "runs").iterdir()):
        if (run / "done").exists():
            network, loss, rate, _ = run.name.split(",")
            groups.setdefault((network, loss, float(rate)), []).append(validations(run))
    print("| network | loss | rate | seeds | near the noisy input | worse than the blur | stopped learning | mean SMAPE | worst |")
    print("| :--- | :--- | ---: | ---: | ---: | ---: | ---: | ---: | ---: |")
    for (network, loss, rate), runs in sorted(groups.items()):
        last = [values[-1] for values in runs]
        # A network whose kernels are all at their bounds has no gradient: its validations agree in all digits.
        stuck = sum(abs(values[-1] - values[-2]) < 1e-6 * values[-1] for values in runs)
        print(
            f"| {network} | {loss} | {rate:g} | {len(runs)} | {sum(v > 0.95 * noisy for v in last)} | {sum(v > blur for v in last)} "
            f"| {stuck} | {sum(last) / len(last):.4f} | {max(last):.4f} |"
        )
    print(f"\nThe noisy input has SMAPE {noisy:.4f}, the best Gaussian blur {blur:.4f}.")


if __name__ == "__main__":
    main()

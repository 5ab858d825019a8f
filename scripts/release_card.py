"""Says in a card of released weights how they were trained and what they score (scripts/train_release.sh).

    release_card.py hours CARD RUN                     prints the core hours that a card speaks of (0 without one) and those of a run
    release_card.py write CARD NAME DATA SCORES HOURS  adds them, and ld_eval's SCORES (--json), below the card's first paragraph
"""
import csv
import json
import pathlib
import re
import sys

METRICS = {"relmse": ("relMSE", 4), "smape": ("SMAPE", 4), "ssim": ("SSIM", 4), "psnr": ("PSNR", 2)}


def hours(card: pathlib.Path, run: pathlib.Path) -> float:
    """timing.csv has the seconds of a step since the row before."""
    found = re.search(r"([0-9.]+) (?:core )?hours", card.read_text(encoding="utf-8")) if card.exists() else None
    seconds, before = 0.0, 0
    with open(run / "timing.csv", newline="", encoding="utf-8") as file:
        for row in csv.DictReader(file):
            seconds += (int(row["step"]) - before) * float(row["seconds_per_step"])
            before = int(row["step"])
    return (float(found.group(1)) if found else 0) + seconds / 3600


def row(name: str, mean: dict) -> str:
    return f"| {name} | " + " | ".join(f"{mean[m]:.{digits}f}" for m, (_, digits) in METRICS.items()) + " |"


def write(card: pathlib.Path, name: str, data: str, scores: pathlib.Path, spent: float) -> None:
    document = json.loads(scores.read_text(encoding="utf-8"))
    manifest = json.loads(pathlib.Path(data, "manifest.json").read_text(encoding="utf-8"))
    train = sum(frame["split"] == "train" for frame in manifest["frames"])
    # Their first cycle begins so (scripts/train_release.sh), and its hours are not among theirs.
    family, size = name.split("_") if "_" in name else (name, "")
    begun = f", begun with the weights of `common_{size}`" if family in ("samples", "history", "pyramid") else ""
    mixed = f" What is released is the mean of these weights and `common_{size}`'s (`ld_export --mix`)." if family == "history" else ""
    recipe = "sequence_small" if family == "history" else "release"
    resolution = "x".join(re.search(r"resolution: \[(\d+), (\d+)\]", manifest["recipe"]).groups())
    lines = [
        f"`configs/{name}.yaml`{begun}, trained by `scripts/train_release.sh` for {spent:.1f} hours in all (by the clock, on one core that other work shared), at last on {train} frames of",
        f"`data/recipes/{recipe}.yaml` at {resolution}; one seed.{mixed} On the {document['frame_count']} validation frames of that recipe, which no step saw but which chose these weights,",
        f"at {document['samples']} samples a pixel (`ld_eval --split validation --samples {document['samples']}`):",
        "",
        "| | " + " | ".join(title for title, _ in METRICS.values()) + " |",
        "| --- |" + " ---: |" * len(METRICS),
        row("noisy", document["methods"]["noisy"]["mean"]),
        row("these weights", document["methods"]["model"]["mean"]),
    ]
    if "floor" in document:
        lines.append(row("floor of the references", document["floor"]["mean"]))
    head, rest = card.read_text(encoding="utf-8").split("\n## ", 1)
    card.write_text(head + "\n" + "\n".join(lines) + "\n\n## " + rest, encoding="utf-8")


def main() -> None:
    if len(sys.argv) == 4 and sys.argv[1] == "hours":
        print(hours(pathlib.Path(sys.argv[2]), pathlib.Path(sys.argv[3])))
    elif len(sys.argv) == 7 and sys.argv[1] == "write":
        write(pathlib.Path(sys.argv[2]), sys.argv[3], sys.argv[4], pathlib.Path(sys.argv[5]), float(sys.argv[6]))
    else:
        sys.exit(__doc__)


if __name__ == "__main__":
    main()

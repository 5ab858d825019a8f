#!/usr/bin/env python3
"""Reads a run's event files with TensorBoard's own reader (PyPI's tensorboard) and compares them with the run's metrics.csv.

    out/peers/venv/bin/python scripts/peers/read_tensorboard.py out/run

Fails where a record's checksum is wrong, a value or a step differs, or a picture cannot be what it says.
"""
import argparse
import csv
import math
import pathlib
import struct
import sys

from tensorboard.backend.event_processing import event_accumulator

COLUMNS = {"train_loss": "training/loss", "epoch": "training/epoch", "learning_rate": "training/learning_rate",
           "skipped": "training/skipped", "rollbacks": "training/rollbacks", "validation_loss": "validation/loss"}


def tag_of(column):
    if column.startswith("kernel_"):
        return "kernels/" + column[len("kernel_"):]
    return COLUMNS.get(column, "validation/" + column)


def compare_scalars(rows, events):
    """Counts the values of the table that the event files hold, too, in the same steps."""
    tags, count = set(events.Tags()["scalars"]), 0
    for column in rows[0]:
        expected = [(int(row["step"]), float(row[column])) for row in rows if column != "step" and row[column] != ""]
        if not expected:
            continue
        tag = tag_of(column)
        if tag not in tags:
            sys.exit(f"no tag {tag!r} among {sorted(tags)}")
        found = [(event.step, event.value) for event in events.Scalars(tag)]
        if [step for step, _ in found] != [step for step, _ in expected]:
            sys.exit(f"{tag}: steps {[s for s, _ in found]}; metrics.csv has {[s for s, _ in expected]}")
        for (step, value), (_, wanted) in zip(found, expected):
            if not math.isclose(value, wanted, rel_tol=1e-6, abs_tol=1e-12):
                sys.exit(f"{tag} at step {step}: {value}; metrics.csv has {wanted}")
        count += len(found)
    return count


def check_pictures(events):
    count = 0
    for tag in events.Tags()["images"]:
        for picture in events.Images(tag):
            data = picture.encoded_image_string
            width, height = struct.unpack(">II", data[16:24])
            if data[:8] != b"\x89PNG\r\n\x1a\n" or (width, height) != (picture.width, picture.height):
                sys.exit(f"{tag} at step {picture.step}: not a PNG of {picture.width} x {picture.height}")
            count += 1
    return count


def main():
    parser = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    parser.add_argument("run", type=pathlib.Path, help="run folder of ld_train")
    run = parser.parse_args().run
    everything = {kind: 0 for kind in ("scalars", "images", "tensors", "histograms", "compressedHistograms", "audio")}
    events = event_accumulator.EventAccumulator(str(run / "tensorboard"), size_guidance=everything)
    events.Reload()
    with open(run / "metrics.csv", encoding="utf-8") as table:
        rows = list(csv.DictReader(table))
    if not rows:
        sys.exit(f"{run}/metrics.csv has no rows")
    values, pictures = compare_scalars(rows, events), check_pictures(events)
    print(f"{values} values in {len(events.Tags()['scalars'])} tags and {pictures} pictures, as TensorBoard reads them: "
          "equal to metrics.csv")


if __name__ == "__main__":
    main()

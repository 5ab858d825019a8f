#!/usr/bin/env python3
"""Stores in each reference of a data set how far it is from its own limit (docs/data_format.md, ldFloor):

    out/peers/venv/bin/python scripts/peers/reference_floor.py --data DATA --out EVALUATION

DATA/halves/0 and DATA/halves/1 hold pictures from two independent halves of each reference's samples, the reference being their
mean. ld_eval scores both halves against it; a half is as far from the mean as the mean is from its limit.
"""
import argparse
import csv
import json
import os
from pathlib import Path

import OpenEXR
import xxhash

import dataset

METRICS = ("relmse", "smape", "ssim", "psnr")


def parse():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--data", type=Path, required=True)
    parser.add_argument("--out", type=Path, required=True, help="folder for ld_eval's tables of the two halves")
    parser.add_argument("--split", default="test")
    parser.add_argument("--bin", type=Path, default=dataset.ROOT / "build/bin", help="where ld_eval is")
    return parser.parse_args()


def floors_of(table):
    """{frame: {metric: mean of the two halves' scores}}"""
    rows = {(row["method"], row["frame"]): row for row in csv.DictReader(table.open(encoding="utf-8"))}
    frames = [frame for method, frame in rows if method == "half_0" and frame not in ("mean", "ci95_low", "ci95_high")]
    return {frame: {metric: sum(float(rows[f"half_{i}", frame][metric]) for i in range(2)) / 2 for metric in METRICS}
            for frame in frames}


def replace(path, write):
    """In one step, so that a reader sees the old file or the new one."""
    unfinished = path.with_name(f".unfinished.{path.name}")
    write(unfinished)
    os.replace(unfinished, path)


def store(path, floor):
    """The file with its floor; returns the new checksum."""
    with OpenEXR.File(str(path), separate_channels=True) as file:
        header, channels = file.header(), {name: channel.pixels.copy() for name, channel in file.channels().items()}
    header.update({f"ldFloor.{metric}": value for metric, value in floor.items()})
    header.pop("channels", None)
    replace(path, lambda unfinished: OpenEXR.File(header, channels).write(str(unfinished)))
    return xxhash.xxh3_64_hexdigest(path.read_bytes())


def main():
    options = parse()
    dataset.run(options.bin / "ld_eval", "--data", options.data, "--split", options.split, "--out", options.out,
                *(part for i in range(2) for part in ("--images", f"half_{i}={options.data / 'halves' / str(i)}")))
    manifest_path = options.data / "manifest.json"
    manifest = json.loads(manifest_path.read_text(encoding="utf-8"))
    floors = floors_of(options.out / "metrics.csv")
    for frame in manifest["frames"]:
        if frame["name"] in floors:
            frame["reference_checksum"] = store(options.data / f"{frame['name']}.reference.exr", floors[frame["name"]])
    replace(manifest_path, lambda unfinished: unfinished.write_text(json.dumps(manifest, indent=1) + "\n", encoding="utf-8"))
    print(f"reference_floor: {len(floors)} references of {options.data} tell their floor")


if __name__ == "__main__":
    main()

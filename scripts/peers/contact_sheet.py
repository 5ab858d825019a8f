#!/usr/bin/env python3
"""One picture of all references of a data set, or of PNG files: contact_sheet.py DATA_OR_FOLDER OUT.jpg [--columns N]

In the order of their names; linear values as sRGB, cut at 1.
"""
import argparse
import json
from pathlib import Path

import numpy as np
import OpenEXR
from PIL import Image


def shown(path):
    if path.suffix == ".png":
        return Image.open(path).convert("RGB")
    with OpenEXR.File(str(path), separate_channels=True) as file:
        x = np.clip(np.stack([file.channels()[c].pixels.astype(np.float32) for c in "RGB"], axis=-1), 0, 1)
    return Image.fromarray((255 * np.where(x <= 0.0031308, 12.92 * x, 1.055 * x ** (1 / 2.4) - 0.055) + 0.5).astype(np.uint8))


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("folder", type=Path)
    parser.add_argument("out", type=Path)
    parser.add_argument("--columns", type=int, default=6)
    options = parser.parse_args()
    manifest = options.folder / "manifest.json"
    if manifest.exists():
        names = sorted(frame["name"] for frame in json.loads(manifest.read_text(encoding="utf-8"))["frames"])
        paths = [options.folder / f"{name}.reference.exr" for name in names]
    else:
        paths = sorted(options.folder.glob("*.png"))
    pictures = [shown(path) for path in paths]
    if not pictures:
        parser.error(f"{options.folder} has neither a manifest.json with frames nor PNG files")
    width, height = pictures[0].size
    sheet = Image.new("RGB", (width * options.columns, height * -(-len(pictures) // options.columns)))
    for i, picture in enumerate(pictures):
        sheet.paste(picture, (i % options.columns * width, i // options.columns * height))
    sheet.save(options.out, quality=85)


if __name__ == "__main__":
    main()

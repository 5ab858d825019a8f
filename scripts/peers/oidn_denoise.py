#!/usr/bin/env python3
"""Denoises a split of a data set with Open Image Denoise (PyPI's pyoidn), for comparison:

    out/peers/venv/bin/python scripts/peers/oidn_denoise.py --data DIR --out PICTURES [--split test] [--threads N]
        [--samples N] [--quality fast|balanced|high] [--prefilter] [--colour DIR]

Colour, albedo and normal are the means of each pixel's valid samples, as a renderer would hand them over; of the first N samples alone with
--samples, as ld_eval's. With --colour the colour is that of DIR/FRAME.exr, such as SVGF's accumulated light. With --prefilter albedo and normal are denoised first, as its manual advises for final frames. Writes one EXR a frame and
cost.json, which `ld_eval --images NAME=PICTURES` and `ld_bench tradeoff --images NAME=PICTURES` read: seconds a frame, from the samples in memory to
the picture, so with the means and the prefilters, the median of the repeats; peak_mb, by how much the resident memory rose meanwhile.
"""
import argparse
import json
import os
import re
import statistics
import time
from pathlib import Path

import numpy as np
import OpenEXR
from oidn_filter import QUALITIES, Means, check, make_device, make_filter, version_of

FEATURES = {"color": ("R", "G", "B"), "albedo": ("albedo.R", "albedo.G", "albedo.B"), "normal": ("N.X", "N.Y", "N.Z")}


def planes(part, names):
    """[H, W, 3]; OpenEXR hands R, G, B over as one array or as three."""
    channels = part.channels
    prefix = names[0][:-1]
    for key in ("RGB" if prefix == "" else prefix + "RGB", prefix.rstrip(".")):
        if key in channels and channels[key].pixels.ndim == 3:
            return channels[key].pixels[..., :3].astype(np.float32)
    return np.stack([channels[name].pixels.astype(np.float32) for name in names], axis=-1)


def read_samples(path, first):
    """The samples of each feature, [samples, height, width, 3], and the windows that the picture gets."""
    with OpenEXR.File(str(path), separate_channels=True) as file:
        parts = [part for part in file.parts if re.fullmatch(r"s\d+", part.name())]
        if not parts:
            raise SystemExit(f"{path}: no sample parts s000, s001, ...")
        if first > len(parts):
            raise SystemExit(f"{path}: {len(parts)} samples, but --samples asks for {first}")
        windows = {key: parts[0].header[key] for key in ("dataWindow", "displayWindow")}
        return {feature: np.stack([planes(part, names) for part in parts[:first or None]]) for feature, names in FEATURES.items()}, windows


def read_colour(path):
    """[1, height, width, 3]"""
    with OpenEXR.File(str(path), separate_channels=True) as file:
        return planes(file.parts[0], FEATURES["color"])[None]


def status_mb(key):
    for line in Path("/proc/self/status").read_text().splitlines():
        if line.startswith(key + ":"):
            return int(line.split()[1]) * 1024 / 1e6
    raise SystemExit(f"/proc/self/status has no {key}")


def denoise(device, samples, options):
    """The picture, the median time from samples to picture, and the memory that it took."""
    Path("/proc/self/clear_refs").write_text("5")
    before = status_mb("VmRSS")
    means = Means(samples, options.threads)
    images = dict(means.images)
    filters = []
    if options.prefilter:
        for name in ("albedo", "normal"):
            oidn, images[name] = make_filter(device, {name: means.images[name]}, options.quality)
            filters.append(oidn)
    oidn, output = make_filter(device, images, options.quality, hdr=True, cleanAux=options.prefilter)
    filters.append(oidn)
    times = []
    for _ in range(options.repeats + 1):  # the first warms up
        start = time.perf_counter()
        means.make()
        for oidn in filters:
            oidn.execute()
            device.wait()
        times.append(time.perf_counter() - start)
    for oidn in filters:
        oidn.release()
    check(device)
    return output, statistics.median(times[1:]), max(status_mb("VmHWM") - before, 0)


def write_picture(path, image, windows):
    partial = path.with_suffix(".partial.exr")
    header = {"compression": OpenEXR.ZIP_COMPRESSION, "type": OpenEXR.scanlineimage, **windows}
    with OpenEXR.File(header, {"RGB": np.ascontiguousarray(image)}) as file:
        file.write(str(partial))
    os.replace(partial, path)


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--data", type=Path, required=True)
    parser.add_argument("--out", type=Path, required=True)
    parser.add_argument("--split", default="test")
    parser.add_argument("--threads", type=int, default=len(os.sched_getaffinity(0)))
    parser.add_argument("--repeats", type=int, default=7)
    parser.add_argument("--samples", type=int, default=0, help="the first so many of each frame (default: all)")
    parser.add_argument("--quality", choices=QUALITIES, default="high")
    parser.add_argument("--prefilter", action="store_true", help="denoise albedo and normal first")
    parser.add_argument("--colour", type=Path, help="pictures FRAME.exr in the place of the samples' mean")
    options = parser.parse_args()

    manifest = json.loads((options.data / "manifest.json").read_text())
    frames = [entry["name"] for entry in manifest["frames"] if entry["split"] == options.split]
    if not frames:
        raise SystemExit(f"{options.data}: no frames in split '{options.split}'")
    options.out.mkdir(parents=True, exist_ok=True)
    device = make_device(options.threads)
    cost = {"program": version_of(device), "threads": options.threads, "peak_mb": 0.0, "seconds": {}}
    for name in frames:
        samples, windows = read_samples(options.data / f"{name}.exr", options.samples)
        if options.colour:
            samples = {feature: values.mean(axis=0, keepdims=True) for feature, values in samples.items()}
            samples["color"] = read_colour(options.colour / f"{name}.exr")
        picture, seconds, memory = denoise(device, samples, options)
        write_picture(options.out / f"{name}.exr", picture, windows)
        cost["seconds"][name] = seconds
        cost["peak_mb"] = max(cost["peak_mb"], memory)
    (options.out / "cost.json").write_text(json.dumps(cost, indent=2) + "\n")
    print(f"{len(frames)} frames by {cost['program']}, {1000 * statistics.median(cost['seconds'].values()):.1f} ms a frame, "
          f"{cost['peak_mb']:.0f} MB at most, {options.threads} threads: {options.out}")


if __name__ == "__main__":
    main()

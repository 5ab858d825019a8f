#!/usr/bin/env python3
"""Denoises a split of a data set with Open Image Denoise (PyPI's pyoidn), for comparison:

    out/peers/venv/bin/python scripts/peers/oidn_denoise.py --data DIR --out PICTURES [--split test] [--threads N]
        [--samples N] [--quality fast|balanced|high] [--prefilter]

Colour, albedo and normal are the means of each pixel's valid samples, as a renderer would hand them over; of the first N samples alone with --samples, as ld_eval's. With --prefilter albedo and normal
are denoised first, as its manual advises for final frames (their time counts). Writes one EXR a
frame and cost.json (seconds a frame: the median of the repeats; peak_mb: by how much the resident memory rose while the
filter was made and run), which `ld_eval --images NAME=PICTURES` and `ld_bench tradeoff --images NAME=PICTURES` read.
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
from pyoidn import Device, Filter
from pyoidn.filter import OIDN_FORMAT_FLOAT3

FEATURES = {"color": ("R", "G", "B"), "albedo": ("albedo.R", "albedo.G", "albedo.B"), "normal": ("N.X", "N.Y", "N.Z")}


def planes(part, names):
    """[H, W, 3]; OpenEXR hands R, G, B over as one array or as three."""
    channels = part.channels
    prefix = names[0][:-1]
    for key in ("RGB" if prefix == "" else prefix + "RGB", prefix.rstrip(".")):
        if key in channels and channels[key].pixels.ndim == 3:
            return channels[key].pixels[..., :3].astype(np.float32)
    return np.stack([channels[name].pixels.astype(np.float32) for name in names], axis=-1)


# Values of OIDNQuality.
QUALITIES = {"fast": 4, "balanced": 5, "high": 6}


def mean_features(path, first):
    """Means over the samples, and the windows that the picture gets; a sample whose radiance is not finite counts as not drawn, guides that
    are not finite are 0. Radiance below 0 is 0."""
    with OpenEXR.File(str(path), separate_channels=True) as file:
        samples = [{feature: planes(part, names) for feature, names in FEATURES.items()}
                   for part in file.parts if re.fullmatch(r"s\d+", part.name())]
        windows = next(({key: part.header[key] for key in ("dataWindow", "displayWindow")}
                        for part in file.parts if re.fullmatch(r"s\d+", part.name())), {})
    if not samples:
        raise SystemExit(f"{path}: no sample parts s000, s001, ...")
    if first > len(samples):
        raise SystemExit(f"{path}: {len(samples)} samples, but --samples asks for {first}")
    samples = samples[:first] if first else samples
    valid = [np.isfinite(sample["color"]).all(axis=-1) for sample in samples]
    count = np.maximum(np.sum(valid, axis=0), 1)[..., None]
    means = {}
    for feature in FEATURES:
        values = [np.where(ok[..., None] & np.isfinite(sample[feature]).all(axis=-1)[..., None], sample[feature], 0)
                  for sample, ok in zip(samples, valid)]
        means[feature] = np.ascontiguousarray(np.sum(values, axis=0) / count, dtype=np.float32)
    means["color"] = np.maximum(means["color"], 0)
    return means, windows


def status_mb(key):
    for line in Path("/proc/self/status").read_text().splitlines():
        if line.startswith(key + ":"):
            return int(line.split()[1]) * 1024 / 1e6
    raise SystemExit(f"/proc/self/status has no {key}")


def make_filter(device, images, quality, **switches):
    """A filter on these images, and the picture that it writes."""
    height, width, _ = next(iter(images.values())).shape
    output = np.zeros((height, width, 3), dtype=np.float32)
    oidn = Filter(device, "RT")
    for name, image in images.items():
        oidn.set_image(name, image, OIDN_FORMAT_FLOAT3, width, height)
    oidn.set_image("output", output, OIDN_FORMAT_FLOAT3, width, height)
    for name, value in switches.items():
        oidn.set_bool(name, value)
    oidn.set_int("quality", QUALITIES[quality])
    oidn.commit()
    return oidn, output


def denoise(device, images, repeats, quality="high", prefilter=False):
    """The picture, the median time of running the filters, and the memory they took."""
    Path("/proc/self/clear_refs").write_text("5")
    before = status_mb("VmRSS")
    filters = []
    given = dict(images)  # Open Image Denoise borrows the arrays: whoever replaces one must keep it alive
    if prefilter:
        for name in ("albedo", "normal"):
            oidn, images[name] = make_filter(device, {name: given[name]}, quality)
            filters.append(oidn)
    oidn, output = make_filter(device, images, quality, hdr=True, cleanAux=prefilter)
    filters.append(oidn)
    times = []
    for _ in range(repeats + 1):  # the first warms up
        start = time.perf_counter()
        for oidn in filters:
            oidn.execute()
            device.wait()
        times.append(time.perf_counter() - start)
    for oidn in filters:
        oidn.release()
    message = device.get_error()
    if message:
        raise SystemExit(f"Open Image Denoise: {message}")
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
    options = parser.parse_args()

    manifest = json.loads((options.data / "manifest.json").read_text())
    frames = [entry["name"] for entry in manifest["frames"] if entry["split"] == options.split]
    if not frames:
        raise SystemExit(f"{options.data}: no frames in split '{options.split}'")
    options.out.mkdir(parents=True, exist_ok=True)
    device = Device()
    device.set_int("numThreads", options.threads)
    device.set_bool("setAffinity", False)
    device.commit()
    version = device.get_int("version")
    cost = {"program": f"Open Image Denoise {version // 10000}.{version // 100 % 100}.{version % 100}",
            "threads": options.threads, "peak_mb": 0.0, "seconds": {}}
    for name in frames:
        images, windows = mean_features(options.data / f"{name}.exr", options.samples)
        picture, seconds, memory = denoise(device, images, options.repeats, options.quality, options.prefilter)
        write_picture(options.out / f"{name}.exr", picture, windows)
        cost["seconds"][name] = seconds
        cost["peak_mb"] = max(cost["peak_mb"], memory)
    (options.out / "cost.json").write_text(json.dumps(cost, indent=2) + "\n")
    print(f"{len(frames)} frames by {cost['program']}, {1000 * statistics.median(cost['seconds'].values()):.1f} ms a frame, "
          f"{cost['peak_mb']:.0f} MB at most, {options.threads} threads: {options.out}")


if __name__ == "__main__":
    main()

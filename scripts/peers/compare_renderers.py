#!/usr/bin/env python3
"""Renders the same scenes with ld_render, Mitsuba 3 and Blender Cycles and prints how far apart they are.

    out/peers/venv/bin/python scripts/peers/compare_renderers.py            a table; side-by-side pictures with --images FOLDER
    out/peers/venv/bin/python scripts/peers/compare_renderers.py --speed    paths per second on the Cornell box

The mean relative difference of a to b is the mean of |a - b| / (b + 0.01 mean(b)) over pixels and channels; ends with 1 when
one with ld_render is above --limit.
"""
import argparse
import contextlib
import math
import os
import resource
import sys
import time
from pathlib import Path

import numpy as np

import dataset
from comparison import exr, scenes, with_cycles, with_mitsuba, with_ours

SCENES = {"cornell": scenes.cornell, "probe": scenes.probe_lit}
EXPOSURE = {"cornell": 2.0, "probe": 1.0}  # of the pictures to look at
NAMES = {"ours": "ld_render", "mitsuba": "Mitsuba 3", "cycles": "Cycles"}


def parse():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--out", type=Path, default=Path("out/peers/compare"))
    parser.add_argument("--scenes", nargs="+", choices=SCENES, default=list(SCENES))
    parser.add_argument("--size", type=int, default=160, help="height of the pictures in pixels (default 160)")
    parser.add_argument("--spp", type=int, default=1024,
                        help="of ld_render and Cycles (default 1024); the Cornell box takes twice as many, and Mitsuba, too")
    parser.add_argument("--threads", type=int, default=2)
    parser.add_argument("--limit", type=float, default=2.0, help="per cent (default 2)")
    parser.add_argument("--images", type=Path, help="folder for renderers_SCENE.png: ld_render, Mitsuba 3, Cycles")
    parser.add_argument("--reuse", action="store_true", help="keep pictures that are in OUT already")
    parser.add_argument("--speed", action="store_true", help="measure paths per second instead")
    parser.add_argument("--bin", type=Path, default=dataset.ROOT / "build/bin", help="where ld_render is")
    return parser.parse_args()


@contextlib.contextmanager
def quiet(log):
    """What libraries in this process print to file descriptor 1 goes to a file."""
    sys.stdout.flush()
    kept = os.dup(1)
    with open(log, "ab") as file:
        os.dup2(file.fileno(), 1)
    try:
        yield
    finally:
        sys.stdout.flush()
        os.dup2(kept, 1)
        os.close(kept)


def render(renderer, scene, options, spp):
    with quiet(options.out / "render.log"):
        if renderer == "ours":
            return with_ours.render(scene, options.out, spp, options.bin / "ld_render", options.threads)
        if renderer == "mitsuba":
            return with_mitsuba.render(scene, options.out, spp, dataset.mitsuba_variant(), options.threads)
        return with_cycles.render(scene, options.out, spp, options.threads)


def blocks(picture, size):
    height, width = picture.shape[0] // size * size, picture.shape[1] // size * size
    return picture[:height, :width].reshape(height // size, size, width // size, size, 3).mean(axis=(1, 3))


def difference(a, b):
    """Mean relative difference in per cent."""
    return 100 * float((np.abs(a - b) / (b + 0.01 * b.mean())).mean())


def write_png(path, pictures, exposure):
    """Side by side with a gap of four white pixels, in sRGB."""
    import mitsuba
    gap = np.ones((pictures[0].shape[0], 4, 3))
    row = [part for picture in pictures for part in (np.clip(picture * exposure, 0, 1), gap)][:-1]
    linear = np.concatenate(row, axis=1)
    encoded = np.where(linear <= 0.0031308, 12.92 * linear, 1.055 * linear ** (1 / 2.4) - 0.055)
    mitsuba.Bitmap((255 * encoded + 0.5).astype(np.uint8)).write(str(path))


def compare(options):
    worst = 0.0
    print(f"{'scene':8} {'a':10} {'b':10} {'pixels':>8} {'4x4':>8} {'a / b - 1':>28}")
    for name in options.scenes:
        scene, pictures = SCENES[name](options.size), {}
        for renderer in NAMES:
            spp = options.spp * scene["samples"] * (2 if renderer == "mitsuba" else 1)
            path = options.out / f"{name}_{renderer}_{options.size}_{spp}.exr"
            if not (options.reuse and path.exists()):
                exr.write(path, render(renderer, scene, options, spp))
            pictures[renderer] = exr.read(path)
        for a, b in (("ours", "mitsuba"), ("ours", "cycles"), ("mitsuba", "cycles")):
            first, second = pictures[a], pictures[b]
            found = difference(first, second)
            ratio = " ".join(f"{value:+8.3f}%" for value in 100 * (first.mean(axis=(0, 1)) / second.mean(axis=(0, 1)) - 1))
            print(f"{name:8} {NAMES[a]:10} {NAMES[b]:10} {found:7.3f}% {difference(blocks(first, 4), blocks(second, 4)):7.3f}% "
                  f"{ratio}", flush=True)
            worst = max(worst, found if a == "ours" else 0.0)
        if options.images:
            write_png(options.images / f"renderers_{name}.png", list(pictures.values()), EXPOSURE[name])
    print(f"compare_renderers: ld_render differs by at most {worst:.3f} %, allowed {options.limit} %")
    return 0 if worst <= options.limit else 1


def processor_seconds():
    """Of this process and of those it started and that ended."""
    return sum(sum(resource.getrusage(who)[:2]) for who in (resource.RUSAGE_SELF, resource.RUSAGE_CHILDREN))


def speed(options):
    """Paths a second from the difference of two renders, so that starting and preparing do not count; the best of three."""
    scene, pixels = scenes.cornell(options.size), options.size ** 2
    few, many = 16, 16 + max(64, options.spp // 8)
    wall, processor = {}, {}
    for _ in range(3):
        for key in [(renderer, spp) for renderer in NAMES for spp in (few, many)]:
            start, used = time.monotonic(), processor_seconds()
            render(key[0], scene, options, key[1])
            wall[key] = min(time.monotonic() - start, wall.get(key, math.inf))
            processor[key] = min(processor_seconds() - used, processor.get(key, math.inf))

    def rate(seconds, renderer):
        return pixels * (many - few) / (seconds[renderer, many] - seconds[renderer, few]) / 1e6

    print(f"Cornell box, {scene['max_bounces']} bounces, {options.size} x {options.size}, {options.threads} threads: "
          f"million paths a second")
    for renderer, name in NAMES.items():
        print(f"{name:10} {rate(wall, renderer):7.3f}, {rate(processor, renderer):7.3f} in a second of one processor")
    for peer in ("cycles", "mitsuba"):
        print(f"ld_render / {NAMES[peer]}: {rate(wall, 'ours') / rate(wall, peer):.2f}, "
              f"by processor time {rate(processor, 'ours') / rate(processor, peer):.2f}")
    return 0


def main():
    options = parse()
    options.out = options.out.resolve()
    options.out.mkdir(parents=True, exist_ok=True)
    start = time.monotonic()
    code = speed(options) if options.speed else compare(options)
    print(f"compare_renderers: {time.monotonic() - start:.0f} s")
    return code


if __name__ == "__main__":
    sys.exit(main())

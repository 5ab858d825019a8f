#!/usr/bin/env python3
"""Times networks of ours and Open Image Denoise on the same samples, in turns, and prints a table. scripts/speed.sh installs what it needs,
renders a frame and calls

    out/peers/venv/bin/python scripts/peers/speed.py --frame FRAME.exr [--sizes 128x128,1280x720,1920x1080] [--threads 1,2]
        [--models common_fast,common_fine] [--parts 1] [--qualities high,balanced,fast] [--repeats 9] [--json FILE]

Everything begins with the samples as numpy arrays [samples, height, width, channels] and ends with a picture [height, width, 3]:

- ours: `layered_denoiser.Denoiser.denoise` of all features that the weights read: the search for invalid samples, the median depth, the
  encoding, the network.
  With --parts N also `Denoiser.denoise_parts` with N parts of the light.
- Open Image Denoise: the means of radiance, albedo and normal over the samples, made by numpy on as many threads (oidn_filter.py), and its
  filter on them (hdr, cleanAux off). The means count; how much of the time they are is shown.

What is made once for all pictures of a size, our plan and their committed filter, counts for neither: a first run of each is thrown away. All
take turns in one process, in an order that shifts from round to round, after pauses in which threads that spin for others fall asleep. Neither
pins threads to CPUs. Variables that say how OpenMP's threads wait or where they run are removed. A size beyond the frame's is filled by
repeating it, a smaller one is cut out of it.
"""
import argparse
import json
import os
import sys
import time
from pathlib import Path

WAITING = ("OMP_WAIT_POLICY", "GOMP_SPINCOUNT", "OMP_PROC_BIND", "OMP_PLACES", "GOMP_CPU_AFFINITY", "OMP_NUM_THREADS", "OMP_DYNAMIC")
PAUSE = 0.05  # seconds
AVERAGED = {"color": "radiance", "albedo": "albedo", "normal": "normal"}


def without_waiting():
    """OpenMP reads the environment when it is loaded, so that it must be right before this process starts."""
    if any(name in os.environ for name in WAITING):
        environment = {name: value for name, value in os.environ.items() if name not in WAITING}
        os.execve(sys.executable, [sys.executable, *sys.argv], environment)


def resized(frame, width, height):
    """The features of a size, contiguous."""
    _, rows, columns, _ = frame.samples["radiance"].shape
    tiles = (1, -(-height // rows), -(-width // columns), 1)
    return {name: np.ascontiguousarray(np.tile(array[:, :height, :width], tiles)[:, :height, :width])
            for name, array in frame.samples.items()}


class Ours:
    def __init__(self, model, samples, threads, parts=0):
        self.name, self.threads = f"{model} +{parts}" if parts else model, threads
        self.denoiser = ld.Denoiser(model)
        self.parts = {str(part): samples["radiance"] for part in range(parts)}
        self.samples = {feature: samples[feature] for feature in self.denoiser.features if feature in samples}

    def run(self):
        """Seconds of the means, and of all."""
        start = time.perf_counter()
        if self.parts:
            self.denoiser.denoise_parts(self.samples, self.parts, threads=self.threads)
        else:
            self.denoiser.denoise(self.samples, threads=self.threads)
        return 0.0, time.perf_counter() - start


class Theirs:
    def __init__(self, quality, device, means):
        self.name, self.device, self.means = f"oidn {quality}", device, means
        self.filter, self.output = oidn.make_filter(device, means.images, quality, hdr=True, cleanAux=False)

    def run(self):
        start = time.perf_counter()
        self.means.make()
        averaged = time.perf_counter()
        self.filter.execute()
        self.device.wait()
        return averaged - start, time.perf_counter() - start


def measure(methods, repeats):
    """Seconds [methods, repeats, (means, all)]."""
    for method in methods:
        method.run()
    seconds = np.zeros((len(methods), repeats, 2))
    for repeat in range(repeats):
        for i in range(len(methods)):
            turn = (i + repeat) % len(methods)
            time.sleep(PAUSE)
            seconds[turn, repeat] = methods[turn].run()
    return seconds


def ratio_interval(seconds, baseline):
    """The ratio of the medians, and a 95 % interval of it: of the ratios for 2000 random choices of rounds, as many as there are, which both
    sides share."""
    rounds = np.random.default_rng(1).integers(len(seconds), size=(2000, len(seconds)))
    ratios = np.median(seconds[rounds], axis=1) / np.median(baseline[rounds], axis=1)
    return (np.median(seconds) / np.median(baseline), *np.quantile(ratios, (0.025, 0.975)))


def rows_of(options, frame, device_of):
    for width, height in options.sizes:
        samples = resized(frame, width, height)
        for threads in options.threads:
            device = device_of(threads)
            means = oidn.Means({name: samples[feature] for name, feature in AVERAGED.items()}, threads)
            methods = [Ours(name, samples, threads, parts) for name in options.models for parts in sorted({0, options.parts})]
            methods += [Theirs(quality, device, means) for quality in options.qualities]
            seconds = measure(methods, options.repeats)
            oidn.check(device)
            baseline = next(i for i, method in enumerate(methods) if method.name == options.baseline)
            for i, method in enumerate(methods):
                low, middle, high = (float(q) for q in np.quantile(seconds[i, :, 1], (0.25, 0.5, 0.75)))
                yield {"width": width, "height": height, "threads": threads, "method": method.name, "seconds": middle,
                       "quartiles": [low, high], "means": float(np.median(seconds[i, :, 0])),
                       "ratio": [float(x) for x in ratio_interval(seconds[i, :, 1], seconds[baseline, :, 1])]}


def line(row, baseline):
    ratio, low, high = row["ratio"]
    compared = "1" if row["method"] == baseline else f"{ratio:.2f} ({low:.2f} to {high:.2f})"
    quartiles = " to ".join(f"{1e3 * q:.1f}" for q in row["quartiles"])
    means = f"{1e3 * row['means']:.1f}" if row["means"] else "-"
    return f"| {row['width']}x{row['height']} | {row['threads']} | {row['method']} | {1e3 * row['seconds']:.1f} | {quartiles} | {means} | {compared} |"


def size(text):
    width, height = (int(side) for side in text.split("x"))
    if min(width, height) < 1:
        raise ValueError
    return width, height


def main():
    cpus = len(os.sched_getaffinity(0))
    words = lambda of: lambda text: [of(word) for word in text.split(",")]  # noqa: E731
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--frame", type=Path, required=True, help="a frame of samples (docs/data_format.md)")
    parser.add_argument("--sizes", type=words(size), default=[(128, 128), (1280, 720), (1920, 1080)])
    parser.add_argument("--threads", type=words(int), default=sorted({1, cpus}))
    parser.add_argument("--models", type=words(str), default=["common_fast", "common_fine"], help="names of released weights, or files")
    parser.add_argument("--parts", type=int, default=0, help="also with so many parts of the light, each the radiance again (default: %(default)s)")
    parser.add_argument("--qualities", type=words(str), default=["high", "balanced", "fast"])
    parser.add_argument("--baseline", default="oidn balanced", help="of the ratios, which are of whole times")
    parser.add_argument("--samples", type=int, default=0, help="the first so many of the frame (default: all)")
    parser.add_argument("--repeats", type=int, default=9)
    parser.add_argument("--json", type=Path)
    options = parser.parse_args()
    names = [*options.models, *(f"oidn {quality}" for quality in options.qualities)]
    if options.baseline not in names:
        parser.error(f"--baseline {options.baseline}: expected one of {', '.join(names)}")

    frame = ld.read_frame(options.frame, options.samples)
    devices = {threads: oidn.make_device(threads) for threads in options.threads}
    table = []
    print(f"| size | threads | method | ms | quartiles | of it means | to {options.baseline} (95 %) |\n| :--- | ---: | :--- | ---: | ---: | ---: | ---: |")
    for row in rows_of(options, frame, devices.get):
        table.append(row)
        print(line(row, options.baseline), flush=True)
    about = {"version": ld.__version__, "oidn": oidn.version_of(next(iter(devices.values()))), "cpus": cpus, "repeats": options.repeats,
             "samples": int(frame.samples["radiance"].shape[0])}
    print(f"\n{about['samples']} samples a pixel, {about['oidn']}, medians of {options.repeats} runs in turns, {cpus} CPUs.")
    if options.json:
        options.json.write_text(json.dumps({**about, "rows": table}, indent=2) + "\n")


if __name__ == "__main__":
    without_waiting()
    import layered_denoiser as ld
    import numpy as np
    import oidn_filter as oidn

    main()

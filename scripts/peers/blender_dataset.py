#!/usr/bin/env python3
"""Makes a data set from any .blend file, with the defocus and motion blur it has, by Blender Cycles.

    out/peers/venv/bin/python scripts/peers/blender_dataset.py --blend FILE.blend --out out/peers/blender

Each picture is rendered SPP times with one sample a pixel and once with many. Without --blend it makes example_scene.py's.
Pictures are different frames of the animation and, with --views, different cameras beside the scene's own.
"""
import argparse
import json
import shutil
import subprocess
import sys
from pathlib import Path

import camera_file
import cycles_depth
import dataset

HERE = Path(__file__).resolve().parent


def parse():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--blend", type=Path, help="the scene (default: one is made)")
    parser.add_argument("--blender", help="a Blender that is installed (default: the Python module bpy)")
    parser.add_argument("--frames", default="8", help="1,12,24: these frames; 8: so many, spread over the animation (default 8)")
    parser.add_argument("--views", type=int, default=1, help="cameras for each frame: the scene's and others beside it")
    parser.add_argument("--jitter", type=float, default=0.15, help="how far beside, as a part of the distance in focus")
    dataset.add_options(parser, Path("out/peers/blender"))
    return parser.parse_args()


def call(command, log):
    """Blender prints a lot; it goes to a file. What failed is shown."""
    with open(log, "w", encoding="utf-8") as file:
        code = subprocess.run([str(part) for part in command], stdout=file, stderr=subprocess.STDOUT).returncode
    if code != 0:
        print("".join(log.read_text(encoding="utf-8").splitlines(keepends=True)[-12:]), file=sys.stderr)
        dataset.stop(f"Blender failed with code {code}; its output is {log}")


def main():
    options = parse()
    renders = Path(f"{options.out}.renders")
    renders.mkdir(parents=True, exist_ok=True)
    if options.blend is None:
        options.blend = renders / "example.blend"
        if not options.blend.exists():
            start = [options.blender, "-b", "--factory-startup", "-P"] if options.blender else [sys.executable]
            call(start + [HERE / "example_scene.py", "--", options.blend.resolve()], renders / "example.log")
    if not options.blend.exists():
        dataset.stop(f"found no {options.blend}")

    there = dataset.frames_in(options.out)
    start = [options.blender, "-b", options.blend, "-P", HERE / "blender_samples.py", "--"] if options.blender else \
        [sys.executable, HERE / "blender_samples.py", "--blend", options.blend]
    call(start + ["--out", renders, "--frames", options.frames, "--views", options.views, "--jitter", options.jitter,
                  "--spp", options.spp, "--reference-spp", options.reference_spp, "--width", options.width,
                  "--height", options.height, "--seed", options.seed, "--prefix", options.prefix,
                  "--skip", ",".join(sorted(there))], renders / "blender.log")

    names = json.loads((renders / "pictures.json").read_text())
    for index, name in enumerate(names):
        if name in there:
            continue
        folder = renders / name
        about = json.loads((folder / "about.json").read_text())
        for sample in sorted(folder.glob("sample_*.exr")):
            cycles_depth.from_mist(sample, about)
        camera_file.write(folder / "camera.yaml", about)
        dataset.import_frame(options, "cycles", name, dataset.split_of(index, len(names), options.split), folder)
        if not options.keep:
            shutil.rmtree(folder)
    print(f"blender_dataset: {options.out} has {len(dataset.frames_in(options.out))} frames")
    dataset.train_and_evaluate(options)


if __name__ == "__main__":
    main()

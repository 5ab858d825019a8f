#!/usr/bin/env python3
"""Renders the Cycles test set, scenes by script that no program of ours rendered (docs/cycles_test_set.md).

    out/peers/venv/bin/python scripts/peers/cycles_test_set.py --out out/cycles_test
    out/peers/venv/bin/python scripts/peers/cycles_test_set.py --out out/cycles_training --random 0:100 --size 128

The second one makes frames to train on, of other scenes, by chance. Each frame is rendered by a process of its own: single samples, then two
halves of the reference. What is there is kept.
"""
import argparse
import json
import re
import shutil
import subprocess
import sys
import zlib
from pathlib import Path

HERE = Path(__file__).resolve().parent
sys.path[:0] = [str(HERE), str(HERE / "cycles_test")]
import camera_file  # noqa: E402
import cycles_depth  # noqa: E402
import dataset  # noqa: E402

# The first word says the kind; the scene's function and its module; whether it takes the folder of pybullet_data.
SCENES = {"defocus_still_life": ("scenes_lens", "still_life", False), "defocus_models": ("scenes_lens", "models", True),
          "motion_toys": ("scenes_lens", "toys", False), "motion_falling": ("scenes_lens", "falling", True),
          "texture_courtyard": ("scenes_surface", "courtyard", False), "glass_liquids": ("scenes_surface", "liquids", False),
          "thin_garden": ("scenes_surface", "garden", False), "interior_room": ("scenes_surface", "room", False),
          "glossy_metals": ("scenes_surface", "metals", False)}
VIEWS = 2


def parse():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--out", type=Path, required=True, help="folder of the data set")
    parser.add_argument("--meshes", type=Path, default=dataset.ROOT / "out/peers/pybullet_data")
    parser.add_argument("--only", default="", help="names of frames or scenes must begin with this")
    parser.add_argument("--random", metavar="FIRST:END", help="instead of the test set, scenes by chance with these numbers, for training")
    parser.add_argument("--size", type=int, default=160)
    parser.add_argument("--spp", type=int, default=16, help="samples a pixel, each a render of its own (default 16)")
    parser.add_argument("--reference-spp", type=int, default=2048, help="two halves of half as many")
    parser.add_argument("--threads", type=int, default=0, help="of Cycles; 0: all processors")
    parser.add_argument("--bin", type=Path, default=dataset.ROOT / "build/bin", help="where ld_import is")
    parser.add_argument("--preview", action="store_true", help="only PNG files of --reference-spp samples, in OUT")
    parser.add_argument("--frame", help=argparse.SUPPRESS)  # the process that renders this frame
    return parser.parse_args()


def names_of(options):
    if options.random:
        numbers = re.fullmatch(r"(\d+):(\d+)", options.random) or dataset.stop(f"--random: expected FIRST:END, such as 0:100, found '{options.random}'")
        return [f"random_{number:04}" for number in range(int(numbers[1]), int(numbers[2]))]
    return [f"{scene}_{view}" for view in range(VIEWS) for scene in SCENES if f"{scene}_{view}".startswith(options.only)]


def number_by_chance(name):
    """Of a scene by chance; None for those of the test set."""
    return int(name[len("random_"):]) if name.startswith("random_") else None


def split_of(name):
    """Of scenes by chance, one in twelve is for validation."""
    number = number_by_chance(name)
    return "test" if number is None else "validation" if number % 12 == 11 else "train"


def build(name, meshes):
    number = number_by_chance(name)
    if number is not None:
        __import__("scenes_random").build(number)
        return
    module, function, takes_meshes = SCENES[name[:-2]]
    getattr(__import__(module), function)(int(name[-1]), *([meshes] if takes_meshes else []))


def settings(scene, options):
    """Cycles as productions use it (Blender's defaults): indirect light clamped at 10, the glossy filter at 1, a light threshold of
    0.01. The same for samples and references, so that they have the same mean."""
    import bpy
    import cycles_samples
    cycles_samples.sample_settings(scene, bpy.context.view_layer)
    bpy.context.view_layer.use_pass_vector = False  # single pictures
    scene.cycles.sample_clamp_indirect, scene.cycles.blur_glossy, scene.cycles.light_sampling_threshold = 10, 1.0, 0.01
    scene.render.resolution_x = scene.render.resolution_y = options.size
    scene.render.threads_mode, scene.render.threads = ("FIXED" if options.threads else "AUTO"), max(options.threads, 1)
    cycles_samples.measure_by_mist(scene)


def render_frame(options):
    """Inside Blender. A file is renamed when it is whole, so what has its name is."""
    import bpy
    import cycles_samples
    build(options.frame, options.meshes.resolve())
    scene = bpy.context.scene
    settings(scene, options)
    scene.frame_set(1)
    if options.preview:
        scene.render.image_settings.file_format, scene.render.image_settings.color_depth = "PNG", "8"
        scene.view_settings.view_transform = "Standard"
        scene.cycles.samples, scene.render.filepath = options.reference_spp, str((options.out / f"{options.frame}.png").resolve())
        bpy.ops.render.render(write_still=True)
        return
    folder = (Path(f"{options.out}.renders") / options.frame).resolve()
    folder.mkdir(parents=True, exist_ok=True)
    half = options.reference_spp // 2
    seed = zlib.crc32(options.frame.encode()) % 2**30  # no two renders share a seed; Cycles takes 31 bits
    renders = [(f"sample_{s:03}.exr", 1) for s in range(options.spp)] + [("half_0.exr", half), ("half_1.exr", half)]
    for i, (name, spp) in enumerate(renders):
        if not (folder / name).exists():
            cycles_samples.render(scene, folder / "unfinished.exr", spp, seed + i, first=1)
            (folder / "unfinished.exr").rename(folder / name)
    about = cycles_samples.camera_of(scene)
    mist = scene.world.mist_settings
    about.update({"mist_start": mist.start, "mist_depth": mist.depth})
    (folder / "about.json").write_text(json.dumps(about))


def channels_of(path):
    import OpenEXR
    with OpenEXR.File(str(path), separate_channels=True) as file:
        return {name: channel.pixels.copy() for part in file.parts for name, channel in part.channels.items()}


def write(path, channels):
    import OpenEXR
    OpenEXR.File({"type": OpenEXR.scanlineimage, "compression": OpenEXR.ZIP_COMPRESSION}, channels).write(str(path))


def join_halves(folder, name, halves):
    """The reference is the mean of its halves, which stay beside the data set: their difference says how noisy it is."""
    both = [channels_of(folder / f"half_{i}.exr") for i in range(2)]
    for i, channels in enumerate(both):
        (halves / str(i)).mkdir(parents=True, exist_ok=True)
        write(halves / f"{i}/{name}.exr", {key[-1]: value for key, value in channels.items() if ".Combined." in key and key[-1] in "RGB"})
    write(folder / "reference.exr", {key: 0.5 * (both[0][key] + both[1][key]) for key in both[0]})


def main():
    options = parse()
    if options.frame:
        render_frame(options)
        return
    options.out.mkdir(parents=True, exist_ok=True)
    there = dataset.frames_in(options.out)
    for name in names_of(options):
        if name in there:
            continue
        log = options.out / f"{name}.png.log" if options.preview else Path(f"{options.out}.renders") / f"{name}.log"
        log.parent.mkdir(parents=True, exist_ok=True)
        with open(log, "w", encoding="utf-8") as file:
            code = subprocess.run([sys.executable, __file__, *sys.argv[1:], "--frame", name], stdout=file, stderr=subprocess.STDOUT).returncode
        if code != 0:
            dataset.stop(f"{name}: Blender ended with code {code}; its output is {log}")
        if options.preview:
            log.unlink()
            continue
        folder = Path(f"{options.out}.renders") / name
        about = json.loads((folder / "about.json").read_text())
        for sample in sorted(folder.glob("sample_*.exr")):
            cycles_depth.from_mist(sample, about)
        join_halves(folder, name, options.out / "halves")
        camera_file.write(folder / "camera.yaml", about)
        dataset.import_frame(options, "cycles", name, split_of(name), folder)
        shutil.rmtree(folder)
    print(f"cycles_test_set: {options.out} has {len(dataset.frames_in(options.out))} frames")


if __name__ == "__main__":
    main()

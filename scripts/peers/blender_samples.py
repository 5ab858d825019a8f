"""Runs inside Blender: renders frames of a scene sample by sample. blender_dataset.py starts it, in either of two ways:

    python blender_samples.py --blend FILE.blend ...             with the module bpy
    blender -b FILE.blend -P blender_samples.py -- ...           with a Blender that is installed

OUT/pictures.json lists the pictures. For each one, NAME, it writes OUT/NAME/sample_*.exr, OUT/NAME/reference.exr and, last of
all, OUT/NAME/about.json.
"""
import argparse
import json
import random
import sys
from pathlib import Path

import bpy
import mathutils

sys.path.insert(0, str(Path(__file__).resolve().parent))
import cycles_samples  # noqa: E402


def parse():
    arguments = sys.argv[sys.argv.index("--") + 1:] if "--" in sys.argv else sys.argv[1:]
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--blend", type=Path)
    parser.add_argument("--out", type=Path, required=True)
    parser.add_argument("--frames", required=True, help="numbers with commas, or a count to spread over the scene's frames")
    parser.add_argument("--views", type=int, required=True)
    parser.add_argument("--jitter", type=float, required=True)
    parser.add_argument("--spp", type=int, required=True)
    parser.add_argument("--reference-spp", type=int, required=True)
    parser.add_argument("--width", type=int, required=True)
    parser.add_argument("--height", type=int, required=True)
    parser.add_argument("--seed", type=int, required=True)
    parser.add_argument("--prefix", required=True)
    parser.add_argument("--skip", default="", help="names with commas that are there already")
    return parser.parse_args(arguments)


def frames_of(scene, text):
    """"1,5,9" are frames; "3" is how many to spread over the animation."""
    if "," in text:
        return [int(number) for number in text.split(",") if number]
    count, first, last = int(text), scene.frame_start, scene.frame_end
    return sorted({round(first + (last - first) * (i + 0.5) / count) for i in range(count)})


def focus_distance(scene, camera):
    """What the camera looks at: its focus, else what its axis meets, else the middle of its clipping range."""
    data = camera.data
    if data.dof.use_dof:
        if data.dof.focus_object:
            return (data.dof.focus_object.matrix_world.translation - camera.matrix_world.translation).length
        return data.dof.focus_distance
    axis = camera.matrix_world.to_quaternion() @ mathutils.Vector((0, 0, -1))
    hit, point, *_ = scene.ray_cast(bpy.context.evaluated_depsgraph_get(), camera.matrix_world.translation, axis)
    return (point - camera.matrix_world.translation).length if hit else 10.0


def add_view(scene, camera, jitter, rng):
    """A camera that follows `camera` beside it and looks at the same point: by parenting, so that animation is kept."""
    distance = focus_distance(scene, camera)
    view = bpy.data.objects.new("view", camera.data)
    scene.collection.objects.link(view)
    view.parent = camera
    offset = mathutils.Vector([rng.uniform(-1, 1) * jitter * distance for _ in range(3)])
    towards = mathutils.Vector((0, 0, -distance)) - offset
    view.matrix_local = mathutils.Matrix.LocRotScale(offset, mathutils.Vector((0, 0, -1)).rotation_difference(towards), None)
    return view


def render_picture(scene, folder, options, seed):
    folder.mkdir(parents=True, exist_ok=True)
    for s in range(options.spp):
        cycles_samples.render(scene, folder / f"sample_{s:03}.exr", 1, seed + s, first=1)
    cycles_samples.render(scene, folder / "reference.exr", options.reference_spp, seed + options.spp, first=1)
    about = cycles_samples.camera_of(scene)
    mist = scene.world.mist_settings
    about.update({"frame": scene.frame_current, "mist_start": mist.start, "mist_depth": mist.depth,
                  "generator": f"Blender {bpy.app.version_string}, Cycles"})
    (folder / "about.json").write_text(json.dumps(about))


def main():
    options = parse()
    if options.blend:
        bpy.ops.wm.open_mainfile(filepath=str(options.blend.resolve()))
    scene = bpy.context.scene
    if scene.camera is None or scene.camera.data.type != "PERSP":
        sys.exit("blender_samples.py: the scene needs an active perspective camera")
    scene.render.resolution_x, scene.render.resolution_y = options.width, options.height
    cycles_samples.sample_settings(scene, bpy.context.view_layer)
    cycles_samples.measure_by_mist(scene)
    rng = random.Random(options.seed)
    frames = frames_of(scene, options.frames)
    scene.frame_set(frames[0])
    cameras = [scene.camera] + [add_view(scene, scene.camera, options.jitter, rng) for _ in range(options.views - 1)]
    pictures = [(f"{options.prefix}_{frame:04}" + (f"_view_{v}" if options.views > 1 else ""), frame, camera)
                for frame in frames for v, camera in enumerate(cameras)]
    options.out.mkdir(parents=True, exist_ok=True)
    (options.out / "pictures.json").write_text(json.dumps([name for name, *_ in pictures]))
    skip = set(options.skip.split(","))
    for p, (name, frame, camera) in enumerate(pictures):
        if name in skip or (options.out / name / "about.json").exists():
            continue
        scene.frame_set(frame)
        scene.camera = camera
        # No two renders of a data set share a seed; Cycles takes 31 bits.
        seed = (options.seed * 1000003 + p * (options.spp + 1)) % 2**31
        render_picture(scene, (options.out / name).resolve(), options, seed)


if __name__ == "__main__":
    main()

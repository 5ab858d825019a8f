#!/usr/bin/env python3
"""Makes a data set from any Mitsuba 3 scene with a perspective or thin-lens camera.

    out/peers/venv/bin/python scripts/peers/mitsuba_dataset.py --scene FILE.xml --out out/peers/mitsuba

Each picture is rendered SPP times with one sample a pixel and once with many; the pictures are views from the scene's camera and
from beside it.
Without --scene it takes the scene of mitsuba_scene.py. Mitsuba 3.9 has no moving objects, so there is no motion blur.
"""
import argparse
import math
import random
import shutil
from pathlib import Path

import mitsuba
import numpy as np

import camera_file
import dataset

# The position gives the depth along the axis exactly, through a lens, too; the AOV depth is the distance along the ray.
AOVS = "albedo:albedo,nn:sh_normal,depth:depth,position:position"
FROM_OURS = np.diag([-1.0, 1, -1, 1])  # Mitsuba's cameras look along +z with +x to the left


def parse():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--scene", type=Path, help="XML file (default: a built-in scene)")
    parser.add_argument("--views", type=int, default=8, help="pictures: the scene's camera and others beside it (default 8)")
    parser.add_argument("--jitter", type=float, default=0.3, help="how far beside, as a part of the distance in focus")
    parser.add_argument("--variant", default=dataset.mitsuba_variant(),
                        help="of Mitsuba (default llvm_ad_rgb where setup.sh found that it works, else scalar_rgb)")
    dataset.add_options(parser, Path("out/peers/mitsuba"))
    return parser.parse_args()


def lens_of(scene):
    """The scene's camera: what a new one needs to see the same."""
    values = mitsuba.traverse(scene.sensors()[0])
    if "x_fov" not in values:
        dataset.stop("the scene's first sensor must be of type perspective or thinlens")

    def number(key, missing):
        return float(np.array(values[key]).ravel()[0]) if key in values else missing

    return {"x_fov": number("x_fov", 0), "aperture": number("aperture_radius", 0), "focus": number("focus_distance", 0),
            "near": number("near_clip", 0.01), "far": number("far_clip", 1e4),
            "to_world": np.array(values["to_world"].matrix, dtype=float).reshape(4, 4)}


def distance_of_interest(scene, lens):
    """The distance in focus; of a pinhole camera, what its axis meets."""
    if lens["aperture"] > 0:
        return lens["focus"]
    origin, axis = lens["to_world"][:3, 3], lens["to_world"][:3, 2]
    hit = scene.ray_intersect(mitsuba.Ray3f(origin.tolist(), axis.tolist()))
    distance = float(np.array(hit.t).ravel()[0])
    return distance if math.isfinite(distance) else 10.0


def view_beside(to_world, distance, jitter, rng):
    """A camera moved by up to jitter * distance along each axis, turned to the same point."""
    centre, up = to_world[:3, 3] + to_world[:3, 2] * distance, to_world[:3, 1]
    origin = to_world[:3, 3] + to_world[:3, :3] @ [rng.uniform(-1, 1) * jitter * distance for _ in range(3)]
    return np.array(mitsuba.ScalarTransform4f().look_at(origin.tolist(), centre.tolist(), up.tolist()).matrix)


def make_sensor(lens, to_world, options):
    sensor = {"type": "thinlens" if lens["aperture"] > 0 else "perspective", "fov": lens["x_fov"], "fov_axis": "x",
              "near_clip": lens["near"], "far_clip": lens["far"], "to_world": mitsuba.ScalarTransform4f(to_world),
              "film": {"type": "hdrfilm", "width": options.width, "height": options.height, "pixel_format": "rgba",
                       "component_format": "float32", "rfilter": {"type": "box"}},
              "sampler": {"type": "independent"}}
    if lens["aperture"] > 0:
        sensor.update({"aperture_radius": lens["aperture"], "focus_distance": lens["focus"]})
    return mitsuba.load_dict(sensor)


def main():
    options = parse()
    if options.scene is not None and not options.scene.exists():
        dataset.stop(f"found no {options.scene}")
    mitsuba.set_variant(options.variant)
    if options.scene:
        scene = mitsuba.load_file(str(options.scene))
    else:
        import mitsuba_scene  # needs the variant
        scene = mitsuba.load_dict(mitsuba_scene.example())
    lens = lens_of(scene)
    own = scene.integrator()
    image = own if own is not None and "Path" in own.class_name() else {"type": "path"}
    integrator = mitsuba.load_dict({"type": "aov", "aovs": AOVS, "image": image})
    fov_y = 2 * math.atan(math.tan(math.radians(lens["x_fov"]) / 2) * options.height / options.width)

    rng = random.Random(options.seed)
    distance = distance_of_interest(scene, lens)
    poses = [lens["to_world"]] + [view_beside(lens["to_world"], distance, options.jitter, rng) for _ in range(options.views - 1)]
    there = dataset.frames_in(options.out)
    for index, pose in enumerate(poses):
        name = f"{options.prefix}_{index:04}"
        if name in there:
            continue
        folder = Path(f"{options.out}.renders") / name
        folder.mkdir(parents=True, exist_ok=True)
        sensor = make_sensor(lens, pose, options)
        # No two renders of a data set share a seed.
        seed = (options.seed * 1000003 + index * (options.spp + 1)) % 2**31
        for s in range(options.spp + 1):
            file, spp = (f"sample_{s:03}.exr", 1) if s < options.spp else ("reference.exr", options.reference_spp)
            mitsuba.render(scene, sensor=sensor, integrator=integrator, spp=spp, seed=seed + s)
            sensor.film().bitmap().write(str(folder / file))
        camera_file.write(folder / "camera.yaml", {"camera_to_world": (pose @ FROM_OURS).tolist(), "fov_y": fov_y,
                                                   "width": options.width, "height": options.height})
        dataset.import_frame(options, "mitsuba", name, dataset.split_of(index, len(poses), options.split), folder)
        if not options.keep:
            shutil.rmtree(folder)
    print(f"mitsuba_dataset: {options.out} has {len(dataset.frames_in(options.out))} frames")
    dataset.train_and_evaluate(options)


if __name__ == "__main__":
    main()

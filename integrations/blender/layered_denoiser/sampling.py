"""A scene of Cycles as a source of single samples: one multi-layer OpenEXR file for each sample of every pixel."""
import contextlib
import math

import bpy

# A pixel of the passes is what one camera ray met, as long as a file holds one sample a pixel.
PASSES = ("combined", "z", "normal", "diffuse_color", "glossy_color", "mist")

# Independent samples, a box filter of one pixel, nothing denoised. Bounces, clamping and caustics stay the artist's.
CYCLES = {"pixel_filter_type": "BOX", "use_adaptive_sampling": False, "use_denoising": False, "use_animated_seed": False,
          "time_limit": 0, "sampling_pattern": "TABULATED_SOBOL", "samples": 1, "sample_offset": 0, "seed": 0,
          "use_sample_subset": False, "sample_subset_length": 1}
RENDER = {"engine": "CYCLES", "use_compositing": False, "use_sequencer": False, "use_persistent_data": True,
          "use_file_extension": True, "use_overwrite": True, "use_placeholder": False, "filepath": ""}
IMAGE = {"media_type": "MULTI_LAYER_IMAGE", "file_format": "OPEN_EXR_MULTILAYER", "color_depth": "32", "exr_codec": "ZIP"}


def set_known(owner, values):
    """Sets what this Blender knows of the attributes, in their order: a file format before its depth."""
    for name, value in values.items():
        if hasattr(owner, name):
            setattr(owner, name, value)


@contextlib.contextmanager
def changed(owner, values):
    """The attributes set, and set back whatever happens."""
    before = {name: getattr(owner, name) for name in values if hasattr(owner, name)}
    try:
        set_known(owner, values)
        yield
    finally:
        for name, value in before.items():
            setattr(owner, name, value)


def settings(scene, view_layer):
    """What makes the scene ready for render(): owners, each with its attributes."""
    return [(scene.render, RENDER), (scene.render.image_settings, IMAGE), (scene.cycles, CYCLES),
            *((layer, {"use": layer == view_layer}) for layer in scene.view_layers),
            (view_layer, {"samples": 0, **{f"use_pass_{name}": True for name in PASSES}})]


def give_world(scene):
    """No world is black; so is this one, which a scene without one gets. Returns the new world, else None."""
    if scene.world is not None:
        return None
    world = scene.world = bpy.data.worlds.new("Layered Denoiser")
    world.use_nodes = True
    world.node_tree.nodes["Background"].inputs["Strength"].default_value = 0
    return world


def mist_as_distance(scene):
    """What makes the pass Mist of a scene with a world the distance to the camera, 1 where the ray escaped: Cycles writes Z for the
    sample in the pixel's middle only. Nothing beyond the far clipping plane is seen; its corners are farther away than its middle."""
    return scene.world.mist_settings, {"start": 0.0, "depth": 2 * scene.camera.data.clip_end, "falloff": "LINEAR"}


@contextlib.contextmanager
def sample_settings(scene, view_layer):
    """The scene made ready for render(), and as it was afterwards."""
    with contextlib.ExitStack() as stack:
        world = give_world(scene)
        if world:
            stack.callback(bpy.data.worlds.remove, world)
        for owner, values in [*settings(scene, view_layer), mist_as_distance(scene)]:
            stack.enter_context(changed(owner, values))
        yield


def render(scene, path, seed, samples=1, first=1):
    """A file of the samples first, first + 1, ... of the sequence that `seed` names; number 0 goes through the pixel's middle whatever
    the seed."""
    cycles = scene.cycles
    cycles.seed, cycles.sample_offset, cycles.samples = seed % 2**31, first, samples
    if hasattr(cycles, "use_sample_subset"):  # since Blender 4.5
        cycles.use_sample_subset = first > 0
        cycles.sample_subset_length = samples
        cycles.samples = first + samples
    scene.render.filepath = str(path)
    bpy.ops.render.render(write_still=True, scene=scene.name)
    if not path.exists():
        raise RuntimeError(f"Blender wrote no {path}")


def depth_assignments(scene):
    """What tells ld_denoise that Mist is the distance from the camera."""
    return ['depth.channels=["{layer}.Mist.Z | {layer}.Mist.V"]', "depth.kind=distance",
            f"depth.scale=[{scene.world.mist_settings.depth!r}]", "depth.escaped_above=0.9999"]


def camera_of(scene):
    """The perspective camera at the present frame: what ld_denoise --camera takes, and its projection."""
    graph = bpy.context.evaluated_depsgraph_get()
    camera, render = scene.camera.evaluated_get(graph), scene.render
    percentage = render.resolution_percentage / 100
    size = int(render.resolution_x * percentage), int(render.resolution_y * percentage)
    projection = camera.calc_matrix_camera(graph, x=size[0], y=size[1], scale_x=render.pixel_aspect_x,
                                           scale_y=render.pixel_aspect_y)
    return {"camera_to_world": [list(row) for row in camera.matrix_world.normalized()],
            "fov_y": 2 * math.atan(1 / projection[1][1]), "width": size[0], "height": size[1],
            "projection": [list(row) for row in projection]}


def write_camera(scene, path):
    """The camera of the present frame for ld_denoise --camera; False where it is no perspective one."""
    if scene.camera.data.type != "PERSP":
        return False
    camera = camera_of(scene)
    rows = "".join(f"  - [{', '.join(format(value, '.9g') for value in row)}]\n" for row in camera["camera_to_world"])
    path.write_text(f"camera_to_world:\n{rows}fov_y: {camera['fov_y']:.9g}\n"
                    f"width: {camera['width']}\nheight: {camera['height']}\n", encoding="ascii")
    return True

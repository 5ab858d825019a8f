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


@contextlib.contextmanager
def changed(owner, values):
    """Sets what this Blender knows of the attributes, and sets them back whatever happens: a file format before its depth."""
    before = {name: getattr(owner, name) for name in values if hasattr(owner, name)}
    try:
        for name in before:
            setattr(owner, name, values[name])
        yield
    finally:
        for name, value in before.items():
            setattr(owner, name, value)


@contextlib.contextmanager
def sample_settings(scene, view_layer):
    """The scene made ready for render_sample(), and as it was afterwards."""
    with contextlib.ExitStack() as stack:
        stack.enter_context(changed(scene.render, RENDER))
        stack.enter_context(changed(scene.render.image_settings, IMAGE))
        stack.enter_context(changed(scene.cycles, CYCLES))
        for layer in scene.view_layers:
            stack.enter_context(changed(layer, {"use": layer == view_layer}))
        stack.enter_context(changed(view_layer, {"samples": 0, **{f"use_pass_{name}": True for name in PASSES}}))
        if scene.world is None:  # no world is black; so is this one
            world = bpy.data.worlds.new("Layered Denoiser")
            world.use_nodes = True
            world.node_tree.nodes["Background"].inputs["Strength"].default_value = 0
            scene.world = world
            stack.callback(bpy.data.worlds.remove, world)
        # The pass Mist as a distance: Cycles writes Z for the sample in the pixel's middle only.
        mist = {"start": 0.0, "depth": 2 * scene.camera.data.clip_end, "falloff": "LINEAR"}
        stack.enter_context(changed(scene.world.mist_settings, mist))
        yield


def render_sample(scene, path, seed):
    """One sample a pixel: the second of the sequence that `seed` names, since the first goes through the pixel's middle."""
    scene.cycles.seed = seed % 2**31
    scene.cycles.sample_offset = 1
    if hasattr(scene.cycles, "use_sample_subset"):  # since Blender 4.5
        scene.cycles.use_sample_subset = True
        scene.cycles.sample_subset_length = 1
        scene.cycles.samples = 2
    scene.render.filepath = str(path)
    bpy.ops.render.render(write_still=True, scene=scene.name)
    if not path.exists():
        raise RuntimeError(f"Blender wrote no {path}")


def depth_assignments(scene):
    """What tells ld_denoise that Mist is the distance from the camera."""
    return ['depth.channels=["{layer}.Mist.Z | {layer}.Mist.V"]', "depth.kind=distance",
            f"depth.scale=[{scene.world.mist_settings.depth!r}]", "depth.escaped_above=0.9999"]


def write_camera(scene, path):
    """The camera of the present frame for ld_denoise --camera; False where it is no perspective one."""
    if scene.camera.data.type != "PERSP":
        return False
    graph = bpy.context.evaluated_depsgraph_get()
    camera, render = scene.camera.evaluated_get(graph), scene.render
    percentage = render.resolution_percentage / 100
    size = int(render.resolution_x * percentage), int(render.resolution_y * percentage)
    projection = camera.calc_matrix_camera(graph, x=size[0], y=size[1], scale_x=render.pixel_aspect_x,
                                           scale_y=render.pixel_aspect_y)
    rows = "".join(f"  - [{', '.join(format(value, '.9g') for value in row)}]\n" for row in camera.matrix_world.normalized())
    path.write_text(f"camera_to_world:\n{rows}fov_y: {2 * math.atan(1 / projection[1][1]):.9g}\n"
                    f"width: {size[0]}\nheight: {size[1]}\n", encoding="ascii")
    return True

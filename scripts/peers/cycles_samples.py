"""Blender Cycles as a source of single samples; works in the module bpy and in `blender -b -P`."""
import math

import bpy

# A pixel of the passes is what one camera ray met, as long as a file holds one sample a pixel.
PASSES = ("combined", "z", "normal", "diffuse_color", "glossy_color", "vector", "mist")


def sample_settings(scene, view_layer, bounces=None):
    """Unbiased, unfiltered Cycles: independent samples, a box filter of one pixel, nothing clamped, nothing denoised."""
    render, cycles = scene.render, scene.cycles
    render.engine = "CYCLES"
    render.resolution_percentage = 100
    render.use_border = render.use_multiview = render.use_compositing = render.use_sequencer = render.use_simplify = False
    render.use_persistent_data = True  # the scene is prepared once for all samples of a frame
    cycles.device = "CPU"
    cycles.pixel_filter_type = "BOX"  # always one pixel wide
    cycles.use_adaptive_sampling = cycles.use_denoising = cycles.use_animated_seed = False
    cycles.use_guiding = cycles.use_fast_gi = False
    cycles.sample_clamp_direct = cycles.sample_clamp_indirect = 0  # 0: no clamping
    cycles.blur_glossy = cycles.light_sampling_threshold = 0
    cycles.caustics_reflective = cycles.caustics_refractive = True
    cycles.time_limit = 0
    # Blue noise would make the samples of neighbouring pixels depend on each other.
    cycles.sampling_pattern = "TABULATED_SOBOL" if bpy.app.version >= (3, 5, 0) else "SOBOL"
    cycles.use_auto_tile = False
    if bounces is not None:
        cycles.max_bounces = cycles.diffuse_bounces = cycles.glossy_bounces = cycles.transmission_bounces = bounces
        cycles.min_light_bounces = bounces
    for layer in scene.view_layers:
        layer.use = layer == view_layer
    view_layer.samples = 0  # 0: the scene's number
    for name in PASSES:
        setattr(view_layer, f"use_pass_{name}", True)
    # Cycles knows no motion vectors where it blurs motion.
    view_layer.use_pass_vector = not render.use_motion_blur
    image = render.image_settings
    if hasattr(image, "media_type"):  # Blender 5
        image.media_type = "MULTI_LAYER_IMAGE"
    image.file_format = "OPEN_EXR_MULTILAYER"
    image.exr_codec = "ZIP"


def measure_by_mist(scene, start, depth):
    """Makes the pass Mist the distance to the camera's centre: (distance - start) / depth, 1 where the ray escaped."""
    if scene.world is None:  # no world is black; so is this one
        scene.world = bpy.data.worlds.new("mist")
        scene.world.use_nodes = True
        scene.world.node_tree.nodes["Background"].inputs["Strength"].default_value = 0
    mist = scene.world.mist_settings
    mist.start, mist.depth, mist.falloff = start, depth, "LINEAR"


def render(scene, path, spp, seed, depth=32, first=0):
    """One multi-layer OpenEXR file of the samples first, first + 1, ... of the sequence that `seed` names.

    Cycles sends sample 0 through the middle of the pixel, so a single sample should be another one; the passes Depth and
    Position are of sample 0 only, though. With depth 16 colours are half floats; other passes stay floats.
    """
    scene.render.image_settings.color_depth = str(depth)
    cycles = scene.cycles
    cycles.seed = seed
    cycles.samples = spp
    cycles.sample_offset = first
    if hasattr(cycles, "use_sample_subset"):  # since Blender 4.5
        cycles.use_sample_subset = first > 0
        cycles.sample_subset_length = spp
        cycles.samples = first + spp
    scene.render.filepath = str(path)
    bpy.ops.render.render(write_still=True, scene=scene.name)


def camera_of(scene):
    """The camera at the present frame, as ld_import takes it (see camera_file.py), and its projection."""
    graph = bpy.context.evaluated_depsgraph_get()
    camera = scene.camera.evaluated_get(graph)
    size = (scene.render.resolution_x, scene.render.resolution_y)
    projection = camera.calc_matrix_camera(graph, x=size[0], y=size[1], scale_x=scene.render.pixel_aspect_x,
                                           scale_y=scene.render.pixel_aspect_y)
    matrix = camera.matrix_world.normalized()
    return {"camera_to_world": [list(row) for row in matrix], "fov_y": 2 * math.atan(1 / projection[1][1]),
            "width": size[0], "height": size[1], "projection": [list(row) for row in projection]}

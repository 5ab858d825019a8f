"""Blender Cycles as a source of single samples; works in the module bpy and in `blender -b -P`."""
import math

import bpy

# A pixel of the passes is what one camera ray met, as long as a file holds one sample a pixel.
PASSES = ("combined", "z", "normal", "diffuse_color", "glossy_color", "vector")


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
    cycles.sampling_pattern = "TABULATED_SOBOL"
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


def render(scene, path, spp, seed, depth=32):
    """One multi-layer OpenEXR file. With depth 16 colours are half floats; other passes stay floats."""
    scene.render.image_settings.color_depth = str(depth)
    scene.cycles.samples = spp
    scene.cycles.seed = seed
    scene.render.filepath = str(path)
    bpy.ops.render.render(write_still=True, scene=scene.name)


def camera_of(scene):
    """The camera at the present frame, as ld_import takes it; see camera_file.py."""
    graph = bpy.context.evaluated_depsgraph_get()
    camera = scene.camera.evaluated_get(graph)
    size = (scene.render.resolution_x, scene.render.resolution_y)
    projection = camera.calc_matrix_camera(graph, x=size[0], y=size[1], scale_x=scene.render.pixel_aspect_x,
                                           scale_y=scene.render.pixel_aspect_y)
    matrix = camera.matrix_world.normalized()
    return {"camera_to_world": [list(row) for row in matrix], "fov_y": 2 * math.atan(1 / projection[1][1]),
            "width": size[0], "height": size[1]}

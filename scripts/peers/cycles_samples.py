"""Blender Cycles as a source of single samples, unbiased; works in the module bpy and in `blender -b -P`. What makes a sample one sample
is the extension's own (integrations/blender)."""
import sys
from pathlib import Path

import bpy

sys.path.insert(0, str(Path(__file__).resolve().parents[2] / "integrations/blender/layered_denoiser"))
import sampling  # noqa: E402

camera_of = sampling.camera_of

RENDER = {"resolution_percentage": 100, "use_border": False, "use_multiview": False, "use_simplify": False}
# Nothing clamped, nothing blurred, nothing left out.
CYCLES = {"device": "CPU", "use_guiding": False, "use_fast_gi": False, "sample_clamp_direct": 0, "sample_clamp_indirect": 0,
          "blur_glossy": 0, "light_sampling_threshold": 0, "caustics_reflective": True, "caustics_refractive": True,
          "use_auto_tile": False}


def sample_settings(scene, view_layer, bounces=None):
    """Independent samples, a box filter of one pixel, and light as it is."""
    for owner, values in sampling.settings(scene, view_layer):
        if owner == scene.cycles and bpy.app.version < (3, 5, 0):
            values = {**values, "sampling_pattern": "SOBOL"}
        sampling.set_known(owner, values)
    sampling.set_known(scene.render, RENDER)
    sampling.set_known(scene.cycles, CYCLES)
    if bounces is not None:
        names = ("max_bounces", "diffuse_bounces", "glossy_bounces", "transmission_bounces", "min_light_bounces")
        sampling.set_known(scene.cycles, dict.fromkeys(names, bounces))
    # Cycles knows no motion vectors where it blurs motion.
    view_layer.use_pass_vector = not scene.render.use_motion_blur


def measure_by_mist(scene):
    """Makes the pass Mist the distance to the camera's centre: (distance - start) / depth."""
    sampling.give_world(scene)
    sampling.set_known(*sampling.mist_as_distance(scene))


def render(scene, path, spp, seed, depth=32, first=0):
    """One multi-layer OpenEXR file of spp samples from number `first` on.

    A single sample should be another one than number 0, which goes through the middle of the pixel; the passes Depth and Position are
    of that one only, though. With depth 16 colours are half floats; other passes stay floats.
    """
    scene.render.image_settings.color_depth = str(depth)
    sampling.render(scene, path, seed, spp, first)

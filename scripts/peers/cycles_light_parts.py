"""Renders a small scene of diffuse, glossy, transparent and glowing things with Blender Cycles, sample by sample and with all passes of
light, for `ld_denoise --also` (docs/denoising.md):

    blender -b -P scripts/peers/cycles_light_parts.py -- OUT [SAMPLES [SIDE]]

writes OUT/sample_000.exr, ..., OUT/reference.exr (of 512 samples) and OUT/camera.yaml. Works with the module bpy, too.
"""
import sys
from pathlib import Path

import bpy

sys.path.insert(0, str(Path(__file__).resolve().parent))
import cycles_samples  # noqa: E402
import sampling  # noqa: E402, found by cycles_samples
from example_scene import material, place  # noqa: E402

PASSES = ("diffuse_direct", "diffuse_indirect", "diffuse_color", "glossy_direct", "glossy_indirect", "glossy_color",
          "transmission_direct", "transmission_indirect", "transmission_color", "emit", "environment")


def add_lamp(scene, name, location, energy, colour):
    lamp = bpy.data.lights.new(name, "AREA")
    lamp.energy, lamp.size, lamp.color = energy, 0.6, colour
    lamp = bpy.data.objects.new(name, lamp)
    lamp.location = location
    scene.collection.objects.link(lamp)
    constraint = lamp.constraints.new("TRACK_TO")
    constraint.target = scene.objects["target"]
    constraint.track_axis, constraint.up_axis = "TRACK_NEGATIVE_Z", "UP_Y"
    lamp.lightgroup = name


def build():
    bpy.ops.wm.read_factory_settings(use_empty=True)
    scene, mesh = bpy.context.scene, bpy.ops.mesh
    scene.render.engine = "CYCLES"
    sky = scene.world = bpy.data.worlds.new("sky")
    sky.use_nodes = True
    sky.node_tree.nodes["Background"].inputs["Color"].default_value = (0.2, 0.3, 0.5, 1)
    sky.node_tree.nodes["Background"].inputs["Strength"].default_value = 0.4
    target = bpy.data.objects.new("target", None)
    target.location = (0, 0, 0.6)
    scene.collection.objects.link(target)
    place(mesh.primitive_plane_add, (0, 0, 0), material("floor", texture="ShaderNodeTexChecker", scale=3.0, Roughness=0.5,
                                                        colours=((0.7, 0.65, 0.6), (0.15, 0.2, 0.3))), size=12, smooth=False)
    place(mesh.primitive_uv_sphere_add, (-1.5, 0.3, 0.6), material("clay", "ShaderNodeBsdfDiffuse", colours=((0.8, 0.25, 0.15),)),
          radius=0.6)
    place(mesh.primitive_uv_sphere_add, (-0.2, 1.0, 0.7), material("metal", Metallic=1.0, Roughness=0.2,
                                                                   colours=((0.9, 0.75, 0.4),)), radius=0.7)
    place(mesh.primitive_uv_sphere_add, (0.3, -0.8, 0.5), material("glass", "ShaderNodeBsdfGlass", Roughness=0.0,
                                                                   colours=((0.9, 1.0, 0.95),)), radius=0.5)
    glow = place(mesh.primitive_cube_add, (1.6, 0.2, 0.4), material("glow", "ShaderNodeEmission", colours=((1.0, 0.5, 0.15),),
                                                                    Strength=4.0), size=0.7, turn=(0, 0, 0.5), smooth=False)
    layer = bpy.context.view_layer
    for group in ("key", "rim", "glow", "sky"):
        layer.lightgroups.add(name=group)
    add_lamp(scene, "key", (2.5, -3, 4), 250, (1.0, 0.9, 0.75))
    add_lamp(scene, "rim", (-3.5, 2, 2.5), 120, (0.5, 0.7, 1.0))
    glow.lightgroup, sky.lightgroup = "glow", "sky"
    camera = scene.camera = bpy.data.objects.new("camera", bpy.data.cameras.new("camera"))
    scene.collection.objects.link(camera)
    camera.location = (0.6, -5.5, 2.4)
    camera.constraints.new("TRACK_TO").target = target
    return scene


def main():
    arguments = sys.argv[sys.argv.index("--") + 1:] if "--" in sys.argv else sys.argv[1:]
    out = Path(arguments[0]).resolve()
    samples, side = int(arguments[1]) if len(arguments) > 1 else 8, int(arguments[2]) if len(arguments) > 2 else 128
    out.mkdir(parents=True, exist_ok=True)
    scene, layer = build(), bpy.context.view_layer
    scene.render.resolution_x = scene.render.resolution_y = side
    cycles_samples.sample_settings(scene, layer)
    sampling.set_known(layer, {f"use_pass_{name}": True for name in PASSES})
    for s in range(samples):
        cycles_samples.render(scene, out / f"sample_{s:03}.exr", 1, 1000 + s, first=1)
    cycles_samples.render(scene, out / "reference.exr", 512, 1, first=1)
    sampling.write_camera(scene, out / "camera.yaml")


if __name__ == "__main__":
    main()

"""Renders a short animation with Blender Cycles, sample by sample, for temporal filters (docs/sequences.md): the camera goes round, a ball rolls.

    blender -b -P scripts/peers/cycles_sequence.py -- OUT [FRAMES [SAMPLES [WIDTH [HEIGHT [REFERENCE [BLUR [ONLY]]]]]]]

writes OUT/0000/sample_000.exr, ..., OUT/0000/reference.exr (of REFERENCE samples) and OUT/0000/camera.yaml; OUT/0001 and so on; and
OUT/mapping.txt, what tells the importer where distance and object are. With the passes Vector, object index, and direct, indirect and emitted light.
ONLY, such as 1,4,7, names the frames that get a reference. What is there is kept. With BLUR 1 the camera has a wide lens and its shutter is open for
half of the time; Cycles then writes no Vector pass. Works with the module bpy, too.
"""
import math
import sys
from pathlib import Path

import bpy

sys.path.insert(0, str(Path(__file__).resolve().parent))
import cycles_samples  # noqa: E402
import sampling  # noqa: E402, found by cycles_samples
from example_scene import material, place  # noqa: E402

PASSES = ("vector", "diffuse_direct", "diffuse_indirect", "diffuse_color", "glossy_direct", "glossy_indirect", "glossy_color",
          "transmission_direct", "transmission_indirect", "transmission_color", "emit", "environment")


def add_index_output(layer):
    """Cycles writes the pass of the object index for sample number 0 alone; as a shader's output it is that of every sample."""
    aov = layer.aovs.add()
    aov.name, aov.type = "Object", "VALUE"
    for surface in bpy.data.materials:
        if not surface.use_nodes:
            continue
        nodes = surface.node_tree.nodes
        output = nodes.new("ShaderNodeOutputAOV")
        output.name = "Object"
        surface.node_tree.links.new(nodes.new("ShaderNodeObjectInfo").outputs["Object Index"], output.inputs["Value"])


def build(frames):
    bpy.ops.wm.read_factory_settings(use_empty=True)
    bpy.context.preferences.edit.keyframe_new_interpolation_type = "LINEAR"
    scene, mesh = bpy.context.scene, bpy.ops.mesh
    scene.render.engine = "CYCLES"
    scene.frame_start, scene.frame_end = 0, frames
    sky = scene.world = bpy.data.worlds.new("sky")
    sky.use_nodes = True
    sky.node_tree.nodes["Background"].inputs["Color"].default_value = (0.25, 0.35, 0.5, 1)
    sky.node_tree.nodes["Background"].inputs["Strength"].default_value = 0.3
    place(mesh.primitive_plane_add, (0, 0, 0), material("floor", texture="ShaderNodeTexChecker", scale=2.0, Roughness=0.6,
                                                        colours=((0.7, 0.65, 0.6), (0.15, 0.2, 0.3))), size=14, smooth=False)
    place(mesh.primitive_plane_add, (0, 3, 3), material("wall", "ShaderNodeBsdfDiffuse", colours=((0.75, 0.7, 0.6),)), size=14,
          turn=(math.pi / 2, 0, 0), smooth=False)
    place(mesh.primitive_cube_add, (1.4, 1.0, 0.7), material("box", "ShaderNodeBsdfDiffuse", colours=((0.2, 0.5, 0.25),)), size=1.4,
          turn=(0, 0, 0.6), smooth=False)
    place(mesh.primitive_uv_sphere_add, (-0.2, 1.5, 0.8), material("metal", Metallic=1.0, Roughness=0.25,
                                                                   colours=((0.9, 0.75, 0.4),)), radius=0.8)
    place(mesh.primitive_cube_add, (-2.4, 1.6, 0.3), material("glow", "ShaderNodeEmission", colours=((1.0, 0.5, 0.15),),
                                                              Strength=5.0), size=0.6, smooth=False)
    ball = place(mesh.primitive_uv_sphere_add, (-1.8, -0.4, 0.5), material("ball", "ShaderNodeBsdfDiffuse",
                                                                           colours=((0.8, 0.2, 0.15),)), radius=0.5)
    lamp = bpy.data.lights.new("lamp", "AREA")
    lamp.energy, lamp.size = 300, 1.0
    lamp = bpy.data.objects.new("lamp", lamp)
    lamp.location = (2, -2, 5)
    scene.collection.objects.link(lamp)
    target = bpy.data.objects.new("target", None)
    target.location = (0, 0.6, 0.7)
    scene.collection.objects.link(target)
    camera = scene.camera = bpy.data.objects.new("camera", bpy.data.cameras.new("camera"))
    scene.collection.objects.link(camera)
    for made in (camera, lamp):
        constraint = made.constraints.new("TRACK_TO")
        constraint.target, constraint.track_axis, constraint.up_axis = target, "TRACK_NEGATIVE_Z", "UP_Y"
    for made, first, last in ((ball, (-1.8, -0.4, 0.5), (1.4, -0.7, 0.5)), (camera, (-1.2, -6.0, 2.2), (1.0, -5.6, 1.8))):
        for frame, location in ((0, first), (frames, last)):
            made.location = location
            made.keyframe_insert("location", frame=frame)
    for index, made in enumerate((made for made in scene.objects if made.type == "MESH"), start=1):
        made.pass_index = index
    return scene


def blur(scene):
    lens = scene.camera.data.dof
    lens.use_dof, lens.focus_object, lens.aperture_fstop = True, bpy.data.objects["target"], 0.4
    scene.render.use_motion_blur, scene.render.motion_blur_shutter = True, 0.5


def main():
    arguments = sys.argv[sys.argv.index("--") + 1:] if "--" in sys.argv else sys.argv[1:]
    out = Path(arguments[0]).resolve()
    numbers = [int(x) for x in arguments[1:7]]
    frames, samples, width, height, reference, blurred = numbers + [16, 2, 160, 90, 128, 0][len(numbers):]
    referenced = {int(x) for x in arguments[7].split(",")} if len(arguments) > 7 else set(range(frames))
    scene, layer = build(frames), bpy.context.view_layer
    if blurred:
        blur(scene)
    scene.render.resolution_x, scene.render.resolution_y = width, height
    cycles_samples.sample_settings(scene, layer)
    cycles_samples.measure_by_mist(scene)
    sampling.set_known(layer, {f"use_pass_{name}": True for name in PASSES})
    add_index_output(layer)
    for frame in range(frames):
        folder = out / f"{frame:04}"
        folder.mkdir(parents=True, exist_ok=True)
        scene.frame_set(frame + 1)
        pictures = [(f"sample_{s:03}.exr", 1, s) for s in range(samples)]
        if frame in referenced:
            pictures.append(("reference.exr", reference, 999))
        for name, spp, stream in pictures:
            if not (folder / name).exists():
                cycles_samples.render(scene, folder / "unfinished.exr", spp, 1000 * frame + stream, first=1)
                (folder / "unfinished.exr").rename(folder / name)
        sampling.write_camera(scene, folder / "camera.yaml")
    assignments = [*sampling.depth_assignments(scene), 'id.channels=["{layer}.Object.X | {layer}.Object.V"]']
    (out / "mapping.txt").write_text("".join(line + "\n" for line in assignments), encoding="ascii")


if __name__ == "__main__":
    main()

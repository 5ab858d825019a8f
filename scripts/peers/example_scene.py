"""Makes a .blend file to try blender_dataset.py on: example_scene.py FILE.blend

A tiled floor under a sky and a lamp, objects with textures, metal, glass and lacquer, depth of field, things that move and turn
with motion blur, and a camera that goes round them. 48 frames.
"""
import math
import sys

import bpy

FRAMES = 48


def material(name, kind="ShaderNodeBsdfPrincipled", texture=None, colours=((0.8, 0.8, 0.8), (0.2, 0.2, 0.2)), scale=5.0,
             **inputs):
    """A material of one shader; a texture mixes two colours into its colour."""
    made = bpy.data.materials.new(name)
    made.use_nodes = True
    tree = made.node_tree
    tree.nodes.clear()
    shader, output = tree.nodes.new(kind), tree.nodes.new("ShaderNodeOutputMaterial")
    tree.links.new(shader.outputs[0], output.inputs["Surface"])
    colour = shader.inputs["Color" if "Color" in shader.inputs else "Base Color"]
    colour.default_value = (*colours[0], 1)
    for key, value in inputs.items():
        shader.inputs[key.replace("_", " ")].default_value = value
    if texture:
        pattern, ramp = tree.nodes.new(texture), tree.nodes.new("ShaderNodeValToRGB")
        places = tree.nodes.new("ShaderNodeTexCoord")
        pattern.inputs["Scale"].default_value = scale
        for element, value in zip(ramp.color_ramp.elements, colours):
            element.color = (*value, 1)
        tree.links.new(places.outputs["Object"], pattern.inputs["Vector"])
        tree.links.new(pattern.outputs["Fac" if "Fac" in pattern.outputs else "Distance"], ramp.inputs[0])
        tree.links.new(ramp.outputs[0], colour)
    return made


def place(operator, location, surface, turn=(0, 0, 0), smooth=True, **arguments):
    operator(location=location, rotation=turn, **arguments)
    made = bpy.context.object
    made.data.materials.append(surface)
    if smooth:
        bpy.ops.object.shade_smooth()
    return made


def key(made, path, *values):
    """Values at even steps over the animation."""
    for i, value in enumerate(values):
        setattr(made, path, value)
        made.keyframe_insert(path, frame=1 + i * (FRAMES - 1) / (len(values) - 1))


def build():
    bpy.ops.wm.read_factory_settings(use_empty=True)
    bpy.context.preferences.edit.keyframe_new_interpolation_type = "LINEAR"
    scene, mesh = bpy.context.scene, bpy.ops.mesh
    scene.render.engine = "CYCLES"
    scene.frame_start, scene.frame_end = 1, FRAMES
    scene.render.use_motion_blur, scene.render.motion_blur_shutter = True, 0.5

    sky = scene.world = bpy.data.worlds.new("sky")
    sky.use_nodes = True
    sky.node_tree.nodes["Background"].inputs["Color"].default_value = (0.35, 0.5, 0.9, 1)
    sky.node_tree.nodes["Background"].inputs["Strength"].default_value = 0.6

    place(mesh.primitive_plane_add, (0, 0, 0), material("floor", texture="ShaderNodeTexChecker", scale=1.5, Roughness=0.4,
                                                        colours=((0.75, 0.7, 0.6), (0.2, 0.12, 0.1))), size=30, smooth=False)
    place(mesh.primitive_cube_add, (0, 4.5, 1.5), material("wall", "ShaderNodeBsdfDiffuse", "ShaderNodeTexNoise", scale=2.0,
                                                           colours=((0.75, 0.3, 0.2), (0.2, 0.35, 0.6))),
          scale=(6, 0.2, 1.5), smooth=False)
    place(mesh.primitive_uv_sphere_add, (-2.2, 0.6, 0.8), material("gold", "ShaderNodeBsdfAnisotropic", Roughness=0.25,
                                                                   colours=((0.95, 0.7, 0.3),)), radius=0.8)
    place(mesh.primitive_uv_sphere_add, (1.9, -0.9, 0.6), material("glass", "ShaderNodeBsdfGlass", Roughness=0.0,
                                                                   colours=((0.95, 1.0, 0.95),)), radius=0.6)
    monkey = place(mesh.primitive_monkey_add, (0.1, 1.2, 1.1), material("lacquer", texture="ShaderNodeTexVoronoi", scale=4.0,
                                                                        colours=((0.1, 0.5, 0.25), (0.9, 0.85, 0.5)),
                                                                        Roughness=0.15), size=1.8)
    cube = place(mesh.primitive_cube_add, (2.6, 1.4, 1.0), material("cube", texture="ShaderNodeTexNoise", scale=9.0,
                                                                    colours=((0.1, 0.15, 0.6), (0.9, 0.9, 0.9))),
                 size=1.1, smooth=False)
    ball = place(mesh.primitive_uv_sphere_add, (-1, -1, 0.35), material("ball", colours=((0.85, 0.08, 0.06),), Roughness=0.3),
                 radius=0.35)
    place(mesh.primitive_torus_add, (-0.9, -0.1, 0.2), material("steel", Metallic=1.0, Roughness=0.35,
                                                                colours=((0.6, 0.62, 0.65),)),
          major_radius=0.55, minor_radius=0.2)
    key(monkey, "rotation_euler", (0, 0, -0.6), (0.2, 0, 0.6))
    key(cube, "rotation_euler", (0, 0, 0), (3, 4, 5))
    key(ball, "location", (-2.5, -1.6, 0.35), (0, -1.8, 1.8), (2.5, -1.6, 0.35))

    lamp = bpy.data.lights.new("lamp", "AREA")
    lamp.energy, lamp.size, lamp.color = 500, 1.5, (1.0, 0.9, 0.75)
    lamp = bpy.data.objects.new("lamp", lamp)
    lamp.location, lamp.rotation_euler = (3, -3, 5), (0.6, 0.5, 0)
    scene.collection.objects.link(lamp)

    camera = scene.camera = bpy.data.objects.new("camera", bpy.data.cameras.new("camera"))
    scene.collection.objects.link(camera)
    target = bpy.data.objects.new("target", None)
    target.location = (0, 0.6, 0.8)
    scene.collection.objects.link(target)
    camera.constraints.new("TRACK_TO").target = target
    camera.data.dof.use_dof, camera.data.dof.focus_object, camera.data.dof.aperture_fstop = True, target, 0.6
    angles = [-2.6 + 2.0 * i / 8 for i in range(9)]
    key(camera, "location", *[(7.5 * math.cos(a), 7.5 * math.sin(a), 2.2 + 0.8 * math.sin(2 * a)) for a in angles])
    scene.frame_set(1)


if __name__ == "__main__":
    build()
    bpy.ops.wm.save_as_mainfile(filepath=sys.argv[-1], compress=True)

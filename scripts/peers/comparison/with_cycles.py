"""Renders a scene of scenes.py with Blender Cycles."""
import math

import bpy
import mathutils
import numpy as np

import cycles_samples
from comparison import exr

Z_UP = np.array([[1.0, 0, 0, 0], [0, 0, -1, 0], [0, 1, 0, 0], [0, 0, 0, 1]])  # Blender's worlds have +z on top


def set_inputs(shader, **values):
    for key, value in values.items():
        found = shader.inputs[key.replace("_", " ")]
        found.default_value = (*value, 1.0) if len(np.shape(value)) and len(found.default_value) == 4 else value


def surface_of(tree, material):
    kind, new = material["kind"], tree.nodes.new
    if kind == "diffuse":
        shader = new("ShaderNodeBsdfDiffuse")
        set_inputs(shader, Color=material["colour"], Roughness=0.0)
    elif kind == "rough_conductor":
        shader = new("ShaderNodeBsdfMetallic")  # since Blender 4.3
        shader.fresnel_type, shader.distribution = "PHYSICAL_CONDUCTOR", "GGX"
        set_inputs(shader, IOR=material["eta"], Extinction=material["k"], Roughness=material["roughness"])
    else:
        shader = new("ShaderNodeBsdfGlass")
        shader.distribution = "GGX"
        set_inputs(shader, Color=material["colour"], IOR=material["ior"], Roughness=material.get("roughness", 0.0))
    if "emission" not in material:
        return shader.outputs[0]
    # Cycles' surfaces shine on both sides.
    light, mix, side = new("ShaderNodeEmission"), new("ShaderNodeMixShader"), new("ShaderNodeNewGeometry")
    strength = max(material["emission"])
    set_inputs(light, Color=np.divide(material["emission"], strength), Strength=strength)
    tree.links.new(side.outputs["Backfacing"], mix.inputs[0])
    tree.links.new(light.outputs[0], mix.inputs[1])
    tree.links.new(shader.outputs[0], mix.inputs[2])
    return mix.outputs[0]


def add_materials(scene):
    made = {}
    for name, material in scene["materials"].items():
        made[name] = bpy.data.materials.new(name)
        made[name].use_nodes = True
        tree = made[name].node_tree
        tree.nodes.clear()
        tree.links.new(surface_of(tree, material), tree.nodes.new("ShaderNodeOutputMaterial").inputs["Surface"])
        if "emission" in material:
            made[name].cycles.emission_sampling = "FRONT"
    return made


def add_mesh(target, mesh, surface):
    turn = Z_UP[:3, :3]
    made = bpy.data.meshes.new("mesh")
    made.from_pydata((mesh["positions"] @ turn.T).tolist(), [], mesh["triangles"].tolist())
    made.shade_smooth()
    made.normals_split_custom_set_from_vertices((mesh["normals"] @ turn.T).tolist())
    made.materials.append(surface)
    placed = bpy.data.objects.new("mesh", made)
    placed.shadow_terminator_geometry_offset = placed.shadow_terminator_shading_offset = 0.0
    target.collection.objects.link(placed)


def add_sky(target, scene, folder):
    world = target.world = bpy.data.worlds.new("world")
    world.use_nodes = True
    background = world.node_tree.nodes["Background"]
    if scene["probe"] is None:
        background.inputs["Strength"].default_value = 0
        return
    # Blender has +x in the middle column; ours, -z, is Blender's +y.
    exr.write(folder / "probe_cycles.exr", np.roll(scene["probe"], -(scene["probe"].shape[1] // 4), axis=1))
    picture = world.node_tree.nodes.new("ShaderNodeTexEnvironment")
    picture.image = bpy.data.images.load(str(folder / "probe_cycles.exr"))
    picture.image.colorspace_settings.name = "Non-Color"
    world.node_tree.links.new(picture.outputs["Color"], background.inputs["Color"])


def build(scene, folder):
    bpy.ops.wm.read_factory_settings(use_empty=True)
    target = bpy.context.scene
    camera = bpy.data.cameras.new("camera")
    camera.sensor_fit, camera.angle_y = "VERTICAL", scene["camera"]["fov_y"]
    camera.clip_start = 1e-3
    target.camera = bpy.data.objects.new("camera", camera)
    target.camera.matrix_world = mathutils.Matrix((Z_UP @ scene["camera"]["camera_to_world"]).tolist())
    target.collection.objects.link(target.camera)
    target.render.resolution_x, target.render.resolution_y = scene["camera"]["width"], scene["camera"]["height"]
    materials = add_materials(scene)
    for mesh in scene["meshes"]:
        add_mesh(target, mesh, materials[mesh["material"]])
    for point in scene["points"]:
        light = bpy.data.lights.new("point", "POINT")
        # Blender gives the power of a point light in watts.
        light.energy = 4 * math.pi * max(point["intensity"])
        light.color, light.shadow_soft_size = np.divide(point["intensity"], max(point["intensity"])), 0.0
        placed = bpy.data.objects.new("point", light)
        placed.location = Z_UP[:3, :3] @ np.array(point["position"])
        target.collection.objects.link(placed)
    add_sky(target, scene, folder)
    return target


def render(scene, folder, spp, threads):
    target = build(scene, folder)
    # Cycles counts the scatterings before the last one.
    cycles_samples.sample_settings(target, bpy.context.view_layer, bounces=scene["max_bounces"] - 1)
    target.render.threads_mode, target.render.threads = "FIXED", threads
    cycles_samples.render(target, folder / "cycles.exr", spp, 1)
    return exr.read(folder / "cycles.exr", "ViewLayer.Combined.")

#!/usr/bin/env python3
"""Writes the files that the importer is tested on, by Blender Cycles and by Mitsuba 3: import_fixtures.py FOLDER

A tilted plane, a diffuse and a metal sphere before a bright sky, seen by a camera that is turned against all axes of the world.
Beside the files: the camera, and a README.md with the values at four pixels that follow from the scene alone.
"""
import argparse
import math
from pathlib import Path

import bpy
import mathutils
import mitsuba
import numpy as np

import camera_file
import cycles_samples

WIDTH, HEIGHT, SPP, REFERENCE_SPP = 16, 12, 4, 1024
FOV_Y = 0.7
CAMERA = mathutils.Matrix.LocRotScale(mathutils.Vector((1.5, -2.0, 0.8)), mathutils.Euler((1.1, 0.3, -0.7), "XYZ"), None)
SKY = (0.8, 1.0, 1.5)
# In the camera's frame: +x right, +y up, looking along -z.
PLANE = {"centre": (-1.2, 0.0, -5.0), "normal": (0.36, 0.48, 0.8), "half_side": 2.2, "albedo": (0.5, 0.3, 0.2)}
SPHERE = {"centre": (-0.5, 0.35, -3.0), "radius": 0.45, "albedo": (0.2, 0.6, 0.4)}
METAL = {"centre": (-0.35, -0.6, -3.0), "radius": 0.35, "colour": (0.9, 0.7, 0.3), "roughness": 0.6}
STEP = (0.1, 0.06, 0.0)  # of the metal sphere from a frame to the next, in moving.exr
PIXELS = {"plane": (1, 8), "diffuse sphere": (5, 3), "metal sphere": (6, 9), "sky": (14, 6)}


def world(point):
    return CAMERA @ mathutils.Vector(point)


def plane_to_world():
    """Takes the square [-1, 1]^2 in the xy plane, facing +z, to the plane of the scene."""
    turn = mathutils.Vector((0, 0, 1)).rotation_difference(mathutils.Vector(PLANE["normal"]))
    return CAMERA @ mathutils.Matrix.LocRotScale(mathutils.Vector(PLANE["centre"]), turn,
                                                 mathutils.Vector((PLANE["half_side"],) * 3))


def expected(pixel):
    """What the ray through the middle of a pixel meets: (name, normal in view space, depth, distance, albedo)."""
    x, y = pixel
    tangent = math.tan(FOV_Y / 2)
    ray = np.array([(2 * (x + 0.5) / WIDTH - 1) * tangent * WIDTH / HEIGHT, (1 - 2 * (y + 0.5) / HEIGHT) * tangent, -1.0])
    ray /= np.linalg.norm(ray)
    hits = []
    normal = np.array(PLANE["normal"])
    distance = normal @ PLANE["centre"] / (normal @ ray)
    if np.abs(np.linalg.inv(np.array(plane_to_world()))[:3] @ np.append(np.array(world(ray * distance)), 1)).max() < 1:
        hits.append((distance, "plane", normal, PLANE["albedo"]))
    for name, ball in (("diffuse sphere", SPHERE), ("metal sphere", METAL)):
        centre = np.array(ball["centre"])
        along = ray @ centre
        square = along ** 2 - centre @ centre + ball["radius"] ** 2
        if square > 0:
            distance = along - math.sqrt(square)
            hits.append((distance, name, (ray * distance - centre) / ball["radius"], ball.get("albedo", (0, 0, 0))))
    if not hits:
        return "sky", np.zeros(3), None, None, (0, 0, 0)
    distance, name, normal, albedo = min(hits, key=lambda hit: hit[0])
    return name, normal, -ray[2] * distance, distance, albedo


def blender_material(name, node_type, colour, roughness):
    material = bpy.data.materials.new(name)
    material.use_nodes = True
    nodes = material.node_tree.nodes
    nodes.clear()
    shader, output = nodes.new(node_type), nodes.new("ShaderNodeOutputMaterial")
    shader.inputs["Color"].default_value = (*colour, 1)
    shader.inputs["Roughness"].default_value = roughness
    if hasattr(shader, "distribution"):
        shader.distribution = "GGX"  # without the energy that other distributions give back, as in Mitsuba
    material.node_tree.links.new(shader.outputs[0], output.inputs["Surface"])
    return material


def build_in_blender():
    bpy.ops.wm.read_factory_settings(use_empty=True)
    scene = bpy.context.scene
    sky = bpy.data.worlds.new("sky")
    sky.use_nodes = True
    sky.node_tree.nodes["Background"].inputs["Color"].default_value = (*SKY, 1)
    scene.world = sky
    camera = bpy.data.cameras.new("camera")
    camera.sensor_fit, camera.angle_y = "VERTICAL", FOV_Y
    scene.camera = bpy.data.objects.new("camera", camera)
    scene.camera.matrix_world = CAMERA
    scene.collection.objects.link(scene.camera)
    scene.render.resolution_x, scene.render.resolution_y = WIDTH, HEIGHT

    bpy.ops.mesh.primitive_plane_add(size=2)
    bpy.context.object.matrix_world = plane_to_world()
    bpy.context.object.data.materials.append(blender_material("plane", "ShaderNodeBsdfDiffuse", PLANE["albedo"], 0))
    for ball, node_type in ((SPHERE, "ShaderNodeBsdfDiffuse"), (METAL, "ShaderNodeBsdfAnisotropic")):
        bpy.ops.mesh.primitive_uv_sphere_add(segments=128, ring_count=64, radius=ball["radius"], location=world(ball["centre"]))
        bpy.context.object.name = "metal" if ball is METAL else "sphere"
        bpy.ops.object.shade_smooth()
        colour = ball.get("albedo") or ball["colour"]
        bpy.context.object.data.materials.append(blender_material("ball", node_type, colour, ball.get("roughness", 0)))
    return scene


def write_stereo(scene, path):
    """Two views in one file: channels with the view's name from Blender 4, parts with it from Blender 5."""
    stereo = scene.camera.data.stereo
    stereo.interocular_distance, stereo.convergence_mode, stereo.pivot = 0.4, "PARALLEL", "LEFT"
    render, image = scene.render, scene.render.image_settings
    render.use_multiview, render.views_format, image.views_format = True, "STEREO_3D", "MULTIVIEW"
    cycles_samples.render(scene, path, 1, 0)
    render.use_multiview = False


def write_cycles(folder):
    scene = build_in_blender()
    cycles_samples.sample_settings(scene, bpy.context.view_layer, bounces=4)
    for s in range(SPP):
        cycles_samples.render(scene, folder / f"sample_{s:02}.exr", 1, s)
    cycles_samples.render(scene, folder / "reference.exr", REFERENCE_SPP, SPP)
    cycles_samples.render(scene, folder / "half.exr", 1, 0, depth=16)
    write_stereo(scene, folder / "stereo.exr")
    scene.render.film_transparent = True
    cycles_samples.render(scene, folder / "transparent_sky.exr", 1, 0)
    scene.render.film_transparent = False
    bpy.context.preferences.edit.keyframe_new_interpolation_type = "LINEAR"
    metal = scene.objects["metal"]
    for frame in (0, 1, 2):
        metal.location = world(METAL["centre"]) + CAMERA.to_3x3() @ mathutils.Vector(STEP) * (frame - 1)
        metal.keyframe_insert("location", frame=frame)
    scene.frame_set(1)
    cycles_samples.render(scene, folder / "moving.exr", 1, 0)
    scene.render.use_motion_blur = True
    bpy.context.view_layer.use_pass_vector = False
    cycles_samples.render(scene, folder / "no_vector.exr", 1, 0)
    camera_file.write(folder / "camera.yaml", cycles_samples.camera_of(scene))
    return f"Blender {bpy.app.version_string}, Cycles on the CPU"


def write_mitsuba(folder):
    mitsuba.set_variant("scalar_rgb")
    transform = mitsuba.ScalarTransform4f

    def ball(values, bsdf):
        return {"type": "sphere", "center": list(world(values["centre"])), "radius": values["radius"], "bsdf": bsdf}

    def diffuse(colour):
        return {"type": "diffuse", "reflectance": {"type": "rgb", "value": list(colour)}}

    # Mitsuba's cameras look along +z with +x to the left.
    to_world = np.array(CAMERA) @ np.diag([-1.0, 1, -1, 1])
    scene = mitsuba.load_dict({
        "type": "scene",
        "integrator": {"type": "aov",
                       "aovs": "albedo:albedo,nn:sh_normal,depth:depth,position:position",
                       "image": {"type": "path", "max_depth": 5}},
        "sensor": {"type": "perspective", "fov": math.degrees(FOV_Y), "fov_axis": "y", "to_world": transform(to_world),
                   "film": {"type": "hdrfilm", "width": WIDTH, "height": HEIGHT, "rfilter": {"type": "box"},
                            "pixel_format": "rgba", "component_format": "float32"}},
        "sky": {"type": "constant", "radiance": {"type": "rgb", "value": list(SKY)}},
        "plane": {"type": "rectangle", "to_world": transform(np.array(plane_to_world())),
                  "bsdf": {"type": "twosided", "bsdf": diffuse(PLANE["albedo"])}},
        "sphere": ball(SPHERE, diffuse(SPHERE["albedo"])),
        "metal": ball(METAL, {"type": "roughconductor", "material": "none", "alpha": METAL["roughness"] ** 2,
                              "distribution": "ggx",
                              "specular_reflectance": {"type": "rgb", "value": list(METAL["colour"])}})})
    for name, spp, seed in [(f"sample_{s:02}", 1, s) for s in range(SPP)] + [("reference", REFERENCE_SPP, SPP)]:
        mitsuba.render(scene, spp=spp, seed=seed)
        scene.sensors()[0].film().bitmap().write(str(folder / f"{name}.exr"))
    camera_file.write(folder / "camera.yaml", {"camera_to_world": [list(row) for row in CAMERA], "fov_y": FOV_Y,
                                               "width": WIDTH, "height": HEIGHT})
    return f"Mitsuba {mitsuba.__version__}, variant scalar_rgb"


README = """\
# {title}

Written by `scripts/peers/import_fixtures.py`. {width} x {height} pixels, row 0 on top.

- `sample_00.exr` ... `sample_{last:02}.exr`: one sample a pixel each, with seeds 0 to {last}, box filter of one pixel.
- `reference.exr`: {reference} samples a pixel with seed {spp}.
{more}- `camera.yaml`: the camera. The vertical field of view is {fov} radians.

Sky: radiance {sky}, constant, the only light. Expected at the middle of pixels (x, y); within a sample the ray goes through any
point of the pixel, so values on spheres differ from these by some per cent:

| pixel | what | normal in view space | normal in world space | depth along the axis | distance | position in the world | diffuse colour |
| --- | --- | --- | --- | --- | --- | --- | --- |
{rows}
The plane goes through {plane} in view space with view normal {normal}: a point of it with view coordinates p has n . p = {offset:.4f}.
The metal sphere: specular colour {metal}, GGX with roughness {roughness} (alpha {alpha:.2f}).

{conventions}"""

CYCLES = """\
Cycles sends the first sample of a render, the only one of these files, through the middle of the pixel whatever the seed: the
table's values hold exactly, but for the spheres being meshes. Normals are in world space and look towards the camera; `Depth.Z` is
along the axis, of the first sample only, 1e10 where the ray escaped; normal and colours are 0 there. `Vector` has four channels
in pixels, y up: from the point to where it was in the frame before (X, Y), and from where it will be in the next one to the point
(Z, W).
"""
CYCLES_MORE = """\
- `half.exr`: `sample_00.exr` written as half floats: depth, normals and vectors stay floats.
- `stereo.exr`: the view `left` from the camera's own place and the view `right` from 0.4 to the right of it, one sample a pixel each with
  seed 0. `cycles5/stereo.exr`: the same by Blender 5.0.1.
- `transparent_sky.exr`: the same with a transparent film: alpha 0 in the sky.
- `moving.exr`: the metal sphere moves by {step} in view space from each frame to the next, which is ({flow_x:.4f}, {flow_y:.4f}) pixels with y
  up where the depth is that of the table's pixel. `no_vector.exr`: the same with motion blur, for which Cycles leaves the pass Vector out.
"""
MITSUBA = """\
The ray of a sample goes through a random point of the pixel. `nn` (AOV `sh_normal`) is in world space and looks to the outside of the
surface, wherever the camera is. `depth.T` is the distance along the ray from the near clipping plane (here 0.01 before the camera
along the axis), 0 where the ray escaped. `position` is in world space, (0, 0, 0) where the ray escaped: the depth along the axis is
-z of the position in view space, which is exact with a thin lens, too. `albedo` is the diffuse reflectance for diffuse surfaces
only; for others Mitsuba gives pi times the BSDF at normal incidence, which may be above 1 (about (1.35, 1.05, 0.45) on the metal
sphere). There is no AOV of the specular colour nor of the roughness. `image.*` repeats R, G, B and A.
"""


def text(vector):
    return "(" + ", ".join(f"{value:.4f}" for value in vector) + ")"


def readme(title, conventions, more):
    rows = ""
    for wanted, pixel in PIXELS.items():
        name, normal, depth, distance, albedo = expected(pixel)
        assert name == wanted, (name, wanted, pixel)
        if depth is None:
            rows += f"| {pixel} | sky | | | escaped | escaped | | |\n"
            continue
        turn = np.array(CAMERA)[:3, :3]
        x, y = (2 * (pixel[0] + 0.5) / WIDTH - 1) * WIDTH / HEIGHT, 1 - 2 * (pixel[1] + 0.5) / HEIGHT
        view = np.array([x * math.tan(FOV_Y / 2), y * math.tan(FOV_Y / 2), -1.0]) * depth
        rows += (f"| {pixel} | {name} | {text(normal)} | {text(turn @ normal)} | {depth:.4f} | {distance:.4f} | "
                 f"{text(world(view))} | {text(albedo)} |\n")
    scale = HEIGHT / 2 / math.tan(FOV_Y / 2) / expected(PIXELS["metal sphere"])[2]
    more = more.format(step=STEP, flow_x=STEP[0] * scale, flow_y=STEP[1] * scale)
    return README.format(title=title, width=WIDTH, height=HEIGHT, last=SPP - 1, spp=SPP, reference=REFERENCE_SPP, fov=FOV_Y,
                         more=more, sky=SKY, rows=rows, plane=PLANE["centre"], normal=PLANE["normal"],
                         offset=float(np.dot(PLANE["centre"], PLANE["normal"])), metal=METAL["colour"],
                         roughness=METAL["roughness"], alpha=METAL["roughness"] ** 2, conventions=conventions)


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("folder", type=Path)
    options = parser.parse_args()
    for name, write, conventions, more in (("cycles", write_cycles, CYCLES, CYCLES_MORE), ("mitsuba", write_mitsuba, MITSUBA, "")):
        folder = (options.folder / name).resolve()
        folder.mkdir(parents=True, exist_ok=True)
        title = write(folder)
        (folder / "README.md").write_text(readme(title, conventions, more))
        print(f"import_fixtures: {folder}: {len(list(folder.glob('*.exr')))} files by {title}")


if __name__ == "__main__":
    main()

"""What the scenes of the Cycles test set are made of: shapes, lights, cameras, motion. z is up; a unit is what a scene likes."""
import math
import random
from pathlib import Path

import bmesh
import bpy
from mathutils import Matrix, Vector

from surfaces import node_tree


def begin(exposure=1.0):
    """An empty scene whose keys are linear between frames 0 and 2; frame 1 is what is rendered."""
    bpy.ops.wm.read_factory_settings(use_empty=True)
    bpy.context.preferences.edit.keyframe_new_interpolation_type = "LINEAR"
    scene = bpy.context.scene
    scene.render.engine = "CYCLES"
    scene.cycles.film_exposure = exposure
    scene.frame_start, scene.frame_end = 0, 2


# Shapes

def finish(made, material, smooth=True):
    made.data.materials.clear()
    made.data.materials.append(material)
    for polygon in made.data.polygons:
        polygon.use_smooth = smooth
    if smooth:
        made.data.set_sharp_from_angle(angle=0.7)
    return made


def shape(kind, material, location, smooth=True, turn=(0, 0, 0), **arguments):
    """One of Blender's primitives: "uv_sphere", "cylinder", "torus", "plane", ..."""
    getattr(bpy.ops.mesh, f"primitive_{kind}_add")(location=location, rotation=turn, **arguments)
    return finish(bpy.context.object, material, smooth)


def ball(material, location, radius, **arguments):
    return shape("uv_sphere", material, location, radius=radius, segments=48, ring_count=24, **arguments)


def spark(material, location, radius):
    """A ball of few triangles: Cycles chooses among all that shine."""
    return shape("ico_sphere", material, location, radius=radius, subdivisions=2)


def box(material, location, size, turn=(0, 0, 0), bevel=0.0):
    """size: full widths; the location is the middle of its bottom."""
    middle = Vector(location) + Matrix.Rotation(turn[2], 3, "Z") @ Vector((0, 0, size[2] / 2))
    made = shape("cube", material, middle, smooth=False, turn=turn, size=1)
    made.data.transform(Matrix.Diagonal((*size, 1)))
    if bevel:
        rounded = made.modifiers.new("bevel", "BEVEL")
        rounded.width, rounded.segments = bevel, 3
    return made


def floor(material, size=40, height=0.0):
    return shape("plane", material, (0, 0, height), smooth=False, size=size)


def wall(material, location, width, height, turn=0.0):
    """An upright rectangle whose texture lies in it; location: the middle of its lower edge."""
    made = shape("plane", material, Vector(location) + Vector((0, 0, height / 2)), False, (math.pi / 2, 0, turn), size=1)
    made.data.transform(Matrix.Diagonal((width, height, 1, 1)))
    return made


def mesh_of(vertices, faces, material, location=(0, 0, 0), smooth=True):
    mesh = bpy.data.meshes.new("mesh")
    mesh.from_pydata(vertices, [], faces)
    made = bpy.data.objects.new("mesh", mesh)
    made.location = location
    bpy.context.scene.collection.objects.link(made)
    return finish(made, material, smooth)


def lathe(profile, material, location, segments=64, rounded=True, turn=(0, 0, 0)):
    """Turns a profile of (radius, height) about z; rounded: a smooth curve through the points."""
    points = [Vector(point).to_3d() for point in profile]
    if rounded:
        curve = []
        for i in range(len(points) - 1):
            before, a = points[max(i - 1, 0)], points[i]
            b, after = points[i + 1], points[min(i + 2, len(points) - 1)]
            for t in (0, 0.25, 0.5, 0.75):
                curve.append(0.5 * (2 * a + (b - before) * t + (2 * before - 5 * a + 4 * b - after) * t * t
                                    + (3 * a - before - 3 * b + after) * t ** 3))
        points = curve + [points[-1]]
    work = bmesh.new()
    rings = []
    for k in range(segments):
        c, s = math.cos(2 * math.pi * k / segments), math.sin(2 * math.pi * k / segments)
        rings.append([work.verts.new((max(p.x, 0) * c, max(p.x, 0) * s, p.y)) for p in points])
    for k in range(segments):
        here, there = rings[k], rings[(k + 1) % segments]
        for i in range(len(points) - 1):
            work.faces.new((here[i], there[i], there[i + 1], here[i + 1]))
    bmesh.ops.remove_doubles(work, verts=work.verts, dist=1e-5)
    bmesh.ops.recalc_face_normals(work, faces=work.faces)
    mesh = bpy.data.meshes.new("lathe")
    work.to_mesh(mesh)
    work.free()
    made = bpy.data.objects.new("lathe", mesh)
    made.location, made.rotation_euler = location, turn
    bpy.context.scene.collection.objects.link(made)
    return finish(made, material)


def wires(lines, radius, material, sides=6):
    """Round tubes along polylines, all in one mesh."""
    vertices, faces = [], []
    for line in lines:
        points = [Vector(point) for point in line]
        start = len(vertices)
        for i, point in enumerate(points):
            along = (points[min(i + 1, len(points) - 1)] - points[max(i - 1, 0)]).normalized()
            side = along.orthogonal().normalized() if i == 0 else (side - along * side.dot(along)).normalized()
            other = along.cross(side)
            for k in range(sides):
                angle = 2 * math.pi * k / sides
                vertices.append(point + radius * (math.cos(angle) * side + math.sin(angle) * other))
        for i in range(len(points) - 1):
            for k in range(sides):
                a, b = start + i * sides + k, start + i * sides + (k + 1) % sides
                faces.append((a, b, b + sides, a + sides))
    return mesh_of(vertices, faces, material)


def blades(roots, length, width, material, rng, lean=0.6):
    """Bent, tapering blades of grass or leaves that grow from `roots`, all in one mesh."""
    vertices, faces = [], []
    for root in roots:
        angle, tall = rng.uniform(0, 2 * math.pi), length * rng.uniform(0.5, 1.0)
        out = Vector((math.cos(angle), math.sin(angle), 0)) * lean * rng.uniform(0.2, 1.0)
        across = Vector((-math.sin(angle), math.cos(angle), 0))
        start, steps = len(vertices), 5
        for i in range(steps):
            t = i / (steps - 1)
            middle = Vector(root) + tall * (out * t * t + Vector((0, 0, t * (1 - 0.3 * lean * t))))
            half = 0.5 * width * (1 - t) ** 0.7 * rng.uniform(0.9, 1.1)
            vertices += [middle - half * across, middle + half * across]
        faces += [(start + 2 * i, start + 2 * i + 1, start + 2 * i + 3, start + 2 * i + 2) for i in range(steps - 1)]
    return mesh_of(vertices, faces, material)


def model(path, material, location, size, turn=(0, 0, 0), upright="z"):
    """An OBJ file, scaled so that its largest side is `size` and turned; the location is the middle of its bottom."""
    bpy.ops.wm.obj_import(filepath=str(path), up_axis="Z" if upright == "z" else "Y",
                          forward_axis="Y" if upright == "z" else "NEGATIVE_Z")
    parts = [part for part in bpy.context.selected_objects if part.type == "MESH"]
    bpy.context.view_layer.objects.active = parts[0]
    if len(parts) > 1:
        bpy.ops.object.join()
    made = bpy.context.object
    made.data.transform(made.matrix_world)
    made.matrix_world = Matrix.Identity(4)
    made.data.transform(Matrix.Rotation(turn[2], 4, "Z") @ Matrix.Rotation(turn[1], 4, "Y") @ Matrix.Rotation(turn[0], 4, "X"))
    low = Vector([min(v.co[i] for v in made.data.vertices) for i in range(3)])
    high = Vector([max(v.co[i] for v in made.data.vertices) for i in range(3)])
    scale = size / max(high - low)
    made.data.transform(Matrix.Scale(scale, 4) @ Matrix.Translation(-Vector(((low.x + high.x) / 2, (low.y + high.y) / 2, low.z))))
    made.location = location
    return finish(made, material) if material else made


# Lights

def link(name, data, location):
    made = bpy.data.objects.new(name, data)
    made.location = location
    bpy.context.scene.collection.objects.link(made)
    return made


def towards(made, target):
    made.rotation_euler = (Vector(target) - made.location).to_track_quat("-Z", "Y").to_euler()
    return made


def area(location, target, size, power, colour=(1, 1, 1), height=None):
    data = bpy.data.lights.new("area", "AREA")
    data.energy, data.size, data.color = power, size, colour
    if height:
        data.shape, data.size_y = "RECTANGLE", height
    return towards(link("area", data, location), target)


def bulb(location, power, radius=0.05, colour=(1.0, 0.75, 0.45)):
    data = bpy.data.lights.new("bulb", "POINT")
    data.energy, data.shadow_soft_size, data.color = power, radius, colour
    return link("bulb", data, location)


def sun(direction, strength, colour=(1.0, 0.93, 0.8), angle=0.02):
    """direction: from where it shines."""
    data = bpy.data.lights.new("sun", "SUN")
    data.energy, data.angle, data.color = strength, angle, colour
    return towards(link("sun", data, direction), (0, 0, 0))


def surroundings(strength=1.0, probe=None, turn=0.0, colour=(0.4, 0.55, 0.9)):
    """One of the probes that come with Blender (CC0), or else a sky of one colour."""
    world = bpy.context.scene.world = bpy.data.worlds.new("world")
    tree = node_tree(world)
    background, output = tree.nodes.new("ShaderNodeBackground"), tree.nodes.new("ShaderNodeOutputWorld")
    tree.links.new(background.outputs[0], output.inputs["Surface"])
    background.inputs["Color"].default_value, background.inputs["Strength"].default_value = (*colour, 1), strength
    if probe:
        picture, mapping = tree.nodes.new("ShaderNodeTexEnvironment"), tree.nodes.new("ShaderNodeMapping")
        places = tree.nodes.new("ShaderNodeTexCoord")
        folder = Path(bpy.utils.system_resource("DATAFILES", path="studiolights/world"))
        picture.image = bpy.data.images.load(str(folder / f"{probe}.exr"))
        mapping.inputs["Rotation"].default_value = (0, 0, turn)
        tree.links.new(places.outputs["Generated"], mapping.inputs["Vector"])
        tree.links.new(mapping.outputs[0], picture.inputs["Vector"])
        tree.links.new(picture.outputs[0], background.inputs["Color"])


# Camera and motion

def camera(location, target, lens=50, focus=None, fstop=None):
    """With `fstop` it has a lens of lens / fstop millimetres (thousandths of a unit) that focuses on the point `focus`."""
    data = bpy.data.cameras.new("camera")
    data.lens = lens
    made = towards(link("camera", data, location), target)
    if fstop:
        data.dof.use_dof, data.dof.aperture_fstop = True, fstop
        axis = (Vector(target) - Vector(location)).normalized()
        data.dof.focus_distance = (Vector(focus or target) - Vector(location)).dot(axis)
    bpy.context.scene.camera = made
    return made


def shutter(opening):
    """Blurs motion over `opening` frames, of the two that keys span."""
    render = bpy.context.scene.render
    render.use_motion_blur, render.motion_blur_shutter = True, opening


def move(made, by=(0, 0, 0), turn=(0, 0, 0), steps=3):
    """From frame 0 to 2 by so much, now being the middle; turn: radians about x, y and z."""
    place, angles = made.location.copy(), Vector(made.rotation_euler)
    for frame, half in ((0, -0.5), (2, 0.5)):
        made.location, made.rotation_euler = place + half * Vector(by), angles + half * Vector(turn)
        made.keyframe_insert("location", frame=frame)
        made.keyframe_insert("rotation_euler", frame=frame)
    made.cycles.motion_steps = steps
    return made


def scatter(count, rng, low, high, height=0.0):
    return [(rng.uniform(low[0], high[0]), rng.uniform(low[1], high[1]), height) for _ in range(count)]


def stream(name):
    return random.Random(name)

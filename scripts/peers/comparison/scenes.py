"""The scenes that are rendered by several renderers, described once.

A scene is a dictionary: name, camera {camera_to_world, fov_y, width, height}, max_bounces (scatterings between camera and light),
samples (a factor on the number that is asked for), materials {name: {kind, colour, roughness, eta, k, ior, emission}}, meshes
[{positions, normals, triangles, material}], points [{position, intensity}], probe (array [height, width, 3] or None; row 0 is +y, the
middle column -z). Right-handed, y up, linear RGB radiance. Roughness is the square root of GGX's alpha. Light leaves the front of a
surface only.
"""
import math

import numpy as np


def camera(origin, target, fov_y, width, height):
    backward = np.subtract(origin, target) / np.linalg.norm(np.subtract(origin, target))
    right = np.cross([0, 1, 0], backward)
    right /= np.linalg.norm(right)
    matrix = np.eye(4)
    matrix[:3] = np.stack([right, np.cross(backward, right), backward, origin], axis=1)
    return {"camera_to_world": matrix, "fov_y": fov_y, "width": width, "height": height}


def quad(corner, edge_1, edge_2, material):
    """A parallelogram that faces edge_1 x edge_2."""
    corner, edge_1, edge_2 = (np.asarray(value, dtype=np.float64) for value in (corner, edge_1, edge_2))
    normal = np.cross(edge_1, edge_2)
    return {"positions": np.array([corner, corner + edge_1, corner + edge_1 + edge_2, corner + edge_2]),
            "normals": np.tile(normal / np.linalg.norm(normal), (4, 1)), "triangles": np.array([[0, 1, 2], [0, 2, 3]]),
            "material": material}


def box(centre, half, turn, material):
    """A box turned about y, without shared corners: six quads as one mesh."""
    cosine, sine = math.cos(turn), math.sin(turn)
    x = np.array([cosine, 0, -sine]) * half[0]
    y = np.array([0, 1.0, 0]) * half[1]
    z = np.array([sine, 0, cosine]) * half[2]
    sides = []
    for out, first, second in ((x, y, z), (y, z, x), (z, x, y)):
        for sign in (1, -1):
            one, two = (first, second) if sign > 0 else (second, first)
            sides.append(quad(np.add(centre, sign * out) - one - two, 2 * one, 2 * two, material))
    return {"positions": np.concatenate([side["positions"] for side in sides]),
            "normals": np.concatenate([side["normals"] for side in sides]),
            "triangles": np.concatenate([side["triangles"] + 4 * i for i, side in enumerate(sides)]), "material": material}


def sphere(centre, radius, material, rings=96):
    """A sphere of triangles with the sphere's own normals."""
    theta, phi = np.meshgrid(np.linspace(0, math.pi, rings + 1), np.linspace(0, 2 * math.pi, 2 * rings + 1), indexing="ij")
    normals = np.stack([np.sin(theta) * np.sin(phi), np.cos(theta), np.sin(theta) * np.cos(phi)], axis=-1).reshape(-1, 3)
    triangles, row = [], 2 * rings + 1
    for i in range(rings):
        for j in range(2 * rings):
            a, b = i * row + j, (i + 1) * row + j
            if i > 0:
                triangles.append((a, b, a + 1))
            if i < rings - 1:
                triangles.append((a + 1, b, b + 1))
    return {"positions": np.asarray(centre) + radius * normals, "normals": normals, "triangles": np.array(triangles),
            "material": material}


def cornell(size):
    """The Cornell box in [-1, 1]^3 with its area light; everything is diffuse."""
    materials = {"white": {"kind": "diffuse", "colour": (0.73, 0.73, 0.73)},
                 "red": {"kind": "diffuse", "colour": (0.63, 0.065, 0.05)},
                 "green": {"kind": "diffuse", "colour": (0.14, 0.45, 0.091)},
                 "light": {"kind": "diffuse", "colour": (0, 0, 0), "emission": (17, 12, 4)}}
    meshes = [quad((-1, -1, 1), (2, 0, 0), (0, 0, -2), "white"), quad((-1, 1, -1), (2, 0, 0), (0, 0, 2), "white"),
              quad((-1, -1, -1), (2, 0, 0), (0, 2, 0), "white"), quad((-1, -1, 1), (0, 0, -2), (0, 2, 0), "red"),
              quad((1, -1, -1), (0, 0, 2), (0, 2, 0), "green"), quad((-0.25, 0.99, -0.2), (0.5, 0, 0), (0, 0, 0.4), "light"),
              box((0.33, -0.7, 0.35), (0.3, 0.3, 0.3), -0.3, "white"), box((-0.35, -0.4, -0.3), (0.3, 0.6, 0.3), 0.35, "white")]
    return {"name": "cornell", "camera": camera((0, 0, 3.9), (0, 0, 0), math.radians(39.3), size, size), "max_bounces": 6,
            "samples": 2, "materials": materials, "meshes": meshes, "points": [], "probe": None}


def sky_picture(height=512):
    """A smooth sky, brighter towards a broad sun and coloured differently on all sides, so that no mirrored axis goes unseen."""
    theta = (np.arange(height) + 0.5) / height * math.pi
    phi = ((np.arange(2 * height) + 0.5) / (2 * height) - 0.5) * 2 * math.pi
    x, y = np.sin(theta)[:, None] * np.sin(phi), np.cos(theta)[:, None] + 0 * phi
    z = -np.sin(theta)[:, None] * np.cos(phi)
    up = 0.5 + 0.5 * y
    picture = np.stack([0.25 + 0.15 * x + 0.1 * up, 0.3 + 0.25 * up - 0.1 * z, 0.35 + 0.55 * up + 0.1 * z], axis=-1)
    sun = np.array([0.5, 0.6, 0.62]) / np.linalg.norm([0.5, 0.6, 0.62])
    cosine = x * sun[0] + y * sun[1] + z * sun[2]
    picture += np.exp(60 * (cosine - 1))[:, :, None] * np.array([14.0, 12.0, 9.0])
    return picture.astype(np.float32)


def probe_lit(size):
    """A floor with balls of four materials under a probe, and a point light behind them."""
    materials = {"floor": {"kind": "diffuse", "colour": (0.5, 0.48, 0.45)},
                 "clay": {"kind": "diffuse", "colour": (0.6, 0.25, 0.15)},
                 "gold": {"kind": "rough_conductor", "colour": (1.0, 0.78, 0.34), "roughness": 0.5,
                          "eta": (0.143, 0.375, 1.442), "k": (3.983, 2.386, 1.603)},
                 "glass": {"kind": "smooth_dielectric", "colour": (1, 1, 1), "ior": 1.5},
                 "frosted": {"kind": "rough_dielectric", "colour": (1, 1, 1), "ior": 1.5, "roughness": 0.5}}
    meshes = [quad((-8, 0, 8), (16, 0, 0), (0, 0, -16), "floor"), sphere((-1.65, 0.6, 0), 0.6, "clay"),
              sphere((-0.4, 0.6, -0.5), 0.6, "gold"), sphere((0.9, 0.6, -0.3), 0.6, "glass"),
              sphere((2.1, 0.6, 0.1), 0.6, "frosted"), box((0.2, 0.25, 0.9), (0.25, 0.25, 0.25), 0.5, "clay")]
    return {"name": "probe", "camera": camera((0.6, 1.7, 5.2), (0.25, 0.55, 0), math.radians(36), size * 3 // 2, size),
            "max_bounces": 8, "samples": 1, "materials": materials, "meshes": meshes,
            "points": [{"position": (-2.5, 2.2, -2.0), "intensity": (6, 7, 9)}], "probe": sky_picture()}

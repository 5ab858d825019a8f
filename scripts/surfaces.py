"""Writes a scene of surfaces that are hard for demodulation, as glTF with its pictures beside it (scripts/surfaces.sh).

    surfaces.py FOLDER

A wall with, from left to right: above, a lamp seen directly that stands askew, so that pixels are half lamp and half wall; a mirror; a
metal of roughness 0.2; below, fine textures, a black surface and one that reflects all light; a textured floor that the mirror shows.
"""
import base64
import json
import math
import pathlib
import random
import struct
import sys
import zlib


def png(path: pathlib.Path, size: int, colour) -> None:
    """colour(x, y) gives three bytes."""
    rows = b"".join(b"\0" + b"".join(bytes(colour(x, y)) for x in range(size)) for y in range(size))

    def chunk(kind: bytes, data: bytes) -> bytes:
        return struct.pack(">I", len(data)) + kind + data + struct.pack(">I", zlib.crc32(kind + data))

    header = struct.pack(">IIBBBBB", size, size, 8, 2, 0, 0, 0)
    path.write_bytes(b"\x89PNG\r\n\x1a\n" + chunk(b"IHDR", header) + chunk(b"IDAT", zlib.compress(rows)) + chunk(b"IEND", b""))


def plate(centre, size, turn=0.0, tilt=0.0) -> dict:
    """A node for the square [-1, 1]^2 facing +z: scaled, turned about z, tilted about x (degrees)."""
    z, x = math.radians(turn) / 2, math.radians(tilt) / 2
    # The quaternion of the tilt after the turn.
    rotation = [math.sin(x) * math.cos(z), -math.sin(x) * math.sin(z), math.cos(x) * math.sin(z), math.cos(x) * math.cos(z)]
    return {"translation": list(centre), "scale": [size[0] / 2, size[1] / 2, 1], "rotation": rotation}


def material(colour, metallic=0.0, roughness=1.0, light=0.0, texture=None) -> dict:
    surface = {"baseColorFactor": [*colour, 1], "metallicFactor": metallic, "roughnessFactor": roughness}
    if texture is not None:
        surface["baseColorTexture"] = {"index": texture}
    found = {"pbrMetallicRoughness": surface}
    if light:
        found |= {"emissiveFactor": [1, 1, 1], "extensions": {"KHR_materials_emissive_strength": {"emissiveStrength": light}}}
    return found


def diffuse(colour) -> dict:
    """Without the coat that glTF's dielectrics have."""
    return material(colour) | {"extras": {"ld": {"kind": "diffuse"}}}


def main() -> None:
    if len(sys.argv) != 2:
        sys.exit("usage: surfaces.py FOLDER")
    folder = pathlib.Path(sys.argv[1])
    folder.mkdir(parents=True, exist_ok=True)
    stream = random.Random(1)
    noise = [[stream.randrange(30, 250) for _ in range(64)] for _ in range(64)]
    png(folder / "checks.png", 128, lambda x, y: (220, 70, 50) if (x // 8 + y // 8) % 2 else (40, 60, 140))
    png(folder / "grain.png", 64, lambda x, y: (noise[y][x], noise[x][y], 128))

    wall, floor, lamp, mirror, metal, grain, black, white, ceiling = range(9)
    surfaces = [
        (wall, plate((0, 1, 0), (10, 3))),
        (floor, plate((0, -0.5, 5), (10, 10), tilt=-90)),
        (lamp, plate((-1.15, 1.4, 0.05), (0.7, 0.45), turn=12)),
        (mirror, plate((0, 1.4, 0.15), (0.9, 0.8), tilt=20)),
        (metal, plate((1.15, 1.4, 0.15), (0.9, 0.8), tilt=20)),
        (grain, plate((-1.15, 0.3, 0.05), (0.9, 0.9))),
        (black, plate((0, 0.3, 0.05), (0.9, 0.9))),
        (white, plate((1.15, 0.3, 0.05), (0.9, 0.9))),
        (ceiling, plate((0, 3, 3), (2, 1), tilt=90)),
    ]
    materials = [
        material((0.5, 0.5, 0.5)),
        material((1, 1, 1), texture=0),
        material((0, 0, 0), light=40),
        material((0.95, 0.95, 0.95), metallic=1, roughness=0),
        material((0.95, 0.8, 0.5), metallic=1, roughness=0.2),
        material((1, 1, 1), texture=1),
        diffuse((0, 0, 0)),
        diffuse((1, 1, 1)),
        material((0, 0, 0), light=12),
    ]
    positions = struct.pack("<12f", -1, -1, 0, 1, -1, 0, 1, 1, 0, -1, 1, 0)
    coordinates = struct.pack("<8f", 0, 1, 1, 1, 1, 0, 0, 0)
    indices = struct.pack("<6H", 0, 1, 2, 0, 2, 3)
    data = positions + coordinates + indices
    camera = {"translation": [0, 0.9, 5.2], "camera": 0}
    scene = {
        "asset": {"version": "2.0"},
        "extensionsUsed": ["KHR_materials_emissive_strength"],
        "scene": 0,
        "scenes": [{"nodes": list(range(len(surfaces) + 1))}],
        "nodes": [{"mesh": index, **place} for index, place in surfaces] + [camera],
        "cameras": [{"type": "perspective", "perspective": {"yfov": math.radians(36), "znear": 0.1}}],
        "meshes": [{"primitives": [{"attributes": {"POSITION": 0, "TEXCOORD_0": 1}, "indices": 2, "material": i}]} for i in range(len(materials))],
        "materials": materials,
        "textures": [{"source": 0}, {"source": 1}],
        "images": [{"uri": "checks.png"}, {"uri": "grain.png"}],
        "buffers": [{"byteLength": len(data), "uri": "data:application/octet-stream;base64," + base64.b64encode(data).decode()}],
        "bufferViews": [
            {"buffer": 0, "byteOffset": 0, "byteLength": 48},
            {"buffer": 0, "byteOffset": 48, "byteLength": 32},
            {"buffer": 0, "byteOffset": 80, "byteLength": 12},
        ],
        "accessors": [
            {"bufferView": 0, "componentType": 5126, "count": 4, "type": "VEC3", "min": [-1, -1, 0], "max": [1, 1, 0]},
            {"bufferView": 1, "componentType": 5126, "count": 4, "type": "VEC2"},
            {"bufferView": 2, "componentType": 5123, "count": 6, "type": "SCALAR"},
        ],
    }
    (folder / "surfaces.gltf").write_text(json.dumps(scene, indent=1), encoding="utf-8")


if __name__ == "__main__":
    main()

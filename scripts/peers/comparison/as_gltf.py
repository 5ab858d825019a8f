"""Writes a scene of scenes.py as a glTF file that holds all its meshes, for `ld_render --scene`."""
import base64
import json

import numpy as np

from comparison import exr

FLOAT, UNSIGNED = 5126, 5125


def material_of(name, material):
    """What glTF has no words for, such as a surface that is only diffuse, stands in extras.ld."""
    made = {"name": name, "pbrMetallicRoughness": {
        "baseColorFactor": [*material["colour"], 1.0], "roughnessFactor": material.get("roughness", 1.0),
        "metallicFactor": 1.0 if material["kind"] == "rough_conductor" else 0.0},
        "extras": {"ld": {"kind": material["kind"], **{key: list(material[key]) for key in ("eta", "k") if key in material}}},
        "extensions": {}}
    if "ior" in material:
        made["extensions"]["KHR_materials_ior"] = {"ior": material["ior"]}
    if "emission" in material:
        strength = max(material["emission"])
        made["emissiveFactor"] = [value / strength for value in material["emission"]]
        made["extensions"]["KHR_materials_emissive_strength"] = {"emissiveStrength": strength}
    return made


class Buffer:
    """Collects arrays and describes them as accessors."""

    def __init__(self):
        self.bytes, self.views, self.accessors = b"", [], []

    def add(self, array, component, shape):
        data = array.tobytes()
        self.views.append({"buffer": 0, "byteOffset": len(self.bytes), "byteLength": len(data)})
        self.bytes += data
        accessor = {"bufferView": len(self.views) - 1, "componentType": component, "count": len(array), "type": shape}
        if shape == "VEC3":
            accessor.update({"min": array.min(axis=0).tolist(), "max": array.max(axis=0).tolist()})
        self.accessors.append(accessor)
        return len(self.accessors) - 1


def write(scene, path):
    buffer, camera = Buffer(), scene["camera"]
    names = list(scene["materials"])
    meshes, nodes = [], []
    for mesh in scene["meshes"]:
        attributes = {"POSITION": buffer.add(mesh["positions"].astype(np.float32), FLOAT, "VEC3"),
                      "NORMAL": buffer.add(mesh["normals"].astype(np.float32), FLOAT, "VEC3")}
        indices = buffer.add(mesh["triangles"].astype(np.uint32).reshape(-1), UNSIGNED, "SCALAR")
        meshes.append({"primitives": [{"attributes": attributes, "indices": indices,
                                       "material": names.index(mesh["material"])}]})
        nodes.append({"mesh": len(meshes) - 1})
    # glTF writes matrices by columns.
    nodes.append({"camera": 0, "matrix": np.asarray(camera["camera_to_world"]).T.ravel().tolist()})
    lights = []
    for point in scene["points"]:
        strength = max(point["intensity"])
        nodes.append({"translation": list(point["position"]), "extensions": {"KHR_lights_punctual": {"light": len(lights)}}})
        lights.append({"type": "point", "intensity": strength, "color": [value / strength for value in point["intensity"]]})
    root = {"nodes": list(range(len(nodes)))}
    if scene["probe"] is not None:
        probe = path.with_suffix(".probe.exr")
        exr.write(probe, scene["probe"])
        root["extras"] = {"ld": {"probe": {"uri": probe.name, "scale": 1.0, "rotation_y": 0.0}}}
    described = {
        "asset": {"version": "2.0", "generator": "scripts/peers/comparison/as_gltf.py"},
        "extensionsUsed": ["KHR_lights_punctual", "KHR_materials_emissive_strength", "KHR_materials_ior"],
        "scene": 0, "scenes": [root], "nodes": nodes, "meshes": meshes,
        "materials": [material_of(name, material) for name, material in scene["materials"].items()],
        "cameras": [{"type": "perspective", "perspective": {"yfov": camera["fov_y"], "znear": 1e-3, "zfar": 1e3,
                                                            "aspectRatio": camera["width"] / camera["height"]}}],
        "buffers": [{"byteLength": len(buffer.bytes), "uri": "data:application/octet-stream;base64,"
                                                             + base64.b64encode(buffer.bytes).decode()}],
        "bufferViews": buffer.views, "accessors": buffer.accessors}
    if lights:
        described["extensions"] = {"KHR_lights_punctual": {"lights": lights}}
    path.write_text(json.dumps(described))

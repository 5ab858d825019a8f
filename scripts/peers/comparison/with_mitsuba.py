"""Renders a scene of scenes.py with Mitsuba 3."""
import math

import drjit
import mitsuba
import numpy as np

from comparison import exr

ROUND = 256  # samples a pixel at a time, because the compiled variants keep all paths in memory; a square, for the sampler


def rgb(value):
    return {"type": "rgb", "value": [float(component) for component in value]}


def bsdf_of(material):
    kind = material["kind"]
    if kind == "diffuse":
        return {"type": "twosided", "bsdf": {"type": "diffuse", "reflectance": rgb(material["colour"])}}
    if kind == "rough_conductor":
        return {"type": "twosided", "bsdf": {"type": "roughconductor", "eta": rgb(material["eta"]), "k": rgb(material["k"]),
                                             "alpha": material["roughness"] ** 2, "distribution": "ggx"}}
    glass = {"int_ior": material["ior"], "ext_ior": 1.0}
    if kind == "smooth_dielectric":
        return {"type": "dielectric", **glass}
    return {"type": "roughdielectric", "alpha": material["roughness"] ** 2, "distribution": "ggx", **glass}


def mesh_of(mesh, name):
    made = mitsuba.Mesh(name, len(mesh["positions"]), len(mesh["triangles"]), has_vertex_normals=True)
    values = mitsuba.traverse(made)
    values["vertex_positions"] = np.ravel(mesh["positions"]).astype(np.float32)
    values["vertex_normals"] = np.ravel(mesh["normals"]).astype(np.float32)
    values["faces"] = np.ravel(mesh["triangles"]).astype(np.uint32)
    values.update()
    return made


def render(scene, folder, spp, variant, threads):
    mitsuba.set_variant(variant)
    drjit.set_thread_count(threads)
    camera, transform = scene["camera"], mitsuba.ScalarTransform4f
    described = {
        "type": "scene",
        "integrator": {"type": "path", "max_depth": scene["max_bounces"] + 1, "rr_depth": 1000},
        "sensor": {"type": "perspective", "fov": math.degrees(camera["fov_y"]), "fov_axis": "y", "near_clip": 1e-3,
                   "to_world": transform(camera["camera_to_world"] @ np.diag([-1.0, 1, -1, 1])),
                   "film": {"type": "hdrfilm", "width": camera["width"], "height": camera["height"], "pixel_format": "rgb",
                            "component_format": "float32", "rfilter": {"type": "box"}},
                   "sampler": {"type": "multijitter", "sample_count": ROUND}}}
    for i, mesh in enumerate(scene["meshes"]):
        # A mesh takes its BSDF from a file only when it is loaded from one.
        path = folder / f"mesh_{i}.ply"
        mesh_of(mesh, f"mesh_{i}").write_ply(str(path))
        material = scene["materials"][mesh["material"]]
        described[f"mesh_{i}"] = {"type": "ply", "filename": str(path), "bsdf": bsdf_of(material)}
        if "emission" in material:
            described[f"mesh_{i}"]["emitter"] = {"type": "area", "radiance": rgb(material["emission"])}
    for i, point in enumerate(scene["points"]):
        described[f"point_{i}"] = {"type": "point", "position": list(point["position"]), "intensity": rgb(point["intensity"])}
    if scene["probe"] is not None:
        # Mitsuba has +z in the middle column.
        exr.write(folder / "probe_mitsuba.exr", np.roll(scene["probe"], scene["probe"].shape[1] // 2, axis=1))
        described["probe"] = {"type": "envmap", "filename": str(folder / "probe_mitsuba.exr")}
    loaded = mitsuba.load_dict(described)
    total, rounds = 0, max(1, spp // ROUND)
    for i in range(rounds):
        total = total + mitsuba.render(loaded, spp=spp // rounds, seed=i).numpy()
    return np.array(total, dtype=np.float64) / rounds

"""A scene to try mitsuba_dataset.py on, as the dictionary that mitsuba.load_dict takes."""
import mitsuba


def rgb(*value):
    return {"type": "rgb", "value": list(value)}


def checkerboard(first, second, repeat):
    return {"type": "checkerboard", "color0": rgb(*first), "color1": rgb(*second),
            "to_uv": mitsuba.ScalarTransform4f().scale([repeat, repeat, 1])}


def example():
    """Balls and boxes of several materials on a chequered floor before a wall, under a lamp and a sky, out of focus far off."""
    move = mitsuba.ScalarTransform4f

    def ball(x, y, z, radius, bsdf):
        return {"type": "sphere", "center": [x, y, z], "radius": radius, "bsdf": bsdf}

    def box(x, y, z, size, turn, bsdf):
        return {"type": "cube", "to_world": move().translate([x, y, z]).rotate([0, 1, 0.2], turn).scale(size), "bsdf": bsdf}

    def both_sides(bsdf):
        return {"type": "twosided", "bsdf": bsdf}

    scene = {
        "type": "scene",
        "integrator": {"type": "path", "max_depth": 9},
        "sensor": {"type": "thinlens", "fov": 40, "fov_axis": "y", "aperture_radius": 0.09, "focus_distance": 6.2,
                   "to_world": move().look_at(origin=[1.2, 2.2, 6.2], target=[0, 0.7, 0], up=[0, 1, 0])},
        "sky": {"type": "constant", "radiance": rgb(0.25, 0.35, 0.55)},
        "lamp": {"type": "rectangle", "to_world": move().look_at(origin=[3, 5, 3], target=[0, 0, 0], up=[0, 1, 0]).scale(0.7),
                 "emitter": {"type": "area", "radiance": rgb(34, 29, 22)},
                 "bsdf": {"type": "diffuse", "reflectance": rgb(0, 0, 0)}},
        "floor": {"type": "rectangle", "to_world": move().rotate([1, 0, 0], -90).scale(12),
                  "bsdf": both_sides({"type": "diffuse", "reflectance": checkerboard((0.7, 0.66, 0.6), (0.15, 0.1, 0.08), 20)})},
        "wall": {"type": "rectangle", "to_world": move().translate([0, 0, -4]).scale(12),
                 "bsdf": both_sides({"type": "diffuse", "reflectance": checkerboard((0.6, 0.25, 0.2), (0.65, 0.3, 0.22), 50)})},
        "gold": ball(-1.6, 0.8, -0.4, 0.8, {"type": "roughconductor", "material": "Au", "alpha": 0.08, "distribution": "ggx"}),
        "glass": ball(1.5, 0.6, 0.9, 0.6, {"type": "dielectric"}),
        "lacquer": ball(0.2, 0.5, 0.8, 0.5, {"type": "roughplastic", "alpha": 0.1, "diffuse_reflectance": rgb(0.7, 0.07, 0.05)}),
        "cube": box(1.7, 0.6, -1.6, 0.6, 35,
                    both_sides({"type": "diffuse", "reflectance": checkerboard((0.1, 0.2, 0.6), (0.9,) * 3, 6)})),
        "steel": box(-0.6, 0.35, 1.7, 0.3, 20, {"type": "roughconductor", "material": "Cr", "alpha": 0.2, "distribution": "ggx"}),
    }
    for i in range(9):
        scene[f"far_{i}"] = ball(-4 + i, 0.25 + 0.3 * (i % 3), -3 + 0.4 * (i % 2), 0.25 + 0.05 * (i % 4),
                                 {"type": "diffuse",
                                  "reflectance": rgb(0.2 + 0.6 * (i % 2), 0.2 + 0.3 * (i % 3), 0.8 - 0.08 * i)})
    return scene

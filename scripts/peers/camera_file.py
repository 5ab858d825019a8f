"""The camera of a frame as a small YAML file, for `ld_import --camera`."""

ABOUT = """\
# camera_to_world: 4x4, by rows, for column vectors: world = matrix * camera. In the camera's frame +x is right, +y up, and it
# looks along -z. fov_y: vertical field of view in radians. width, height: pixels.
"""


def write(path, camera):
    """camera: {"camera_to_world": four rows of four, "fov_y", "width", "height"}."""
    rows = "".join(f"  - [{', '.join(format(value, '.9g') for value in row)}]\n" for row in camera["camera_to_world"])
    with open(path, "w", encoding="ascii") as file:
        file.write(f"{ABOUT}camera_to_world:\n{rows}fov_y: {camera['fov_y']:.9g}\n"
                   f"width: {camera['width']}\nheight: {camera['height']}\n")

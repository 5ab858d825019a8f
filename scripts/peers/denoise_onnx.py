#!/usr/bin/env python3
"""Denoises frames of a sequence, or one, with an ONNX model of ld_export: denoise_onnx.py MODEL.onnx FRAME.exr... FOLDER

Needs onnxruntime, numpy and OpenEXR, nothing of this project: an example of how another program feeds the model
(docs/export.md). The model's metadata says which features it reads and how each is encoded.
"""
import re
import sys
from pathlib import Path

import numpy as np
import onnxruntime
import OpenEXR

# The channels of each feature in a sample part (docs/data_format.md).
CHANNELS = {"radiance": "R G B", "normal": "N.X N.Y N.Z", "depth": "Z", "albedo": "albedo.R albedo.G albedo.B",
            "specular": "specular.R specular.G specular.B", "roughness": "roughness", "motion": "motion.X motion.Y",
            "coc": "coc", "lens": "lens.X lens.Y", "time": "time", "flow": "flow.X flow.Y", "emission": "emission.R emission.G emission.B"}
LARGEST = np.float32(65504)  # of half; the depth where a ray escaped


def tone_map(x):
    y = np.log1p(np.maximum(x, 0))
    return np.where(y <= 0.0031308, 12.92 * y, 1.055 * y ** (1 / 2.4) - 0.055)


def encode(values, encoding, scale, depth_scale):
    if encoding == "tone_map":
        return tone_map(values)
    if encoding == "identity":
        return np.clip(values, -LARGEST, LARGEST)
    if encoding == "depth":
        depth = np.maximum(values, 0)
        return np.where(depth >= LARGEST, 1, depth / (depth + depth_scale))
    if encoding == "squash":
        return values / (np.abs(values) + scale)
    raise SystemExit(f"the model wants an encoding that this program does not know: {encoding}")


def median_depth(depths):
    """What ld_denoise computes where a file does not say: the median over the rays that met something; 1 without any."""
    met = np.sort(np.concatenate([depth[depth < LARGEST] for depth in depths])) if depths else []
    return max(met[len(met) // 2], np.float32(1e-6)) if len(met) else np.float32(1)


def read_frame(path, features):
    """features [1, S, F, H, W], radiance [1, S, 3, H, W] and valid [1, S, 1, H, W] of a frame."""
    with OpenEXR.File(path, separate_channels=True) as file:
        samples = [part for part in file.parts if re.fullmatch("s[0-9]{3,4}", part.header.get("name", ""))]
        plane = lambda part, name: part.channels[name].pixels.astype(np.float32)
        depth_scale = file.parts[0].header.get("ldDepthScale") or median_depth([plane(part, "Z") for part in samples if "Z" in part.channels])
        radiance, encoded = [], []
        for part in samples:
            radiance.append([plane(part, name) for name in "RGB"])
            encoded.append([encode(plane(part, name), encoding, scale, depth_scale)
                            for feature, encoding, scale in features for name in CHANNELS[feature].split()])
    radiance = np.array(radiance, np.float32)[None]
    return {"features": np.array(encoded, np.float32)[None], "radiance": radiance,
            "valid": np.ones_like(radiance[:, :, :1])}


def is_behind_a_cut(path):
    with OpenEXR.File(path, header_only=True) as file:
        return file.parts[0].header.get("ldCut", 0) != 0


def features_of(session):
    """(name, encoding, scale) in the order in which the model reads them."""
    lines = session.get_modelmeta().custom_metadata_map["features"].splitlines()
    return [(words[0], words[2], float(words[3]) if len(words) > 3 else 0) for words in map(str.split, lines)]


def empty_state(session, inputs):
    """What a model that remembers reads at the first frame of a sequence: zeros, by the names of its inputs."""
    sizes = dict(zip("BHW", (inputs["valid"].shape[0], *inputs["valid"].shape[3:])))
    parts = [part for part in session.get_inputs() if part.name.startswith("state")]
    divisor = lambda name: int(name.split("/")[1])  # "H_padded/4"
    multiple = max([divisor(size) for part in parts for size in part.shape if "/" in str(size)], default=1)
    def side(size):
        if "/" not in str(size):
            return sizes.get(size, size)
        return -(-sizes[size[0]] // multiple) * multiple // divisor(size)
    return {part.name: np.zeros([int(side(size)) for size in part.shape], np.float32) for part in parts}


def denoise(session, inputs, state):
    """The picture [B, 3, H, W], and what the frame leaves for the next one of the sequence."""
    image, *left = session.run(["image"] + ["next_" + name for name in state], {**inputs, **state})
    return image, dict(zip(state, left))


def main(model, frames, folder):
    session = onnxruntime.InferenceSession(model)
    state = None
    for frame in frames:
        inputs = read_frame(frame, features_of(session))
        if state is None or is_behind_a_cut(frame):
            state = empty_state(session, inputs)
        image, state = denoise(session, inputs, state)
        channels = {"RGB": np.ascontiguousarray(image[0].transpose(1, 2, 0))}
        header = {"type": OpenEXR.scanlineimage, "compression": OpenEXR.ZIP_COMPRESSION}
        OpenEXR.File(header, channels).write(str(Path(folder) / Path(frame).name))


if __name__ == "__main__":
    if len(sys.argv) < 4:
        raise SystemExit(__doc__)
    main(sys.argv[1], sys.argv[2:-1], sys.argv[-1])

"""RGB pictures as OpenEXR files."""
import numpy as np
import OpenEXR


def write(path, picture):
    """picture: [height, width, 3], written as floats."""
    header = {"type": OpenEXR.scanlineimage, "compression": OpenEXR.ZIP_COMPRESSION}
    channels = {name: np.ascontiguousarray(picture[:, :, i], dtype=np.float32) for i, name in enumerate("RGB")}
    OpenEXR.File(header, channels).write(str(path))


def read(path, prefix=""):
    """[height, width, 3] of the first part that has the channels prefix + R, G, B."""
    with OpenEXR.File(str(path), separate_channels=True) as file:
        for part in file.parts:
            if all(prefix + name in part.channels for name in "RGB"):
                return np.stack([part.channels[prefix + name].pixels.astype(np.float64) for name in "RGB"], axis=-1)
    raise ValueError(f"{path}: found no channels {prefix}R, {prefix}G, {prefix}B")

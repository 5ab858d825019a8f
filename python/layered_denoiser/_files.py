"""Frames and pictures on disk."""

from __future__ import annotations

import os
from collections.abc import Sequence
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import ArrayLike, NDArray

from . import _native
from ._arrays import as_floats, checked_count, shape_text


@dataclass(frozen=True, eq=False)
class Frame:
    """The samples of a picture, as read_frame() returns them and Denoiser.denoise() takes them."""

    samples: dict[str, NDArray[np.float32]]
    """Arrays [samples, height, width, channels] by feature."""
    valid: NDArray[np.bool_]
    """[samples, height, width]: False for a sample that was not drawn, or held a NaN or an infinity."""
    alpha: NDArray[np.float32] | None
    """[samples, height, width], by which the radiance is premultiplied; None where the file has none."""
    depth_scale: float
    """The median depth, as the program found it that wrote the file: depths are seen relative to it."""
    parts: dict[str, NDArray[np.float32]] = field(default_factory=dict)
    """Parts of the light, [samples, height, width, 3] by name: those that read_frame() was asked for."""
    world_to_camera: NDArray[np.float64] | None = None
    """[4, 4], for points as rows, as OpenEXR's attribute has it; None where the file has none. Filters read it."""
    world_to_ndc: NDArray[np.float64] | None = None
    """The same of worldToNDC."""


def _matrix(numbers: list[float]) -> NDArray[np.float64] | None:
    return np.array(numbers).reshape(4, 4) if numbers else None


def read_frame(path: str | os.PathLike[str], samples: int = 0, also: Sequence[str] = ()) -> Frame:
    """Reads a frame of samples, as ld_render and ld_import write it: OpenEXR with a part for each sample.

    Of its samples the first `samples`; 0: all. `also` are patterns (*, ?, [...]) of parts of the light that it holds beside the
    radiance, as ["light_*", "diffuse"]; one that fits none is an error. Values are mended as by ld_denoise: samples with a NaN or an infinity become invalid,
    negative radiance becomes 0. The arrays look into one memory, plane behind plane; nothing is copied.

    Raises RuntimeError where the file is missing, damaged, or no frame.
    """
    count = checked_count("samples", samples, 4096)
    if isinstance(also, str) or not all(isinstance(pattern, str) for pattern in also):
        raise ValueError(f"also is {also!r}; expected a list of patterns")
    arrays, valid, alpha, depth_scale, parts, camera, ndc = _native.read_frame(os.fspath(path), count, 0, list(also))
    return Frame(arrays, valid.view(np.bool_), alpha, depth_scale, parts, _matrix(camera), _matrix(ndc))


def read_image(path: str | os.PathLike[str]) -> NDArray[np.float32]:
    """Reads R, G and B of an OpenEXR picture, a reference for example: [height, width, 3], linear.

    Values that are NaN, infinite or negative are read as 0. Raises RuntimeError where the file is missing, damaged, or no picture.
    """
    return _native.read_image(os.fspath(path))


def write_image(path: str | os.PathLike[str], image: ArrayLike) -> None:
    """Writes a picture [height, width, 3]; of one channel: [height, width] or [height, width, 1].

    `.exr` holds linear half floats and, as a fourth channel, alpha; `.png` 8 bits of the tone map, sRGB of log(1 + x). The file is
    written beside and renamed, so that one with its name is whole.

    Raises ValueError for a wrong shape, dtype or extension, RuntimeError where the file cannot be written.
    """
    array = as_floats("the image", image)
    if array.ndim == 2:
        array = array[..., None]
    most = 3 if os.fspath(path).lower().endswith(".png") else 4
    if array.ndim != 3 or array.shape[2] not in (1, 3, most) or min(array.shape) < 1:
        raise ValueError(
            f"the image has the shape {shape_text(array.shape)}; expected [height, width, channels] with 1, 3 or, in EXR, 4 channels"
        )
    _native.write_image(os.fspath(path), np.ascontiguousarray(np.moveaxis(array, -1, 0)))

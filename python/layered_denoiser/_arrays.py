"""What callers pass, checked and brought into the form that the extension module takes."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from . import _native


def as_floats(what: str, value: ArrayLike) -> NDArray[np.float32]:
    """The array itself where it holds float32 at whole multiples of 4 bytes, else a converted copy. Raises ValueError for what is no
    array of real numbers."""
    try:
        array = np.asarray(value)
    except ValueError as error:
        raise ValueError(f"{what} is no array: {error}; expected an array of float32") from error
    if array.dtype.kind not in "fiub":
        raise ValueError(f"{what} has the dtype {array.dtype}; expected float32, or real numbers that can be converted to it")
    floats = array.astype(np.float32, copy=False)
    if not floats.flags.aligned or any(stride % floats.itemsize for stride in floats.strides):
        floats = floats.copy()
    return floats


def shape_text(shape: tuple[Any, ...]) -> str:
    return "[" + ", ".join(str(size) for size in shape) + "]"


def checked_samples(samples: Mapping[str, ArrayLike], features: Mapping[str, int], required: list[str]) -> dict[str, NDArray[np.float32]]:
    """The arrays of those features that the network reads, [samples, height, width, channels], all of one size. Raises ValueError for
    names that are no features, for a required one that is missing, and for wrong shapes and types."""
    if not isinstance(samples, Mapping):
        raise ValueError(f"samples are a {type(samples).__name__}; expected a dict of arrays by the features' names, or a Frame")
    for name in samples:
        if not isinstance(name, str):
            raise ValueError(f"samples have the key {name!r}; expected names of features")
        _native.feature_channels(name)  # raises, naming the nearest one
    for name in dict.fromkeys(["radiance", *required]):
        if name not in samples:
            found = ", ".join(samples) or "nothing"
            raise ValueError(
                f"the feature '{name}' is missing, which these weights need; expected {', '.join(required)}, found {found}; "
                f"render it, or use weights that do without it"
            )
    checked: dict[str, NDArray[np.float32]] = {}
    size: tuple[int, ...] = ()
    for name in ["radiance", *(name for name in features if name != "radiance" and name in samples)]:
        channels = _native.feature_channels(name)
        array = as_floats(f"the feature '{name}'", samples[name])
        if array.ndim == 3 and channels == 1:
            array = array[..., None]
        _check_shape(name, array.shape, channels, size)
        size = array.shape[:3]
        if name in features:
            checked[name] = array
    return checked


def _check_shape(name: str, shape: tuple[int, ...], channels: int, size: tuple[int, ...]) -> None:
    """`size` is that of the radiance, empty for the radiance itself."""
    wanted = (*(size or ("samples", "height", "width")), channels)
    if len(shape) == 4 and shape[3] == channels and min(shape) >= 1 and shape[:3] == (size or shape[:3]):
        return
    advice = ""
    if len(shape) == 3 and not size and shape[2] == channels:
        advice = "; a picture alone is one sample: array[None]"
    elif len(shape) == 4 and shape[1] == channels and shape[3] != channels:
        advice = "; channels come last: numpy.moveaxis(array, 1, -1)"
    elif size:
        advice = "; all features have the size of the radiance"
    raise ValueError(f"the feature '{name}' has the shape {shape_text(shape)}; expected {shape_text(wanted)}{advice}")


def checked_parts(parts: Mapping[str, ArrayLike], size: tuple[int, ...]) -> dict[str, NDArray[np.float32]]:
    """Arrays [samples, height, width, 3] by name, of the radiance's size. Raises ValueError."""
    if not isinstance(parts, Mapping):
        raise ValueError(f"parts are a {type(parts).__name__}; expected a dict of arrays by their names")
    checked: dict[str, NDArray[np.float32]] = {}
    for name, value in parts.items():
        array = as_floats(f"the part '{name}'", value)
        if array.shape != (*size, 3):
            raise ValueError(
                f"the part '{name}' has the shape {shape_text(array.shape)}; expected {shape_text((*size, 3))}, that of the radiance"
            )
        checked[name] = array
    return checked


def checked_alpha(alpha: ArrayLike | None, size: tuple[int, ...]) -> NDArray[np.float32] | None:
    """[samples, height, width]. Raises ValueError."""
    if alpha is None:
        return None
    array = as_floats("alpha", alpha)
    if array.ndim == 4 and array.shape[3] == 1:
        array = array[..., 0]
    if array.shape != size:
        raise ValueError(f"alpha has the shape {shape_text(array.shape)}; expected {shape_text(size)}, one value for each sample")
    return array


def checked_valid(valid: ArrayLike | None, size: tuple[int, ...]) -> NDArray[np.uint8] | None:
    """Bytes, 0 for a sample that does not count."""
    if valid is None:
        return None
    array = np.asarray(valid)
    if array.dtype.kind not in "iub":
        raise ValueError(f"valid has the dtype {array.dtype}; expected bool")
    if array.shape != size:
        raise ValueError(f"valid has the shape {shape_text(array.shape)}; expected {shape_text(size)}, one value for each sample")
    return np.ascontiguousarray(array != 0).view(np.uint8)


def checked_count(what: str, value: Any, most: int) -> int:
    """A whole number from 0."""
    if isinstance(value, bool) or not isinstance(value, (int, np.integer)) or not 0 <= value <= most:
        raise ValueError(f"{what} is {value!r}; expected a whole number from 0 to {most}")
    return int(value)


def checked_matrix(name: str, matrix: ArrayLike | None) -> list[float]:
    """The 16 numbers row by row; none for None."""
    if matrix is None:
        return []
    array = np.asarray(matrix, dtype=np.float64)
    if array.shape != (4, 4) or not np.isfinite(array).all():
        raise ValueError(f"{name} is {shape_text(array.shape)}; expected 4 x 4 finite numbers, or None")
    return [float(number) for number in array.ravel()]

"""The denoiser."""

from __future__ import annotations

import os
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from . import _native
from ._arrays import checked_alpha, checked_count, checked_matrix, checked_parts, checked_samples, checked_valid
from ._files import Frame

_native.keep_released_models_in(str(Path(__file__).parent / "models"))


def released_weights() -> list[str]:
    """The names of the weights that come with this package, which Denoiser() takes."""
    return list(_native.released_models())


@dataclass(frozen=True, eq=False)
class DenoisedParts:
    """What Denoiser.denoise_parts() returns; linear, float32."""

    picture: NDArray[np.float32]
    """[height, width, 3]."""
    parts: dict[str, NDArray[np.float32]]
    """[height, width, 3] by name."""
    alpha: NDArray[np.float32] | None
    """[height, width]; None where it was not asked for."""


@dataclass(frozen=True)
class Skipped:
    """What Denoiser.skipped says; shares, 0 to 1."""

    pixels: float
    """Those whose light is even."""
    samples: float
    """Of what networks make of each sample: the samples that are the first of their pixel again."""
    layers: float
    """Of the pixels of layers: those without influence."""


class Denoiser:
    """A network with its weights, or a filter (Denoiser.filter).

    `weights` is a .safetensors file, a checkpoint or run folder of ld_train, or the name of released weights: "common" (the default),
    "common_fast", "means" (for renders of which only each pixel's mean is known). What was planned for a frame is kept for the next
    of its size. One denoiser works for one thread at a time; two may work in two threads. Where `remembers` is true, every frame is the next of
    a sequence, until restart() or another size.

    Raises RuntimeError where there are no such weights, or where they are damaged.
    """

    def __init__(self, weights: str | os.PathLike[str] = "common") -> None:
        path = os.fspath(weights)
        if not isinstance(path, str):
            raise ValueError(f"weights are {path!r}; expected a path or a name as text")
        # A run folder stays what it is: its best checkpoint may become another.
        self._weights = path if os.path.exists(path) else _native.resolve_model(path)
        self._native = _native.Denoiser(self._weights)

    @classmethod
    def filter(cls, kind: str, **settings: Any) -> Denoiser:
        """A denoiser without weights: "eaw" (Dammertz et al. 2010) or "svgf" (Schied et al. 2017), with settings such as alpha=0.1
        (docs/filters.md). "svgf" remembers. Raises ValueError for another kind or setting.
        """
        self = cls.__new__(cls)
        self._weights = ""
        texts = [f"{key}={str(value).lower() if isinstance(value, bool) else value}" for key, value in settings.items()]
        self._native = _native.Denoiser(kind, texts)
        return self

    def __repr__(self) -> str:
        return f"<layered_denoiser.Denoiser {self._native.name}{' of ' + self._weights if self._weights else ''}>"

    @property
    def weights(self) -> str:
        """The file or folder that the weights come from; empty for a filter."""
        return self._weights

    @property
    def network(self) -> str:
        """The name of the network, or of the filter."""
        return self._native.name

    @property
    def remembers(self) -> bool:
        """Whether frames have something of those before."""
        return self._native.remembers

    def restart(self) -> None:
        """The next frame follows none of those before, as after a cut."""
        self._native.restart()

    @property
    def skipped(self) -> Skipped:
        """What was left out of the work on the last frame."""
        return Skipped(*self._native.skipped)

    @property
    def features(self) -> dict[str, int]:
        """What the network reads of each sample: names and how many channels each has."""
        return dict(self._native.features)

    @property
    def required(self) -> list[str]:
        """Those of the features that must be there; the network does without the others, less well."""
        return list(self._native.required)

    def denoise(
        self,
        samples: Frame | Mapping[str, ArrayLike],
        valid: ArrayLike | None = None,
        *,
        depth_scale: float | None = None,
        threads: int = 0,
        max_memory_mb: int = 0,
        skip_within: float = 0,
        progress: Callable[[float], Any] | None = None,
        world_to_camera: ArrayLike | None = None,
        world_to_ndc: ArrayLike | None = None,
    ) -> NDArray[np.float32]:
        """Denoises a frame: [height, width, 3], linear, float32.

        samples: what read_frame() returned, or arrays [samples, height, width, channels] by feature: radiance 3 (linear), normal 3
            (view space, +y up, +z towards the camera), depth 1 (along the view axis, 65504 where the ray escaped), albedo 3, specular 3,
            roughness 1 and others (docs/data_format.md). `features` says which the weights read; others are left alone. float32 of
            any strides is read where it lies, other real numbers are converted. One channel may also be [samples, height, width].
        valid: [samples, height, width], False for samples that were not drawn; None: all were. Samples with a NaN or an infinity in
            their radiance do not count anyway.
        depth_scale: the unit of depth; None: that of the frame, or the median of the finite depths.
        threads: that compute; 0: OMP_NUM_THREADS, or all CPUs of the process. The bits are those of ld_denoise with as many, and with
            --skip-within as skip_within here.
        max_memory_mb: what the whole process may take, in MB of 2^20 bytes, the samples' copy aside; 0: no bound. Filters take none.
        skip_within: how far the picture x may be from that of all work, so that what is known beforehand need not be computed: in each channel by
            at most skip_within * (1 + |x|), 0 to 1; 0: by no bit. `skipped` says what was left out.
        progress: called now and then with the share that is done, 0 to 1. A result that is false, other than None, cancels.
        world_to_camera, world_to_ndc: [4, 4], OpenEXR's matrices for points as rows, for filters; None: those of the Frame, or not known.

        Python's lock is released while this computes. Ctrl-C ends it with KeyboardInterrupt.

        Raises ValueError for arrays that do not fit and for a memory bound that is too small, Cancelled, and what `progress` raises.
        """
        matrices = (world_to_camera, world_to_ndc)
        return self._denoise(samples, {}, None, valid, depth_scale, threads, max_memory_mb, skip_within, progress, matrices)[0]

    def denoise_parts(
        self,
        samples: Frame | Mapping[str, ArrayLike],
        parts: Mapping[str, ArrayLike] | None = None,
        alpha: ArrayLike | None = None,
        valid: ArrayLike | None = None,
        *,
        depth_scale: float | None = None,
        threads: int = 0,
        max_memory_mb: int = 0,
        skip_within: float = 0,
        progress: Callable[[float], Any] | None = None,
        world_to_camera: ArrayLike | None = None,
        world_to_ndc: ArrayLike | None = None,
    ) -> DenoisedParts:
        """Denoises a frame and, with the picture's own weights, parts of its light and its alpha.

        parts: arrays [samples, height, width, 3] by name, linear, which may be negative; None: those of the Frame. Where they sum to
            the radiance in every sample, the parts that come out sum to the picture, to rounding. A colour with a NaN or an infinity
            where the radiance has none counts as 0.
        alpha: [samples, height, width], 0 to 1; None: it is not filtered. Samples with a NaN or an infinity in it do not count.

        The others are those of denoise(), whose picture this gives, bit for bit.
        """
        if parts is None:
            parts = samples.parts if isinstance(samples, Frame) else {}
        matrices = (world_to_camera, world_to_ndc)
        pictures = self._denoise(samples, parts, alpha, valid, depth_scale, threads, max_memory_mb, skip_within, progress, matrices)
        named = dict(zip(parts, pictures[1:]))
        return DenoisedParts(pictures[0], named, None if alpha is None else pictures[-1][..., 0])

    def _denoise(
        self,
        samples: Frame | Mapping[str, ArrayLike],
        parts: Mapping[str, ArrayLike],
        alpha: ArrayLike | None,
        valid: ArrayLike | None,
        depth_scale: float | None,
        threads: int,
        max_memory_mb: int,
        skip_within: float,
        progress: Callable[[float], Any] | None,
        matrices: tuple[ArrayLike | None, ArrayLike | None],
    ) -> list[NDArray[np.float32]]:
        """The picture, the parts in their order, and alpha [height, width, 1] where it is given."""
        scale: float | None = None
        if isinstance(samples, Frame):
            valid = samples.valid if valid is None else valid
            scale = samples.depth_scale
            matrices = tuple(own if given is None else given for given, own in zip(matrices, (samples.world_to_camera, samples.world_to_ndc)))
            samples = samples.samples
        scale = scale if depth_scale is None else depth_scale
        if scale is not None and not (isinstance(scale, (int, float, np.floating)) and 0 < scale < np.inf):
            raise ValueError(f"depth_scale is {scale!r}; expected a number above 0, or None")
        if isinstance(skip_within, bool) or not (isinstance(skip_within, (int, float, np.floating)) and 0 <= skip_within <= 1):
            raise ValueError(f"skip_within is {skip_within!r}; expected a number from 0 to 1")
        if progress is not None and not callable(progress):
            raise ValueError(f"progress is {progress!r}; expected a function of the share that is done, or None")
        arrays = checked_samples(samples, self.features, self.required)
        size = arrays["radiance"].shape[:3]
        return self._native.denoise(
            arrays,
            list(checked_parts(parts, size).values()),
            checked_alpha(alpha, size),
            checked_valid(valid, size),
            0.0 if scale is None else float(scale),
            checked_count("threads", threads, 4096),
            checked_count("max_memory_mb", max_memory_mb, 10**9),
            float(skip_within),
            progress,
            checked_matrix("world_to_camera", matrices[0]),
            checked_matrix("world_to_ndc", matrices[1]),
        )

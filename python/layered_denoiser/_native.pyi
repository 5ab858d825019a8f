from collections.abc import Callable
from typing import Any

import numpy as np
from numpy.typing import NDArray

version: str

class Cancelled(RuntimeError): ...

class Denoiser:
    def __init__(self, weights: str) -> None: ...
    @property
    def network(self) -> str: ...
    @property
    def features(self) -> list[tuple[str, int]]: ...
    @property
    def required(self) -> list[str]: ...
    def denoise(
        self,
        samples: dict[str, NDArray[np.float32]],
        parts: list[NDArray[np.float32]],
        alpha: NDArray[np.float32] | None,
        valid: NDArray[np.uint8] | None,
        depth_scale: float,
        threads: int,
        max_memory_mb: int,
        progress: Callable[[float], Any] | None,
        /,
    ) -> list[NDArray[np.float32]]: ...

def feature_channels(name: str, /) -> int: ...
def read_frame(
    path: str, samples: int, threads: int, also: list[str], /
) -> tuple[dict[str, NDArray[np.float32]], NDArray[np.uint8], NDArray[np.float32] | None, float, dict[str, NDArray[np.float32]]]: ...
def read_image(path: str, /) -> NDArray[np.float32]: ...
def write_image(path: str, planes: NDArray[np.float32], /) -> None: ...

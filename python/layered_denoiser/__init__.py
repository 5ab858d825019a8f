"""Denoises Monte Carlo renders from their individual samples.

    import layered_denoiser as ld

    frame = ld.read_frame("frame.exr")
    denoiser = ld.Denoiser("common")
    picture = denoiser.denoise(frame)
    ld.write_image("denoised.png", picture)

Samples are float32 arrays [samples, height, width, channels], one for each feature: linear radiance and, where the renderer has them,
normals, depth, albedo and others. `help(ld.Denoiser.denoise)` says what they hold.
"""

from ._denoiser import DenoisedParts, Denoiser, Skipped, released_weights
from ._files import Frame, read_frame, read_image, write_image
from ._native import Cancelled
from ._native import version as __version__

__all__ = ["Cancelled", "DenoisedParts", "Denoiser", "Frame", "Skipped", "__version__", "read_frame", "read_image", "released_weights", "write_image"]

Cancelled.__module__ = __name__
Cancelled.__doc__ = "Raised by Denoiser.denoise() when its progress function asked to stop."

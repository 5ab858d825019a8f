"""Open Image Denoise (PyPI's pyoidn) as oidn_denoise.py and speed.py use it: means of the samples in, a picture out."""
from concurrent.futures import ThreadPoolExecutor

import numpy as np
from pyoidn import Device, Filter
from pyoidn.filter import OIDN_FORMAT_FLOAT3

# Values of OIDNQuality.
QUALITIES = {"fast": 4, "balanced": 5, "high": 6}

_STRIP = 65536  # pixels; a sum of that size stays in the cache while samples are added


def make_device(threads):
    """A device on so many threads, which are not pinned to CPUs: ours are not either."""
    device = Device()
    device.set_int("numThreads", threads)
    device.set_bool("setAffinity", False)
    device.commit()
    return device


def version_of(device):
    version = device.get_int("version")
    return f"Open Image Denoise {version // 10000}.{version // 100 % 100}.{version % 100}"


def check(device):
    message = device.get_error()
    if message:
        raise SystemExit(f"Open Image Denoise: {message}")


def make_filter(device, images, quality, **switches):
    """A filter on these images, and the picture that it writes. The images are borrowed: whoever replaces one must keep it alive."""
    height, width, _ = next(iter(images.values())).shape
    output = np.zeros((height, width, 3), dtype=np.float32)
    oidn = Filter(device, "RT")
    for name, image in images.items():
        oidn.set_image(name, image, OIDN_FORMAT_FLOAT3, width, height)
    oidn.set_image("output", output, OIDN_FORMAT_FLOAT3, width, height)
    for name, value in switches.items():
        oidn.set_bool(name, value)
    oidn.set_int("quality", QUALITIES[quality])
    oidn.commit()
    return oidn, output


class Means:
    """Means over the samples on some threads. `samples` are "color" and guides, [samples, height, width, 3]; `images` of the same names
    receive their means, [height, width, 3]. A sample whose color is not finite counts as not drawn, guides that are not finite are 0.
    Color below 0 is 0."""

    def __init__(self, samples, threads):
        self.samples = samples
        count, self.height, width, _ = samples["color"].shape
        self.images = {name: np.empty((self.height, width, 3), dtype=np.float32) for name in samples}
        self._share = np.float32(1 / count)
        self._rows = max(_STRIP // width // 3, 1)
        self._pool = ThreadPoolExecutor(threads) if threads > 1 else None

    def make(self):
        strips = [slice(y, y + self._rows) for y in range(0, self.height, self._rows)]
        for _ in (self._pool.map if self._pool else map)(self._make_rows, strips):
            pass

    def _make_rows(self, rows):
        with np.errstate(over="ignore", invalid="ignore"):
            for name, values in self.samples.items():
                np.sum(values[:, rows], axis=0, out=self.images[name][rows])
        # A value that is not finite is seen in the sum, which spares the rule from looking at each.
        if all(np.isfinite(image[rows]).all() for image in self.images.values()):
            for image in self.images.values():
                image[rows] *= self._share
        else:
            self._make_valid_rows(rows)
        np.maximum(self.images["color"][rows], 0, out=self.images["color"][rows])

    def _make_valid_rows(self, rows):
        drawn = np.isfinite(self.samples["color"][:, rows]).all(axis=-1)[..., None]
        count = np.maximum(drawn.sum(axis=0), 1)
        for name, values in self.samples.items():
            good = drawn & np.isfinite(values[:, rows]).all(axis=-1)[..., None]
            self.images[name][rows] = np.where(good, values[:, rows], 0).sum(axis=0, dtype=np.float64) / count

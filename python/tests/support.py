"""What the tests share: the project's programs and made-up samples."""
import os
import subprocess
from pathlib import Path

import numpy as np

ROOT = Path(__file__).resolve().parents[2]
FRAME = ROOT / "tests/fixtures/before_simd/frame.exr"
SAMPLE_WEIGHTS = ROOT / "tests/fixtures/before_simd/layer.safetensors"  # which need all features
PROGRAMS = Path(os.environ.get("LD_BUILD", ROOT / "build")).resolve() / "bin"


def run(program, *arguments):
    """One of the project's programs, as a user would run it."""
    done = subprocess.run([PROGRAMS / program, *map(str, arguments)], capture_output=True, text=True)
    if done.returncode:
        raise AssertionError(f"{program} failed: {done.stderr}")


def noisy_samples(height=12, width=17, count=4, features=("radiance", "normal", "depth", "albedo", "specular"), seed=1):
    """A ramp with noise, all features contiguous."""
    random = np.random.default_rng(seed)
    channels = {"radiance": 3, "normal": 3, "depth": 1, "albedo": 3, "specular": 3}
    return {name: random.gamma(2, 0.5, (count, height, width, channels[name])).astype(np.float32) for name in features}

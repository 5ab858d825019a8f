#!/usr/bin/env python3
"""SSIM and PSNR of the same pictures by scikit-image: skimage_test.py WRITE_METRIC_PICTURES OUT.

Both are defined on tone-mapped values, so the tone map (sRGB of log(1 + x), cut at 1) is written once more here, in
numpy; so are relMSE and SMAPE.
"""
import json
import subprocess
import sys
from pathlib import Path

import numpy as np
from skimage.metrics import peak_signal_noise_ratio, structural_similarity

TOLERANCE = 1e-4


def tone_map(x):
    u = np.log1p(np.maximum(x, 0))
    return np.minimum(np.where(u <= 0.0031308, 12.92 * u, 1.055 * u ** (1 / 2.4) - 0.055), 1)


def scores_by_skimage(denoised, reference):
    d, r = tone_map(denoised), tone_map(reference)
    return {
        "ssim": structural_similarity(r, d, data_range=1.0, channel_axis=0, gaussian_weights=True, sigma=1.5,
                                      use_sample_covariance=False),
        "psnr": peak_signal_noise_ratio(r, d, data_range=1.0),
        "relmse": np.mean((denoised - reference) ** 2 / (reference ** 2 + 1e-4)),
        "smape": np.mean(np.abs(denoised - reference) / (np.abs(denoised) + np.abs(reference) + 0.01)),
    }


def main():
    program, out = Path(sys.argv[1]), Path(sys.argv[2])
    subprocess.run([program, out], check=True)
    entries = json.loads((out / "scores.json").read_text())
    largest = {}
    for entry in entries:
        pictures = [np.fromfile(out / f"{entry['name']}.{part}", np.float32).reshape(3, entry["height"], entry["width"]).astype(np.float64)
                    for part in ("denoised", "reference")]
        for metric, expected in scores_by_skimage(*pictures).items():
            difference = abs(entry[metric] - expected) / (max(expected, 1) if metric == "relmse" else 1)
            largest[metric] = max(largest.get(metric, 0), difference)
            if not difference <= TOLERANCE:
                raise AssertionError(f"{metric} of pair {entry['name']} ({entry['width']}x{entry['height']}): {entry[metric]}, scikit-image {expected}")
    if len(entries) < 10:
        raise AssertionError(f"only {len(entries)} pairs")
    print(f"{len(entries)} pairs; largest differences: " + ", ".join(f"{name} {value:.1e}" for name, value in largest.items()))


if __name__ == "__main__":
    main()

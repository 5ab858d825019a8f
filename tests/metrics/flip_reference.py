#!/usr/bin/env python3
"""Prints the numbers of flip_test.cpp with the authors' own program (PyPI: flip-evaluator):

  python3 -m venv out/flip && out/flip/bin/pip install flip-evaluator==1.7 numpy
  out/flip/bin/python tests/metrics/flip_reference.py
"""
import flip_evaluator
import numpy as np


def tone_map(v):
    u = np.log1p(v)
    return np.minimum(np.where(u <= 0.0031308, 12.92 * u, 1.055 * u ** (1 / 2.4) - 0.055), 1)


for width, height in ((31, 33), (64, 48), (1, 1), (2, 1), (1, 40), (17, 12)):
    y, x, c = np.meshgrid(np.arange(height), np.arange(width), np.arange(3), indexing="ij")
    r = ((x * x * 37 + y * y * 101 + x * y * 3 + c * 59) % 256) / 128 * ((x // 8 + y // 8) % 3 + 1) / 2
    r = np.where((x * 3 + y * 5) % 41 == 7, 32 * r, r)
    d = np.maximum(r + ((x * 7 + y * 13 + x * y * 5 + c * 3) % 17 - 8) / 32, 0)
    low = flip_evaluator.evaluate(*(tone_map(v).astype(np.float32) for v in (r, d)), "LDR", applyMagma=False)[1]
    _, high, used = flip_evaluator.evaluate(*(v.astype(np.float32) for v in (r, d)), "HDR", applyMagma=False)
    print(f"{{{width}, {height}, {low:.6f}, {high:.6f}, {used['startExposure']:.4f}, {used['stopExposure']:.4f}, {used['numExposures']}}},")

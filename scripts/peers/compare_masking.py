#!/usr/bin/env python3
"""Why rough metal and glass are a little brighter in Cycles: which shadowing of microfacets a renderer computes.

    out/peers/venv/bin/python scripts/peers/compare_masking.py

A gold plane, GGX with alpha 0.25, under a sky of 1 all round, one bounce, seen at several angles. What it reflects is compared
with two integrals: shadowing and masking as independent, G1(i) G1(o) [Walter et al. 2007, eq. 23], and both by the same height,
1 / (1 + Lambda(i) + Lambda(o)) [Heitz 2014, eq. 99].
"""
import math
import sys

import numpy as np

import compare_renderers
from comparison import scenes

GOLD = scenes.probe_lit(8)["materials"]["gold"]
ALPHA = GOLD["roughness"] ** 2


def plane_at(angle):
    """A plane so far from a camera so narrow that all pixels see it at the angle."""
    origin = 100 * np.array([math.sin(angle), math.cos(angle), 0.0])
    return {"name": "masking", "camera": scenes.camera(origin, (0, 0, 0), 0.01, 32, 32), "max_bounces": 1,
            "materials": {"gold": GOLD}, "points": [], "probe": np.ones((16, 32, 3), dtype=np.float32),
            "meshes": [scenes.quad((-50, 0, 50), (100, 0, 0), (0, 0, -100), "gold")]}


def smith_lambda(cosine):
    return 0.5 * (np.sqrt(1 + ALPHA ** 2 * (1 / cosine ** 2 - 1)) - 1)


def fresnel(cosine, eta, k):
    """Exact for a conductor, mean over both polarisations."""
    square, sine = cosine ** 2, 1 - cosine ** 2
    t0 = eta ** 2 - k ** 2 - sine
    ab = np.sqrt(t0 ** 2 + 4 * eta ** 2 * k ** 2)
    a = np.sqrt(0.5 * (ab + t0))
    s = (ab + square - 2 * a * cosine) / (ab + square + 2 * a * cosine)
    return 0.5 * s * (1 + (square * ab + sine ** 2 - 2 * a * cosine * sine) / (square * ab + sine ** 2 + 2 * a * cosine * sine))


def predicted(angle, same_height, count=2_000_000):
    """Reflectance, red, by microfacets drawn by their density D(h) cos(h)."""
    rng = np.random.default_rng(1)
    u, phi = rng.random(count), 2 * math.pi * rng.random(count)
    cos_h = np.sqrt((1 - u) / (1 + (ALPHA ** 2 - 1) * u))
    sin_h = np.sqrt(1 - cos_h ** 2)
    half = np.stack([sin_h * np.cos(phi), sin_h * np.sin(phi), cos_h], axis=1)
    out = np.array([math.sin(angle), 0, math.cos(angle)])
    dot = half @ out
    into = 2 * dot[:, None] * half - out
    cosine = into[:, 2]
    lit = (dot > 0) & (cosine > 0)
    one, two = smith_lambda(np.where(lit, cosine, 1)), smith_lambda(np.array(out[2]))
    shadow = 1 / (1 + one + two) if same_height else 1 / ((1 + one) * (1 + two))
    weight = fresnel(np.where(lit, dot, 1), GOLD["eta"][0], GOLD["k"][0]) * shadow * dot / (cos_h * out[2])
    return float(np.where(lit, weight, 0).mean())


def main():
    options = compare_renderers.parse()
    options.out = options.out.resolve()
    options.out.mkdir(parents=True, exist_ok=True)
    print(f"{'angle':>6} {'G1 G1':>8} {'by height':>10} " + " ".join(f"{name:>10}" for name in compare_renderers.NAMES.values()))
    for degrees in (0, 45, 70, 80):
        angle = math.radians(max(degrees, 0.01))
        found = [compare_renderers.render(renderer, plane_at(angle), options, 1024)[:, :, 0].mean()
                 for renderer in compare_renderers.NAMES]
        print(f"{degrees:6} {predicted(angle, False):8.4f} {predicted(angle, True):10.4f} "
              + " ".join(f"{value:10.4f}" for value in found), flush=True)
    return 0


if __name__ == "__main__":
    sys.exit(main())

#!/usr/bin/env python3
"""Checks the ONNX models of ld_export with onnxruntime: the networks of configs/, each with random weights, against the C++
program's output on three sizes of picture; with --model and --frame also a trained network against ld_denoise, over a sequence.

Fails when onnxruntime differs from C++ by more than 1e-4 (|a - b| / (|b| + 0.01)) anywhere, or refuses a model.
"""
import argparse
import json
import resource
import struct
import subprocess
import sys
import tempfile
import time
from pathlib import Path

import numpy as np
import onnxruntime
import OpenEXR

sys.path.insert(0, str(Path(__file__).parent))
import denoise_onnx  # noqa: E402

ALLOWED = 1e-4
CONFIGS = ["quick", "quick_layer_weighted", "quick_optimized", "quick_pixel_blend", "quick_pixel_gather",
           "quick_pixel_pyramid", "quick_pixel_splat", "quick_sample_splat", "quick_layer_history", "quick_recurrent"]
TYPES = {"F32": np.float32}


def read_safetensors(path):
    data = Path(path).read_bytes()
    length = struct.unpack("<Q", data[:8])[0]
    tensors = {}
    for name, entry in json.loads(data[8:8 + length]).items():
        if name != "__metadata__":
            begin, end = (8 + length + offset for offset in entry["data_offsets"])
            tensors[name] = np.frombuffer(data[begin:end], TYPES[entry["dtype"]]).reshape(entry["shape"])
    return tensors


def difference(found, expected):
    return float((np.abs(found - expected) / (np.abs(expected) + 0.01)).max())


def session_of(path, threads):
    options = onnxruntime.SessionOptions()
    options.intra_op_num_threads = threads
    options.add_session_config_entry("session.intra_op.allow_spinning", "0")
    return onnxruntime.InferenceSession(str(path), options)


def export(arguments, out, extra=()):
    result = subprocess.run(["build/bin/ld_export", *arguments, "--format", "onnx", "--out", str(out), *extra],
                            capture_output=True, text=True)
    if result.returncode != 0:
        raise SystemExit(f"ld_export {' '.join(arguments)} failed:\n{result.stderr}{result.stdout}")


def seconds(session, config_features, size):
    height, width, samples = size
    random = np.random.default_rng(1)
    inputs = {"features": random.random((1, samples, config_features, height, width), np.float32),
              "radiance": random.random((1, samples, 3, height, width), np.float32),
              "valid": np.ones((1, samples, 1, height, width), np.float32)}
    state, times = denoise_onnx.empty_state(session, inputs), []
    for _ in range(3):
        start = time.perf_counter()
        denoise_onnx.denoise(session, inputs, state)
        times.append(time.perf_counter() - start)
    return sorted(times)[1]


def check_network(config, dtype, options):
    stem = options.out / f"{config}_{dtype}"
    model, data = stem.with_suffix(".onnx"), stem.with_suffix(".safetensors")
    export(["--untrained", f"configs/{config}.yaml", "--dtype", dtype], model, ["--check-data", str(data)])
    start = time.perf_counter()
    session = session_of(model, options.threads)
    load = time.perf_counter() - start
    tensors, worst, sizes = read_safetensors(data), 0, []
    for i in range(len(tensors) // 4):
        inputs = {name: tensors[f"{name}_{i}"] for name in ("features", "radiance", "valid")}
        found = denoise_onnx.denoise(session, inputs, denoise_onnx.empty_state(session, inputs))[0]
        worst = max(worst, difference(found, tensors[f"image_{i}"]))
        sizes.append("x".join(str(n) for n in found.shape[:1] + found.shape[2:]))
    line = f"{config:24} {dtype}  {model.stat().st_size / 1e6:7.2f} MB  load {load:5.2f} s  difference {worst:.1e}  ({', '.join(sizes)})"
    if options.time:
        features = tensors["features_0"].shape[2]
        line += f"  {1000 * seconds(session, features, options.time):.0f} ms"
        line += f"  peak {resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1024:.0f} MB"
    print(line, flush=True)
    return worst


def pixels(path):
    with OpenEXR.File(str(path), separate_channels=True) as file:
        return np.array([file.parts[0].channels[c].pixels for c in "RGB"], np.float64)


def check_frames(model, frames, options):
    """A trained network on the frames of a sequence in their order, through the example program and through ld_denoise."""
    exported = options.out / "trained.onnx"
    export(["--model", model], exported)
    with tempfile.TemporaryDirectory() as folder:
        taken, found, expected = (Path(folder) / name for name in ("taken", "onnx", "ld_denoise"))
        for path in (taken, found, expected):
            path.mkdir()
        names = [f"{number:04}.exr" for number in range(len(frames))]
        for name, frame in zip(names, frames):
            (taken / name).symlink_to(Path(frame).resolve())
        denoise_onnx.main(str(exported), [str(taken / name) for name in names], found)
        subprocess.run(["build/bin/ld_denoise", "--model", model, str(taken / "####.exr"), "--float", "--output", str(expected / "####.exr")], check=True)
        worst = max(difference(pixels(found / name), pixels(expected / name)) for name in names)
    print(f"{model} on {len(frames)} frames: difference {worst:.1e}")
    return worst


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--configs", nargs="+", default=CONFIGS, help="names in configs/, without .yaml")
    parser.add_argument("--dtypes", nargs="+", default=["f32", "f16"])
    parser.add_argument("--model", help="a trained model (as ld_denoise takes it)")
    parser.add_argument("--frame", nargs="+", help="a frame for it, or those of a sequence in their order")
    parser.add_argument("--out", type=Path, default=Path("out/peers/onnx"))
    parser.add_argument("--threads", type=int, default=2)
    parser.add_argument("--time", type=int, nargs=3, metavar=("H", "W", "SPP"), help="also time this size")
    options = parser.parse_args()
    options.out.mkdir(parents=True, exist_ok=True)
    print(f"onnxruntime {onnxruntime.__version__}, allowed {ALLOWED:.0e}")
    failed = [f"{config} {dtype}" for config in options.configs for dtype in options.dtypes
              if not check_network(config, dtype, options) <= ALLOWED]
    if options.model and not check_frames(options.model, options.frame, options) <= ALLOWED:
        failed.append(options.model)
    if failed:
        raise SystemExit("onnxruntime and C++ differ: " + ", ".join(failed))


if __name__ == "__main__":
    main()

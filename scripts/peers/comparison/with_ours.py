"""Renders a scene of scenes.py with ld_render."""
import shutil
import subprocess
import sys

from comparison import as_gltf, exr


def render(scene, folder, spp, program, threads):
    path, out = folder / f"{scene['name']}.gltf", folder / f"{scene['name']}_ours"
    as_gltf.write(scene, path)
    shutil.rmtree(out, ignore_errors=True)
    command = [program, "--scene", path, "--out", out, "--views", 1, "--seed", 1, "--threads", threads,
               f"resolution=[{scene['camera']['width']},{scene['camera']['height']}]", "spp=1",
               f"reference_spp.train={spp}", f"max_bounces={scene['max_bounces']}"]
    try:
        result = subprocess.run([str(part) for part in command], capture_output=True, text=True)
    except OSError as error:
        sys.exit(f"compare_renderers.py: cannot start {program}: {error.strerror}; build it first (README.md)")
    if result.returncode != 0:
        sys.exit(f"compare_renderers.py: ld_render failed with code {result.returncode}:\n{result.stderr[-2000:]}")
    return exr.read(out / "frame_000000.reference.exr")

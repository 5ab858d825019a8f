"""Installs the extension of integrations/blender into a fresh Blender and runs it, as scripts/test_peers.sh does:

    python check_blender_extension.py --program build/bin/ld_denoise --out out/peers/extension

In the module bpy: its default scene, an animation of four frames, and a job that is cancelled half-way. Leaves the pictures in OUT.
"""
import argparse
import importlib
import os
import shutil
import subprocess
import sys
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]


def package(folder):
    """Made and checked by Blender's own `--command extension`, which the module bpy has as a script."""
    import bpy
    command = [sys.executable, Path(bpy.utils.system_resource("SCRIPTS")) / "addons_core/bl_pkg/cli/blender_ext.py"]
    source = ROOT / "integrations/blender/layered_denoiser"
    subprocess.run([*command, "validate", source], check=True)
    subprocess.run([*command, "build", "--source-dir", source, "--output-filepath", folder / "layered_denoiser.zip"], check=True)
    return folder / "layered_denoiser.zip"


def install(path):
    import bpy
    bpy.ops.extensions.package_install_files(filepath=str(path), repo="user_default", enable_on_install=True)
    return importlib.import_module("bl_ext.user_default.layered_denoiser")


def settings_now():
    """What a job must leave as it was."""
    import bpy
    scene, layer = bpy.context.scene, bpy.context.view_layer
    owners = (scene.render, scene.render.image_settings, scene.cycles, layer)
    values = [(name, str(getattr(owner, name))) for owner in owners for name in dir(owner)
              if not name.startswith("_") and isinstance(getattr(owner, name), (bool, int, float, str))]
    return [scene.frame_current, len(bpy.data.worlds), scene.world] + values


def expect_unchanged(before):
    changed = [(old, new) for old, new in zip(before, settings_now()) if old != new]
    assert not changed, f"the scene was changed: {changed}"


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--program", type=Path, required=True)
    parser.add_argument("--out", type=Path, required=True)
    options = parser.parse_args()
    shutil.rmtree(options.out, ignore_errors=True)
    options.out.mkdir(parents=True)
    out, program = options.out.resolve(), str(options.program.resolve())
    os.environ["BLENDER_USER_RESOURCES"] = str(out / "user")  # before bpy is loaded: a Blender that nobody has used
    import bpy
    addon = install(package(out))
    scene = bpy.context.scene
    scene.render.resolution_x, scene.render.resolution_y = 96, 72
    cube = bpy.data.objects["Cube"]
    cube.keyframe_insert("rotation_euler", frame=1)
    cube.rotation_euler.z = 1
    cube.keyframe_insert("rotation_euler", frame=4)
    before = settings_now()
    common = ["--program", program, "--threads", "1"]

    assert addon.command([*common, "--output", str(out / "still.exr"), "--samples", "8", "--noisy", str(out / "noisy.exr")]) == 0
    expect_unchanged(before)
    assert addon.command([*common, "--output", str(out / "frame_##.exr"), "--samples", "2", "--frames", "1:5"]) == 0
    frames = [out / f"frame_{frame:02}.exr" for frame in range(1, 5)]
    assert all(frame.is_file() for frame in frames), "an animation of 4 frames has 4 pictures"
    expect_unchanged(before)

    # Cancelled between two samples of the third frame: two pictures, nothing else, the scene as it was.
    job = importlib.import_module(addon.__name__ + ".job")
    partial = out / "cancelled"
    steps = job.run(scene, bpy.context.view_layer, job.Settings(program, "common", 2, range(1, 5), str(partial / "a_##.exr"), 1))
    for _share, text, _picture, _noisy in steps:
        if text == "frame 3, sample 2 of 2":
            break
    steps.close()
    assert sorted(file.name for file in partial.iterdir()) == ["a_01.exr", "a_02.exr"], "finished pictures and nothing else"
    expect_unchanged(before)

    assert addon.command([*common, "--output", str(out / "x.exr"), "--model", "nosuch"]) == 1
    assert not (out / "x.exr").exists()
    assert addon.command(["--output", str(out / "x.exr"), "--program", "/nosuch"]) == 1
    print(f"check_blender_extension: Blender {bpy.app.version_string}: still, animation and cancelling work; pictures in {out}")


if __name__ == "__main__":
    sys.exit(main())

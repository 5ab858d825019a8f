"""From a scene to denoised pictures, in steps between which whoever runs them may stop."""
import os
import shutil
import subprocess
import tempfile
from pathlib import Path

from . import sampling


class Settings:
    """What one job does. `program`: ld_denoise; `model`: a released name or a file; `frames`: numbers; `output`: a path with one run
    of # for the frame's number where there are several; `seed`: of the first sample."""

    def __init__(self, program, model, samples, frames, output, threads=0, seed=0):
        self.program, self.model, self.samples, self.frames = program, model, samples, list(frames)
        self.output, self.threads, self.seed = output, threads, seed


def find_program(preferred=""):
    """The path of ld_denoise: the preferred one, else of $PATH. Raises RuntimeError."""
    found = shutil.which(preferred or "ld_denoise")
    if not found:
        raise RuntimeError(f"found no program {preferred or 'ld_denoise'}; name it in the add-on's preferences or with --program")
    return found


def output_of(pattern, frame, several):
    """The file of a frame: #### becomes its number, which is appended where a pattern for several frames has none."""
    path = Path(pattern)
    if path.suffix.lower() not in (".exr", ".png"):
        path = path.with_name(path.name + ".exr")
    hashes = path.stem.count("#")
    if hashes == 0:
        return path.with_name(f"{path.stem}_{frame:04}{path.suffix}") if several else path
    if "#" * hashes not in path.stem:
        raise RuntimeError(f"{pattern}: two places for a number; expected one run of #")
    return path.with_name(path.stem.replace("#" * hashes, f"{frame:0{hashes}}") + path.suffix)


def check(scene, settings):
    if scene.camera is None:
        raise RuntimeError("the scene has no active camera")
    if not os.access(settings.program, os.X_OK):
        raise RuntimeError(f"{settings.program} is no program that can be run")
    if scene.render.use_multiview:
        raise RuntimeError("stereo scenes are not rendered by this add-on; switch Stereoscopy off")


def denoise_command(scene, settings, samples, folder, output):
    command = [settings.program, "--model", settings.model, "--preset", "cycles", *map(str, samples), "--output", str(output),
               "--noisy", str(folder / "noisy.exr"), "--allow-identical"]  # a still picture of nothing has no noise
    camera = folder / "camera.yaml"
    if sampling.write_camera(scene, camera):
        command += ["--camera", str(camera)]
        for assignment in sampling.depth_assignments(scene):
            command += ["--set", assignment]
    if settings.threads > 0:
        command += ["--threads", str(settings.threads)]
    return command


def run_program(command):
    """Yields while the program runs; ends it when the generator is closed. Raises RuntimeError with its last line."""
    with tempfile.TemporaryFile(mode="w+", encoding="utf-8") as log:
        process = subprocess.Popen(command, stdout=log, stderr=subprocess.STDOUT)
        try:
            while process.poll() is None:
                yield
        finally:
            if process.poll() is None:
                process.terminate()
            process.wait()
        log.seek(0)
        lines = [line for line in log.read().splitlines() if line.strip()]
    if process.returncode != 0:
        raise RuntimeError(lines[-1] if lines else f"{command[0]} ended with {process.returncode}")


def run(scene, view_layer, settings):
    """Yields (share that is done, what is being done, finished picture or None, its noisy picture or None). The caller shows or copies the
    noisy picture before it goes on. Closing the generator ends the job: pictures that are finished stay, nothing is half written, and
    the scene is as it was."""
    check(scene, settings)
    steps, done, before = len(settings.frames) * (settings.samples + 1), 0, scene.frame_current
    with tempfile.TemporaryDirectory(prefix="layered_denoiser_") as temporary, sampling.sample_settings(scene, view_layer):
        folder = Path(temporary)
        try:
            for frame in settings.frames:
                scene.frame_set(frame)
                samples = []
                for s in range(settings.samples):
                    yield done / steps, f"frame {frame}, sample {s + 1} of {settings.samples}", None, None
                    samples.append(folder / f"sample_{s:03}.exr")
                    samples[-1].unlink(missing_ok=True)
                    sampling.render(scene, samples[-1], settings.seed + frame * settings.samples + s)
                    done += 1
                output = output_of(settings.output, frame, len(settings.frames) > 1)
                output.parent.mkdir(parents=True, exist_ok=True)
                for _ in run_program(denoise_command(scene, settings, samples, folder, output)):
                    yield done / steps, f"frame {frame}, denoising", None, None
                done += 1
                yield done / steps, f"frame {frame}", output, folder / "noisy.exr"
        finally:
            scene.frame_set(before)

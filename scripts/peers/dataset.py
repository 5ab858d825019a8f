"""What blender_dataset.py and mitsuba_dataset.py share: from rendered files to a data set, and from there to a table."""
import json
import math
import subprocess
import sys
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]


def add_options(parser, out):
    parser.add_argument("--out", type=Path, default=out, help=f"folder of the data set (default {out})")
    parser.add_argument("--width", type=int, default=256)
    parser.add_argument("--height", type=int, default=256)
    parser.add_argument("--spp", type=int, default=8, help="samples a pixel, each a render of its own (default 8)")
    parser.add_argument("--reference-spp", type=int, default=1024)
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--prefix", default="shot", help="start of the names of the frames")
    parser.add_argument("--split", default="auto", choices=("auto", "train", "validation", "test"),
                        help="auto: of every eight pictures, at least one for validation and one for testing")
    parser.add_argument("--bin", type=Path, default=ROOT / "build/bin", help="where ld_import, ld_train and ld_eval are")
    parser.add_argument("--keep", action="store_true", help="keep the renders beside the data set, in OUT.renders")
    parser.add_argument("--train", type=int, metavar="STEPS", default=0,
                        help="then train configs/quick.yaml so many steps into OUT.run and print the table of ld_eval")


def stop(message):
    sys.exit(f"{Path(sys.argv[0]).name}: {message}")


def mitsuba_variant():
    """The fastest variant that setup.sh found to work on this machine."""
    found = ROOT / "out/peers/venv/mitsuba_variant"
    return found.read_text().strip() if found.exists() else "scalar_rgb"


def run(*command):
    """Runs a program of this project and shows what it prints; ends this one with its exit code when it fails."""
    command = [str(part) for part in command]
    print("+", " ".join(command), flush=True)
    try:
        code = subprocess.run(command).returncode
    except OSError as error:
        stop(f"cannot start {command[0]}: {error.strerror}; build it first (README.md)")
    if code != 0:
        sys.exit(code)


def frames_in(out):
    """{name: split} of the frames that the data set has already, so that an interrupted run continues."""
    manifest = out / "manifest.json"
    if not manifest.exists():
        return {}
    return {frame["name"]: frame["split"] for frame in json.loads(manifest.read_text())["frames"]}


def split_of(index, count, wanted):
    """The last pictures are for testing, those before for validation: neighbours in time look alike."""
    if wanted != "auto" or count < 3:
        return "train" if wanted == "auto" else wanted
    share = max(1, count // 8)
    return "test" if index >= count - share else "validation" if index >= count - 2 * share else "train"


def import_frame(options, preset, name, split, folder):
    """folder: sample_*.exr, reference.exr and camera.yaml."""
    run(options.bin / "ld_import", "--preset", preset, "--out", options.out, "--name", name, "--split", split,
        "--reference", folder / "reference.exr", "--camera", folder / "camera.yaml", *sorted(folder.glob("sample_*.exr")))


def train_and_evaluate(options):
    """A network with the features that the data set has; too short a training to be good, long enough to see it work."""
    if not options.train:
        return
    trained = Path(f"{options.out}.run")
    frames = list(frames_in(options.out).values()).count("train")
    if frames == 0:
        stop(f"{options.out} has no frames of the split train to train on")
    batch = min(4, frames)  # the crops of a step come from different frames
    epochs = math.ceil(options.train / (frames // batch))  # the schedule of the learning rate ends with the steps
    run(options.bin / "ld_train", "--config", ROOT / "configs/quick.yaml", f"data.path={options.out}",
        "network.features=auto", f"data.batch={batch}", f"epochs={epochs}", f"run.max_steps={options.train}", "--out", trained)
    run(options.bin / "ld_eval", "--data", options.out, "--model", f"quick={trained}", "--out", f"{options.out}.eval")

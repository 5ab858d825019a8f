#!/usr/bin/env python3
"""Pictures and time slices of a sequence out of the strips that ld_eval has left (docs/sequences.md).

    python3 scripts/time_slices.py EVAL OUT.png FRAMES [--row R] [--methods NAME ...]

EVAL is the folder of `ld_eval --report-frames N`, FRAMES the names of the first and last of consecutive frames, such as
frame_000108:frame_000119. Above each method's picture of the middle frame, below it row R of every frame, the first at the top: what stands still must
be upright and smooth, noise that changes from frame to frame makes it ragged. Needs oiiotool.
"""
import argparse
import json
import re
import subprocess
from pathlib import Path

TITLE, GAP, LINE = 18, 2, 4  # of a strip, in pixels; how tall a row of the slice is


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("eval", type=Path)
    parser.add_argument("out")
    parser.add_argument("frames", help="FIRST:LAST")
    parser.add_argument("--row", type=int, help="of the slice; default: two thirds down")
    parser.add_argument("--methods", nargs="+", help="default: all of the strip")
    options = parser.parse_args()
    frames = re.fullmatch(r"(.*?)(\d+):\1(\d+)", options.frames)
    if not frames:
        parser.error(f"frames are {options.frames!r}; expected FIRST:LAST, such as frame_000108:frame_000119")
    stem, start, last = frames.groups()
    strips = [options.eval / "strips" / f"{stem}{number:0{len(start)}}.png" for number in range(int(start), int(last) + 1)]
    count = len(strips)
    if not (options.eval / "metrics.json").exists():
        parser.error(f"there is no {options.eval / 'metrics.json'}; ld_eval --report-frames N --out {options.eval} writes it")
    known = [*json.loads((options.eval / "metrics.json").read_text())["methods"]]
    known = [*(name for name in known if name not in ("reference", "floor")), "reference"]
    if unknown := set(options.methods or []) - set(known):
        parser.error(f"no method is named {', '.join(sorted(unknown))}; {options.eval} has {', '.join(known)}")
    if not strips:
        parser.error(f"frames {options.frames}: the last comes before the first")
    if missing := [strip for strip in strips if not strip.exists()]:
        parser.error(f"there is no {missing[0]}; ld_eval leaves strips of so many frames as --report-frames says")
    size = subprocess.run(["oiiotool", "--info", str(strips[0])], capture_output=True, text=True, check=True).stdout
    across, down = map(int, re.search(r"(\d+)\s*x\s*(\d+)", size).groups())
    width, height = (across + GAP) // len(known) - GAP, down - TITLE
    row = height * 2 // 3 if options.row is None else options.row
    if not 0 <= row < height:
        parser.error(f"--row {row}: the pictures have the rows 0 to {height - 1}")
    command = ["oiiotool"]
    chosen = options.methods or known
    for method in chosen:
        x = known.index(method) * (width + GAP)
        for strip in strips:
            command += [str(strip), "--cut", f"{width}x1+{x}+{TITLE + row}", "--resize:filter=box", f"{width}x{LINE}"]
        command += ["--mosaic", f"1x{count}"]
        command += ["--create", f"{width}x{down + GAP + count * LINE}", "3", "--paste", f"+0+{down + GAP}"]
        command += [str(strips[count // 2]), "--cut", f"{width}x{down}+{x}+0", "--swap", "--paste", "+0+0"]
    command += [f"--mosaic:pad={GAP}", f"{len(chosen)}x1", "--resize", "200%", "-o", options.out]
    subprocess.run(command, check=True)
    print(f"time_slices: {count} frames of {width}x{height}, row {row}, in {options.out}")


if __name__ == "__main__":
    main()

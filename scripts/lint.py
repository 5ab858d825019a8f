#!/usr/bin/env python3
"""Runs clang-tidy over the tracked files of a compile database: lint.py BUILD_FOLDER [PATH ...] [--fast].

clang-tidy walks every header, which takes 5 to 60 s: so all files of a target are read at once (CMake's unity builds),
and what was found clean is not read again until something it depends on changes: its preprocessed text (comments
included, for NOLINT), the check lists, or clang-tidy. --fast leaves out what names LibTorch's folders.
"""
import argparse
import concurrent.futures
import hashlib
import json
import os
import re
import shlex
import subprocess
import sys
from pathlib import Path


def sources(entry):
    """The files of ours that a command compiles: several where CMake has put them into one."""
    if "/Unity/" not in entry["file"]:
        return [entry["file"]]
    return re.findall(r'^#include "(.*)"$', Path(entry["file"]).read_text(), flags=re.M)


def unity_options(entry):
    """What makes clang-tidy take the included files for ours; their folder's settings it does not find."""
    if "/Unity/" not in entry["file"]:
        return []
    checks = ",-bugprone-suspicious-include"
    if "/tests/" in sources(entry)[0]:
        checks += "," + re.search(r"^Checks: '(.*)'$", Path("tests/.clang-tidy").read_text(), flags=re.M)[1]
    return ["--checks=" + checks, r"--header-filter=(src|models|tests)/.*\.(h|cpp)$"]


def fingerprint(entry, settings):
    """Hash of all that decides what clang-tidy says about this file; None when it cannot be preprocessed."""
    command = shlex.split(entry["command"])
    output = command.index("-o")
    command[output:output + 2] = []
    command[command.index("-c")] = "-E"
    result = subprocess.run(command + ["-C", "-P"], cwd=entry["directory"], capture_output=True)
    if result.returncode != 0:
        return None
    return hashlib.sha256(settings + entry["command"].encode() + result.stdout).hexdigest()


def lint(entry, database, stamps, settings):
    """The findings as text; empty when the file is clean."""
    key = fingerprint(entry, settings)
    if key and (stamps / key).exists():
        return ""
    # Without OpenMP, because clang brings no omp.h and cannot read GCC's; LibTorch's headers do without.
    result = subprocess.run(["clang-tidy", "-quiet", "-p", str(database), "--extra-arg=-fno-openmp",
                             *unity_options(entry), entry["file"]], capture_output=True, text=True)
    if result.returncode == 0:
        if key:
            (stamps / key).touch()
        return ""
    return result.stdout or result.stderr


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("build", type=Path)
    parser.add_argument("paths", nargs="*", help="only files below these (default: all)")
    parser.add_argument("--fast", action="store_true")
    parser.add_argument("--jobs", type=int, default=len(os.sched_getaffinity(0)))
    options = parser.parse_intermixed_args()

    tracked = subprocess.check_output(["git", "ls-files"], text=True).splitlines()
    wanted = tuple(os.path.normpath(path) for path in options.paths)
    paths = {os.path.abspath(path) for path in tracked
             if not wanted or any(path == place or path.startswith(place + "/") for place in wanted)}
    entries = [entry for entry in json.loads((options.build / "compile_commands.json").read_text())
               if paths.intersection(sources(entry)) and not (options.fast and "torch/csrc" in entry["command"])]
    settings = subprocess.check_output(["clang-tidy", "--version"])
    settings += b"".join(Path(path).read_bytes() for path in tracked if path.endswith(".clang-tidy"))
    stamps = options.build / "clean"
    stamps.mkdir(exist_ok=True)

    # The same finding in a header would come once for each file that includes it.
    shown, bad_runs = set(), 0
    with concurrent.futures.ThreadPoolExecutor(options.jobs) as pool:
        runs = [pool.submit(lint, entry, options.build, stamps, settings) for entry in entries]
        for run in concurrent.futures.as_completed(runs):
            findings = run.result()
            bad_runs += bool(findings)
            for finding in re.split(r"^(?=/\S+:\d+:\d+: (?:error|warning):)", findings, flags=re.M):
                if finding.strip() and finding not in shown:
                    shown.add(finding)
                    print(finding.rstrip(), flush=True)
    read = sum(len(sources(entry)) for entry in entries)
    print(f"lint: {read} files in {len(entries)} runs, {bad_runs} with findings")
    return 1 if bad_runs else 0


if __name__ == "__main__":
    sys.exit(main())

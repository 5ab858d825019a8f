"""Runs the commands that the pages show, small, each page in a folder of its own that looks like the project's and holds what the page
takes as given. commands.toml says what small means, what is given, and what is left out and why."""
import os
import re
import shutil
import subprocess
import time
from dataclasses import dataclass, field
from pathlib import Path

import known
import pages
import snippets
from header_comments import ROOT

COPIED = ["configs", "scripts", "examples", "integrations", "data/recipes", "data/import"]   # so that no command writes to the project's
LINKED = ["models", "tests"]
TIMEOUT = 120


@dataclass
class Result:
    command: pages.Piece
    state: str           # passed, failed, left out
    why: str = ""
    ran: str = ""
    seconds: float = 0


@dataclass
class Runner:
    rules: dict
    folder: Path
    extent: str          # "brief", "", "all"
    results: list = field(default_factory=list)

    def run(self, text, folder):
        environment = dict(os.environ, PATH=f"{known.BIN}:{os.environ['PATH']}", OMP_NUM_THREADS="1",
                           OMP_WAIT_POLICY="passive", TMPDIR=str(self.folder))
        try:
            return subprocess.run(["bash", "-euo", "pipefail", "-c", text], cwd=folder, env=environment, timeout=TIMEOUT,
                                  stdin=subprocess.DEVNULL, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True)
        except subprocess.TimeoutExpired:
            return subprocess.CompletedProcess(text, 1, f"did not end within {TIMEOUT} s")

    def make_given(self, names):
        """What these pages take as given, made once by the programs themselves. Returns the complaint of the step that failed."""
        self.place = self.folder / "given"
        self.look_like_project(self.place)
        if self.extent == "brief":
            names = [name for name in names if name in self.rules["brief"]["pages"]]
        wanted = {source for name in names for source in self.rules["page"].get(name, {}).get("given", {}).values()}
        return next(filter(None, (self.make(source) for source in sorted(wanted))), "")

    def make(self, name):
        step = self.rules["make"].get(name)
        if step is None or (self.place / name).exists():
            return ""
        if complaint := self.make(step["of"]) if "of" in step else "":
            return complaint
        done = self.run(self.small(step["run"]), self.place)
        return f"{step['run']}: {done.stdout.strip()[-400:]}" if done.returncode else ""

    def look_like_project(self, folder):
        for name in COPIED:
            shutil.copytree(ROOT / name, folder / name)
        for pattern, replacement in self.rules["replace"]["in_configs"]:
            for config in (folder / "configs").iterdir():
                config.write_text(re.sub(pattern, replacement, config.read_text()))
        for name in LINKED:
            (folder / name).symlink_to(ROOT / name)
        (folder / "build").symlink_to(known.BUILD)
        (folder / "out").mkdir()
        if (ROOT / "out/peers").exists():
            (folder / "out/peers").symlink_to(ROOT / "out/peers")

    def small(self, text, page=""):
        for pattern, replacement in self.rules["page"].get(page, {}).get("replace", []):
            text = re.sub(pattern, replacement, text)
        for pattern, replacement in self.rules["replace"]["everywhere"]:
            text = re.sub(pattern, replacement, text)
        for pattern, words in self.rules["small"].items():
            if re.match(rf"(?:time )?(?:build/bin/)?{pattern}", text):
                text += " " + words
        return text

    def left_out(self, command):
        """Why a command is not run; empty when it is."""
        for entry in self.rules["left_out"]:
            if re.search(entry["command"], command.text) and re.search(entry.get("page", ""), command.page):
                if "unless" in entry and all(Path(ROOT / path).exists() for path in entry["unless"]):
                    continue
                if entry.get("slow") and self.extent == "all":
                    continue
                return entry["why"] + ("; --all runs it" if entry.get("slow") else "")
        if self.extent == "brief" and command.page not in self.rules["brief"]["pages"]:
            return "--brief"
        return ""

    def run_page(self, page, blocks):
        folder = self.folder / page.replace("/", "_")
        self.look_like_project(folder)
        for name, source in self.rules["page"].get(page, {}).get("given", {}).items():
            found = self.place / source if (self.place / source).exists() else ROOT / source
            target = folder / name
            target.parent.mkdir(parents=True, exist_ok=True)
            if found.is_dir():
                shutil.copytree(found, target, symlinks=True)
            elif found.exists():
                shutil.copy(found, target)
        return [result for block in blocks for result in self.run_block(block, folder)]

    def run_block(self, block, folder):
        if snippets.is_snippet(block):
            shown = pages.Piece(block.page, block.line, f"({block.language}) {block.text.splitlines()[0]} ...")
            text, why = snippets.command_of(block, folder, self.rules["declarations"].get(block.page, {}))
            return [self.try_out(shown, text, why, folder)]
        if block.language != "sh":
            return []
        return [self.try_out(command, self.small(command.text, block.page), self.left_out(command), folder)
                for command in pages.commands(block)]

    def try_out(self, shown, text, why_not, folder):
        if why_not:
            return Result(shown, "left out", why_not)
        start = time.monotonic()
        done = self.run(text, folder)
        state, why = ("failed", done.stdout.strip()[-600:]) if done.returncode else ("passed", "")
        return Result(shown, state, why, text, time.monotonic() - start)

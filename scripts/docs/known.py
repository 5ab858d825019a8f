"""What there is: the programs and scripts of the project with their options, and the keys of its YAML files."""
import concurrent.futures
import functools
import os
import re
import subprocess
from pathlib import Path

import keys_page
from header_comments import ROOT

BUILD = Path(os.environ.get("LD_BUILD", ROOT / "build"))
BIN = BUILD / "bin"
PYTHONS = ("python", "python3", "out/peers/venv/bin/python")


def print_help(*command):
    return subprocess.run([str(BIN / command[0]), *command[1:], "--help"], capture_output=True, text=True, check=True).stdout


@functools.lru_cache(None)
def help_texts():
    """Of all programs and of ld_bench's subcommands, asked for at once: each takes a while to load LibTorch."""
    with concurrent.futures.ThreadPoolExecutor() as pool:
        names = [(name,) for name in program_names()]
        texts = dict(zip(names, pool.map(lambda name: print_help(*name), names)))
        benches = [("ld_bench", name) for name in subcommands_in(texts["ld_bench",])]
        return texts | dict(zip(benches, pool.map(lambda name: print_help(*name), benches)))


def help_text(*command):
    return help_texts()[command]


def subcommands_in(text):
    return re.findall(r"^  (\w+) ", text.partition("Subcommands:\n")[2].partition("\n\n")[0], re.M)


def help_options(text):
    return {option for line in text.splitlines() if line.startswith("  -") for option in re.findall(r"--?[a-zA-Z][\w-]*", line[:50])}


@functools.lru_cache(None)
def program_options(name, subcommand=""):
    options = help_options(help_text(name))
    return options | help_options(help_text(name, subcommand)) if subcommand else options


@functools.lru_cache(None)
def subcommands(name):
    return subcommands_in(help_text(name))


@functools.lru_cache(None)
def script_options(path):
    """Every --option that the source of a script names; those that it passes on count as well."""
    return set(re.findall(r"--[a-z][\w-]*", (ROOT / path).read_text()))


@functools.lru_cache(None)
def defaults(kind):
    return {key["key"]: key["default"] for key in keys_page.known_keys(str(BIN / "ld_inspect"), kind)}


def keys(kind):
    return list(defaults(kind))


def is_key(kind, name):
    """Also sections, and what begins a key with [] in it."""
    return any((key.replace("[]", "") + ".").startswith(name + ".") for key in keys(kind))


@functools.lru_cache(None)
def test_programs():
    return {match for file in (ROOT / "tests").rglob("CMakeLists.txt") for match in re.findall(r"ld_test\((\w+)", file.read_text())}


@functools.lru_cache(None)
def files():
    """The sources and scripts of the project."""
    return [f"/{path.relative_to(ROOT)}" for folder in ("src", "models", "scripts", "tests", "examples", "integrations", "docs")
            for path in (ROOT / folder).rglob("*.*")]


def program_names():
    return sorted(path.name for path in BIN.glob("ld_*"))

"""What there is: the programs and scripts of the project with their options, and the keys of its YAML files."""
import functools
import re
import subprocess
from pathlib import Path

import keys_page
from header_comments import ROOT

BIN = ROOT / "build" / "bin"
PYTHONS = ("python", "python3", "out/peers/venv/bin/python")


@functools.lru_cache(None)
def help_text(*command):
    return subprocess.run([str(BIN / command[0]), *command[1:], "--help"], capture_output=True, text=True, check=True).stdout


def help_options(text):
    return {option for line in text.splitlines() if line.startswith("  -") for option in re.findall(r"--?[a-zA-Z][\w-]*", line[:50])}


@functools.lru_cache(None)
def program_options(name, subcommand=""):
    options = help_options(help_text(name))
    return options | help_options(help_text(name, subcommand)) if subcommand else options


@functools.lru_cache(None)
def subcommands(name):
    _, _, after = help_text(name).partition("Subcommands:\n")
    return re.findall(r"^  (\w+) ", after.partition("\n\n")[0], re.M)


@functools.lru_cache(None)
def script_options(path):
    """Every --option that the source of a script names; those that it passes on count as well."""
    return set(re.findall(r"--[a-z][\w-]*", (ROOT / path).read_text()))


@functools.lru_cache(None)
def keys(kind):
    return [key["key"] for key in keys_page.known_keys(str(BIN / "ld_inspect"), kind)]


def is_key(kind, name):
    """Also sections, and what begins a key with [] in it."""
    return any(key == name or key.startswith(name + ".") or key.replace("[]", "").startswith(name + ".") for key in keys(kind))


@functools.lru_cache(None)
def test_programs():
    return {match for file in (ROOT / "tests").rglob("CMakeLists.txt") for match in re.findall(r"ld_test\((\w+)", file.read_text())}


def program_names():
    return sorted(path.name for path in BIN.glob("ld_*"))

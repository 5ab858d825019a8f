#!/usr/bin/env python3
"""Writes docs/keys.md: all keys of the YAML files, as the programs know them (ld_inspect --keys), with the comments of the headers.

  scripts/docs/keys_page.py           writes the page
  scripts/docs/keys_page.py --check   says whether the page is what would be written; exit code 1 when it is not
"""
import argparse
import json
import os
import re
import subprocess
import sys
import tempfile
from pathlib import Path

import header_comments

PAGE = header_comments.ROOT / "docs" / "keys.md"
INTRO = """# All keys

Every key of every YAML file that the programs read, with its default and what it may be. An unknown key is an error that names the
nearest known one. `key.sub=value` on the command line sets any of them.

This page is written by `scripts/docs/keys_page.py`. The keys are those that `ld_inspect --keys train` (`recipe`, `mapping`, `camera`, `eaw`, `svgf`)
prints; the last column is the comment of the key's field in the source. A test fails when the page is older than either.
"""
KINDS = {
    "train": ("Training configurations", "TrainConfig",
              "What `ld_train --config` reads. [Training](training.md), [loading](loading.md) and [networks](networks.md) explain them. "
              "A file may also say `base: FILE`, which names [a configuration that it builds on](training.md)."),
    "recipe": ("Scene recipes", "Recipe",
               "What `ld_render --recipe` reads. [Rendering](rendering.md) and [scenes](scenes.md) explain them."),
    "mapping": ("Mappings", "ImportMapping",
                "What `ld_import --mapping` and `ld_denoise --mapping` read. [Import](import.md#mappings) explains them. FEATURE stands for "
                "`alpha` and for every feature: {features}. Each feature but `alpha` has a second choice with the same keys, "
                "`depth_2.channels` for instance."),
    "camera": ("Camera files", "CameraConfig",
               "What `ld_import --camera` and `ld_denoise --camera` read. [Import](import.md#the-camera) explains them."),
    "eaw": ("The filter EAW", "EawSettings",
            "What `--filter eaw` takes, as `--set eaw.KEY=value`. [Filters](filters.md) explains them."),
    "svgf": ("The filter SVGF", "SvgfSettings",
             "What `--filter svgf` takes, as `--set svgf.KEY=value`. [Filters](filters.md) explains them."),
}


def known_keys(program, kind):
    with tempfile.NamedTemporaryFile(suffix=".json") as file:
        subprocess.run([program, "--keys", kind, "--json", file.name], check=True, stdout=subprocess.DEVNULL)
        return json.loads(Path(file.name).read_text())


def folded(keys):
    """The keys of all features as one FEATURE.key each, and the features' names."""
    groups, features, plain = {}, [], []
    for key in keys:
        feature, _, name = key["key"].partition(".")
        if not name:
            plain.append(key)
            continue
        if feature.endswith("_2"):
            continue
        if feature not in features:
            features.append(feature)
        groups.setdefault((name, key["type"], key["default"], key["allowed"]), []).append(feature)
    for (name, kind, default, allowed), of in groups.items():
        plain.append({"key": f"FEATURE.{name}", "type": kind, "default": default, "allowed": allowed,
                      "of": of if len(of) < len(features) else []})
    return plain, features


def cell(text):
    return text.replace("|", "\\|")


def row(key, what):
    of = "of " + ", ".join(f"`{name}`" for name in key["of"]) + ": " if key.get("of") else ""
    what = re.sub(r"\b((?:[\w./]+/)?\w+\.(?:h|md)(?:#\w+)?)", r"`\1`", what)
    kind = key["type"] + (": " + key["allowed"] if key["allowed"] else "")
    return f"| `{key['key']}` | {cell(kind)} | `{cell(key['default'])}` | {of}{cell(what)} |\n"


def section_text(keys, structs, struct):
    """Tables: keys without a section first, then one for each section."""
    sections = {}
    for key in keys:
        outer, _, inner = key["key"].partition(".")
        sections.setdefault(outer if inner else "", []).append(key)
    text = ""
    for section in sorted(sections, key=lambda name: name != ""):
        if section:
            text += f"\n### {section}\n"
        text += "\n| key | is | default | what |\n| --- | --- | --- | --- |\n"
        for key in sections[section]:
            path = key["key"]
            if path.startswith("FEATURE."):
                what = header_comments.describe(structs, "FeatureMapping", path.partition(".")[2])
            else:
                what = header_comments.describe(structs, struct, path)
            if not what:
                sys.exit(f"keys_page.py: no comment in the headers says what {path} is")
            text += row(key, what)
    return text


def page(program):
    structs = header_comments.read_structs()
    text = INTRO
    for kind, (title, struct, about) in KINDS.items():
        keys = known_keys(program, kind)
        features = []
        if kind == "mapping":
            keys, features = folded(keys)
        names = ", ".join(f"`{name}`" for name in features if name != "alpha")
        text += f"\n## {title}\n\n{about.format(features=names)}\n" + section_text(keys, structs, struct)
    return text


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--check", action="store_true", help="compare instead of writing")
    parser.add_argument("--program", default=os.environ.get("LD_BUILD", str(header_comments.ROOT / "build")) + "/bin/ld_inspect",
                        help="ld_inspect (default: that of build/, or of the folder that LD_BUILD names)")
    options = parser.parse_args()
    text = page(options.program)
    if not options.check:
        PAGE.write_text(text)
        print(f"keys_page: {text.count(chr(10) + '| `')} keys in {PAGE}")
    elif not PAGE.exists() or PAGE.read_text() != text:
        sys.exit("keys_page: docs/keys.md is not what the programs say now; run scripts/docs/keys_page.py")
    else:
        print(f"keys_page: docs/keys.md is up to date, {text.count(chr(10) + '| `')} keys")


if __name__ == "__main__":
    main()

"""Checks the extension's manifest against the schema that Blender's manual describes ("How to Create Extensions"), where no Blender is
at hand: check_manifest.py [FOLDER]. Blender's own check is `blender --command extension validate`."""
import re
import sys
import tomllib
from pathlib import Path

TEXT, LIST, TABLE = str, list, dict
REQUIRED = {"schema_version": TEXT, "id": TEXT, "version": TEXT, "name": TEXT, "tagline": TEXT, "maintainer": TEXT, "type": TEXT,
            "blender_version_min": TEXT, "license": LIST}
OPTIONAL = {"blender_version_max": TEXT, "website": TEXT, "copyright": LIST, "tags": LIST, "platforms": LIST, "wheels": LIST,
            "permissions": TABLE, "build": TABLE}
PERMISSIONS = {"files", "network", "clipboard", "camera", "microphone"}
VERSION = r"\d+\.\d+\.\d+"


def terse(text):
    """What the manual asks of taglines and of reasons for permissions."""
    return 0 < len(text) <= 64 and text == text.strip() and (text[-1].isalnum() or text[-1] in ")]}")


def problems(manifest):
    """What is wrong, a line each."""
    for key in sorted(set(REQUIRED) - set(manifest)):
        yield f"{key} is missing"
    for key, value in manifest.items():
        kind = {**REQUIRED, **OPTIONAL}.get(key)
        if kind is None:
            yield f"{key} is no key of the schema"
        elif not isinstance(value, kind) or not value:
            yield f"{key} is not a {kind.__name__} that holds something"
        elif kind is LIST and not all(isinstance(item, str) and item.strip() for item in value):
            yield f"{key} is not a list of texts"
    text = {key: value for key, value in manifest.items() if isinstance(value, str)}
    for key, pattern in (("schema_version", r"1\.0\.0"), ("id", r"[A-Za-z][A-Za-z0-9]*(_[A-Za-z0-9]+)*"),
                         ("version", VERSION + r"([-+][0-9A-Za-z.+-]+)?"), ("type", "add-on|theme"),
                         ("blender_version_min", VERSION), ("blender_version_max", VERSION)):
        if key in text and not re.fullmatch(pattern, text[key]):
            yield f"{key} = {text[key]!r} is not of the pattern {pattern}"
    if "tagline" in text and not terse(text["tagline"]):
        yield "tagline is longer than 64 letters or ends in a full stop"
    for name in manifest.get("license", []):
        if not str(name).startswith("SPDX:"):
            yield f"license {name!r} is no SPDX identifier"
    for name, reason in dict(manifest.get("permissions", {})).items():
        if name not in PERMISSIONS or not terse(str(reason)):
            yield f"permission {name}: not one of {', '.join(sorted(PERMISSIONS))}, or its reason is no short phrase"


def main():
    folder = Path(sys.argv[1]) if len(sys.argv) > 1 else Path(__file__).resolve().parent / "layered_denoiser"
    with open(folder / "blender_manifest.toml", "rb") as file:
        manifest = tomllib.load(file)
    found = list(problems(manifest))
    if manifest.get("type") == "add-on" and not (folder / "__init__.py").is_file():
        found.append("an add-on needs an __init__.py")
    if manifest.get("id") != folder.name:
        found.append(f"the id {manifest.get('id')} is not the folder's name")
    for line in found:
        print(f"check_manifest: {line}", file=sys.stderr)
    # The checks themselves: each of these changes must be found.
    for key, value in (("id", "two  words"), ("version", "1"), ("tagline", "Ends in a full stop."), ("license", ["Apache"]),
                       ("permissions", {"disk": "Writes"}), ("tags", "Render"), ("unknown", "x"), ("name", "")):
        if not list(problems({**manifest, key: value})):
            found.append(key)
            print(f"check_manifest: a wrong {key} was not found", file=sys.stderr)
    if not found:
        print(f"check_manifest: {manifest['id']} {manifest['version']} is as the manual says")
    return 1 if found else 0


if __name__ == "__main__":
    sys.exit(main())

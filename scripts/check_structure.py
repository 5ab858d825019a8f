#!/usr/bin/env python3
"""Holds the folders of src/ and models/ to what docs/architecture.md promises; exit code 1 and a line for each fault:

  - the graph of which folder includes which has no circle,
  - no header's name stands in two folders,
  - no folder holds more than 40 sources, no `main` has more than 100 lines.
"""
import collections
import re
import sys
from pathlib import Path

ROOT = Path(__file__).resolve().parent.parent
MOST_FILES, MOST_LINES_OF_MAIN = 40, 100


def included_folders(path):
    for name in re.findall(r'^#include "([^"]+)"', path.read_text(), flags=re.M):
        for base in (ROOT / "src", ROOT):
            if (base / name).exists():
                yield (base / name).parent
                break


def circle(graph):
    """Some folders that include each other in turn; empty where there are none."""
    done = set()

    def visit(folder, trail):
        if folder in trail:
            return trail[trail.index(folder):] + [folder]
        if folder in done:
            return []
        for other in sorted(graph[folder]):
            if found := visit(other, trail + [folder]):
                return found
        done.add(folder)
        return []

    for folder in sorted(graph):
        if found := visit(folder, []):
            return found
    return []


def main():
    sources = sorted(path for base in ("src", "models") for path in (ROOT / base).rglob("*") if path.suffix in (".h", ".cpp"))
    graph, names, sizes, faults = collections.defaultdict(set), collections.defaultdict(set), collections.Counter(), []
    for path in sources:
        folder = path.parent
        sizes[folder] += 1
        graph[folder] |= {other for other in included_folders(path) if other != folder}
        if path.suffix == ".h":
            names[path.name].add(folder)
        if start := re.search(r"^int main\(.*?^}", path.read_text(), flags=re.M | re.S):
            lines = start.group().count("\n") + 1
            if lines > MOST_LINES_OF_MAIN:
                faults.append(f"{path.relative_to(ROOT)}: main has {lines} lines; expected at most {MOST_LINES_OF_MAIN}")
    if found := circle(graph):
        faults.append("folders include each other: " + " -> ".join(str(folder.relative_to(ROOT)) for folder in found))
    for name, folders in sorted(names.items()):
        if len(folders) > 1:
            faults.append(f"{name} stands in {' and '.join(sorted(str(f.relative_to(ROOT)) for f in folders))}; one name, one thing")
    for folder, count in sorted(sizes.items()):
        if count > MOST_FILES:
            faults.append(f"{folder.relative_to(ROOT)} holds {count} sources; expected at most {MOST_FILES}")
    print("\n".join(faults) or f"structure: {len(sizes)} folders, {len(sources)} sources, no circle")
    return 1 if faults else 0


if __name__ == "__main__":
    sys.exit(main())

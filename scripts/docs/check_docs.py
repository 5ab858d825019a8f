#!/usr/bin/env python3
"""Checks what README.md and docs/*.md show: the work of scripts/check_docs.sh, which says how it is used."""
import argparse
import concurrent.futures
import sys
import tempfile
import time
import tomllib
from pathlib import Path

import check_static
import pages
import run_commands
from header_comments import ROOT


def run_all(names, rules, options):
    with tempfile.TemporaryDirectory() as folder:
        runner = run_commands.Runner(rules, Path(folder), "brief" if options.brief else "all" if options.all else "")
        complaint = runner.make_given(names)
        if complaint:
            sys.exit(f"check_docs: what pages take as given cannot be made: {complaint}")
        with concurrent.futures.ThreadPoolExecutor(options.jobs) as pool:
            runs = [pool.submit(runner.run_page, name, pages.read_page(name)[0]) for name in names]
            return [result for run in runs for result in run.result()]


def report(results, verbose):
    for result in results:
        if result.state == "failed":
            print(f"{result.command.place()}: FAILED: {result.command.text}\n  as {result.ran}\n  {result.why}")
        elif verbose and result.state == "passed":
            print(f"{result.command.place()}: passed in {result.seconds:.1f} s: {result.ran}")
    brief = sum(result.why == "--brief" for result in results)
    if brief:
        print(f"left out, --brief: {brief} commands and snippets of other pages")
    for result in results:
        if result.state == "left out" and result.why != "--brief":
            print(f"{result.command.place()}: left out, {result.why}: {result.command.text.splitlines()[0][:90]}")


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0], prog="check_docs.sh")
    parser.add_argument("pages", nargs="*", help="only these (default: README.md and docs/*.md)")
    parser.add_argument("--static", action="store_true", help="run nothing, only look")
    parser.add_argument("--brief", action="store_true", help="run the pages that commands.toml calls brief only")
    parser.add_argument("--all", action="store_true", help="also run what takes longer than some seconds")
    parser.add_argument("--verbose", action="store_true", help="also list the commands that passed, as they were run")
    parser.add_argument("--jobs", type=int, default=2, help="pages that run at once (default: 2)")
    options = parser.parse_args()
    start = time.monotonic()
    with open(ROOT / "scripts/docs/commands.toml", "rb") as file:
        rules = tomllib.load(file)
    names = options.pages or pages.page_names()

    found = check_static.Findings()
    for name in names:
        check_static.check_page(found, name, set(rules["external"]))
    for fault in found.faults:
        print(f"FAULT {fault}")
    results = [] if options.static else run_all(names, rules, options)
    report(results, options.verbose)

    print(f"check_docs: {len(names)} pages; looked at " + ", ".join(f"{number} {what}" for what, number in sorted(found.counts.items())) +
          f": {len(found.faults)} faults")
    failed = sum(result.state == "failed" for result in results)
    if not options.static:
        passed, left_out = (sum(result.state == state for result in results) for state in ("passed", "left out"))
        print(f"check_docs: {len(results)} commands and snippets in blocks: {passed + failed} run, {passed} passed, {failed} failed, "
              f"{left_out} left out; {time.monotonic() - start:.0f} s")
    return 1 if found.faults or failed else 0


if __name__ == "__main__":
    sys.exit(main())

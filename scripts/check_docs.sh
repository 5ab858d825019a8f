#!/usr/bin/env bash
# Checks README.md and docs/*.md: every program, script, option, key, path and link that they name exists, and the commands in their
# blocks run. Each page runs in a temporary folder that looks like the project's, small: scripts/docs/commands.toml says how, and what
# is left out and why. All that is left out is listed. Exit code 1 when something is wrong.
#   scripts/check_docs.sh             what takes seconds
#   scripts/check_docs.sh --all       also what takes longer
#   scripts/check_docs.sh --static    looks, and runs nothing
#   scripts/check_docs.sh PAGE...     only these pages; --verbose lists what was run
#   scripts/check_docs.sh --brief     runs some pages only: what ctest does
# Needs the programs in build/bin (or in bin/ of the folder that LD_BUILD names) and Python 3.11.
set -euo pipefail
cd "$(dirname "$0")/.."
exec python3 -B scripts/docs/check_docs.py "$@"

#!/usr/bin/env bash
# Builds the Python package (docs/python.md) and installs it into out/peers/venv, which setup.sh makes. About two minutes on two cores.
set -euo pipefail
cd "$(dirname "$0")/../.."
python=out/peers/venv/bin/python
. scripts/packages.sh
header=$("$python" -c 'import sysconfig; print(sysconfig.get_path("include") + "/Python.h")')
[ -e "$header" ] || install_missing peers python3-dev
"$python" -m pip install --quiet --disable-pip-version-check --force-reinstall --no-deps ./python

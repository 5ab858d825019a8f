#!/usr/bin/env bash
# Makes out/peers/torch, a Python environment with PyPI's PyTorch alone: its LibTorch is what scripts/test_pypi_torch.sh builds against,
# its torchrun is tried by scripts/peers/launchers.sh. 3 GB are loaded from PyPI, 5 GB are on disk. Safe to run twice.
set -euo pipefail
cd "$(dirname "$0")/../.."
venv=out/peers/torch
wanted=scripts/peers/torch_requirements.txt

if cmp -s "$wanted" "$venv/requirements.txt"; then
  echo "peers: $venv is up to date"
  exit 0
fi

python=${PYTHON:-python3}
command -v "$python" > /dev/null || { echo "torch.sh: found no $python; install Debian's python3 or name one with PYTHON=..." >&2; exit 1; }
. scripts/packages.sh
"$python" -c 'import ensurepip' 2> /dev/null || install_missing peers python3-venv

[ -x "$venv/bin/pip" ] || "$python" -m venv "$venv"
"$venv/bin/pip" install --quiet --no-cache-dir --disable-pip-version-check -r "$wanted"
"$venv/bin/python" -W ignore -c 'import torch; print("peers: PyTorch", torch.__version__)'
cp "$wanted" "$venv/requirements.txt"

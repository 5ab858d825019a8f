#!/usr/bin/env bash
# Speed beside Open Image Denoise, from the same arrays in memory, in turns:
#
#   scripts/speed.sh [--json FILE] [OPTIONS]
#
# Installs both (Open Image Denoise from PyPI: 250 MB with numpy on first use; the Python package is built anew), renders a frame of 1920x1080 pixels
# with 8 samples into out/speed/ where there is none, and prints a table. The options are those of scripts/peers/speed.py, which says what is
# timed and how. Environment: BIN, default build/bin.
set -euo pipefail
cd "$(dirname "$0")/.."
scripts/peers/setup.sh numpy pyoidn >&2
scripts/peers/python_package.sh
frame=out/speed/frame_000000.exr
if [ ! -e "$frame" ]; then
  "${BIN:-build/bin}/ld_render" --recipe data/recipes/quick.yaml --out out/speed --frames 0:1 \
    'resolution=[1920,1080]' spp=8 reference_spp.train=1 reference_spp.validation=1 reference_spp.test=1 >&2
fi
exec out/peers/venv/bin/python scripts/peers/speed.py --frame "$frame" "$@"

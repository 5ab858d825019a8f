#!/usr/bin/env bash
# Makes the Debian package (scripts/package.sh), installs it in a fresh Debian of this machine's release, and runs the quickstart's steps
# there with it, and the example of the library. Needs root and debootstrap (scripts/setup.sh --dev).
#   scripts/test_package.sh [FOLDER]   the tree is /var/tmp/ld_package, thrown away first; MIRROR=URL takes another mirror
set -euo pipefail
cd "$(dirname "$0")/.."
me=test_package
. scripts/debian_tree.sh
scripts/package.sh
. /etc/os-release
make_tree "$(realpath -m "${1:-/var/tmp/ld_package}")" "$VERSION_CODENAME" ON
cp build/package/*.deb "$tree/srv/"
# shellcheck disable=SC2016
in_tree bash -euc '
  cd /srv
  apt-get update -q
  DEBIAN_FRONTEND=noninteractive apt-get install -q -y --no-install-recommends ./*.deb
  command -v gcc cmake && { echo "a compiler was installed"; exit 1; }
  dpkg -s layer-denoiser | grep -E "^(Version|Installed-Size|Depends)"
  /usr/share/layer_denoiser/quickstart.sh
  DEBIAN_FRONTEND=noninteractive apt-get install -q -y --no-install-recommends cmake g++ make > /dev/null
  cmake -S /usr/share/layer_denoiser/examples -B out/examples > /dev/null
  cmake --build out/examples
  out/examples/denoise_c /usr/share/layer_denoiser/models/common_fast.safetensors out/picture.pfm
  apt-get remove -q -y layer-denoiser > /dev/null
  [ ! -e /usr/bin/ld_denoise ] && [ ! -e /usr/share/layer_denoiser ]'
echo "$me: installed, the quickstart and the library ran, removed"

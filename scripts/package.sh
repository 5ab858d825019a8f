#!/usr/bin/env bash
# Makes a Debian package of what build/ holds, after bringing it up to date: build/package/layer-denoiser_*.deb. Its dependencies are the
# packages of this machine's Debian, so it fits that release alone. scripts/test_package.sh installs it elsewhere and tries it.
set -euo pipefail
cd "$(dirname "$0")/.."
[ -e build/CMakeCache.txt ] || scripts/setup.sh --no-tests
cmake --build --preset release
rm -rf build/package
cpack --config build/CPackConfig.cmake -B build/package > build-package.log || { cat build-package.log >&2; exit 1; }
package=$(ls build/package/*.deb)
echo "package: $package, $(stat -c %s "$package" | numfmt --to=si)B, $(dpkg-deb -f "$package" Installed-Size) kB installed"

#!/usr/bin/env bash
# Makes out/peers/venv, a Python environment with Blender (as the module bpy), Mitsuba 3, Open Image Denoise, onnxruntime and
# TensorBoard: 1.4 GB from PyPI. Needs Python 3.11, for which Blender's long-term release is there. Nothing else in the project needs it.
# Safe to run twice.
#
#   scripts/peers/setup.sh [PACKAGE...]
#
# With names of packages of requirements.txt, installs those alone.
set -euo pipefail
cd "$(dirname "$0")/../.."
venv=out/peers/venv
wanted=scripts/peers/requirements.txt

if cmp -s "$wanted" "$venv/requirements.txt"; then
  echo "peers: $venv is up to date"
  exit 0
fi
only=()
for name in "$@"; do
  only+=("$(grep -E "^$name==" "$wanted")") || { echo "setup.sh: $wanted has no package '$name'" >&2; exit 1; }
done

python=${PYTHON:-python3.11}
command -v "$python" >/dev/null || { echo "setup.sh: found no $python; install Debian's python3 or name one with PYTHON=..." >&2; exit 1; }
"$python" -c 'import sys; sys.exit(sys.version_info[:2] != (3, 11))' || { echo "setup.sh: $python is not Python 3.11" >&2; exit 1; }

packages=()
"$python" -c 'import ensurepip' 2>/dev/null || packages+=(python3-venv)
. scripts/packages.sh
if [ ${#only[@]} -gt 0 ]; then
  install_missing peers "${packages[@]}"
  [ -x "$venv/bin/pip" ] || "$python" -m venv "$venv"
  "$venv/bin/pip" install --quiet --disable-pip-version-check "${only[@]}"
  exit 0
fi
# What Blender is linked to, although nothing is shown on a screen; and what makes Mitsuba 4 times faster (LLVM 15 is too old).
libraries=$(ldconfig -p)
while read -r library package; do
  [[ $library == '' || $libraries == *"$library "* ]] || packages+=("$package")
done <<'END'
libSM.so.6 libsm6
libXi.so.6 libxi6
libXrender.so.1 libxrender1
libXfixes.so.3 libxfixes3
libXext.so.6 libxext6
libxkbcommon.so.0 libxkbcommon0
libGL.so.1 libgl1
libLLVM.so.19.1 libllvm19
END
install_missing peers "${packages[@]}"

[ -x "$venv/bin/pip" ] || "$python" -m venv "$venv"
"$venv/bin/pip" install --quiet --disable-pip-version-check -r "$wanted"
"$venv/bin/python" -c 'import bpy, mitsuba; print("peers: Blender", bpy.app.version_string, "and Mitsuba", mitsuba.__version__)'
# A compiler that does not fit ends the whole process, so it is tried out here.
variant=llvm_ad_rgb
"$venv/bin/python" -c 'import mitsuba; mitsuba.set_variant("llvm_ad_rgb"); s = mitsuba.load_dict(mitsuba.cornell_box())
print(mitsuba.render(s, spp=1).numpy().mean())' > /dev/null 2>&1 || variant=scalar_rgb
echo "$variant" > "$venv/mitsuba_variant"
echo "peers: Mitsuba renders with its variant $variant"
cp "$wanted" "$venv/requirements.txt"

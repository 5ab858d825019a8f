#!/usr/bin/env bash
# Fetches CC0 probes, meshes and surface textures for random scenes to data/generated/assets: the npm package
# @pmndrs/assets 1.7.0 (13 MB), all of it under CC0 1.0 by its LICENSE. Its 18 probes are from Poly Haven (once HDRI
# Haven), 512 pixels wide; the textures are its normal maps and a cloud, used as colours; the meshes a rabbit and an ape. Logos, fonts and matcaps stay
# behind. Nothing in the project depends on these files; a recipe uses them when it says so (docs/scenes.md).
set -euo pipefail
cd "$(dirname "$0")/.."
out=data/generated/assets
version=1.7.0
checksum=152bd218a3390703f184f0c6ce16e73c8f0a87f32d38530d418a09d33d8208dc
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT

curl --fail --silent --show-error --location --output "$work/assets.tgz" \
  "https://registry.npmjs.org/@pmndrs/assets/-/assets-$version.tgz"
echo "$checksum  $work/assets.tgz" | sha256sum --check --quiet
tar -xzf "$work/assets.tgz" -C "$work"

# Each file is a line of JavaScript: export default 'data:...;base64,...'
unpack() {  # FOLDER_IN_PACKAGE FOLDER_HERE NAME...
  local from=$1 to=$out/$2 count=0
  shift 2
  mkdir -p "$to"
  for name in "$@"; do
    sed -e "s/^.*base64,//" -e "s/['\"].*$//" "$work/package/$from/$name.js" | base64 --decode > "$to/$name"
    count=$((count + 1))
  done
  echo "$count files in $to"
}
names() {  # FOLDER_IN_PACKAGE PATTERN
  (cd "$work/package/$1" && for f in $2.js; do echo "${f%.js}"; done)
}
unpack hdri probes $(names hdri '*.exr')
unpack models meshes bunny.glb suzi.glb
unpack normals textures $(names normals '*.webp')
unpack textures textures cloud.webp
cp "$work/package/LICENSE" "$out/LICENSE"

#!/usr/bin/env bash
# Builds the current commit and runs its tests on Debian 13 (trixie), in a tree of its own: debootstrap makes it, then scripts/test.sh
# runs in it as on any new machine. Needs root and debootstrap (scripts/setup.sh --dev). Nothing stays mounted or running.
#   scripts/test_debian13.sh                  the tree is /var/tmp/ld_debian13
#   scripts/test_debian13.sh FOLDER           another one, outside of the project
#   scripts/test_debian13.sh --fresh [FOLDER] throws the tree away first
#   scripts/test_debian13.sh --exchange       no tests: once both are built, here and there, each reads what the other wrote (1 min)
# What is not committed is not tested. Run again, it keeps the installed tree and its build folder and compiles what has changed.
# JOBS=N sets how many compilers run at once (default: the CPUs). MIRROR=URL takes another mirror.
set -euo pipefail
cd "$(dirname "$0")/.."
me=test_debian13
. scripts/debian_tree.sh

fresh=OFF exchange=OFF folder=/var/tmp/ld_debian13
for argument in "$@"; do
  case "$argument" in
    --fresh) fresh=ON ;;
    --exchange) exchange=ON ;;
    -*) echo "$me: unknown option '$argument'; expected --fresh, --exchange or a folder" >&2; exit 2 ;;
    *) folder=$(realpath -m "$argument") ;;
  esac
done
make_tree "$folder" trixie $fresh

inside=/srv/layer_denoiser  # the project in the tree
if [ $exchange = ON ]; then
  there() { in_tree bash "$inside/scripts/exchange.sh" "$@"; }
  shared=/srv/exchange
  rm -rf "$tree$shared"
  scripts/exchange.sh write "$tree$shared/here"
  there write "$shared/there"
  for writer in here there; do
    scripts/exchange.sh read "$tree$shared/$writer" here
    there read "$shared/$writer" there
    scripts/exchange.sh compare "$tree$shared/$writer" here there
  done
  echo "$me: each of the two builds reads what the other wrote, and differs by rounding"
  exit
fi

# Fetched rather than copied: files that have not changed keep their times, so they are not compiled again.
copy=$tree$inside
[ -d "$copy/.git" ] || git init -q "$copy"
git -C "$copy" fetch -q --depth 1 "file://$PWD" HEAD
git -C "$copy" checkout -q -f --detach FETCH_HEAD
git -C "$copy" clean -q -ffd
echo "$me: Debian $(cat "$tree/etc/debian_version"), $(git log -1 --format='commit %h: %s')"

in_tree CMAKE_BUILD_PARALLEL_LEVEL="${JOBS:-$(nproc)}" bash "$inside/scripts/test.sh"

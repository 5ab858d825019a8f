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

fresh=OFF exchange=OFF tree=/var/tmp/ld_debian13
for argument in "$@"; do
  case "$argument" in
    --fresh) fresh=ON ;;
    --exchange) exchange=ON ;;
    -*) echo "test_debian13.sh: unknown option '$argument'; expected --fresh, --exchange or a folder" >&2; exit 2 ;;
    *) tree=$(realpath -m "$argument") ;;
  esac
done
case "$tree/" in
  "$PWD"/*) echo "test_debian13.sh: $tree is in the project; the tree needs a folder outside of it" >&2; exit 2 ;;
esac
if [ "$(id -u)" -ne 0 ]; then
  echo "test_debian13.sh: needs root, for debootstrap, chroot and mounts; run it with sudo" >&2
  exit 1
fi
command -v debootstrap > /dev/null ||
  { echo "test_debian13.sh: no debootstrap; run scripts/setup.sh --dev or apt-get install debootstrap" >&2; exit 1; }

# The mark is there as soon as a tree is ours: nothing else is ever deleted.
mark=$tree/.layer_denoiser_debian13
if [ -e "$tree" ] && [ ! -e "$mark" ] && [ -n "$(ls -A "$tree")" ]; then
  echo "test_debian13.sh: $tree exists and was not made by this script; name another folder" >&2
  exit 1
fi
mkdir -p "$tree"
exec 9>> "$mark"
flock -n 9 || { echo "test_debian13.sh: another run is at work in $tree" >&2; exit 1; }

# Runs a command with mounts and processes of its own, which end with it or with this script, however that ends.
alone() {
  # In the background, so that a signal is answered at once; but bash has background commands ignore Ctrl-C, which tests send.
  env --default-signal=INT,QUIT unshare --mount --pid --fork --kill-child --mount-proc "$@" 9>&- &
  child=$!
  wait "$child"
}
child=
stop() { [ -z "$child" ] || kill -KILL "$child" 2> /dev/null || true; exit "$1"; }
trap 'stop 129' HUP
trap 'stop 130' INT
trap 'stop 143' TERM

if [ $fresh = ON ] || [ "$(cat "$mark")" != installed ]; then
  find "$tree" -xdev -mindepth 1 -maxdepth 1 ! -path "$mark" -exec rm -rf --one-file-system {} +
  : > "$mark"
  SECONDS=0
  alone debootstrap --variant=minbase --include=ca-certificates trixie "$tree" "${MIRROR:-http://deb.debian.org/debian}" ||
    { echo "test_debian13.sh: debootstrap failed; its log is $tree/debootstrap/debootstrap.log" >&2; exit 1; }
  echo installed > "$mark"
  echo "test_debian13: made $tree in $SECONDS s"
fi

in_tree() {
  # shellcheck disable=SC2016
  alone bash -euc '
    mount -t proc proc "$0/proc"
    mount --rbind /dev "$0/dev"
    mount -t tmpfs tmpfs "$0/dev/shm"
    cd /
    exec chroot "$0" env -i HOME=/root PATH=/usr/sbin:/usr/bin:/sbin:/bin LC_ALL=C.UTF-8 TERM=dumb "$@"' "$tree" "$@"
}

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
  echo "test_debian13: each of the two builds reads what the other wrote, and differs by rounding"
  exit
fi

# Fetched rather than copied: files that have not changed keep their times, so they are not compiled again.
copy=$tree$inside
[ -d "$copy/.git" ] || git init -q "$copy"
git -C "$copy" fetch -q --depth 1 "file://$PWD" HEAD
git -C "$copy" checkout -q -f --detach FETCH_HEAD
git -C "$copy" clean -q -ffd
echo "test_debian13: Debian $(cat "$tree/etc/debian_version"), $(git log -1 --format='commit %h: %s')"

in_tree CMAKE_BUILD_PARALLEL_LEVEL="${JOBS:-$(nproc)}" bash "$inside/scripts/test.sh"

# Sourced by scripts that try something in a fresh Debian of its own, a folder that debootstrap fills. Set `me` to the script's name.
# Needs root and debootstrap (scripts/setup.sh --dev). Nothing stays mounted or running.
# shellcheck shell=bash

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

# make_tree FOLDER RELEASE FRESH: the tree is there after it, made anew where it is not whole or FRESH is ON. It stays locked.
make_tree() {
  tree=$1
  case "$tree/" in
    "$PWD"/*) echo "$me: $tree is in the project; the tree needs a folder outside of it" >&2; exit 2 ;;
  esac
  [ "$(id -u)" -eq 0 ] || { echo "$me: needs root, for debootstrap, chroot and mounts; run it with sudo" >&2; exit 1; }
  command -v debootstrap > /dev/null ||
    { echo "$me: no debootstrap; run scripts/setup.sh --dev or apt-get install debootstrap" >&2; exit 1; }
  # The mark is there as soon as a tree is ours: nothing else is ever deleted.
  local mark=$tree/.layer_denoiser_tree
  if [ -e "$tree" ] && [ ! -e "$mark" ] && [ -n "$(ls -A "$tree")" ]; then
    echo "$me: $tree exists and was not made by this script; name another folder" >&2
    exit 1
  fi
  mkdir -p "$tree"
  exec 9>> "$mark"
  flock -n 9 || { echo "$me: another run is at work in $tree" >&2; exit 1; }
  if [ "$3" = ON ] || [ "$(cat "$mark")" != installed ]; then
    find "$tree" -xdev -mindepth 1 -maxdepth 1 ! -path "$mark" -exec rm -rf --one-file-system {} +
    : > "$mark"
    SECONDS=0
    alone debootstrap --variant=minbase --include=ca-certificates "$2" "$tree" "${MIRROR:-http://deb.debian.org/debian}" ||
      { echo "$me: debootstrap failed; its log is $tree/debootstrap/debootstrap.log" >&2; exit 1; }
    echo installed > "$mark"
    echo "$me: made $tree in $SECONDS s"
  fi
}

in_tree() {
  # shellcheck disable=SC2016
  alone bash -euc '
    mount -t proc proc "$0/proc"
    mount --rbind /dev "$0/dev"
    mount -t tmpfs tmpfs "$0/dev/shm"
    cd /
    exec chroot "$0" env -i HOME=/root PATH=/usr/sbin:/usr/bin:/sbin:/bin LC_ALL=C.UTF-8 TERM=dumb "$@"' "$tree" "$@"
}

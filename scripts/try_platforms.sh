#!/usr/bin/env bash
# try_platforms.sh [--folder DIR] [bullseye|bookworm|trixie|aarch64]...
# Runs demo.sh and test.sh of what is committed here, from nothing, in a fresh Debian 11, 12 or 13 each, and
# test_aarch64.sh in a Debian 12; without names, all four. Prints a row for each: seconds, seconds of CPU time,
# tests. Fails when one of them failed.
# The logs stay in DIR, and the packages that were fetched, for the next time; else in .workspace/platforms. The
# systems are folders of DIR while they are tried. Needs root and debootstrap.
set -euo pipefail
# shellcheck source=scripts/workspace.sh
source "$(dirname "${BASH_SOURCE[0]}")/workspace.sh"

folder=$workspace/platforms
platforms=()
while (($# > 0)); do
  case $1 in
    --folder)
      (($# > 1)) || refuse "--folder: of what name?"
      folder=$2
      shift
      ;;
    bullseye | bookworm | trixie | aarch64) platforms+=("$1") ;;
    -h | --help)
      sed -n '2,7s/^# //p' "${BASH_SOURCE[0]}"
      exit 0
      ;;
    *) refuse "$1 is no platform; there are bullseye, bookworm, trixie and aarch64" ;;
  esac
  shift
done
if ((${#platforms[@]} == 0)); then
  platforms=(bullseye bookworm trixie aarch64)
fi
((EUID == 0)) || refuse "only root can set up a system in a folder"
command -v debootstrap >/dev/null || refuse "debootstrap is not installed"
mkdir -p "$folder"
folder=$(cd "$folder" && pwd -P)

# Where this system's packages are from, if it is a Debian; else debootstrap chooses.
mirror() {
  apt-get indextargets --format "\$(REPO_URI)" "Created-By: Packages" "Origin: Debian" "Label: Debian" 2>/dev/null |
    head -n 1
}

# alone COMMAND...: with mounts and processes of its own, none of which outlives it.
alone() { unshare --mount --pid --fork --kill-child "$@"; }

# make_system PLATFORM: a Debian with git, which holds a clone of this one. Processors of others are Debian 12's.
make_system() {
  local platform=$1 system=$folder/$1/system suite=$1 source
  mapfile -t source < <(mirror)
  if [[ $platform == aarch64 ]]; then
    suite=bookworm
  fi
  rm -rf "$system"
  mkdir -p "$folder/$platform/packages"
  alone debootstrap --variant=minbase --include=ca-certificates,git --cache-dir="$folder/$platform/packages" \
    "$suite" "$system" "${source[@]}"
  # Without which roslaunch starts nothing.
  echo "127.0.0.1 localhost" >"$system/etc/hosts"
  git clone --quiet --no-hardlinks "$clone" "$system/matchbox_slam"
  if [[ $platform == aarch64 ]]; then
    in_system aarch64 dpkg --add-architecture arm64
  fi
}

# in_system PLATFORM COMMAND... The system's folder becomes the root of its mounts: of a mere chroot, Linux makes
# no users' namespaces.
in_system() {
  local platform=$1
  shift
  # shellcheck disable=SC2016  # the inner shell's
  alone bash -c 'mount --bind "$1" "$1" && mount --bind "$2" "$1/var/cache/apt/archives" && cd "$1" && shift 2 &&
    mount -t proc proc proc && mkdir -p dev/shm && mount -t tmpfs tmpfs dev/shm && pivot_root . . && umount -l . && exec "$@"' \
    bash "$folder/$platform/system" "$folder/$platform/packages" \
    env -i HOME=/root LANG=C.UTF-8 TERM=dumb PATH=/usr/sbin:/usr/bin:/sbin:/bin \
    bash -c 'cd /matchbox_slam && exec "$@"' bash "$@"
}

# try_script PLATFORM NAME: runs scripts/NAME.sh there. Sets `seconds`, of the clock and of the processor.
try_script() {
  local log=$folder/$1-$2 TIMEFORMAT='%0R %0U %0S' state=0 user system
  say "$1: scripts/$2.sh, to $log.log" >&2
  { time in_system "$1" "scripts/$2.sh" &>"$log.log"; } 2>"$log.time" || state=1
  read -r seconds user system < <(tail -n 1 "$log.time")
  seconds+=" ($((user + system)))"
  ((state == 0)) || complain "$1: scripts/$2.sh failed; the end of $log.log: $(tail -n 3 "$log.log")"
  return "$state"
}

row() { printf '%-9s %-22s %-14s %-14s %s\n' "$@"; }

# try_platform PLATFORM: prints its row. Fails when a script did.
try_platform() {
  local compiler=- demo=- tests=- counts=- state=0 seconds script=test program=c++
  say "$1: a fresh system, to $folder/$1-system.log" >&2
  if make_system "$1" &>"$folder/$1-system.log"; then
    case $1 in
      aarch64) script=test_aarch64 program=aarch64-linux-gnu-g++ ;;
      *)
        try_script "$1" demo || state=1
        demo=$seconds
        ;;
    esac
    try_script "$1" "$script" || state=1
    tests=$seconds
    counts=$(tail -n 1 "$folder/$1-$script.log")
    compiler=$(in_system "$1" "$program" --version 2>/dev/null | head -n 1) || true
  else
    complain "$1: no system; the end of $folder/$1-system.log: $(tail -n 3 "$folder/$1-system.log")"
    state=1
  fi
  rm -rf --one-file-system "$folder/$1/system"
  row "$1" "${compiler##*) }" "$demo" "$tests" "$counts"
  return "$state"
}

trap 'rm -rf --one-file-system "$folder"/*/system' EXIT
rows=$(row platform compiler "demo [s] (CPU)" "tests (CPU)" result)
failed=0
for platform in "${platforms[@]}"; do
  new=$(try_platform "$platform") || failed=1
  rows+=$'\n'$new
done
say "$(git -C "$clone" rev-parse --short HEAD) from nothing"
echo "$rows"
exit "$failed"

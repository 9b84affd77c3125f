#!/usr/bin/env bash
# demo.sh [BAG [map_bag options]]
# Maps a bag; without one, a bag that it simulates, and then says how far the result is from the truth.
# Installs missing packages and builds what it needs first. Results go to .workspace/results/, or where --out says.
set -euo pipefail
# shellcheck source=scripts/workspace.sh
source "$(dirname "${BASH_SOURCE[0]}")/workspace.sh"

map_bag() { "$workspace/devel/lib/matchbox_slam/map_bag" "$@"; }

demo_of_simulation() {
  local out=$workspace/results/rooms
  local programs=$workspace/devel/lib/matchbox_slam
  mkdir -p "$out"
  say "Simulating a robot that drives through rooms"
  "$programs/simulate" --world rooms --seed 1 --bag "$out/rooms.bag" --truth "$out/truth.tum"
  say "Mapping $out/rooms.bag"
  map_bag "$out/rooms.bag" --out "$out"
  say "Error of the trajectory, and of the odometry"
  "$programs/evaluate" ate "$out/trajectory.tum" "$out/odometry.tum" --truth "$out/truth.tum"
  name_results "$out"
}

demo_of_bag() {
  local bag=$1
  shift
  local out="" previous="" argument
  for argument in "$@"; do
    case $argument in
      --out=*) out=${argument#--out=} ;;
      *) if [[ $previous == --out ]]; then out=$argument; fi ;;
    esac
    previous=$argument
  done
  if [[ -z $out ]]; then
    out=$workspace/results/$(basename "$bag" .bag)
    set -- --out "$out" "$@"
  fi
  say "Mapping $bag"
  map_bag "$bag" "$@"
  name_results "$out"
}

name_results() {
  say "Results are in $1"
  echo "map.png         the map, for people: trajectory, raw odometry and loops drawn over it"
  echo "map.pgm, .yaml  the map, for map_server and navigation"
  echo "map.slam        all that was learnt, to go on with: --map"
  echo "report.html     the run, to look at in a browser"
  echo "trajectory.tum, odometry.tum, report.json; doc/first_map.md tells of the others"
}

case ${1:-} in
  -h | --help)
    sed -n '2,4s/^# //p' "${BASH_SOURCE[0]}"
    exit 0
    ;;
  -*) refuse "$1: the bag comes first: demo.sh [BAG [map_bag options]]" ;;
esac
if (($# > 0)) && [[ ! -e $1 ]]; then
  refuse "$1: there is no such file or folder"
fi
prepare_workspace programs
if (($# > 0)); then
  demo_of_bag "$@"
else
  demo_of_simulation
fi

#!/usr/bin/env bash
# build.sh
# Builds everything in .workspace/, also the nodes, which demo.sh leaves out. Installs missing packages first.
# Then `source .workspace/devel/setup.bash` makes roslaunch and rosrun find the package.
set -euo pipefail
# shellcheck source=scripts/workspace.sh
source "$(dirname "${BASH_SOURCE[0]}")/workspace.sh"

case ${1:-} in
  "") ;;
  -h | --help)
    sed -n '2,4s/^# //p' "${BASH_SOURCE[0]}"
    exit 0
    ;;
  *) refuse "$1 is no argument; allowed: none, or --help" ;;
esac

prepare_workspace all

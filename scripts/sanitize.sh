#!/usr/bin/env bash
# sanitize.sh [SANITIZERS [TEST]...]
# Builds what needs no ROS with sanitizers, address,undefined unless others are named, in .workspace/sanitize-..., and runs
# the named test programs, such as test_map, or all. Fails at the first thing that they report. Installs missing packages first.
set -euo pipefail
# shellcheck source=scripts/workspace.sh
source "$(dirname "${BASH_SOURCE[0]}")/workspace.sh"

case ${1:-} in
  -h | --help)
    sed -n '2,4s/^# //p' "${BASH_SOURCE[0]}"
    exit 0
    ;;
esac
sanitizers=${1:-address,undefined}
known='(address|undefined|thread|leak|float-cast-overflow)'
[[ $sanitizers =~ ^$known(,$known)*$ ]] ||
  refuse "$sanitizers are no sanitizers; name such as address,undefined or thread"
tests=("${@:2}")
for test in "${tests[@]}"; do
  [[ $test == test_* ]] || refuse "$test is no test program; they are called test_*, see test/CMakeLists.txt"
done

install_dependencies all
folder=$workspace/sanitize-${sanitizers//,/-}
build_without_ros "$folder" "${tests[@]}" -- "-DMATCHBOX_SANITIZE=$sanitizers"
export TSAN_OPTIONS="suppressions=$clone/test/tsan.supp ${TSAN_OPTIONS:-}"
run_without_ros "$folder" "${tests[@]}"

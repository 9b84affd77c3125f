#!/usr/bin/env bash
# coverage.sh [--floor PERCENT] [TEST]...
# Builds what needs no ROS in .workspace/coverage and runs the named test programs, such as test_map, or all. Prints
# the share of the lines of src/ and include/ that they ran; fails when it is below PERCENT: 80 of all tests, 0 of
# named ones. What is built with ROS alone (nodes, bags, tf) is not counted. Installs missing packages first.
set -euo pipefail
# shellcheck source=scripts/workspace.sh
source "$(dirname "${BASH_SOURCE[0]}")/workspace.sh"

floor=""
tests=()
while (($# > 0)); do
  case $1 in
    --floor)
      [[ ${2:-} =~ ^[0-9]+$ ]] || refuse "--floor takes a percentage, such as 80"
      floor=$2
      shift
      ;;
    -h | --help)
      sed -n '2,5s/^# //p' "${BASH_SOURCE[0]}"
      exit 0
      ;;
    test_*) tests+=("$1") ;;
    *) refuse "$1 is no test program; they are called test_*, see test/CMakeLists.txt" ;;
  esac
  shift
done
if [[ -z $floor ]]; then
  floor=$((${#tests[@]} == 0 ? 80 : 0))  # 80 is a guess; raise it to just below what is measured
fi

install_dependencies all
install_missing gcovr
folder=$workspace/coverage
build_without_ros "$folder" "${tests[@]}" -- -DCMAKE_BUILD_TYPE=Coverage \
  "-DCMAKE_CXX_FLAGS_COVERAGE=-O1 -g --coverage -fprofile-update=atomic"
find "$folder" -name '*.gcda' -delete
run_without_ros "$folder" "${tests[@]}"
say "Lines that were run"
gcovr --root "$clone" --filter "$clone/src/" --filter "$clone/include/" --fail-under-line "$floor" \
  --sort-uncovered "$folder" || fail "less than $floor % of the lines were run, or gcovr failed: see above"

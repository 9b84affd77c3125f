#!/usr/bin/env bash
# test.sh [--style]
# Builds the package and runs every test of it and of the example matcher. Installs missing packages
# first. The last line says how many tests passed and failed; fails when one failed or none ran.
# With --style, check_style.sh is one of them.
# Tests on real recordings look for them in $MATCHBOX_DATA, else in ../shared/data beside the clone.
set -euo pipefail
# shellcheck source=scripts/workspace.sh
source "$(dirname "${BASH_SOURCE[0]}")/workspace.sh"

style=false
case ${1:-} in
  "") ;;
  --style)
    style=true
    shift
    ;;
  -h | --help)
    sed -n '2,6s/^# //p' "${BASH_SOURCE[0]}"
    exit 0
    ;;
esac
if (($# > 0)); then
  refuse "unknown option $1; to run some tests, see CONTRIBUTING.md"
fi

results=$workspace/build/test_results
rm -rf "$results"
prepare_workspace all
if $style; then
  outcome=""
  "$clone/scripts/check_style.sh" || outcome='<failure message="see the output above"/>'
  mkdir -p "$results"
  echo "<testcase classname='scripts' name='check_style'>$outcome</testcase>" >"$results/style.xml"
fi
if [[ -z ${MATCHBOX_DATA:-} && -d $clone/../shared/data ]]; then
  MATCHBOX_DATA=$(cd "$clone/../shared/data" && pwd)
  export MATCHBOX_DATA
fi
say "Building the tests"
build -DCATKIN_ENABLE_TESTING=ON tests
say "Running the tests"
# run_tests succeeds also when tests fail: the results tell. Python tests and nodes run one at a time:
# a crowd of them would wait for one another.
catkin_make --directory "$workspace" -j"$(job_count)" run_tests_matchbox_slam_gtest </dev/null
catkin_make --directory "$workspace" -j1 run_tests_matchbox_slam_python \
  run_tests_matchbox_slam_rostest run_tests_example_matcher </dev/null
/usr/bin/python3 "$clone/scripts/count_tests.py" "$results"

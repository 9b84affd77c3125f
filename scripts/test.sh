#!/usr/bin/env bash
# test.sh
# Builds the package and runs every test of it and of the example matcher. Installs missing packages
# first. The last line says how many tests passed and failed; fails when one failed or none ran.
# Tests on real recordings look for them in $MATCHBOX_DATA, else in ../shared/data beside the clone.
set -euo pipefail
# shellcheck source=scripts/workspace.sh
source "$(dirname "${BASH_SOURCE[0]}")/workspace.sh"

case ${1:-} in
  "") ;;
  -h | --help)
    sed -n '2,5s/^# //p' "${BASH_SOURCE[0]}"
    exit 0
    ;;
  *) fail "takes no arguments; to run some tests, see CONTRIBUTING.md" ;;
esac

prepare_workspace
if [[ -z ${MATCHBOX_DATA:-} && -d $clone/../shared/data ]]; then
  MATCHBOX_DATA=$(cd "$clone/../shared/data" && pwd)
  export MATCHBOX_DATA
fi
say "Building the tests"
build tests
say "Running the tests"
results=$workspace/build/test_results
rm -rf "$results"
# run_tests succeeds also when tests fail: the results tell. One at a time, since some measure time.
catkin_make --directory "$workspace" -j1 run_tests </dev/null
/usr/bin/python3 "$clone/scripts/count_tests.py" "$results"

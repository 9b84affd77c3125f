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

if [[ -z ${MATCHBOX_DATA:-} && -d $clone/../shared/data ]]; then
  MATCHBOX_DATA=$(cd "$clone/../shared/data" && pwd)
  export MATCHBOX_DATA
fi

results=$workspace/build/test_results
# run_tests PRIORITY OPTION...: those of the built tests that CTest's options choose. Fails only when they could not
# be run: of what failed their results tell.
run_tests() {
  local state=0
  (cd "$workspace/build" && nice -n "$1" ctest --no-tests=error --timeout 3600 --output-on-failure "${@:2}") </dev/null ||
    state=$?
  ((state == 0 || state == 8))
}

# What waits for nobody lets the nodes go first, which run beside it.
low=10

rm -rf "$results"
prepare_workspace all programs_of_node_tests
if $style; then
  outcome=""
  "$clone/scripts/check_style.sh" || outcome='<failure message="see the output above"/>'
  mkdir -p "$results"
  echo "<testcase classname='scripts' name='check_style'>$outcome</testcase>" >"$results/style.xml"
fi
# Nodes run one at a time, as a crowd of them would wait for one another; and beside all that follows, as each
# mostly waits.
nodes_log=$workspace/build/node_tests.log
set -m  # in a group of its own, which ends when this script does; rostest ends its nodes
run_tests 0 -R _rostest_ &>"$nodes_log" &
nodes=$!
set +m
trap 'kill -- -"$nodes" 2>/dev/null || true; wait "$nodes" || true' EXIT
say "Building the other tests"
nice -n "$low" ninja -C "$workspace/build" -j"$(job_count)" tests </dev/null
say "Running the tests"
run_tests "$low" -E _rostest_ -j"$(job_count)"
ran=0
wait "$nodes" || ran=$?
trap - EXIT
cat "$nodes_log"
((ran == 0)) || fail "the tests of nodes could not be run: see above"
/usr/bin/python3 "$clone/scripts/count_tests.py" "$results"

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
# run_tests PRIORITY OPTION...: those of the built tests that CTest's options choose. Fails when one of them did.
run_tests() {
  (cd "$workspace/build" && nice -n "$1" ctest --no-tests=error --timeout 3600 --output-on-failure "${@:2}") </dev/null
}

# What waits for nobody lets the nodes go first, which run beside it.
low_priority=10

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
run_tests 0 -j1 -R _rostest_ &>"$nodes_log" &
nodes=$!
set +m
trap 'kill -- -"$nodes" 2>/dev/null || true; wait "$nodes" || true' EXIT
say "Building the other tests"
nice -n "$low_priority" ninja -C "$workspace/build" -j"$(job_count)" tests </dev/null
say "Running the tests"
failed=0
run_tests "$low_priority" -E _rostest_ -j"$(job_count)" || failed=1
wait "$nodes" || failed=1
trap - EXIT
cat "$nodes_log"
# Of a test that could not be run, or took too long, there is no result that says so.
if ((failed)) && ! grep -Eqrs '<(failure|error)\b' "$results"; then
  mkdir -p "$results"
  echo "<testcase classname='scripts' name='ctest'><failure message='tests left no result: see above'/></testcase>" >"$results/ctest.xml"
fi
/usr/bin/python3 "$clone/scripts/count_tests.py" "$results"

#!/usr/bin/env bash
# check_style.sh [--tidy [FILE.cpp]...]
# Checks formatting (clang-format), the package (catkin_lint), the scripts (shellcheck) and that each test is built. With --tidy
# also runs clang-tidy, over the given sources or all; this takes minutes and needs a built workspace.
# Installs missing tools first, clang-tidy apart.
set -euo pipefail
# shellcheck source=scripts/workspace.sh
source "$(dirname "${BASH_SOURCE[0]}")/workspace.sh"

tidy=false
case ${1:-} in
  "") ;;
  --tidy)
    tidy=true
    shift
    ;;
  -h | --help)
    sed -n '2,5s/^# //p' "${BASH_SOURCE[0]}"
    exit 0
    ;;
  *) refuse "unknown option $1; see --help" ;;
esac

use_system_ros
install_missing catkin-lint clang-format python3-rosdep2 shellcheck
failed=()

# check NAME COMMAND...: runs it, and goes on when it fails.
check() {
  local name=$1
  shift
  say "$name"
  if ! command -v "$1" >/dev/null; then
    failed+=("$name ($1 is not installed)")
  elif ! "$@"; then
    failed+=("$name")
  fi
}

sources() {
  find "$clone"/{benchmark,doc,include,src,test} -name '*.[ch]pp' "$@" | sort
}

# catkin_lint asks rosdep, here of local files only, so that it needs no network.
with_local_rosdep() {
  env -u ROS_DISTRO \
    ROSDEP_SOURCE_PATH="$workspace/rosdep/sources.list.d" \
    ROSDISTRO_INDEX_URL="file://$workspace/rosdep/index.yaml" \
    /usr/bin/python3 "$@"
}

prepare_rosdep() {
  local sources=$workspace/rosdep/sources.list.d output
  mkdir -p "$sources"
  printf '%%YAML 1.1\n---\ndistributions: {}\ntype: index\nversion: 4\n' \
    >"$workspace/rosdep/index.yaml"
  echo "yaml file://$clone/scripts/rosdep.yaml" >"$sources/10-package-xml.list"
  output=$(with_local_rosdep /usr/bin/rosdep update 2>&1) || fail "rosdep update: $output"
}

lint_package() {
  prepare_rosdep
  link_packages  # since catkin_lint insists on folders of the packages' names
  with_local_rosdep /usr/bin/catkin_lint -W2 --strict \
    --rosdistro "${ROS_DISTRO:-Debian}" "$workspace/src/matchbox_slam" "$workspace/src/example_matcher"
}

tidy_files() {
  local database=$workspace/build/compile_commands.json
  if [[ ! -f $database ]]; then
    fail "clang-tidy needs $database; run scripts/build.sh first"
  fi
  # Headers that GCC has precompiled clang cannot read; and sources that are built as one it is to read one by one.
  mkdir -p "$workspace/tidy"
  /usr/bin/python3 - "$database" >"$workspace/tidy/compile_commands.json" <<'END'
import json, pathlib, re, sys

commands = []
for entry in json.loads(pathlib.Path(sys.argv[1]).read_text()):
    entry['command'] = re.sub(r' -Winvalid-pch| -include \S*cmake_pch\.hxx', '', entry['command'])
    sources = [entry['file']]
    if '/Unity/' in entry['file']:
        sources = re.findall('#include "(.*)"', pathlib.Path(entry['file']).read_text())
    for source in sources:
        commands.append({**entry, 'file': source, 'command': entry['command'].replace(entry['file'], source)})
json.dump(commands, sys.stdout)
END
  # The database knows the sources by their place in the workspace.
  realpath -z --relative-to="$clone" "$@" |
    sed -z "s|^|$workspace/src/matchbox_slam/|" |
    xargs -0 --max-procs="$(nproc)" --max-args=1 \
      clang-tidy -p "$workspace/tidy" --quiet --extra-arg=-std=c++17  # which is GCC's default
}

# A test that no list names is never run.
all_tests_are_built() {
  local file name unbuilt=()
  while read -r file; do
    name=$(basename "$file" .cpp)
    grep -Eqw "$name|${name#test_}" "$clone/test/CMakeLists.txt" || unbuilt+=("$file")
  done < <(find "$clone/test" -name 'test_*.cpp' | sort)
  ((${#unbuilt[@]} == 0)) || { printf 'not in test/CMakeLists.txt: %s\n' "${unbuilt[@]}" && false; }
}

mapfile -t files < <(sources)
check "all tests are built" all_tests_are_built
check "clang-format" clang-format --dry-run -Werror "${files[@]}"
check "catkin_lint" lint_package
check "shellcheck" shellcheck --external-sources --source-path="$clone" \
  "$clone"/scripts/*.sh "$clone/scripts/simulate_then_play" "$clone/benchmark/reproduce/one_node_slurm.sh" \
  "$clone/benchmark/reproduce/profiles/slurm/status.sh" "$clone/.ci/run"
if $tidy; then
  if (($# == 0)); then
    mapfile -t files < <(sources -name '*.cpp')
    set -- "${files[@]}"
  fi
  check "clang-tidy" tidy_files "$@"
fi

echo
if ((${#failed[@]} > 0)); then
  printf 'failed: %s\n' "${failed[@]}"
  exit 1
fi
echo "all checks passed"

# shellcheck shell=bash
# Sourced by the other scripts: installs what package.xml names, and builds the package in a workspace
# of its own in .workspace/. Needs Debian 11 to 13, or Ubuntu 20.04 with the package sources of ROS Noetic.

clone=$(cd "$(dirname "${BASH_SOURCE[0]}")/.." && pwd -P)
workspace=$clone/.workspace

say() { printf '\n== %s\n' "$*"; }

complain() { printf '%s: %s\n' "$(basename "$0")" "$*" >&2; }

# The work failed.
fail() {
  complain "$@"
  exit 1
}

# It was asked for what there is not.
refuse() {
  complain "$@"
  exit 2
}

# setup.bash of ROS and catkin reads variables that may be unset, and the arguments of who sources it.
source_setup() {
  local setup=$1
  [[ -f $setup ]] || return 0
  shift
  set +u
  # shellcheck source=/dev/null
  source "$setup"
  set -u
}

# The system's ROS and the system's Python, whatever else the user's shell has set up.
use_system_ros() {
  unset CMAKE_PREFIX_PATH ROS_PACKAGE_PATH ROS_HOSTNAME PYTHONPATH PYTHONHOME
  # Before a python3 of pyenv or conda, which has no catkin_pkg.
  export PATH=/usr/bin:/bin:/usr/sbin:/sbin:$PATH
  export ROS_HOME=$workspace/ros_home
  export ROS_IP=127.0.0.1
  source_setup /opt/ros/noetic/setup.bash
}

# Such as "debian-12".
operating_system() {
  # shellcheck source=/dev/null
  (source /etc/os-release && echo "$ID-${VERSION_ID:-}")
}

as_root() {
  if ((EUID == 0)); then
    "$@"
  elif command -v sudo >/dev/null; then
    sudo "$@"
  else
    fail "has to install packages, but is neither root nor has sudo. Run as root: $*"
  fi
}

# Those of the named packages that are not installed.
not_installed() {
  local package
  for package in "$@"; do
    # shellcheck disable=SC2016  # the format is dpkg-query's
    [[ $(dpkg-query --show --showformat='${db:Status-Abbrev}' "$package" 2>/dev/null) == ii* ]] ||
      echo "$package"
  done
}

install_missing() {
  local missing
  mapfile -t missing < <(not_installed "$@")
  if ((${#missing[@]} == 0)); then
    return
  fi
  say "Installing ${missing[*]}"
  as_root apt-get update -qq || echo "apt-get update failed; trying with the lists there are" >&2
  as_root env DEBIAN_FRONTEND=noninteractive \
    apt-get install -y -qq --no-install-recommends -o Dpkg::Use-Pty=0 "${missing[@]}" >/dev/null ||
    fail "apt-get could not install the packages above (on Ubuntu: is the source of ROS Noetic's \
packages configured?)"
}

# list_dependencies programs|all: one a line; none where the system is unknown. Installs what it takes to tell.
list_dependencies() {
  local kind=$1 system list reader=(python3-catkin-pkg python3-yaml)
  if [[ $kind == programs ]]; then
    local -x MATCHBOX_WITH_RVIZ=OFF MATCHBOX_WITH_OPENCV=OFF
  fi
  system=$(operating_system)
  case $system in
    debian-11 | debian-12 | debian-13 | ubuntu-20.04) ;;
    *)
      echo "$(basename "$0"): $system is neither Debian 11, 12 or 13 nor Ubuntu 20.04; building with" \
        "the packages that are there" >&2
      return
      ;;
  esac
  list=$workspace/packages-$kind
  if [[ ! -s $list || -n $(find "$clone/package.xml" "$clone/doc/example_matcher/package.xml" \
    "$clone"/scripts/{list_packages.py,rosdep.yaml,workspace.sh} -newer "$list") ]]; then
    install_missing "${reader[@]}" >&2
    mkdir -p "$workspace"
    # Besides what reads package.xml, what that does not name by custom: a compiler and what calls it.
    {
      printf '%s\n' "${reader[@]}" build-essential cmake ninja-build
      /usr/bin/python3 "$clone/scripts/list_packages.py" "$system" "$kind" \
        "$clone/package.xml" "$clone/doc/example_matcher/package.xml"
    } >"$list.new" || return  # in a substitution bash goes on by itself
    mv "$list.new" "$list"
  fi
  cat "$list"
}

# install_dependencies programs|all
install_dependencies() {
  local packages
  packages=$(list_dependencies "$1")
  # shellcheck disable=SC2086  # one word each
  install_missing $packages
}

# Compilers need about 1 GB each.
job_count() {
  local processors gigabytes
  processors=$(nproc)
  gigabytes=$(awk '/MemAvailable/ {print int($2 / 1048576)}' /proc/meminfo)
  if ((gigabytes < processors)); then
    processors=$((gigabytes > 0 ? gigabytes : 1))
  fi
  echo "$processors"
}

# The packages as folders of the workspace. The package's own is made of links to what is in the clone: a
# single link to the clone would contain itself, over which find -L, and so rosrun, stumbles.
link_packages() {
  local package=$workspace/src/matchbox_slam entry
  rm -rf "$package"
  mkdir -p "$package"
  for entry in "$clone"/*; do
    if [[ ${entry##*/} != build* ]]; then
      ln -s "$entry" "$package"
    fi
  done
  ln -sfn "$clone/doc/example_matcher" "$workspace/src/example_matcher"
}

has_tests() { grep -qs '^CATKIN_ENABLE_TESTING:BOOL=ON$' "$workspace/build/CMakeCache.txt"; }

# build [-DOPTION]... TARGET...
build() {
  local options=()
  while [[ $1 == -D* ]]; do
    options+=("$1")
    shift
  done
  if [[ $clone =~ [[:space:]] ]]; then
    fail "catkin cannot build below a folder with a space in its name: $clone"
  fi
  link_packages
  local program
  for program in catkin_make ninja; do
    command -v "$program" >/dev/null || fail "$program is not installed"
  done
  # What was configured for make ninja cannot go on with.
  local cache=$workspace/build/CMakeCache.txt
  if [[ -f $cache ]] && ! grep -q '^CMAKE_GENERATOR:INTERNAL=Ninja$' "$cache"; then
    rm -r "$workspace/build"
  fi
  # By ninja, as make compiles nothing of a library before all that it is linked with is there.
  catkin_make --use-ninja --directory "$workspace" -j"$(job_count)" -DCMAKE_BUILD_TYPE=Release \
    -DCMAKE_EXPORT_COMPILE_COMMANDS=ON -DPYTHON_EXECUTABLE=/usr/bin/python3 "${options[@]}" \
    --make-args "$@"
}

# The programs that map and evaluate simulated and recorded bags: no nodes, no tests. Where tests were configured they
# stay so.
build_programs() {
  build "-DCATKIN_ENABLE_TESTING=$(has_tests && echo ON || echo OFF)" evaluate map_bag matchbox_slam_plugins simulate
}

# Installs what nodes and tests need, where it is missing, while the programs are built.
install_while_building() {
  local packages missing installing state=0
  packages=$(list_dependencies all)
  # shellcheck disable=SC2086  # one word each
  missing=$(not_installed $packages)
  [[ -n $missing ]] || return 0
  say "Building the programs in $workspace, while more packages are installed"
  # Configured before, as half of a package would mislead it.
  build -DCATKIN_ENABLE_TESTING=OFF build.ninja
  as_root true  # asks for a password while nobody else writes
  # shellcheck disable=SC2086  # one word each
  install_missing $missing &
  installing=$!
  build_programs || state=$?
  wait "$installing" || fail "packages could not be installed: see above"
  return "$state"
}

# prepare_workspace programs|all [TARGET]...: installs what it takes, builds and sources the workspace. More targets
# are built with `all`.
prepare_workspace() {
  local kind=$1
  shift
  use_system_ros
  install_dependencies programs
  use_system_ros  # ROS may be there only now
  if [[ $kind == all ]]; then
    install_while_building
  fi
  say "Building in $workspace"
  case $kind in
    programs) build_programs ;;
    all) build -DCATKIN_ENABLE_TESTING=ON all "$@" ;;
  esac
  source_setup "$workspace/devel/setup.bash"
}

# build_without_ros FOLDER [TARGET]... -- [-DOPTION]...: the core, its programs and tests, by plain CMake.
build_without_ros() {
  local folder=$1 targets=()
  shift
  while [[ $1 != -- ]]; do
    targets+=("$1")
    shift
  done
  shift
  say "Building in $folder"
  mkdir -p "$folder"
  cmake -S "$clone" -B "$folder" -DMATCHBOX_WITH_ROS=OFF "$@" &>"$folder.log" ||
    fail "CMake could not configure; the end of $folder.log: $(tail -n 12 "$folder.log")"
  cmake --build "$folder" -j"$(job_count)" ${targets[@]:+--target "${targets[@]}"}
}

# run_without_ros FOLDER [TEST]...: these, or all.
run_without_ros() {
  local folder=$1 names
  shift
  names=$(IFS='|' && echo "$*")
  say "Running the tests"
  # Sanitized or emulated on a busy machine some take longer than the 25 minutes that CTest allows.
  (cd "$folder" && ctest -j"$(job_count)" --timeout 14400 --output-on-failure ${names:+-R "^($names)\$"})
}

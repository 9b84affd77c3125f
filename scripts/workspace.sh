# shellcheck shell=bash
# Sourced by the other scripts: installs what package.xml names, and builds the package in a workspace
# of its own in .workspace/. Needs Debian 12, or Ubuntu 20.04 with the package sources of ROS Noetic.

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

# Runs a command that reads rosdep's lists: local files only, so that it needs no network.
with_local_rosdep() {
  env -u ROS_DISTRO \
    ROSDEP_SOURCE_PATH="$workspace/rosdep/sources.list.d" \
    ROSDISTRO_INDEX_URL="file://$workspace/rosdep/index.yaml" \
    "$@"
}

local_rosdep() { with_local_rosdep /usr/bin/python3 /usr/bin/rosdep "$@"; }

prepare_rosdep() {
  local sources=$workspace/rosdep/sources.list.d
  mkdir -p "$sources"
  printf '%%YAML 1.1\n---\ndistributions: {}\ntype: index\nversion: 4\n' \
    >"$workspace/rosdep/index.yaml"
  echo "yaml file://$clone/scripts/rosdep.yaml" >"$sources/10-system-libraries.list"
  if [[ -f /usr/share/python3-rosdep2/debian.yaml ]]; then
    echo "yaml file:///usr/share/python3-rosdep2/debian.yaml debian" >"$sources/20-debian.list"
  fi
  local output
  output=$(local_rosdep update 2>&1) || fail "rosdep update: $output"
}

# resolve_packages SYSTEM [rosdep's options]: the packages of the keys in the package.xml files. A key
# that rosdep does not know is a ROS package, and those are named by one rule on Ubuntu.
resolve_packages() {
  local system=$1 folders=("$clone" "$clone/doc/example_matcher") keys unknown key
  shift
  mapfile -t keys < <(local_rosdep keys "$@" --from-paths "${folders[@]}" | grep -v '^matchbox_slam$')
  if ((${#keys[@]} == 0)); then
    fail "rosdep found no dependencies in package.xml"
  fi
  # Lines that start with # repeat the key and name the installer.
  local_rosdep resolve "${keys[@]}" 2>"$workspace/rosdep/errors" | grep -v '^#' | tr ' ' '\n' || true
  mapfile -t unknown < <(sed -n "s/^ERROR: no rosdep rule for '\(.*\)'.*/\1/p" \
    "$workspace/rosdep/errors")
  for key in "${unknown[@]}"; do
    if [[ $system != ubuntu-* ]]; then
      fail "package.xml: rosdep knows no package for '$key' on $system"
    fi
    echo "ros-noetic-${key//_/-}"
  done
}

# install_dependencies programs|all
install_dependencies() {
  local kind=$1 system rosdep list types=()
  if [[ $kind == programs ]]; then
    types=(-t buildtool -t build)
    local -x MATCHBOX_WITH_RVIZ=OFF
  fi
  system=$(operating_system)
  case $system in
    debian-12) rosdep=python3-rosdep2 ;;
    ubuntu-20.04) rosdep=python3-rosdep ;;
    *)
      echo "$(basename "$0"): $system is neither Debian 12 nor Ubuntu 20.04; building with the" \
        "packages that are there" >&2
      return
      ;;
  esac
  list=$workspace/packages-$kind
  if [[ ! -s $list || -n $(find "$clone/package.xml" "$clone/doc/example_matcher/package.xml" \
    "$clone/scripts/rosdep.yaml" "$clone/scripts/workspace.sh" -newer "$list") ]]; then
    # Besides rosdep, what package.xml does not name by custom: a compiler and make.
    install_missing "$rosdep" build-essential cmake
    mkdir -p "$workspace"
    prepare_rosdep
    local resolved
    resolved=$(resolve_packages "$system" "${types[@]}")
    { printf '%s\n' "$rosdep" build-essential cmake && sort -u <<<"$resolved"; } >"$list.new"
    mv "$list.new" "$list"
  fi
  local packages
  mapfile -t packages <"$list"
  install_missing "${packages[@]}"
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
  command -v catkin_make >/dev/null || fail "catkin_make is not installed"
  catkin_make --directory "$workspace" -j"$(job_count)" -DCMAKE_BUILD_TYPE=Release \
    -DCMAKE_EXPORT_COMPILE_COMMANDS=ON -DPYTHON_EXECUTABLE=/usr/bin/python3 "${options[@]}" \
    --make-args "$@"
}

# prepare_workspace programs|all: installs what it takes, builds and sources the workspace. `programs` are
# those that map and evaluate simulated and recorded bags: no nodes, no tests.
prepare_workspace() {
  use_system_ros
  install_dependencies "$1"
  use_system_ros  # ROS may be there only now
  say "Building in $workspace"
  case $1 in
    programs)
      build -DCATKIN_ENABLE_TESTING=OFF evaluate map_bag matchbox_slam_plugins simulate
      ;;
    all) build -DCATKIN_ENABLE_TESTING=ON all ;;
  esac
  source_setup "$workspace/devel/setup.bash"
}

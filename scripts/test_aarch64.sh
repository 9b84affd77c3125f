#!/usr/bin/env bash
# test_aarch64.sh [TEST]...
# Builds what needs no ROS for aarch64, with Debian's cross compiler and libraries, in .workspace/aarch64, and runs the
# named test programs, such as test_map, or all, under QEMU. The last line says how many tests passed and failed.
# Needs Debian 12 that knows the architecture arm64, and Linux 6.7; installs missing packages first.
set -euo pipefail
# shellcheck source=scripts/workspace.sh
source "$(dirname "${BASH_SOURCE[0]}")/workspace.sh"

case ${1:-} in
  -h | --help)
    sed -n '2,5s/^# //p' "${BASH_SOURCE[0]}"
    exit 0
    ;;
esac
for test in "$@"; do
  [[ $test == test_* ]] || refuse "$test is no test program; they are called test_*, see test/CMakeLists.txt"
done
[[ $'\n'$(dpkg --print-foreign-architectures)$'\n' == *$'\narm64\n'* ]] ||
  refuse "this system knows no arm64; type: dpkg --add-architecture arm64 && apt-get update"

install_missing crossbuild-essential-arm64 cmake libeigen3-dev nlohmann-json3-dev qemu-user-static \
  lib{cairo2,ceres,fmt,gtest,opencv-imgproc,png,yaml-cpp}-dev:arm64 zlib1g-dev:arm64
folder=$workspace/aarch64
build_without_ros "$folder" "$@" -- -DCMAKE_BUILD_TYPE=Release -DCMAKE_SYSTEM_NAME=Linux \
  -DCMAKE_SYSTEM_PROCESSOR=aarch64 -DCMAKE_CXX_COMPILER=aarch64-linux-gnu-g++

# emulated COMMAND...: where it and the programs that it runs may be aarch64's. QEMU is registered for it alone, which
# leaves the rest of the system as it is.
emulated() {
  local header='\x7fELF\x02\x01\x01\x00\x00\x00\x00\x00\x00\x00\x00\x00\x02\x00\xb7\x00'
  local mask='\xff\xff\xff\xff\xff\xff\xff\x00\xff\xff\xff\xff\xff\xff\xff\xff\xfe\xff\xff\xff'
  # shellcheck disable=SC2016  # the inner shell's
  unshare --user --map-root-user --mount bash -c 'set -e
    mount -t binfmt_misc none /proc/sys/fs/binfmt_misc
    echo "$1" >/proc/sys/fs/binfmt_misc/register
    shift
    exec "$@"' bash ":qemu-aarch64:M:0:$header:$mask:/usr/bin/qemu-aarch64-static:F" "$@"
}

export -n MATCHBOX_DATA
results=$folder/test_results
rm -rf "$results"
export GTEST_OUTPUT=xml:$results/
ran=0
emulated bash -c "source '$clone/scripts/workspace.sh'; run_without_ros \"\$@\"" bash "$folder" "$@" || ran=$?
/usr/bin/python3 "$clone/scripts/count_tests.py" "$results"
((ran == 0)) || fail "ctest returned $ran"

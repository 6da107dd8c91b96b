#!/usr/bin/env bash
# Compiles the library and its tests for another machine, into build/MACHINE:
#
#   workflow/build_for.sh aarch64      # or windows: a toolchain file of cmake/toolchains/
#
# Highway is compiled first, into build/highway-MACHINE: Debian has no package of it for Windows, and one for ARM only where apt was told of
# that architecture. The sources are those of this system's own package, in its version and with its patches: apt gets them from where it gets
# packages, and checks who signed them. Exits with 77 and one line that says why where the compiler or these sources cannot be had.
set -euo pipefail
cd "$(dirname "$0")/.."
source workflow/setup.sh
machine=${1-}
case $machine in
  aarch64) packages=g++-aarch64-linux-gnu compiler=aarch64-linux-gnu-g++ ;;
  windows) packages=g++-mingw-w64-x86-64-posix compiler=x86_64-w64-mingw32-g++-posix ;;
  *) echo "build_for.sh ${machine:-without a machine}: expected aarch64 or windows" >&2; exit 2 ;;
esac
lacks() { echo "Not built for $machine: $*" >&2; exit 77; }
command -v "$compiler" > /dev/null || lacks "no $compiler (package $packages)"

work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
quietly() { "$@" > "$work/log" 2>&1 || { cat "$work/log" >&2; exit 1; }; }
# apt with lists of its own, which name sources instead of packages, in whichever of its two notations the system's are
apt_of_sources() {
  apt-get -q -o Dir::Etc::SourceList=/dev/null -o Dir::Etc::SourceParts="$work/parts" -o Dir::State::Lists="$work/lists" -o Dir::Cache="$work/cache" "$@" > "$work/log" 2>&1 ||
    lacks "Highway's sources: $(tail -1 "$work/log")"
}
install_highway() {
  local prefix=$PWD/build/highway-$machine version list
  version=$(dpkg-query -W -f '${source:Version}' libhwy-dev 2> /dev/null) || lacks "no libhwy-dev here, whose version Highway would have"
  [ "$(cat "$prefix/version" 2> /dev/null)" != "$version" ] || return 0
  mkdir -p "$work/parts" "$work/lists/partial" "$work/cache/archives/partial"
  chmod 755 "$work"  # apt fetches as a user of its own
  for list in /etc/apt/sources.list.d/*.sources; do
    [ ! -f "$list" ] || sed 's/^Types:.*/Types: deb-src/' "$list" > "$work/parts/${list##*/}"
  done
  for list in /etc/apt/sources.list /etc/apt/sources.list.d/*.list; do
    [ ! -f "$list" ] || sed -n 's/^deb /deb-src /p' "$list" > "$work/parts/${list##*/}.list"
  done
  apt_of_sources update
  (cd "$work" && apt_of_sources source "highway=$version") || exit $?
  quietly cmake -S "$work"/highway-*/ -B "$work/build" -G Ninja --toolchain "$PWD/cmake/toolchains/$machine.cmake" -DCMAKE_BUILD_TYPE=Release \
    -DBUILD_TESTING=OFF -DHWY_ENABLE_CONTRIB=OFF -DHWY_ENABLE_EXAMPLES=OFF
  quietly cmake --build "$work/build"
  rm -rf "$prefix"
  quietly cmake --install "$work/build" --prefix "$prefix"
  echo "$version" > "$prefix/version"
}
require_writable
(
  lock_build
  install_highway
  quietly cmake --preset "$machine"
  cmake --build --preset "$machine" --parallel "$(build_jobs)"
) 8> build/.lock

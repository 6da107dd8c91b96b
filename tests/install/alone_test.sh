#!/usr/bin/env bash
# The library configures where nothing but a compiler and Highway is installed: every other package that cmake/dependencies.cmake
# looks for is made unfindable.
#
#   alone_test.sh CMAKE GENERATOR CXX
set -euo pipefail
cmake=$1 generator=$2 cxx=$3
cd "$(dirname "$0")/../.."
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
mapfile -t packages < <(sed -n 's/^ *find_package(\([A-Za-z0-9_-]*\).*/\1/p' cmake/dependencies.cmake | sort -u)
[ "${#packages[@]}" -gt 5 ] || { echo "alone_test: no packages found in cmake/dependencies.cmake" >&2; exit 1; }
configure() {
  "$cmake" --no-warn-unused-cli -S . -B "$work/$1" -G "$generator" -DCMAKE_CXX_COMPILER="$cxx" "${packages[@]/#/-DCMAKE_DISABLE_FIND_PACKAGE_}" "${@:2}"
}
packages=("${packages[@]/%/=ON}")
configure library -DNLG_BUILD_TOOLS=OFF -DNLG_BUILD_TESTS=OFF -DNLG_BUILD_BENCHMARKS=OFF
# the same without the switches must fail, or nothing was made unfindable
if configure tools > "$work/tools.log" 2>&1; then echo "alone_test: the tools configure without their packages" >&2; exit 1; fi

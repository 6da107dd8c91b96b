#!/usr/bin/env bash
# The library configures where nothing but a compiler and Highway is installed, and a bake without what training and tests need: packages
# that cmake/dependencies.cmake looks for are made unfindable.
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
configure library -DNLG_BUILD_TOOLS=OFF -DNLG_BUILD_TESTS=OFF
# the same without the switches must fail, or nothing was made unfindable
if configure tools > "$work/tools.log" 2>&1; then echo "alone_test: the tools configure without their packages" >&2; exit 1; fi
# a bake and the viewer, where what only training and tests need is not there
mapfile -t packages < <(sed -n '/if(NLG_BUILD_TRAINING)/,/endif()/p; /find_package(GTest/p' cmake/dependencies.cmake |
  sed -n 's/^ *find_package(\([A-Za-z0-9_-]*\).*/\1=ON/p')
[[ " ${packages[*]} " == *" Torch=ON "* ]] || { echo "alone_test: libtorch is not among what training needs" >&2; exit 1; }
configure bake -DNLG_BUILD_TRAINING=OFF -DNLG_BUILD_TESTS=OFF
"$cmake" --build "$work/bake" --target help > "$work/targets"
for tool in bake view render datagen; do grep -q "nlg-$tool\b" "$work/targets" || { echo "alone_test: no nlg-$tool without training" >&2; exit 1; }; done

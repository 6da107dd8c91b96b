#!/usr/bin/env bash
# The installed package, as an engine meets it: in another place than it was installed to, with the examples built against it.
#
#   install_test.sh BUILD_FOLDER MAKE_WEIGHTS CMAKE GENERATOR CONFIGURATION CC CXX CXX_FLAGS
set -euo pipefail
build=$1 make_weights=$2 cmake=$3 generator=$4 configuration=$5 cc=$6 cxx=$7 cxx_flags=${8-}
source=$(cd "$(dirname "$0")/../.." && pwd)
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
fail() { echo "install_test: $*" >&2; exit 1; }

"$cmake" --install "$build" --prefix "$work/first" > "$work/install.log" || { cat "$work/install.log"; exit 1; }
mv "$work/first" "$work/moved"
prefix=$work/moved
headers=$prefix/include

# no path of this machine in what CMake will read
if grep -rn -e "$source" -e "$build" -e "$work" "$prefix" --include='*.cmake'; then fail "paths of the build are installed"; fi

# every header by itself, with nothing but the package to include from
while read -r header; do
  echo "#include \"$header\"" > "$work/one.cpp"
  "$cxx" -std=c++20 -Wall -Wextra -Wpedantic -Werror -fsyntax-only -I "$headers" "$work/one.cpp" || fail "$header cannot be included"
done < <(cd "$headers" && find . -name '*.h' | sed 's#^\./##' | sort)
# what the documentation tells engines to include is there, needed by another header or not
while read -r header; do
  [ -f "$headers/$header" ] || fail "docs/guide/library.md names $header, which is not installed"
done < <(grep -oE 'nlg/[a-z_]+\.h' "$source/docs/guide/library.md" | sort -u)
"$cc" -x c -std=c11 -Wall -Wextra -Wpedantic -Werror -fsyntax-only "$headers/nlg/nlg.h" || fail "nlg.h is no C"

# the guide's own lines compile, and positions of floats do not
lines_of() { awk -v fence="\`\`\`$1" '$0 == fence { inside = 1; block = ""; next } inside && /^```/ { inside = 0; if (block ~ /^#include/) printf "%s", block } inside { block = block $0 "\n" }' "$source/docs/guide/library.md"; }
lines_of cpp > "$work/guide.cpp"
lines_of c > "$work/guide.c"
grep -q lookUpIrradiances "$work/guide.cpp" && grep -q "double position_m" "$work/guide.c" || fail "docs/guide/library.md has no look-up"
"$cxx" -std=c++20 -Wall -Wextra -Werror -fsyntax-only -I "$headers" "$work/guide.cpp" || fail "the C++ of docs/guide/library.md does not compile"
"$cc" -std=c11 -Wall -Wextra -Werror -fsyntax-only -I "$headers" "$work/guide.c" || fail "the C of docs/guide/library.md does not compile"
sed 's/double position_m/float position_m/' "$work/guide.c" > "$work/floats.c"
! "$cc" -std=c11 -w -fsyntax-only -I "$headers" "$work/floats.c" 2> /dev/null || fail "positions of floats compile"

"$cmake" -S "$source/examples" -B "$work/build" -G "$generator" -DCMAKE_PREFIX_PATH="$prefix" -DCMAKE_BUILD_TYPE="$configuration" \
  -DCMAKE_C_COMPILER="$cc" -DCMAKE_CXX_COMPILER="$cxx" -DCMAKE_CXX_FLAGS="$cxx_flags" > "$work/configure.log" ||
  { cat "$work/configure.log"; fail "find_package(nlg) does not work"; }
"$cmake" --build "$work/build" > "$work/build.log" || { cat "$work/build.log"; fail "the examples do not build"; }

# by pkg-config, for whoever has no CMake: a program in C, and a shared library
export PKG_CONFIG_PATH=$(dirname "$(find "$prefix" -name nlg.pc)")
read -r -a flags <<< "$(pkg-config --cflags --libs nlg) $cxx_flags"
"$cc" "$source/examples/bake_minimal.c" -o "$work/by_pkg_config" "${flags[@]}" || fail "pkg-config's flags do not link"
"$cc" -shared -fPIC "$source/examples/bake_minimal.c" -o "$work/plug_in.so" "${flags[@]}" || fail "the library is for no plug-in"
"$make_weights" "$work/weights.safetensors" mlp
"$work/by_pkg_config" "$work/weights.safetensors" | grep -q "^stored" || fail "what pkg-config's flags link does not run"

for representation in mlp tent_mlp pf5; do
  "$make_weights" "$work/weights.safetensors" "$representation"
  output=$("$work/build/bake_minimal" "$work/weights.safetensors")
  echo "$output"
  grep -q "^$representation, [1-9][0-9]* numbers" <<< "$output" || fail "bake_minimal names another representation"
  network=$(sed -n 's/^network: RMSE \([0-9.]*\),.*/\1/p' <<< "$output")
  stored=$(sed -n 's/^stored: RMSE \([0-9.]*\),.*/\1/p' <<< "$output")
  awk -v n="$network" -v s="$stored" 'BEGIN { exit !(n > 0.02 && s > 0 && s < n) }' || fail "the policy: '$network' to '$stored'"
  # C and C++ sum the same numbers in another order
  in_c=$("$work/build/bake_minimal_c" "$work/weights.safetensors" | sed -n 's/^stored: *RMSE \([0-9.]*\),.*/\1/p')
  awk -v s="$stored" -v c="$in_c" 'BEGIN { exit !(c > 0 && s - c < 2e-5 && c - s < 2e-5) }' || fail "C: '$in_c', C++: '$stored'"
done

# theta from rays alone, by weights that read samples and by no others
"$make_weights" "$work/samples.safetensors" tent_mlp4 samples
[ "$("$work/build/moving_door" "$work/samples.safetensors" "$work/door.pgm" | grep -c '144 probes, rays .* ms, network .* ms')" -eq 3 ] ||
  fail "moving_door: expected three states of the door"
[ "$(wc -c < "$work/door.pgm")" -gt 153600 ] || fail "moving_door: no picture"
status=0
"$work/build/moving_door" "$work/weights.safetensors" 2> "$work/stderr" || status=$?
{ [ "$status" -eq 3 ] && grep -q "expected weights that read samples" "$work/stderr"; } || fail "moving_door takes weights of coefficients: $status"

# the installed program finds the weights that were installed with it, wherever both were moved to
"$make_weights" "$prefix/share/neural-light-grid/weights/tent_mlp4.safetensors" tent_mlp4
(cd "$work" && env -u NLG_WEIGHTS "$prefix/bin/nlg-bake" house:3 --spacing-m 3 --extent-m=0,0,0,6,6,3 --refine-rounds 0) 2> "$work/bake.txt" ||
  { cat "$work/bake.txt"; fail "nlg-bake SCENE does not work"; }
grep -qF "weights: $prefix/share/neural-light-grid/weights/tent_mlp4.safetensors" "$work/bake.txt" || { cat "$work/bake.txt"; fail "other weights were taken"; }
[ -s "$work/house_3.safetensors" ] || fail "nlg-bake SCENE left no light grid named after the scene"

head -c 1000 "$work/weights.safetensors" > "$work/cut.safetensors"
for example in bake_minimal bake_minimal_c moving_door; do
  status=0
  "$work/build/$example" "$work/cut.safetensors" 2> "$work/stderr" || status=$?
  [ "$status" -eq 3 ] || fail "$example: a cut file gives exit code $status"
  grep -q "_" "$work/stderr" || fail "$example: a cut file is refused without a reason"
done

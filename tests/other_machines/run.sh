#!/usr/bin/env bash
# The library for another machine: its own tests by an emulator, and programs in C and C++ against what is installed, whose numbers are
# compared with this machine's.
#
#   run.sh MACHINE BUILD_FOLDER CC        MACHINE as in cmake/toolchains/
set -euo pipefail
machine=$1 build=$2 cc=$3
cd "$(dirname "$0")/../.."
case $machine in
  aarch64) compiler=aarch64-linux-gnu emulator=(qemu-aarch64 -L /usr/aarch64-linux-gnu) ending="" ;;
  windows) compiler=x86_64-w64-mingw32 emulator=(cmake/toolchains/wine.sh) ending=.exe ;;
esac
needed=${emulator[0]}
[ "$machine" != windows ] || needed=/usr/lib/wine/wine64
command -v "$needed" > /dev/null || { echo "skipped: no $needed"; exit 77; }
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
fail() { echo "other_machines: $*" >&2; exit 1; }

status=0
workflow/build_for.sh "$machine" > "$work/log" 2>&1 || status=$?
[ $status = 0 ] || { tail -100 "$work/log"; exit $status; }
ctest --preset "$machine" --parallel "$(nproc)"

# as a user's own project: the examples, and nothing but C, of what is installed
prefix=$work/installed
cmake --install "build/$machine" --prefix "$prefix" > "$work/log" || { cat "$work/log"; fail "does not install"; }
cmake -S examples -B "$work/examples" -G Ninja --toolchain "$PWD/cmake/toolchains/$machine.cmake" -DCMAKE_BUILD_TYPE=Release \
  "-DCMAKE_PREFIX_PATH=$prefix;$PWD/build/highway-$machine" > "$work/log" 2>&1 && cmake --build "$work/examples" > "$work/log" 2>&1 ||
  { cat "$work/log"; fail "the examples do not build"; }
numbers=(-std=c11 -O2 -Wall -Wextra -Wpedantic -Werror tests/other_machines/numbers.c)
if [ "$machine" = windows ]; then
  cp "$prefix/bin/nlg.dll" "$work/examples"
  "$compiler-gcc-posix" "${numbers[@]}" -o "$work/examples/numbers.exe" -I "$prefix/include" -L "$prefix/lib" -lnlg
  unwanted=$("$compiler-objdump" -p "$work/examples/nlg.dll" | sed -n 's/.*DLL Name: //p' | grep -ivE '^(kernel32|msvcrt|user32)\.dll$' || true)
  [ -z "$unwanted" ] || fail "nlg.dll needs other DLLs: $unwanted"
else
  "$compiler-gcc" "${numbers[@]}" -o "$work/examples/numbers" -I "$prefix/include" -L "$prefix/lib" -L "build/highway-$machine/lib" \
    -lnlg_runtime_eval -lnlg_weights_file -lnlg_regular_file -lhwy -lstdc++ -lm
fi
"$cc" "${numbers[@]}" -o "$work/numbers" -I include -L "$build/runtime_eval" -L "$build/runtime_eval/weights_file" -L "$build/runtime_eval/regular_file" \
  -lnlg_runtime_eval -lnlg_weights_file -lnlg_regular_file -lhwy -lstdc++ -lm

weights=weights/tent_mlp4.safetensors
for example in bake_minimal bake_minimal_c; do
  output=$("${emulator[@]}" "$work/examples/$example$ending" $weights)
  echo "$example: $output"
  grep -q "^tent_mlp4, [1-9][0-9]* numbers" <<< "$output" || fail "$example on $machine"
done
"$build/bin/nlg-bake" house:3 --weights $weights --spacing-m 1 --extent-m=0,0,0,6,3,6 --sky 1,1,1 --sun 40,50,3,2.8,2.5 --out "$work/grid.safetensors" 2> "$work/log" || { cat "$work/log"; fail "no grid"; }
for target in scalar ssse3 sse4 avx2 avx512; do
  # those that this machine has
  NLG_SIMD=$target "$work/numbers" $weights "$work/grid.safetensors" > "$work/$target.txt" 2> "$work/log" || rm "$work/$target.txt"
done
"${emulator[@]}" "$work/examples/numbers$ending" $weights "$work/grid.safetensors" > "$work/other"
/usr/bin/python3 tests/other_machines/compare.py "$work"/*.txt "$work/other"

#!/usr/bin/env bash
# Builds a fuzz target with Clang and lets it run: run.sh weights|light_grid BUILD_FOLDER CLANG++ RUNS [libFuzzer options …]
#
# What it finds is written into BUILD_FOLDER, with the command's output naming the file; the corpus stays there, so that the next
# run goes on from it.
set -euo pipefail
format=$1 build=$2 compiler=$3 runs=$4
shift 4
case $format in
  weights) limits=(-max_len=4096 -dict=tests/fuzz/weights.dict) ;;
  light_grid) limits=(-max_len=12000) ;;
  *) echo "run.sh: $format: expected weights or light_grid" >&2; exit 2 ;;
esac
cd "$(dirname "$0")/../.."
cmake --preset fuzz -B "$build" -DCMAKE_CXX_COMPILER="$compiler" > /dev/null
cmake --build "$build" --target "${format}_fuzz" "${format}_seeds"
corpus=$build/$format.corpus seeds=$build/$format.seeds
mkdir -p "$corpus" "$seeds"
"$build/bin/${format}_seeds" "$seeds"
"$build/bin/${format}_fuzz" -runs="$runs" "${limits[@]}" -artifact_prefix="$build/" \
  -print_final_stats=1 -verbosity=1 "$@" "$corpus" "$seeds"

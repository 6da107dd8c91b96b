#!/usr/bin/env bash
# Builds the fuzz target with Clang and lets it run: run.sh BUILD_FOLDER CLANG++ RUNS [libFuzzer options …]
#
# What it finds is written into BUILD_FOLDER, with the command's output naming the file; the corpus stays there, so that the next
# run goes on from it.
set -euo pipefail
build=$1 compiler=$2 runs=$3
shift 3
cd "$(dirname "$0")/../.."
cmake --preset fuzz -B "$build" -DCMAKE_CXX_COMPILER="$compiler" > /dev/null
cmake --build "$build" --target weights_fuzz weights_seeds
mkdir -p "$build/corpus" "$build/seeds"
"$build/bin/weights_seeds" "$build/seeds"
"$build/bin/weights_fuzz" -runs="$runs" -max_len=4096 -dict=tests/fuzz/weights.dict -artifact_prefix="$build/" \
  -print_final_stats=1 -verbosity=1 "$@" "$build/corpus" "$build/seeds"

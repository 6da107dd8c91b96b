#!/usr/bin/env bash
# Builds a fuzz target with Clang and lets it run: run.sh TARGET BUILD_FOLDER CLANG++ RUNS [libFuzzer options …]
#
# What it finds is written into BUILD_FOLDER, with the command's output naming the file; the corpus stays there, so that the next
# run goes on from it. TARGET is one of targets.cmake.
set -euo pipefail
target=$1 build=$2 compiler=$3 runs=$4
shift 4
cd "$(dirname "$0")/../.."
if ! grep -q "^nlg_fuzz_target($target " tests/fuzz/targets.cmake; then
  echo "run.sh: $target: expected one of $(sed -n 's/^nlg_fuzz_target(\([a-z0-9_]*\) .*/\1/p' tests/fuzz/targets.cmake | xargs)" >&2
  exit 2
fi
# once it is there, the build itself configures anew whenever that is needed
[ -f "$build/build.ninja" ] || cmake --preset fuzz -B "$build" -DCMAKE_CXX_COMPILER="$compiler" -Wno-dev > /dev/null
cmake --build "$build" --target "${target}_fuzz"
program=$build/bin/${target}_fuzz corpus=$build/$target.corpus seeds=$build/$target.seeds
mkdir -p "$corpus" "$seeds"
# files of readers that take no bytes lie in memory
[ -d /dev/shm ] && scratch=$(mktemp -d -p /dev/shm) || scratch=$(mktemp -d)
trap 'rm -rf "$scratch"' EXIT
export TMPDIR=$scratch
"$program" --seeds "$seeds"
mapfile -t limits < "$program.options"
# memory and time that no small file may take
"$program" -runs="$runs" -rss_limit_mb=2048 -malloc_limit_mb=512 -timeout=60 "${limits[@]}" -artifact_prefix="$build/$target-" \
  -print_final_stats=1 -verbosity=1 "$@" "$corpus" "$seeds"

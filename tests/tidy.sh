#!/usr/bin/env bash
# clang-tidy over every source of the tree, or over those whose path matches: tests/tidy.sh [regular expression …]
#
# Any finding ends it with exit code 1. It reads what the compiler would be called with; nothing is compiled. Kernels are read for
# one SIMD target, since the others are the same source.
set -euo pipefail
cd "$(dirname "$0")/.."
mkdir -p build
cmake --preset tidy -Wno-dev > build/configure.log 2>&1 || { cat build/configure.log >&2; exit 1; }
cmake --build --preset tidy --target nlg_revision > build/tidy/revision.log  # the one header that is made
run=$(command -v run-clang-tidy-14) || { echo "tidy.sh: run-clang-tidy-14 is not installed (package clang-tidy-14)" >&2; exit 1; }
[ $# -gt 0 ] || set -- "$PWD/"
status=0
"$run" -quiet -p build/tidy -j "$(nproc)" "$@" > build/tidy/findings.log 2> build/tidy/errors.log || status=$?
# a header's finding comes once for every source that includes it
sed 's/\x1b\[[0-9;]*m//g' build/tidy/findings.log | grep -E ': (warning|error):' | sort -u || true
[ "$status" -eq 0 ] || echo "tidy.sh: build/tidy/findings.log and errors.log hold the whole of it" >&2
exit "$status"

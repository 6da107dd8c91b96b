#!/usr/bin/env bash
# Installs what is missing, builds everything that is tested, and runs the test suite.
set -euo pipefail
cd "$(dirname "$0")"

usage() {
  cat << 'TEXT'
Usage: ./test.sh [--all | --sanitize address,undefined | --sanitize thread | --tidy]

Installs what is missing, builds, and runs the test suite: a quarter of an hour on two cores.

  --all                          before a release: the heavy tests, too (all of fault injection, every fuzz target, Slurm with kills, all bad
                                 input, a large level in the browser, a bare Debian, the library on ARM and Windows), and a build of the
                                 benchmarks; an hour and a half on two cores
  --sanitize address,undefined   the default suite in a build of its own with AddressSanitizer and UndefinedBehaviorSanitizer
  --sanitize thread              … with ThreadSanitizer
  --tidy                         clang-tidy 14 over every source instead: nothing is linked, no test runs
  --help                         this text
TEXT
}

refuse() {
  echo "test.sh: $*; ./test.sh --help lists the options" >&2
  exit 2
}

what=release
tests=release
while [ $# -gt 0 ]; do
  [ "$what/$tests" = release/release ] || refuse "one of --all, --sanitize and --tidy at a time"
  case $1 in
    --help) usage; exit 0 ;;
    --all) tests=all; shift ;;
    --tidy) what=tidy; shift ;;
    --sanitize)
      case ${2-} in
        address,undefined) what=sanitize-address ;;
        thread) what=sanitize-thread ;;
        "") refuse "--sanitize: expected address,undefined or thread" ;;
        *) refuse "--sanitize $2: expected address,undefined or thread" ;;
      esac
      tests=$what
      shift 2
      ;;
    *) refuse "unknown option $1" ;;
  esac
done
[ "$tests" != all ] || echo "The whole suite takes about an hour and a half on two cores."

source workflow/setup.sh
mkdir -p build
[ "$tests" = all ] && heavy=(machines) || heavy=()
install_packages train pipeline package tests "${heavy[@]}"

if [ "$what" = tidy ]; then
  exec tests/tidy.sh
fi

# for one test each, which says that it was skipped where this fails
for package in onnxruntime naga ktx-parse three; do workflow/install_from_npm.sh $package build/$package || true; done
if [ "$what" = release ]; then
  build tests
  [ "$tests" != all ] || build tests benchmarks/all
else
  cmake --preset "$what" -Wno-dev > build/configure.log 2>&1 || { cat build/configure.log >&2; exit 1; }
  cmake --build --preset "$what" --parallel "$(build_jobs)"
fi
log=build/$what/Testing/Temporary/LastTest.log
failed=0
ctest --preset "$tests" --parallel "$(nproc)" || failed=1
if [ "$failed" = 1 ]; then
  echo
  echo "What the tests that failed said last:"
  # many tests' words stand above: whoever reads only the end must find the reason there
  awk '/^[0-9]+\/[0-9]+ Testing: / { name = $3; lines = 0; inside = 0 }
       /^<end of output>/ { inside = 0 }
       inside { line[lines++ % 40] = $0 }
       /^Output:/ { inside = 1 }
       /^Test Failed/ { print "== " name; for (i = lines > 40 ? lines - 40 : 0; i < lines; ++i) print line[i % 40] }' "$log"
fi
[ "$tests" = all ] || echo "test.sh: heavy tests were left to ./test.sh --all"
tests/summary.py "$log"
exit "$failed"

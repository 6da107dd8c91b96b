#!/usr/bin/env bash
# Installs what is missing, builds everything, and runs the whole test suite.
set -euo pipefail
cd "$(dirname "$0")"

usage() {
  cat << 'TEXT'
Usage: ./test.sh [--sanitize address,undefined | --sanitize thread | --tidy]

Installs what is missing, builds everything, and runs the whole test suite.

  --sanitize address,undefined   the same in a build of its own with AddressSanitizer and UndefinedBehaviorSanitizer
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
while [ $# -gt 0 ]; do
  case $1 in
    --help) usage; exit 0 ;;
    --tidy) chosen=tidy; shift ;;
    --sanitize)
      case ${2-} in
        address,undefined) chosen=sanitize-address ;;
        thread) chosen=sanitize-thread ;;
        "") refuse "--sanitize: expected address,undefined or thread" ;;
        *) refuse "--sanitize $2: expected address,undefined or thread" ;;
      esac
      shift 2
      ;;
    *) refuse "unknown option $1" ;;
  esac
  [ "$what" = release ] || refuse "one of --sanitize and --tidy at a time"
  what=$chosen
done

source workflow/setup.sh
mkdir -p build
install_packages tests

if [ "$what" = tidy ]; then
  exec tests/tidy.sh
fi

# for one test each, which says that it was skipped where this fails
for package in onnxruntime naga ktx-parse three; do workflow/install_from_npm.sh $package build/$package || true; done
if [ "$what" = release ]; then
  build
else
  cmake --preset "$what" -Wno-dev > build/configure.log 2>&1 || { cat build/configure.log >&2; exit 1; }
  cmake --build --preset "$what" --parallel "$(build_jobs)"
fi
if ! ctest --preset "$what" --parallel "$(nproc)"; then
  echo
  echo "What the tests that failed said last:"
  # a thousand tests' words stand above: whoever reads only the end must find the reason there
  awk '/^[0-9]+\/[0-9]+ Testing: / { name = $3; lines = 0; inside = 0 }
       /^<end of output>/ { inside = 0 }
       inside { line[lines++ % 40] = $0 }
       /^Output:/ { inside = 1 }
       /^Test Failed/ { print "== " name; for (i = lines > 40 ? lines - 40 : 0; i < lines; ++i) print line[i % 40] }' "build/$what/Testing/Temporary/LastTest.log"
  exit 1
fi

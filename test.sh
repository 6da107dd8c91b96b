#!/usr/bin/env bash
# Installs what is missing, builds everything, and runs the whole test suite.
set -euo pipefail
cd "$(dirname "$0")"
source workflow/setup.sh
mkdir -p build
install_packages
# for one test, which says that it was skipped where this fails
workflow/install_onnxruntime.sh build/onnxruntime || true
build
ctest --preset release --parallel "$(nproc)"

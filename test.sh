#!/usr/bin/env bash
# Installs what is missing, builds everything, and runs the whole test suite.
set -euo pipefail
cd "$(dirname "$0")"
source workflow/setup.sh
mkdir -p build
install_packages
build
ctest --preset release --parallel "$(nproc)"

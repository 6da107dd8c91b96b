#!/usr/bin/env bash
# Makes the packages in build/release/package, of what a bake, the viewer, pictures and engines need: nlg_VERSION_ARCHITECTURE.deb, and
# nlg-VERSION-Linux-PROCESSOR.tar.zst, which may be unpacked anywhere.
set -euo pipefail
cd "$(dirname "$0")/.."
source workflow/setup.sh
install_packages package
build "" installed
SOURCE_DATE_EPOCH=$(git log -1 --format=%ct) cpack --config build/release/CPackConfig.cmake

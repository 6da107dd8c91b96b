#!/usr/bin/env bash
# Makes the packages in build/release/package, of what a bake, the viewer, pictures and engines need: nlg_VERSION_ARCHITECTURE.deb, and
# nlg-VERSION-Linux-PROCESSOR.tar.zst, which may be unpacked anywhere. --training: those of training instead, nlg-training…
set -euo pipefail
cd "$(dirname "$0")/.."
source workflow/setup.sh
config=CPackConfig.cmake
if [ "${1:-}" = --training ]; then
  config=CPackTraining.cmake
  install_packages package train
  build train nlg-datagen nlg-pca nlg-cache nlg-train nlg-export nlg-bake nlg-validate
else
  install_packages package
  build package installed
fi
SOURCE_DATE_EPOCH=$(git log -1 --format=%ct) cpack --config "build/release/$config"

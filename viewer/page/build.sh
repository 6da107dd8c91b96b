#!/usr/bin/env bash
# Builds the page of nlg-view, built/, from source/ and three.js. Needs node and npm; whoever only builds the tools needs neither,
# because built/ is committed.
#
#     build.sh [FOLDER]     writes to FOLDER instead of built/: the test page_is_built compares the two
set -euo pipefail
cd "$(dirname "$0")"
out=$(realpath -m "${1:-built}")
npm ci --no-audit --no-fund --ignore-scripts --silent
node node_modules/esbuild/install.js
mkdir -p "$out"
node_modules/.bin/esbuild source/main.js --bundle --minify --format=iife --target=es2022 --loader:.glsl=text --legal-comments=eof \
  --log-level=warning --charset=ascii --outfile="$out/viewer.js"
cp source/index.html "$out/index.html"
cp node_modules/three/LICENSE "$out/three.LICENSE"

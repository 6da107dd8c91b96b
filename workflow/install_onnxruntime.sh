#!/usr/bin/env bash
# Installs onnxruntime, which one test compares exported models with, into FOLDER. Nothing else needs it.
#
#   workflow/install_onnxruntime.sh FOLDER
#
# Needs Node.js with npm, and asks Debian for them. Says why in one line and exits with 1 where it cannot be had.
set -euo pipefail
folder=$1
version=1.17.3
# there already, and of this version
grep -qs "\"version\": \"$version\"" "$folder/node_modules/onnxruntime-node/package.json" && exit 0
fail() { echo "onnxruntime is not installed: $*; the test onnx_runtime will be skipped" >&2; exit 1; }

if ! command -v npm > /dev/null || ! command -v node > /dev/null; then
  as_root=()
  if [ "$(id -u)" -ne 0 ]; then
    command -v sudo > /dev/null || fail "no npm, and neither root nor sudo to install it"
    as_root=(sudo)
  fi
  "${as_root[@]}" env DEBIAN_FRONTEND=noninteractive apt-get install -q -y --no-install-recommends nodejs npm > /dev/null ||
    fail "no npm, and no package of it"
fi
mkdir -p "$folder"
echo '{"private": true}' > "$folder/package.json"
# without its install script, which would fetch what only graphics cards need
log=$(npm install --prefix "$folder" --ignore-scripts --no-audit --no-fund --no-package-lock --fetch-retries=1 --fetch-timeout=60000 \
  "onnxruntime-node@$version" 2>&1) || fail "npm: $(tail -1 <<< "$log")"
node -e 'require(process.argv[1])' "$(realpath "$folder")/node_modules/onnxruntime-node" || fail "it does not load"

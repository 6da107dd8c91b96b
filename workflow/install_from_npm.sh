#!/usr/bin/env bash
# Installs what comes from npm into FOLDER, which is best build/WHAT:
#
#   workflow/install_from_npm.sh WHAT FOLDER
#
#   onnxruntime   one test compares exported models with it; nothing else needs it
#   naga          makes WGSL of shaders (export/shader/wgsl.mjs); WebGPU needs it, nothing else
#   ktx-parse     one test reads exported KTX2 files with it; nothing else needs it
#   three         one test shows exported light in it, in the version of nlg-view's page; nothing else needs it
#
# Needs Node.js with npm, and asks Debian for them. Says why in one line and exits with 1 where it cannot be had.
set -euo pipefail
what=${1-} folder=${2-}
case $what in
  onnxruntime) package=onnxruntime-node version=1.17.3 ;;
  naga) package=naga-wasm version=30.1.0 ;;
  ktx-parse) package=ktx-parse version=2.0.0 ;;
  three) package=three version=$(sed -n 's/.*"three": "\(.*\)".*/\1/p' "$(dirname "$0")/../viewer/page/package.json") ;;
  *) echo "install_from_npm.sh ${what:-without a name}: expected onnxruntime, naga, ktx-parse or three, and a folder" >&2; exit 2 ;;
esac
[ -n "$folder" ] || { echo "install_from_npm.sh $what: expected a folder" >&2; exit 2; }
# there already, and of this version
grep -qs "\"version\": \"$version\"" "$folder/node_modules/$package/package.json" && exit 0
fail() { echo "$what is not installed: $*; what needs it will be skipped" >&2; exit 1; }

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
# without install scripts: that of onnxruntime would fetch what only graphics cards need
log=$(npm install --prefix "$folder" --ignore-scripts --no-audit --no-fund --no-package-lock --fetch-retries=1 --fetch-timeout=60000 \
  "$package@$version" 2>&1) || fail "npm: $(tail -1 <<< "$log")"
(cd "$folder" && node -e "import('$package')") || fail "it does not load"

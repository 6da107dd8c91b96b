#!/usr/bin/env bash
# The page in viewer/page/built is what viewer/page/build.sh makes of its sources. Skipped, with exit code 77, where npm or its packages
# cannot be had.
set -uo pipefail
root=$(cd "$(dirname "$0")/../.." && pwd)
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
command -v npm > /dev/null || { echo "skipped: no npm"; exit 77; }
# not in the sources: another build may run there
mkdir "$folder/viewer" "$folder/render"
cp -r "$root/viewer/page" "$folder/viewer" && rm -rf "$folder/viewer/page/node_modules"
cp "$root/render/neutral_tone.glsl" "$folder/render"
if ! log=$("$folder/viewer/page/build.sh" "$folder/built" 2>&1); then
  if [ ! -d "$folder/viewer/page/node_modules/three" ]; then
    echo "skipped: npm: $(tail -1 <<< "$log")"
    exit 77
  fi
  echo "$log"
  exit 1
fi
for file in viewer.js index.html three.LICENSE; do
  cmp "$folder/built/$file" "$root/viewer/page/built/$file" || { echo "viewer/page/build.sh makes another $file"; exit 1; }
done

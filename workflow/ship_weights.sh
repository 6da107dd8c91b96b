#!/usr/bin/env bash
# Puts a run's exported weights into weights/, with a model card each, and takes what the run measured as the figures of all documentation.
#
#   workflow/ship_weights.sh [--force] RUN CONFIG REPRESENTATION ...
#
# --force  ship what is worse than what lies there, or of a revision with uncommitted changes; without it such weights are refused
# RUN      the result folder of a finished run, out/NAME
# CONFIG   the configuration that it was made by: the cards name it
# Files of other representations stay; their cards keep figures only where this run measured them too. The test suite then checks what
# lies there: it loads, all of it is float16, and together it takes at most 32 MB.
set -euo pipefail
force=''
[ "${1:-}" != --force ] || { force=yes; shift; }
[ $# -ge 3 ] || { sed -n '2,10s/^# \{0,1\}//p' "$0" >&2; exit 2; }
run=$(realpath "$1") config=$2
shift 2
cd "$(dirname "$0")/.."
[ -f "$config" ] || { echo "ship_weights: $config: expected a configuration, as a path from the sources' folder" >&2; exit 2; }
for name in "$@"; do
  [ -f "$run/weights/$name.safetensors" ] || { echo "ship_weights: $run/weights/$name.safetensors: expected weights, got none" >&2; exit 3; }
done
code=0
/usr/bin/python3 docs/figures/model_card.py --may-ship "$run" "$config" "$@" || code=$?
# what could not be judged is not forced either
if [ "$code" != 0 ] && { [ "$code" != 6 ] || [ -z "$force" ]; }; then
  echo "ship_weights: nothing was copied$([ "$code" != 6 ] || echo "; --force ships all the same")" >&2
  exit "$code"
fi
for name in "$@"; do
  install -m 644 "$run/weights/$name.safetensors" "weights/$name.safetensors"
done
/usr/bin/python3 docs/figures/model_card.py "$run" "$config" "$@"
/usr/bin/python3 docs/figures/results.py collect "$run" --config "$config"
du -cb weights/*.safetensors

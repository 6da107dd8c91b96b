#!/usr/bin/env bash
# Verifies every shard of a run and removes those that are damaged, so that the workflow makes them again.
#
#   check_shards.sh BIN_FOLDER DATASET_FOLDER
#
# Prints the removed ones on stdout, one a line; why, on stderr.
set -euo pipefail
bin=$1 dataset=$2
[ -d "$dataset" ] || exit 0

check() {
  local status=0
  message=$("$1/nlg-datagen" info --quiet "$2" 2>&1) || status=$?
  case $status in
    0) ;;
    3)
      echo "$message: it will be made again" >&2
      rm -f -- "$2"
      printf '%s\n' "$2"
      ;;
    *)
      echo "$message" >&2
      return 255
      ;;
  esac
}
export -f check
find "$dataset" -name '*.h5' -print0 | sort -z | xargs -0 -r -P "$(nproc)" -n 1 bash -c 'check "$@"' check "$bin"

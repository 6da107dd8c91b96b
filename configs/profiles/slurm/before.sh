#!/usr/bin/env bash
# What pipeline.sh calls before it starts: takes out of the queue the jobs that a run of this folder left there when it was killed, and
# waits until they are gone. Two jobs would make one file.
#
#   before.sh RUN_FOLDER
set -euo pipefail
folder=$(realpath -m -- "$1")

jobs_left() {
  local queue job comment
  queue=$(squeue --me --noheader --format='%i %k')
  while read -r job comment; do [ "$comment" != "$folder" ] || echo "$job"; done <<< "$queue"
}

left=$(jobs_left)
[ -n "$left" ] || exit 0
echo "Cancelling jobs that a killed run of $folder left in the queue: ${left//$'\n'/ }" >&2
# shellcheck disable=SC2086
scancel --quiet $left
while [ -n "$(jobs_left)" ]; do sleep 1; done

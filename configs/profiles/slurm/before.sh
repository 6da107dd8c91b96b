#!/usr/bin/env bash
# What pipeline.sh calls before it starts: takes out of the queue the jobs that a run of this folder left there when it was killed, and
# waits until they are gone. Two jobs would make one file.
#
#   before.sh RUN_FOLDER
set -euo pipefail
folder=$(realpath -m -- "$1")

WAIT_S=600  # for jobs that were cancelled; those of a node that is lost stay in the queue for longer

# a controller that does not answer has not said that nothing is left
queue() {
  local try
  for try in 1 2 3 4 5; do
    [ "$try" = 1 ] || sleep 2
    if timeout 60 squeue --me --noheader --format='%i %k'; then return; fi
  done
  echo "before.sh: squeue does not say what is in the queue; a job that a killed run left there would make the same files" >&2
  return 1
}

jobs_left() {
  local lines job comment
  lines=$(queue) || return 1
  while read -r job comment; do [ "$comment" != "$folder" ] || echo "$job"; done <<< "$lines"
}

left=$(jobs_left) || exit 1
[ -n "$left" ] || exit 0
echo "Cancelling jobs that a killed run of $folder left in the queue: ${left//$'\n'/ }" >&2
# shellcheck disable=SC2086
scancel --quiet $left
end=$((SECONDS + WAIT_S))
while left=$(jobs_left) || exit 1; [ -n "$left" ]; do
  if [ "$SECONDS" -ge "$end" ]; then
    echo "before.sh: jobs of $folder are in the queue $((WAIT_S / 60)) minutes after they were cancelled: ${left//$'\n'/ }" >&2
    exit 1
  fi
  sleep 1
done

#!/usr/bin/env bash
# Runs nlg-train as COUNT processes that train together: by srun inside a Slurm job that has a task for each, otherwise here.
#
#   train_together.sh COUNT FOLDER COMMAND …
#
# FOLDER is one that all of them can write. They meet in a file there, a fresh one each time, which is gone afterwards. When one fails
# the others are ended; the exit code is that of the first that failed.
set -euo pipefail

count=$1 folder=$2
shift 2
[ "$count" != 1 ] || exec "$@"
mkdir -p "$folder"
# of a training that was killed; the run's lock lets no other one be at work here
rm -f "$folder"/meeting.????????
meeting=$(mktemp -u "$folder/meeting.XXXXXXXX")
trap 'rm -f "$meeting"' EXIT

if [ -n "${SLURM_JOB_ID:-}" ] && [ "${SLURM_NTASKS:-1}" = "$count" ]; then
  # srun does not take the cores of a task over from sbatch
  srun --ntasks "$count" --cpus-per-task "${SLURM_CPUS_PER_TASK:-1}" --kill-on-bad-exit=1 "$@" --rendezvous "$meeting"
  exit
fi

processes=()
for ((rank = 0; rank < count; ++rank)); do
  "$@" --processes "$count" --rank "$rank" --rendezvous "$meeting" &
  processes+=($!)
done
trap 'kill "${processes[@]}" 2> /dev/null || true' INT TERM
code=0
for _ in "${processes[@]}"; do
  wait -n || code=$?
  [ "$code" = 0 ] || break
done
[ "$code" = 0 ] || kill "${processes[@]}" 2> /dev/null || true
wait || true
exit "$code"

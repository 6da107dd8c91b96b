#!/usr/bin/env bash
# Runs one job of snakemake's on the first machine of NLG_MACHINES that has none, and ends as the job does. A machine that is named twice
# takes two jobs at a time.
#
#   NLG_MACHINES   names, with blanks between them
#   NLG_REACH      what starts a command on the machine HOST; default: ssh -o BatchMode=yes HOST
#   run.sh JOBSCRIPT          (from the folder of the checkout)
set -euo pipefail
[ -n "${NLG_MACHINES:-}" ] || { echo "run.sh: NLG_MACHINES: expected the machines' names, got none" >&2; exit 2; }
reach=${NLG_REACH:-ssh -o BatchMode=yes HOST}
mkdir -p .snakemake/machines
while true; do
  number=0
  for machine in $NLG_MACHINES; do
    number=$((number + 1))
    exec 7>> ".snakemake/machines/$number"
    flock -n 7 || continue
    {
      printf 'cd %q\n' "$PWD"
      for name in NLG_BIN NLG_OUT NLG_ARCHIVE_ROOT; do [ -z "${!name:-}" ] || printf 'export %s=%q\n' "$name" "${!name}"; done
      printf 'exec bash %q < /dev/null\n' "$(realpath -- "$1")"
    } | ${reach//HOST/$machine} bash -s
    exit
  done
  sleep 0.2
done

#!/usr/bin/env bash
# configs/profiles/machines with two workers on this machine in place of two machines: both work, and the bytes are those of one machine.
#   machines_test.sh BIN_FOLDER          (from the source folder)
set -euo pipefail

temporary=$(mktemp -d)
trap 'rm -rf "$temporary"' EXIT
export NLG_BIN=$1
printf '#!/bin/bash\necho "$1" >> %q\nshift\nexec "$@"\n' "$temporary/reached" > "$temporary/reach.sh"
chmod +x "$temporary/reach.sh"

# three shards are two groups of jobs
sed 's/families: .*/families: [house]/; s/savings: .*/savings: []/; s/max_functions: .*/max_functions: 40/' configs/smoke.yaml > "$temporary/run.yaml"
# makes the basis in the folder $1; the rest goes to snakemake
basis() {
  local folder=$1
  shift
  NLG_OUT=$temporary/$folder /usr/bin/snakemake "$temporary/$folder/smoke/basis.h5" "$@" -s workflow/Snakefile --configfile "$temporary/run.yaml" --nolock \
    > "$temporary/$folder.log" 2>&1 || { cat "$temporary/$folder.log" >&2; echo "FAILED: snakemake into $folder" >&2; exit 1; }
}
basis here --cores 2
NLG_MACHINES="one two" NLG_REACH="$temporary/reach.sh HOST" basis elsewhere --profile configs/profiles/machines --group-components shards=2 --latency-wait 5
[ "$(sort -u "$temporary/reached")" = $'one\ntwo' ] || { echo "FAILED: reached $(sort "$temporary/reached" | uniq -c)" >&2; exit 1; }
cmp "$temporary/here/smoke/basis.h5" "$temporary/elsewhere/smoke/basis.h5"
# a job that fails is a run that fails
! NLG_MACHINES="one" NLG_REACH="false HOST" NLG_OUT=$temporary/none /usr/bin/snakemake "$temporary/none/smoke/dataset/training/house_0.0.h5" -s workflow/Snakefile --configfile "$temporary/run.yaml" \
  --nolock --profile configs/profiles/machines --latency-wait 1 > /dev/null 2>&1

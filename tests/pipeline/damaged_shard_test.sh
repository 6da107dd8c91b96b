#!/usr/bin/env bash
# A damaged shard is found and made again, to the same bytes; the sound ones are left alone.
#
#   damaged_shard_test.sh BIN_FOLDER     (from the source folder)
set -euo pipefail

export NLG_BIN=$1
temporary=$(mktemp -d)
trap 'rm -rf "$temporary"' EXIT
dataset=$temporary/smoke/dataset

fail() {
  echo "FAILED: $*" >&2
  exit 1
}

workflow() {
  NLG_OUT=$temporary /usr/bin/snakemake -s workflow/Snakefile --configfile configs/smoke.yaml --cores 2 --nolock "$@" \
    >"$temporary/log" 2>&1 || {
    cat "$temporary/log" >&2
    fail "snakemake $*"
  }
}

shards=("$dataset/training/house_0.0.h5" "$dataset/training/clutter_1.0.h5" "$dataset/held_out/house_2.0.h5")
workflow "${shards[@]}"
before=$(sha256sum "${shards[@]}")
[ -z "$(workflow/check_shards.sh "$NLG_BIN" "$dataset")" ] || fail "sound shards were removed"

# one bit in the middle of one shard; another shard cut short
/usr/bin/python3 - "${shards[0]}" "${shards[2]}" <<'PYTHON'
import os, sys

with open(sys.argv[1], "r+b") as file:
    place = os.path.getsize(sys.argv[1]) // 2
    file.seek(place)
    byte = file.read(1)[0]
    file.seek(place)
    file.write(bytes([byte ^ 4]))
os.truncate(sys.argv[2], os.path.getsize(sys.argv[2]) - 1)
PYTHON
age=$(stat -c '%Y %Z' "${shards[1]}")
mapfile -t removed < <(workflow/check_shards.sh "$NLG_BIN" "$dataset" 2>"$temporary/messages" | sort)
[ "${removed[*]}" = "${shards[2]} ${shards[0]}" ] || fail "removed: ${removed[*]}"
[ "$(grep -c 'made again' "$temporary/messages")" = 2 ] || fail "messages: $(cat "$temporary/messages")"
workflow "${removed[@]}"
[ "$(sha256sum "${shards[@]}")" = "$before" ] || fail "the shards made again are others"
[ "$(stat -c '%Y %Z' "${shards[1]}")" = "$age" ] || fail "a sound shard was made again"
echo "damaged shard test: all holds"

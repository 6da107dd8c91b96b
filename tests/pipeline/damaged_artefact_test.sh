#!/usr/bin/env bash
# What is damaged of a run is put aside and made again, to the same bytes; whatever else lies there is left alone.
#
#   damaged_artefact_test.sh BIN_FOLDER     (from the source folder)
#
# It damages shards; the fault injection damages the other files.
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
  NLG_OUT=$temporary /usr/bin/snakemake -s workflow/Snakefile --configfile configs/smoke.yaml --cores 2 --nolock \
    --log-handler-script workflow/run_progress.py "$@" \
    >"$temporary/log" 2>&1 || {
    cat "$temporary/log" >&2
    fail "snakemake $*"
  }
}

shards=("$dataset/training/house_0.0.h5" "$dataset/training/clutter_1.0.h5" "$dataset/held_out/house_2.0.h5")
workflow "${shards[@]}"
before=$(sha256sum "${shards[@]}")

# checks the shards of configuration $2 with the tools in $1: messages in $temporary/messages
check() {
  NLG_OUT=$temporary /usr/bin/python3 workflow/check_artefacts.py "$2" "$1" "${@:3}" 2>"$temporary/messages"
}

# the check must end with exit code $1 and one line that holds $2, and move nothing
refuses() {
  local code=0 files
  files=$(find "$temporary" -path "$temporary/messages" -prune -o -print | sort)
  check "$3" "$4" || code=$?
  [ "$code" = "$1" ] || fail "exit code $code, expected $1 and '$2': $(cat "$temporary/messages")"
  [ "$(wc -l <"$temporary/messages")" = 1 ] && grep -qF -- "$2" "$temporary/messages" || fail "expected one line with '$2', got: $(cat "$temporary/messages")"
  [ "$(find "$temporary" -path "$temporary/messages" -prune -o -print | sort)" = "$files" ] || fail "a check that ended with $1 moved files"
}

check "$NLG_BIN" configs/smoke.yaml && [ ! -s "$temporary/messages" ] || fail "sound shards: $(cat "$temporary/messages")"

# --- one bit in the middle of one shard; another shard cut short; files that no plan names, and a link out of the folder, are damaged too
mkdir "$temporary/elsewhere"
echo notes >"$dataset/notes.h5"
echo notes >"$dataset/training/house_0.1.h5"
echo notes >"$temporary/elsewhere/linked.h5"
ln -s "$temporary/elsewhere/linked.h5" "$dataset/training/clutter_0.0.h5"
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
damaged=$(sha256sum <"${shards[0]}")

# a shard that is no file stops the check before anything moves
mv "$dataset/training/clutter_0.0.h5" "$temporary/link"
mv "$dataset/training/house_0.1.h5" "$temporary/unplanned"
mv "${shards[1]}" "$temporary/sound"
mkfifo "${shards[1]}"
refuses 3 "clutter_1.0.h5" "$NLG_BIN" configs/smoke.yaml
rm "${shards[1]}"
mv "$temporary/sound" "${shards[1]}"
mv "$temporary/link" "$dataset/training/clutter_0.0.h5"
mv "$temporary/unplanned" "$dataset/training/house_0.1.h5"

age=$(stat -c '%Y' "${shards[1]}")
check "$NLG_BIN" configs/smoke.yaml || fail "a check of damaged shards: $(cat "$temporary/messages")"
[ "$(grep -c 'made again' "$temporary/messages")" = 2 ] || fail "messages: $(cat "$temporary/messages")"
grep -q "clutter_0.0.h5 is reached through a link" "$temporary/messages" || fail "nothing was said of a link: $(cat "$temporary/messages")"
grep -q "1 shards in .* are of no run" "$temporary/messages" || fail "nothing was said of a shard of no run: $(cat "$temporary/messages")"
[ "$(sha256sum <"${shards[0]}.damaged")" = "$damaged" ] && [ ! -e "${shards[0]}" ] || fail "a damaged shard was not put aside as it was"
for stranger in "$dataset/notes.h5" "$dataset/training/house_0.1.h5" "$dataset/training/clutter_0.0.h5" "$temporary/elsewhere/linked.h5"; do
  [ "$(cat "$stranger")" = notes ] || fail "$stranger, which is none of the run's files, was touched"
done
rm "$dataset/training/clutter_0.0.h5"
workflow "${shards[@]}"
[ "$(sha256sum "${shards[@]}")" = "$before" ] || fail "the shards made again are others"
[ "$(stat -c '%Y' "${shards[1]}")" = "$age" ] || fail "a sound shard was made again"
# what is of no run goes on request, and nothing else
check "$NLG_BIN" configs/smoke.yaml --prune && [ ! -e "$dataset/training/house_0.1.h5" ] && [ -e "$dataset/notes.h5" ] || fail "--prune: $(cat "$temporary/messages")"
[ "$(sha256sum "${shards[@]}")" = "$before" ] || fail "--prune touched the run's shards"

# --- pictures that no rule has finished are left to the workflow, which makes them again
places=$temporary/smoke/light/two_rooms_0_places
mkdir -p "$places"
printf cut >"$places/picture.png"
check "$NLG_BIN" configs/smoke.yaml && [ -e "$places/picture.png" ] && grep -q "nothing says what 1 files were made of" "$temporary/messages" || fail "pictures of a killed rule: $(cat "$temporary/messages")"

# --- a configuration that cannot be used: nothing is looked at, one line, exit code 2; configurations_test.py has what may be wrong in one
mkdir -p "$temporary/victim/dataset/training"
echo precious >"$temporary/victim/dataset/training/house_0.0.h5"
sed "s|^name: smoke\$|name: ../victim|" configs/smoke.yaml >"$temporary/bad.yaml"
refuses 2 "a folder's name" "$NLG_BIN" "$temporary/bad.yaml"
refuses 2 "nowhere.yaml" "$NLG_BIN" "$temporary/nowhere.yaml"
[ "$(cat "$temporary/victim/dataset/training/house_0.0.h5")" = precious ] || fail "another folder's file was touched"

# --- what is judged is what the workflow makes
NLG_OUT=$temporary /usr/bin/snakemake -s workflow/Snakefile --configfile configs/smoke.yaml --summary 2>"$temporary/log" | tail -n +2 | cut -f 1 |
  grep -v -e /dataset/ -e functions.cache -e 'savings/.*\.safetensors' -e 'bakes/.*\.safetensors' | sort >"$temporary/made"
NLG_OUT=$temporary /usr/bin/python3 -c 'import sys; sys.path.insert(0, "workflow"); import configuration; run = configuration.load(sys.argv[1]); print(*sorted([*run.artefacts(), *run.picture_folders()]), sep="\n")' configs/smoke.yaml >"$temporary/judged"
diff "$temporary/made" "$temporary/judged" || fail "artefacts of the configuration are not what the workflow makes: $(cat "$temporary/log")"
echo "damaged artefact test: all holds"

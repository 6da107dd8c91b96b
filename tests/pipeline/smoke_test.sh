#!/bin/bash
# The whole chain on next to nothing, as the workflow runs it: what it leaves, what it re-makes, and that it repeats itself.
#   smoke_test.sh BIN_FOLDER          (from the source folder)
set -euo pipefail

export NLG_BIN=$1
temporary=$(mktemp -d)
trap 'rm -rf "$temporary"' EXIT
out=$temporary/first/smoke

fail() {
  echo "FAILED: $*" >&2
  exit 1
}

# runs the workflow into the folder $1; the rest goes to snakemake. --nolock: another run of this checkout is none of our business
pipeline() {
  local folder=$1
  shift
  NLG_OUT=$temporary/$folder /usr/bin/snakemake -s workflow/Snakefile --configfile configs/smoke.yaml --cores 2 --nolock "$@" \
    >"$temporary/$folder.log" 2>&1 || {
    cat "$temporary/$folder.log" >&2
    fail "snakemake into $folder"
  }
}

pipeline first

# --- the README's own configuration is one that the workflow takes
NLG_OUT=$temporary/default /usr/bin/snakemake -s workflow/Snakefile --configfile pipeline.yaml --cores 1 --nolock --dryrun --quiet \
  >"$temporary/default.log" 2>&1 || { cat "$temporary/default.log" >&2; fail "dry run of pipeline.yaml"; }

# --- what it leaves
[ -s "$out/report.html" ] || fail "no report.html"
for part in stages frontier stability savings light; do
  grep -q "<section id=\"$part\">" "$out/report.html" || fail "report.html lacks the section $part"
done
[ ! -e "$out/savings/clutter_2.safetensors" ] || fail "the light grid of a table of savings was kept"
! grep -Eq '(src|href)="(https?:)?//' "$out/report.html" || fail "report.html loads something from elsewhere"
/usr/bin/python3 - "$out/validation/summary.json" <<'PYTHON'
import json, sys

summary = json.load(open(sys.argv[1]))
words, fits = ["network", "corrected", "fitted", "stored"], ["direct", "best_known"]
functions = summary["functions"]
assert functions["distinct"] > functions["held_out"] > 0, functions
assert functions["held_out"] >= functions["take_theta"] >= functions["hard"], functions
for name, representation in summary["representations"].items():
    # corrections never end above where they started, and nothing is below what is best known
    means = {word: representation["sample"][word]["theta"]["blend_rmse"]["mean"] for word in words + fits}
    for better, worse in [("corrected", "network"), *(("best_known", word) for word in words + fits)]:
        assert means[better] <= means[worse] * (1 + 1e-4), f"{name}: {better} has a mean blend RMSE of {means[better]}, {worse} of {means[worse]}"
PYTHON

# --- a bake with the generators that it made: the same bytes on any number of threads, and figures that add up
weights=("$out/weights/tent_mlp.safetensors" "$out/weights/mlp.safetensors")
bake=(--weights "${weights[@]}" --config configs/smoke.yaml --spacing-m 1.5 --extent-m=0,0,0,6,6,3)
"$NLG_BIN/nlg-bake" house:3 "${bake[@]}" --threads 1 --out "$temporary/one.safetensors" --json "$temporary/one.json" 2>/dev/null
"$NLG_BIN/nlg-bake" house:3 "${bake[@]}" --threads 2 --out "$temporary/two.safetensors" >/dev/null 2>&1
cmp "$temporary/one.safetensors" "$temporary/two.safetensors" || fail "two threads baked another light grid than one"
"$NLG_BIN/nlg-bake" house:3 "${bake[@]}" --theta-precision float32 --out "$temporary/whole.safetensors" --json "$temporary/whole.json" 2>/dev/null
/usr/bin/python3 - "$temporary"/{one,whole}.{json,safetensors} <<'PYTHON'
import json, os, sys

one, one_file, whole, whole_file = sys.argv[1:]
one, whole = json.load(open(one)), json.load(open(whole))
parts = ["functions", "free_space", "bare_tents", "in_solid", "empty", "duplicates"]
assert sum(one[part] for part in parts) == one["probes"] > one["functions"] > 0, one
assert sum(one["representations"].values()) == one["functions"], one
# a later word never fails where the one before passed, whatever the mean does: refinement trades a little RMSE for leaks
failing = [whole["rmse"][word]["failing"] for word in ["network", "corrected", "fitted", "stored"]]
assert failing == sorted(failing, reverse=True) and failing[-1] == whole["still_failing"], whole
assert one["took_fit"] == round(one["share_fitted"]["theta"] * one["functions"]) and one["ended"]["network"] < one["functions"], one
assert one["bytes"] == os.path.getsize(one_file) and whole["bytes"] == os.path.getsize(whole_file), (one, whole)
# hidden layers in bytes, the last in halves, 104 numbers and 9; and less, since a file codes them
functions = whole["theta_bytes"] // 452
assert 60 * functions < one["theta_bytes"] < 122 * functions and whole["theta_bytes"] == 452 * functions, (one["theta_bytes"], whole["theta_bytes"])
assert whole["rmse"]["fitted"]["mean"] == whole["rmse"]["stored"]["mean"], whole
PYTHON

# --- info of every kind of file: what it is, and that every byte was verified
"$NLG_BIN/nlg-cache" --basis "$out/basis.h5" --shards "$out"/dataset/training/*.h5 --out "$temporary/functions.cache" >/dev/null
for case in "nlg-datagen $out/dataset/training/house_0.0.h5" "nlg-pca $out/basis.h5" "nlg-cache $temporary/functions.cache" \
  "nlg-train $out/training/tent_mlp.ckpt" "nlg-export $out/weights/tent_mlp.safetensors" "nlg-bake $temporary/one.safetensors"; do
  read -r tool file <<<"$case"
  info=$("$NLG_BIN/$tool" info --json "$file") || fail "$tool info refuses $file"
  [[ $info == *"$(sha256sum <"$file" | cut -c 1-64)"* && $info == *"every byte (SHA-256)"* ]] || fail "$tool info $file: $info"
done
# a sound file of another kind is no damaged one: 3, so that the workflow does not put it aside
for case in "nlg-export $temporary/one.safetensors" "nlg-export $out/basis.h5" "nlg-train $out/weights/tent_mlp.safetensors" "nlg-train $out/basis.h5" \
  "nlg-bake $out/weights/tent_mlp.safetensors" "nlg-cache $out/basis.h5" "nlg-pca $out/dataset/training/house_0.0.h5" "nlg-datagen $out/basis.h5"; do
  read -r tool file <<<"$case"
  code=0
  "$NLG_BIN/$tool" info "$file" >/dev/null 2>"$temporary/info.txt" || code=$?
  [ "$code" = 3 ] && [ "$(wc -l <"$temporary/info.txt")" = 1 ] || fail "$tool info $file: exit code $code, expected 3: $(cat "$temporary/info.txt")"
done

# --- a stability case that does not hold: the report is made all the same and shows it; a tool that fails otherwise ends the run
/usr/bin/python3 workflow/failed_cases.py "$out/stability.json" >"$temporary/failed.txt" || fail "cases do not hold: $(cat "$temporary/failed.txt")"
mkdir "$temporary/bin"
ln -s "$NLG_BIN"/nlg-* "$temporary/bin/"
rm "$temporary/bin/nlg-validate"
cat >"$temporary/bin/nlg-validate" <<'SCRIPT'
#!/bin/bash
# the last argument is the table to write: of another run, with one case that fails
/usr/bin/python3 - "$STABILITY_TABLE" "${@: -1}" <<'PYTHON'
import json, sys

table = json.load(open(sys.argv[1]))
table["cases"][0].update(name="made to fail", holds=False)
json.dump(table, open(sys.argv[2], "w"))
PYTHON
exit "$STABILITY_CODE"
SCRIPT
chmod +x "$temporary/bin/nlg-validate"
cp "$out/stability.json" "$temporary/stability.json"
(
  export NLG_BIN=$temporary/bin STABILITY_TABLE=$temporary/stability.json STABILITY_CODE=6
  cp -a "$temporary/first" "$temporary/failing"
  pipeline failing --forcerun stability
)
grep -q '<tr class="fails">' "$temporary/failing/smoke/report.html" || fail "a case that does not hold is not in the report"
code=0
/usr/bin/python3 workflow/failed_cases.py "$temporary/failing/smoke/stability.json" >"$temporary/failed.txt" || code=$?
[ "$code" = 6 ] && grep -q "made to fail" "$temporary/failed.txt" || fail "failed_cases.py: exit code $code, $(cat "$temporary/failed.txt")"
! (
  export NLG_BIN=$temporary/bin STABILITY_TABLE=$temporary/stability.json STABILITY_CODE=3
  pipeline failing --forcerun stability
) 2>"$temporary/stopped.txt" || fail "nlg-validate stability ended with 3 and the run went on"

# --- what it was said to take beforehand is what it took
NLG_OUT=$temporary/first /usr/bin/python3 workflow/plan.py configs/smoke.yaml --bin "$NLG_BIN" >"$temporary/planned.log" || fail "plan.py refuses configs/smoke.yaml"
"$NLG_BIN/nlg-datagen" info --json "$out"/dataset/*/*.h5 >"$temporary/shards.jsonl"
/usr/bin/python3 - "$temporary/planned.log" "$temporary/shards.jsonl" <<'PYTHON'
import json, re, sys

plan = open(sys.argv[1]).read()
number = lambda text: float(text.replace(",", ""))
shards, probes, functions = (sum(map(number, column)) for column in zip(*re.findall(r"([\d,]+) shards, about ([\d,]+) probes, ([\d,]+) functions", plan)))
megabytes = number(re.search(r"disk +([\d,]+) MB", plan)[1])
for stage in ("data set", "basis", "function cache", "train mlp", "train tent_mlp", "export", "validate", "frontier", "stability", "savings", "light", "report", "all"):
    assert re.search(rf"^{stage} +\d+ (s|min|h)\b.*$", plan, re.M), f"no time of the stage {stage}:\n{plan}"
made = [json.loads(line) for line in open(sys.argv[2])]
assert shards == len(made), f"{shards} shards planned, {len(made)} made"
for name, planned, key, unit in [("probes", probes, "visited_probes", 1), ("functions", functions, "functions", 1), ("MB", megabytes, "bytes", 1e6)]:
    actual = sum(shard[key] for shard in made) / unit
    assert abs(planned / actual - 1) < (0.2 if planned > 10 else 0.5), f"{name}: {planned} planned, {actual} made"
PYTHON

# --- nothing changed: nothing to do
pipeline first
grep -q "Nothing to be done" "$temporary/first.log" || fail "a second run did something: $(grep -E '^rule|^    rule' "$temporary/first.log")"

# --- one shard gone: it is made again, to the same bytes, and the other shards are left alone
shard=$out/dataset/training/house_1.0.h5
before=$(sha256sum "$out"/dataset/*/*.h5 "$out/basis.h5")
ages=$(stat -c '%n %Y %Z' "$out"/dataset/*/*.h5 | grep -v house_1)
rm "$shard"
# snakemake does not miss what nothing that is out of date needs: the shard is asked for by name
pipeline first "$shard" "$out/basis.h5"
[ "$(grep -c '^rule datagen:' "$temporary/first.log")" = 1 ] || fail "one shard was missing, not as many made: $(cat "$temporary/first.log")"
[ "$(stat -c '%n %Y %Z' "$out"/dataset/*/*.h5 | grep -v house_1)" = "$ages" ] || fail "a shard was made again that was still there"
grep -q '^rule pca:' "$temporary/first.log" || fail "the basis depends on the shard and was not made again"
[ "$(sha256sum "$out"/dataset/*/*.h5 "$out/basis.h5")" = "$before" ] || fail "the same seeds gave other bytes"

echo "smoke test: all holds"

#!/usr/bin/env bash
# Measures every figure that the documentation publishes at one clean revision, in a checkout of its own, on an idle machine.
#
#   docs/figures/measure.sh [PART …]     functions bakes light views reliability cycles; none: all of them
#   docs/figures/measure.sh collect      what is there → docs/results and every text (results.py)
#
# The first part checks the present commit out into out/release/source and builds it there; all later parts are of that revision, whatever
# is edited here. What is measured is not measured again: a run that was stopped goes on, and parts may run on different days. On two cores
# some three hours.
# `git worktree remove --force out/release/source; rm -r out/release` begins anew.
# Needs Debian's packages of the levels (docs/guide/levels.md); cycles: blender.
set -euo pipefail
cd "$(dirname "$0")/../.."
root=$PWD/out/release source=$PWD/out/release/source
levels=${NLG_ARCHIVE_ROOT:-}/usr/share/games/openarena/baseoa
all_levels="aggressor am_galmevish2 am_spacecont am_thornish am_underworks2 ctf_gate1 ctf_inyard czest1dm dm6ish hydronex2 islanddm kaos2 mlca1
  oa_bases7 oa_dm1 oa_dm5 oa_koth1 oa_minia oa_rpg3dm2 oa_thor oacmpctf3 oacmpdm1 oacmpdm3 wrackdm17"
lit="kaos2 aggressor oa_dm1 oa_dm5 oa_minia house:3 house:5 apartment:3 apartment:4 clutter:2 kitchen:0 meeting:0 daylight:0 daylight:2
  daylight:4 daylight:6 cornell:0 two_rooms:0 two_rooms:1"
default=weights/tent_mlp4.safetensors

case ${1:-} in -h | --help) sed -n '2,12s/^# \{0,1\}//p' "$0"; exit 0 ;; esac
parts=("$@")
[ $# -gt 0 ] || parts=(functions bakes light views reliability cycles)
for part in "${parts[@]}"; do
  case $part in
    functions | bakes | light | views | reliability | cycles) ;;
    collect) [ "${parts[*]}" = collect ] || { echo "measure.sh: collect cannot be combined with parts: it comes when they are done" >&2; exit 2; } ;;
    *) echo "measure.sh: expected functions, bakes, light, views, reliability, cycles or collect, got '$part'" >&2; exit 2 ;;
  esac
done

if [ "${parts[*]}" = collect ]; then
  run=$root/openarena
  [ ! -f "$run/evaluation/summary.json" ] || /usr/bin/python3 docs/figures/results.py collect "$run" --config configs/openarena.yaml --made-by "docs/figures/measure.sh functions bakes"
  [ ! -d "$root/light" ] || /usr/bin/python3 docs/figures/results.py collect-light "$root/light"
  [ ! -f "$root/fault_injection/table.json" ] || /usr/bin/python3 docs/figures/results.py collect-fault-injection "$root/fault_injection"
  [ ! -d "$root/cycles" ] || /usr/bin/python3 docs/figures/results.py collect-cycles "$root/cycles"
  exit 0
fi

if [ ! -d "$source" ]; then
  [ -z "$(git status --porcelain)" ] || { echo "measure.sh: expected a tree without changes: figures carry its revision" >&2; exit 2; }
  git worktree prune
  git worktree add --detach "$source" HEAD
fi
cd "$source"
source workflow/setup.sh
source workflow/environment.sh
install_packages train pipeline tests
build "train tests" nlg-bake nlg-datagen nlg-validate nlg-render nlg-pca nlg-cache nlg-train nlg-export bench_runtime_eval bench_libtorch
bin=$source/build/release/bin
mkdir -p "$root/openarena"
simd=$(grep -qw avx512f /proc/cpuinfo && echo AVX-512 || echo AVX2)
# a level without its game's images and scripts has other light, and says so in one line only
for archive in pak0.pk3 pak1-maps.pk3 pak4-textures.pk3 pak6-patch085.pk3 pak6-patch088.pk3 z_oacmp-volume1-v3.pk3; do
  [ -f "$levels/$archive" ] || { echo "measure.sh: $levels/$archive: expected Debian's openarena-data openarena-088-data openarena-oacmp1, got no such file" >&2; exit 2; }
done
machine="$(sed -n '0,/^model name/s/^model name[^:]*: //p' /proc/cpuinfo), $simd, $(nproc) cores"
[ -f "$root/openarena/machine.txt" ] || echo "$machine" > "$root/openarena/machine.txt"
known=$(cat "$root/openarena/machine.txt")
[ "$known" = "$machine" ] || { echo "measure.sh: expected the machine that measured the other parts, $known, got $machine" >&2; exit 2; }
echo "measuring $(git describe --always --dirty --abbrev=12)"

# made FILE COMMAND …: runs it where the file is missing; tools write files whole or not at all
made() {
  local file=$1
  shift
  [ ! -s "$file" ] || return 0
  mkdir -p "$(dirname "$file")"
  echo "$(date +%T) $file"
  "$@" > "$file.log" 2>&1 || { tail -3 "$file.log" >&2; return 1; }
}

# A level of the packages, or a procedural scene.
scene() { case $1 in *:*) echo "$1" ;; *) echo "$levels:$1" ;; esac; }

benchmark() {
  made "$1.json" sh -c '"$2" --benchmark_repetitions=7 --benchmark_report_aggregates_only=true --benchmark_out_format=json --benchmark_out="$1.new" &&
    mv "$1.new" "$1"' sh "$1.json" "$bin/$2"
}

functions() {
  local run=$root/openarena config=$root/openarena.yaml shards
  # as many of each scene: no figure of a scene is that of one large level
  sed 's/max_functions: [0-9]*/max_functions: 150/' configs/openarena.yaml > "$config"
  # the names that the rules have
  export NLG_OUT=$source/out
  shards=$(PYTHONPATH=workflow:. /usr/bin/python3 -c 'import sys, configuration; print(*configuration.load(sys.argv[1]).shards("evaluation"))' "$config")
  # shellcheck disable=SC2086
  NLG_BIN=$bin /usr/bin/snakemake -s workflow/Snakefile --config file="$config" --cores "$(nproc)" --nolock --quiet --allowed-rules datagen -- $shards
  # shellcheck disable=SC2086
  made "$run/evaluation/summary.json" "$bin/nlg-validate" --config "$config" --weights weights/*.safetensors --held-out $shards --out "$run/evaluation"
  # shellcheck disable=SC2086
  made "$run/evaluation/frontier.json" "$bin/nlg-validate" frontier --config "$config" --weights weights/*.safetensors --held-out $shards --out "$run/evaluation"
  made "$run/stability.json" sh -c '"$1" stability --weights weights/*.safetensors --out "$2/stability.json" || [ $? = 6 ]' sh "$bin/nlg-validate" "$run"
  benchmark "$run/benchmarks/runtime_eval" bench_runtime_eval
  benchmark "$run/benchmarks/libtorch" bench_libtorch
  mkdir -p "$root/light"
  ln -sfn ../openarena/benchmarks "$root/light/benchmarks"
}

bakes() {
  local level
  mkdir -p "$root/grids"
  for level in $all_levels; do
    made "$root/openarena/bakes/$level.json" "$bin/nlg-bake" "$(scene "$level")" --threads 1 --out "$root/grids/$level.safetensors" \
      --json "$root/openarena/bakes/$level.json"
  done
  made "$root/light/bakes/kaos2.json" "$bin/nlg-bake" "$(scene kaos2)" --out "$root/grids/kaos2.whole.safetensors" --json "$root/light/bakes/kaos2.json"
}

light() {
  local name file direct
  for direct in all reflected; do
    for name in $lit; do
      # of indirect light: without the largest levels, and without boxes that a lamp alone lights
      [[ $direct = all || " kaos2 oa_dm1 cornell:0 two_rooms:0 two_rooms:1 " != *" $name "* ]] || continue
      file=$root/light/$([ "$direct" = all ] || echo indirect/)${name//:/_}.json
      made "$file" "$bin/nlg-validate" light "$(scene "$name")" --weights "$default" --spacings 1 2 --grid-spacings 1.4 2.8 --thin-errors .03 .06 .1 \
        --light-direct "$direct" --out "$file"
    done
  done
}

views() {
  local name seed file
  # a wall may be lucky with one offset of the lattice: three of them, for all methods alike
  for seed in 1 2 3; do
    for name in $lit; do
      mkdir -p "$root/truth/${name//:/_}"
      file=$root/light/views/${name//:/_}_$seed.json
      made "$file" "$bin/nlg-validate" views "$(scene "$name")" --seed "$seed" --weights "$default" --target-functions \
        --truth "$root/truth/${name//:/_}" --out "$file" $([ "$seed" != 1 ] || echo --pictures "$root/pictures")
    done
  done
}

reliability() {
  build "train tests"
  made "$root/fault_injection/table.json" sh -c 'tests/fault_injection/run.py --seed 1 --kills 300 --errors 500 --damage 3000 --scenes 400 --jobs 2 --out "$1" || [ $? = 6 ]' \
    sh "$root/fault_injection"
}

cycles() { made "$root/cycles/sum.result.json" docs/figures/cycles/compare.py --bin "$bin" --out "$root/cycles"; }

for part in "${parts[@]}"; do "$part"; done

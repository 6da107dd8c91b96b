#!/usr/bin/env bash
# Installs what is missing, builds, and runs the whole pipeline: levels → data set → generators → report.
#
#   ./pipeline.sh [OPTION ...] [CONFIG] [LEVELS]
#
# CONFIG     a configuration: pipeline.yaml (the default, where no LEVELS are named), configs/levels.yaml (where they are) or another
# LEVELS     a folder of your levels: .glb, .gltf, .obj, or a game's .pk3. By configs/levels.yaml one in six is held out, and results
#            go to out/NAME, the folder's name
# --plan     only say what the run will take, stage by stage
# --set SECTION.KEY=VALUE   over the configuration, as often as you like: --set train.steps=8000. Several values, train.steps=4000,8000,
#                           here or as a list in the configuration, are as many runs, which are then compared
# --bin FOLDER              the tools that are there (or NLG_BIN=FOLDER): nothing is installed or built
# --profile FOLDER          a profile of snakemake's that runs the stages elsewhere; configs/profiles/slurm: as jobs of Slurm
# --prune                   remove shards in the folder of the run's data that are of no run
# A run that was stopped goes on where it was when it is started again. Exit codes: 2 a configuration or option that cannot be used,
# or another run at work; 3 a file that cannot be judged; 5 results that cannot be written; 6 the report is there, and a stability case
# in it does not hold; 130 stopped by Ctrl-C, 143 by SIGTERM; 1 everything else, a tool that failed among it, whose line says why.
set -euo pipefail
# Ctrl-C and SIGTERM, heard here alone: an interpreter that is still importing would show a traceback, or miss it
runner=''
# The processes that one started, and theirs.
descendants() {
  local child
  for child in $(cat "/proc/$1/task/"*/children 2> /dev/null); do echo "$child"; descendants "$child"; done
}
stop() {
  trap '' INT TERM
  # its tools hear Ctrl-C themselves, but not a signal to this process alone; snakemake would wait for them
  while [ -n "$runner" ] && kill -INT "$runner" 2> /dev/null; do
    sleep .2
    # shellcheck disable=SC2046
    kill -TERM $(descendants "$runner") 2> /dev/null || true
  done
  echo "pipeline.sh: stopped; the same command goes on" >&2
  exit "$1"
}
trap 'stop 130' INT
trap 'stop 143' TERM
python() { (trap '' INT; exec /usr/bin/python3 "$@"); }

refuse() {
  echo "pipeline.sh: $*; ./pipeline.sh --help lists the options" >&2
  exit 2
}

plan='' profile='' prune='' changes=() sets=() names=()
while [ $# -gt 0 ]; do
  case $1 in
    -h | --help) sed -n '2,18s/^# \{0,1\}//p' "$0"; exit 0 ;;
    --plan) plan=yes; shift ;;
    --prune) prune=--prune; shift ;;
    --set)
      [ $# -ge 2 ] || refuse "--set: expected SECTION.KEY=VALUE, got nothing"
      sets+=("--set=$2")
      shift 2
      ;;
    --set=*) sets+=("$1"); shift ;;
    --bin)
      [ -d "${2:-}" ] || refuse "--bin: expected a folder of tools, got ${2:-none}"
      NLG_BIN=$2
      shift 2
      ;;
    --profile)
      [ -f "${2:-}/config.yaml" ] || refuse "--profile: expected a folder with a config.yaml, got ${2:-none}"
      # from this folder; snakemake does not quote the paths of a profile's scripts
      profile=$(realpath --relative-base="$(dirname "$0")" -- "$2")
      [[ $profile != *[[:space:]]* ]] || refuse "--profile: expected a path without blanks, got $profile"
      shift 2
      ;;
    --) shift; break ;;
    -*) refuse "unknown option $1" ;;
    *) names+=("$1"); shift ;;
  esac
done
set -- "${names[@]}" "$@"
[ $# -le 2 ] || refuse "expected at most a configuration and a folder of levels, got $# arguments"
[ -n "${1-pipeline.yaml}" ] || refuse "expected a configuration, got an empty name"
[ ! -d "${1:-}" ] || set -- "$(dirname "$0")/configs/levels.yaml" "$@"
[ $# -le 2 ] || refuse "expected at most a configuration and a folder of levels, got two folders"
config=$(realpath -m -- "${1:-$(dirname "$0")/pipeline.yaml}")
[ -f "$config" ] || { echo "pipeline.sh: $config: expected a configuration file or a folder of levels, got neither" >&2; exit 2; }
levels=()
if [ $# -ge 2 ]; then
  [ -d "$2" ] || { echo "pipeline.sh: $2: expected a folder of levels, got none" >&2; exit 2; }
  levels=("$(realpath -- "$2")")
fi
changes=("${sets[@]}" ${levels[@]:+--levels "${levels[@]}"})
# a package has its tools beside this script, and builds nothing
[ -n "${NLG_BIN:-}" ] || [ -f "$(dirname "$0")/CMakeLists.txt" ] || NLG_BIN=$(dirname "$0")/bin
if [ -n "${NLG_BIN:-}" ]; then
  [ -d "$NLG_BIN" ] || refuse "NLG_BIN: expected a folder of tools, got $NLG_BIN"
  NLG_BIN=$(realpath -- "$NLG_BIN")
  export NLG_BIN
  # nothing is installed here: what runs the stages must be there
  [ -n "$plan" ] || [ -x /usr/bin/snakemake ] || refuse "snakemake: expected at /usr/bin/snakemake, got none; apt-get install snakemake"
fi

cd "$(dirname "$0")"
source workflow/setup.sh
if [ -z "${NLG_BIN:-}" ]; then
  mkdir -p build
  # a plan takes nlg-datagen alone
  if [ -n "$plan" ]; then install_packages pipeline; else install_packages train pipeline; fi
fi
# several values of a setting: as many runs, one after the other
sweep=$(python workflow/configuration.py "$config" "${changes[@]}" --sweep)
if [ -n "$sweep" ]; then
  folders=() worst=0
  trap : INT  # the run that is stopped says so
  while IFS=$'\t' read -r -u 3 folder settings; do
    IFS=$'\t' read -r -a settings <<< "$settings"
    echo "pipeline.sh: ${settings[*]}" >&2
    code=0
    ./pipeline.sh ${plan:+--plan} $prune ${profile:+--profile "$profile"} "${sets[@]}" "${settings[@]}" "$config" "${levels[@]}" || code=$?
    [ "$code" = 0 ] || [ "$code" = 6 ] || exit "$code"
    [ "$code" = 0 ] || worst=$code
    folders+=("$folder")
  done 3<<< "$sweep"
  # what is worse in one of them is what the sweep asks for
  [ -n "$plan" ] || validate/report/compare.py "${folders[@]}" || [ $? = 6 ]
  exit "$worst"
fi
# judged before anything is built, made or moved
judged=$(python workflow/configuration.py "$config" "${changes[@]}")
mapfile -t judged <<< "$judged"
run=${judged[0]} data=${judged[3]}
purpose=train
read -r -a tools <<< "${judged[1]}"
[ -z "$plan" ] || { purpose='' tools=(nlg-datagen); }
if [ -n "${NLG_BIN:-}" ]; then
  for tool in "${tools[@]}"; do
    [ -x "$NLG_BIN/$tool" ] || refuse "NLG_BIN: expected $tool in $NLG_BIN, which the run will need, got none"
  done
else
  build "$purpose" "${tools[@]}"
fi
python workflow/copies.py "$config" "${changes[@]}" --bin "${NLG_BIN:-build/release/bin}"
if [ -n "$plan" ]; then
  python workflow/plan.py "$config" "${changes[@]}" --bin "${NLG_BIN:-build/release/bin}"
  exit
fi
mkdir -p "$run" "$data" 2> /dev/null || { echo "pipeline.sh: $run: cannot be written: no folder can be made there" >&2; exit 5; }
for lock in "$run/.lock" "$run/.jobs.lock" "$data/.lock" "$data/.jobs.lock"; do
  # a pipe would keep everybody waiting who asks for it
  if [ -e "$lock" ] && [ ! -f "$lock" ]; then echo "pipeline.sh: $lock: expected a regular file, got something else" >&2; exit 2; fi
done
# Our own locks instead of snakemake's, which outlives a killed run. They belong to the results, whatever checkout works on them: one is
# held by the run, the other by every job for as long as it lives (workflow/Snakefile), so that a tool which outlives its killed run
# still keeps others away.
exec 9>> "$run/.lock" || exit 5
flock -n 9 || { echo "pipeline.sh: $run: another run is at work there" >&2; exit 2; }
if [ "$data" != "$run" ]; then
  exec 8>> "$data/.lock" || exit 5
  flock -n 8 || { echo "pipeline.sh: $data: another run is at work there" >&2; exit 2; }
fi
if [ ${#changes[@]} -gt 0 ]; then
  python workflow/configuration.py "$config" "${changes[@]}" --write > /dev/null
  config=$(realpath -- "${judged[2]}")
fi
run_folder=$(realpath -m -- "$run")
export NLG_PLAN=$run_folder/plan.json
# a batch system's jobs wait in its queue: their times are not those of the stages
[ -n "$profile" ] || export NLG_TIMES=$run_folder/times.json
python workflow/plan.py "$config" --bin "${NLG_BIN:-build/release/bin}" --out "$NLG_PLAN" ||
  echo "pipeline.sh: the run goes on without a plan" >&2
# what does the work: all cores of this machine, or what a profile says
where=(--cores "$(nproc)")
if [ -n "$profile" ]; then
  where=(--profile "$profile")
  [ ! -x "$profile/before.sh" ] || "$profile/before.sh" "$run"
fi
for folder in "$run" "$data"; do
  flock -n "$folder/.jobs.lock" true || { echo "pipeline.sh: $folder: a tool of a run that was killed is still at work there" >&2; exit 2; }
done
# what is another file than the run made is put aside
python workflow/check_artefacts.py "$config" "${NLG_BIN:-build/release/bin}" $prune
# what it keeps for itself lies in the run's folder; a profile's scripts are told from here
[ -n "$profile" ] || where+=(--directory "$run")
rm -rf "$run/.progress"
/usr/bin/snakemake all -s workflow/Snakefile --configfile "$config" "${where[@]}" --rerun-incomplete --nolock \
  --log-handler-script "$PWD/workflow/run_progress.py" &
runner=$!
wait "$runner"
runner=''
# snakemake takes it away after the last training, and forgets it where it was killed just then
rm -f "$run/training/functions.cache"* "$data/training/functions.cache"*  # with what a killed run left of it
# the headline, what each generator was judged by, and the rule
cat "$run/verdict.txt"
echo "The report: $(realpath "$run/report.html")"
[ ! -e "$run/evaluation/report.html" ] || echo "… of the evaluation: $(realpath "$run/evaluation/report.html")"
code=0
failed=$(python workflow/failed_cases.py "$run/stability.json") || code=$?
[ "$code" != 6 ] || printf 'pipeline.sh: stability cases that do not hold:\n%s\n' "$failed" >&2
exit "$code"

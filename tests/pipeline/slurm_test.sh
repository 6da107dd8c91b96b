#!/usr/bin/env bash
# The whole chain as jobs of a real Slurm on this machine: the same bytes as without, also when jobs, the run itself and the node are
# killed on the way; training by srun.
#
#   slurm_test.sh BIN_FOLDER short|whole          (from the source folder)
#
# The short form makes shards and a basis as jobs, and kills nothing.
#
# munged, slurmctld and slurmd have their keys, sockets, ports and files in a temporary folder: nothing of the system is touched, and
# another Slurm here is none of our business.
set -euo pipefail

skip() {
  echo "skipped: $*"
  exit 77
}

[ "$(id -u)" = 0 ] || skip "slurmd runs jobs as root alone"
for tool in munged slurmctld slurmd sbatch srun; do
  command -v "$tool" > /dev/null || skip "no $tool: packages munge, slurmctld, slurmd and slurm-client"
done

NLG_BIN=$(realpath "$1")
form=$2
source=$PWD
slower=${NLG_TEST_TIMEOUT_FACTOR:-1}
temporary=$(mktemp -d)
# munged wants a way to its socket that all can go
chmod 755 "$temporary"
# of a Slurm that this test itself is a job of
unset "${!SLURM_@}" "${!SBATCH_@}" "${!SRUN_@}"
# every process of the test has this in its environment, whoever its parent is: so the test knows its own
SLURM_CONF=$temporary/slurm.conf

own_processes() {
  local folder
  for folder in /proc/[0-9]*; do
    [ "${folder#/proc/}" = $$ ] || ! grep -qszx "SLURM_CONF=$SLURM_CONF" "$folder/environ" || echo "${folder#/proc/}"
  done
}

# what jobs are made of
job_processes() {
  local process
  for process in $(own_processes); do
    ! grep -qsz "^SLURM_JOB_ID=" "/proc/$process/environ" && ! grep -qs "^slurmstepd" "/proc/$process/comm" || echo "$process"
  done
}

clean_up() {
  local processes
  for _ in {1..50}; do
    processes=$(own_processes)
    [ -n "$processes" ] || break
    # shellcheck disable=SC2086
    kill -9 $processes 2> /dev/null || true
    sleep 0.1
  done
  rm -rf "$temporary"
}
trap clean_up EXIT
trap 'exit 1' INT TERM
# also when this shell is killed outright, by the time limit of ctest for instance
(setsid bash -c "$(declare -f own_processes clean_up)
  SLURM_CONF=$SLURM_CONF temporary=$temporary
  while kill -0 $$ 2> /dev/null; do sleep 1; done; clean_up" > /dev/null 2>&1 &)

export NLG_BIN SLURM_CONF
# snakemake asks for its jobs every second then, not every ten
export CI=true

fail() {
  echo "FAILED: $*" >&2
  tail -n 15 "$temporary"/*.log 2> /dev/null | cut -c 1-300 >&2
  tail -n 4 .snakemake/slurm/*.log 2> /dev/null | cut -c 1-300 >&2
  exit 1
}

# waits until a command holds, at most $1 seconds, and no longer than the run that it is waited for in
driver=
wait_for() {
  local deadline=$((SECONDS + $1 * slower))
  shift
  until "$@" > /dev/null 2>&1; do
    [ -z "$driver" ] || kill -0 "$driver" 2> /dev/null || fail "the run has ended, which was to come to: $*"
    [ "$SECONDS" -lt "$deadline" ] || fail "waited in vain for: $*"
    sleep 0.1
  done
}

start_slurm() {
  local ports
  ports=$(/usr/bin/python3 -c '
import socket
sockets = [socket.socket() for _ in range(2)]
for one in sockets:
    one.bind(("127.0.0.1", 0))
print(*[one.getsockname()[1] for one in sockets])')
  head -c 128 /dev/urandom > "$temporary/munge.key"
  chmod 400 "$temporary/munge.key"
  mkdir "$temporary/state" "$temporary/spool"
  # the node claims what our jobs ask for: this test measures nothing. Sanitizers take longer than the jobs' limits, which are the plan's
  cat > "$SLURM_CONF" << CONF
ClusterName=test
SlurmctldHost=localhost
SlurmUser=root
AuthType=auth/munge
AuthInfo=socket=$temporary/munge.socket
CryptoType=crypto/munge
SlurmctldPort=${ports% *}
SlurmdPort=${ports#* }
SlurmctldPidFile=$temporary/slurmctld.pid
SlurmdPidFile=$temporary/slurmd.pid
SlurmctldLogFile=$temporary/slurmctld.log
SlurmdLogFile=$temporary/slurmd.log
StateSaveLocation=$temporary/state
SlurmdSpoolDir=$temporary/spool
MailProg=/bin/true
ProctrackType=proctrack/linuxproc
TaskPlugin=task/none
JobAcctGatherType=jobacct_gather/none
SelectType=select/cons_tres
SelectTypeParameters=CR_Core_Memory
SlurmdParameters=config_overrides
SchedulerParameters=batch_sched_delay=0,sched_interval=1,sched_min_interval=100000
KillWait=2
OverTimeLimit=$((5 * (slower - 1)))
ReturnToService=2
NodeName=node NodeAddr=127.0.0.1 NodeHostname=localhost CPUs=4 RealMemory=64000
PartitionName=all Nodes=node Default=YES State=UP
CONF
  echo "CgroupPlugin=cgroup/v1" > "$temporary/cgroup.conf"
  munged --key-file="$temporary/munge.key" --socket="$temporary/munge.socket" --pid-file="$temporary/munged.pid" \
    --log-file="$temporary/munged.log" --seed-file="$temporary/munged.seed"
  slurmctld -f "$SLURM_CONF"
  start_node
  wait_for 20 node_is idle
}

start_node() { slurmd -f "$SLURM_CONF" -N node; }
node_is() { [ "$(sinfo --noheader --format=%T)" = "$1" ]; }
runs() { [ -n "$(squeue --noheader --states=RUNNING --name="$1")" ]; }
# … and has come so far as its tool
works() { [ -n "$(job_processes | sed 's|.*|/proc/&/comm|' | xargs -r grep -lsx "$1")" ]; }
queue_is_empty() { [ -z "$(squeue --noheader)" ]; }

# a folder of our own to run in: snakemake's records and the jobs' logs lie where it runs
mkdir "$temporary/checkout"
ln -s "$source"/{workflow,configs,tool,validate,pipeline.yaml} "$temporary/checkout/"
cd "$temporary/checkout"

# --- every stage on less than next to nothing
/usr/bin/python3 - configs/smoke.yaml "$temporary" << 'PYTHON'
import sys

import yaml

config = yaml.safe_load(open(sys.argv[1]))
config["scenes"]["per_family"] = 2
config["split"]["held_out"] = ["*_1"]
config["representations"] = ["tent_mlp"]
config["datagen"]["max_functions"] = 60
config["basis"]["components"] = 32
config["train"].update(steps=200, batch=16, checkpoint_steps=10)
config["bake"]["spacing_m"] = 3.0
config["validate"].update(direct_functions=2, direct_adam_steps=50)
config["frontier"].update(functions=2, repeats=1)
config["report"].update(savings=["clutter_1"])
config["validate_light"].update(air_samples=16, surface_samples=16, walks=1, truth_rays=16, probe_rays=16)
yaml.safe_dump(config, open(sys.argv[2] + "/run.yaml", "w"))
# two processes, and no exact last layers, which would make rounding larger: docs/guide/training.md
config["train"].update(steps=40, batch=8, exact_last_layer=False, processes=2)
yaml.safe_dump(config, open(sys.argv[2] + "/together.yaml", "w"))
PYTHON

# runs the workflow of configuration $2 into the folder $1; the rest goes to snakemake, files to make first: what a profile holds is
# appended, and would be files behind a "--"
workflow() {
  local folder=$1 config=$2
  shift 2
  NLG_OUT=$temporary/$folder exec /usr/bin/snakemake "$@" -s workflow/Snakefile --configfile "$temporary/$config.yaml" --nolock \
    --rerun-incomplete --log-handler-script workflow/run_progress.py
}
# … as jobs of Slurm, as pipeline.sh does
by_slurm() { workflow "$@" --profile configs/profiles/slurm --cores 2 --group-components shards=3 --latency-wait 10; }

local_run=$temporary/local/smoke run=$temporary/slurm/smoke
results=(basis.h5)
[ "$form" = short ] || results=(weights/tent_mlp.safetensors validation/functions.csv light/two_rooms_0.json)
(workflow local run "${results[@]/#/$local_run/}" --cores 2) > "$temporary/local.log" 2>&1 || fail "the run without Slurm"
start_slurm

# the files of the run without Slurm: every one that has the same bytes
compared=0
compare() {
  local file
  while read -r file; do
    case $file in
      # validations that come faster than pictures have none
      training/*/worst-*.png) continue ;;
      # the times at which rows of the curve came
      training/*/events.out.tfevents.*) continue ;;
      # times stand in them
      .origins/* | .snakemake/* | training/*.json | light/*.json | */.snakemake_timestamp | validation/summary.json | validation/functions.csv) continue ;;
    esac
    cmp "$local_run/$file" "$run/$file" || fail "$file has other bytes than without Slurm"
    compared=$((compared + 1))
  done < <(cd "$local_run" && find . -type f -printf '%P\n')
  [ "$(find .snakemake/slurm -name '*.log' -exec grep -l '^rule datagen:' {} + | wc -l)" = 2 ] || fail "four shards, three a job, were not made by two jobs"
}
nothing_is_left() {
  queue_is_empty || fail "jobs are left: $(squeue)"
  [ -z "$(job_processes)" ] || fail "processes of jobs are left: $(job_processes)"
  echo "slurm test, $form: all holds"
}

if [ "$form" = short ]; then
  (by_slurm slurm run "$run/basis.h5") > "$temporary/short.log" 2>&1 || fail "shards and basis as jobs"
  compare
  [ "$compared" -ge 5 ] || fail "only $compared files were compared"
  nothing_is_left
  exit 0
fi

# --- a run that is killed leaves its jobs behind; the next one takes them out of the queue first
by_slurm slurm run > "$temporary/killed.log" 2>&1 &
driver=$!
wait_for 300 runs nlg-train
kill -9 "$driver"
wait "$driver" 2> /dev/null || true
configs/profiles/slurm/before.sh "$run" 2> "$temporary/before.log"
queue_is_empty || fail "jobs of a killed run are in the queue: $(squeue)"
grep -q "Cancelling jobs" "$temporary/before.log" || fail "the killed run had no jobs: nothing was tested"

# --- slurmd is killed and comes back; then the whole node goes, with all that works on it
by_slurm slurm run > "$temporary/slurm.log" 2>&1 &
driver=$!
wait_for 300 works nlg-train
kill -9 "$(cat "$temporary/slurmd.pid")"
start_node
wait_for 300 runs nlg-stability
# shellcheck disable=SC2046
kill -9 "$(cat "$temporary/slurmd.pid")" $(job_processes)
# the controller would find out within minutes
scontrol update NodeName=node State=DOWN Reason=dead
wait_for 300 grep -q "NODE_FAIL" "$temporary/slurm.log"
start_node
wait "$driver" || fail "the run did not survive its node"

# --- the same bytes as without
compare
[ "$compared" -gt 20 ] || fail "only $compared files were compared"
for file in report.html stability.json savings/clutter_1.json validation/frontier.json; do [ -s "$run/$file" ] || fail "no $file"; done
[ ! -e "$run/training/functions.cache" ] || fail "the cache was kept"

# --- two processes by srun train what one does: the sums of floats differ in their order, 1e-7 of the gradient a step, printed with six digits
mkdir -p "$temporary/together/smoke"
cp -a "$run/dataset" "$run/basis.h5" "$run/basis.json" "$temporary/together/smoke/"
(by_slurm together together "$temporary/together/smoke/training/tent_mlp.ckpt" --notemp) > "$temporary/together.log" 2>&1 || fail "two processes by srun"
OPENBLAS_NUM_THREADS=1 "$NLG_BIN/nlg-train" --config "$temporary/together.yaml" --processes 1 --representation tent_mlp --basis "$run/basis.h5" \
  --cache "$temporary/together/smoke/training/functions.cache" --held-out "$run"/dataset/held_out/*.h5 --out "$temporary/one.ckpt" --run "$temporary/one" --log "$temporary/one.csv" > /dev/null
/usr/bin/python3 - "$temporary/one.csv" "$temporary/together/smoke/training/tent_mlp.csv" << 'PYTHON'
import csv, sys

one, two = (list(csv.DictReader(open(path))) for path in sys.argv[1:])
assert [row["step"] for row in one] == [row["step"] for row in two] and len(one) > 2, (one, two)
for key in ["training_loss", "held_out_blend_rmse"]:
    off = max(abs(float(a[key]) - float(b[key])) / float(b[key]) for a, b in zip(one, two))
    assert off <= 2e-4, f"{key} of two processes is off by a share of {off}"
PYTHON
grep -q '"processes": 2' "$temporary/together/smoke/training/tent_mlp/config.json" || fail "one process trained, not two"
grep -q "launch task" "$temporary/slurmd.log" || fail "the two were not started by srun"
[ -z "$(find "$temporary/together" -name 'meeting.*')" ] || fail "the file of their meeting was left"

# --- nothing is left at work
nothing_is_left

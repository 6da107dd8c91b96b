#!/usr/bin/env bash
# What has become of a Slurm job, in snakemake's words: running, success or failed. Asks the controller, no database; the controller
# forgets a job some minutes after its end (MinJobAge), and then the job's own log knows (jobscript.sh).
#
#   status.sh JOB          (from the folder of the checkout)
set -euo pipefail
# an interrupt is for snakemake, which cancels its jobs then: this answer must not look like a failure
trap '' INT

job=$1
log=.snakemake/slurm/$job.log

# one line on stderr, and what the tools said
failed() {
  if [ ! -f "$log" ]; then
    echo "slurm job $job: $1" >&2
  else
    echo "slurm job $job: $1; its log: $log" >&2
    grep -E '^(nlg-[a-z]+[a-z ]*|[a-z_]+\.py|slurmstepd|srun): ' "$log" | tail -n 5 >&2 || true
  fi
  echo failed
  exit 0
}

if ! shown=$(timeout 30 scontrol --oneliner show job "$job" 2>&1); then
  case $shown in
    *"Invalid job id"*) ;;
    # the controller is away, or too busy: jobs do not end by that
    *) echo running; exit 0 ;;
  esac
  # Slurm may have had a word of its own after it
  tail -n 20 "$log" 2> /dev/null | grep -qxF "nlg: the job is done" || failed "forgotten by Slurm, and its log has no end"
  echo success
  exit 0
fi
state=$(sed -n 's/.* JobState=\([A-Z_]*\).*/\1/p' <<< "$shown")
reason=$(sed -n 's/.* Reason=\([A-Za-z_]*\).*/\1/p' <<< "$shown")
case $state:$reason in
  # it asks for what no node has, or more than the site allows: it would stay in the queue for ever
  PENDING:PartitionConfig | PENDING:PartitionTimeLimit | PENDING:PartitionNodeLimit | PENDING:BadConstraints | PENDING:InvalidAccount | PENDING:InvalidQOS)
    scancel "$job" || true
    failed "taken out of the queue, where it could never begin ($reason)"
    ;;
esac
case $state in
  COMPLETED) echo success ;;
  PENDING | CONFIGURING | RUNNING | COMPLETING | SUSPENDED | STOPPED | SIGNALING | STAGE_OUT | RESIZING | REQUEUED | REQUEUE_FED | REQUEUE_HOLD | RESV_DEL_HOLD | SPECIAL_EXIT)
    echo running ;;
  *) failed "$state" ;;
esac

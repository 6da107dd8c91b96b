#!/usr/bin/python3
"""How far a run is, from snakemake's events: lines of a pipe, the line of a terminal, the time left.

    progress_test.py      (from the source folder)
"""
import json
import os
import sys
import tempfile

sys.path.insert(0, "workflow")
from run_progress import RunProgress, Times  # noqa: E402
from tool.duration import duration  # noqa: E402

STATS = """Job stats:
job         count    min threads    max threads
--------  -------  -------------  -------------
all             1              1              1
datagen         3              1              1
train           1              2              2
total           5              1              2
"""
PLAN = {"configuration": "c", "stages": [{"name": "data set", "rule": "datagen", "jobs": 3, "core_s": 6.0, "cores": 1}, {"name": "train mlp", "rule": "train", "jobs": 1, "core_s": 100.0, "cores": 2}]}
failures = []


def check(holds, claim):
    if not holds:
        failures.append(claim)


class Run:
    """A run whose clock is set by hand."""

    def __init__(self, is_terminal, times=""):
        self.text, self.time_s = "", 100.0
        self.progress = RunProgress(self._write, is_terminal, lambda: self.time_s, cores=2, plan=PLAN, times=times)
        self.progress.take({"level": "run_info", "msg": STATS})

    def _write(self, text):
        self.text += text

    def begins(self, job, rule, **wildcards):
        self.progress.take({"level": "job_info", "jobid": job, "name": rule, "wildcards": wildcards, "threads": 2 if rule == "train" else 1})

    def ends(self, job):
        self.progress.take({"level": "job_finished", "jobid": job})


def check_pipe():
    run = Run(is_terminal=False)
    run.progress.take({"level": "info", "msg": "Select jobs to execute..."})
    for job in range(3):
        run.begins(job, "datagen", scene=f"house_{job}")
        run.time_s += 40
        run.ends(job)
    run.begins(3, "train", representation="mlp")
    run.time_s += 5
    run.progress.take({"level": "job_error", "jobid": 3, "name": "train", "output": ["mlp.ckpt"]})
    run.progress.take({"level": "error", "msg": "Exiting because a job execution failed."})
    check(run.text.splitlines() == ["[3/4] datagen: 3 jobs, 2 min 00 s", "[3/4] train failed: mlp.ckpt; its own line stands above",
                                    "Exiting because a job execution failed."], f"a pipe gets {run.text!r}")
    run = Run(is_terminal=False)
    for job in range(3):
        run.begins(job, "datagen", scene=f"house_{job}")
    run.progress.take({"level": "group_error", "groupid": "shards", "job_error_info": [{"name": "datagen", "jobid": job} for job in range(3)]})
    run.progress.take({"level": "info", "msg": "Trying to restart job shards."})
    check(run.text.splitlines() == ["[0/4] datagen failed: a job that made 3 of them; its own line stands above",
                                    "… and is tried once more, with more memory and time"], f"a group of jobs that failed: {run.text!r}")
    check(not run.progress.running, f"a group that failed is at work: {run.progress.running}")
    run = Run(is_terminal=False)
    run.progress.take({"level": "info", "msg": "Nothing to be done (all requested files are present and up to date)."})
    check(run.text.startswith("nothing to be done"), f"a run that is over says {run.text!r}")


def check_terminal():
    run = Run(is_terminal=True)
    run.begins(0, "datagen", scene="house_0", jitter=1)
    check("[0/4] 0 s: datagen house_0 1" in run.text and "left" not in run.text, f"before a job is done: {run.text!r}")
    run.time_s += 7
    run.ends(0)
    # two shards of 7 s on two cores where 2 s were planned, and a training that was planned to take 50 s
    left = run.progress.left_s()
    check(abs(left - (7 + 7 / 2 * 50)) < 1, f"after a shard: {left} s left")
    run.begins(1, "datagen", scene="house_1")
    run.begins(2, "datagen", scene="house_2")
    run.text = ""
    run.progress.tick()
    check("datagen house_1, datagen house_2" in run.text and "\n" not in run.text and run.text.startswith("\r"), f"two at work: {run.text!r}")
    run.ends(1)
    run.ends(2)
    run.begins(3, "train", representation="mlp")
    run.time_s += 1e6
    check(run.progress.left_s() == 0, f"longer than expected: {run.progress.left_s()} s left")
    run.text = ""
    run.ends(3)
    check(run.text.startswith("\r\033[K[4/4] train: ") and "\n\r\033[K[4/4]" in run.text, f"a stage that is over: {run.text!r}")


def check_times():
    """Times of a run that was stopped and goes on add up; those of another plan do not."""
    with tempfile.TemporaryDirectory() as folder:
        path = os.path.join(folder, "times.json")
        for job in range(2):
            run = Run(is_terminal=False, times=path)
            run.begins(job, "datagen", scene=f"house_{job}")
            run.time_s += 4
            run.ends(job)
        run.begins(3, "train", representation="mlp")
        run.time_s += 60
        run.ends(3)
        with open(path) as file:
            found = json.load(file)
        check(found == {"plan": "c", "stages": {"data set": {"jobs": 2, "seconds": 8.0}, "train mlp": {"jobs": 1, "seconds": 60.0}}}, f"times: {found}")
        check(Times(path, {**PLAN, "configuration": "d"}).stages == {}, "times of another plan")


def main():
    check(duration(59.4) == "59 s" and duration(61) == "1 min 01 s" and duration(3660) == "1 h 01 min", "durations")
    check_pipe()
    check_terminal()
    check_times()
    for failure in failures:
        print("FAILED:", failure)
    return 1 if failures else 0


if __name__ == "__main__":
    sys.exit(main())

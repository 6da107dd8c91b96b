#!/usr/bin/python3
"""How far a run is, from Snakemake's events: what failed, the time left, times that add up. The clock is set by hand.

    progress_test.py      (from the source folder)
"""
import json
import os
import sys
import tempfile
import threading
import unittest

sys.path.insert(0, "workflow")
from run_progress import RunProgress, Times  # noqa: E402

STATS = """Job stats:
job         count    min threads    max threads
--------  -------  -------------  -------------
all             1              1              1
datagen         3              1              1
train           1              2              2
total           5              1              2
"""
PLAN = {"configuration": "c", "clock_s": 60, "stages": [{"name": "data set", "rule": "datagen", "jobs": 3, "core_s": 6.0, "cores": 1}, {"name": "train mlp", "rule": "train", "jobs": 1, "core_s": 100.0, "cores": 2}]}


class Run:
    def __init__(self, is_terminal=False, times="", folder=""):
        self.text, self.time_s = "", 100.0
        self.progress = RunProgress(self._write, is_terminal, lambda: self.time_s, cores=2, plan=PLAN, times=times, folder=folder)
        self.progress.take({"level": "run_info", "msg": STATS})

    def _write(self, text):
        self.text += text

    def begins(self, job, rule, **wildcards):
        self.progress.take({"level": "job_info", "jobid": job, "name": rule, "wildcards": wildcards, "threads": 2 if rule == "train" else 1})

    def works(self, job, rule, seconds, **wildcards):
        self.begins(job, rule, **wildcards)
        self.time_s += seconds
        self.progress.take({"level": "job_finished", "jobid": job})


class Progress(unittest.TestCase):
    def test_a_log_gets_a_line_a_stage_and_what_failed(self):
        run = Run()
        for job in range(3):
            run.works(job, "datagen", 40, scene=f"house_{job}")
        run.begins(3, "train", representation="mlp")
        run.progress.take({"level": "job_error", "jobid": 3, "name": "train", "output": ["mlp.ckpt"]})
        self.assertEqual(run.text.splitlines(), ["[3/4] datagen: 3 jobs, 2 min 00 s", "[3/4] train failed: mlp.ckpt; what its tool said stands above"])

    def test_a_group_that_failed_is_no_longer_at_work(self):
        run = Run()
        for job in range(3):
            run.begins(job, "datagen", scene=f"house_{job}")
        run.progress.take({"level": "group_error", "groupid": "shards", "job_error_info": [{"name": "datagen", "jobid": job} for job in range(3)]})
        self.assertIn("datagen failed", run.text)
        self.assertFalse(run.progress.running)

    def test_a_log_hears_how_far_tools_are_and_that_a_plan_is_overrun_once(self):
        with tempfile.TemporaryDirectory() as folder:
            run = Run(folder=folder)
            run.works(0, "datagen", 40, scene="house_0")
            run.begins(3, "train", representation="mlp")
            with open(os.path.join(folder, "nlg-train.7"), "w") as file:
                file.write("nlg-train: steps: 3 of 9\n")
            for _ in range(2):
                run.progress.tick()
        lines = run.text.splitlines()
        self.assertEqual(sum("were planned; it will be about" in line for line in lines), 1)
        self.assertEqual([line for line in lines if "train mlp; nlg-train: steps: 3 of 9" in line], [lines[-2], lines[-1]])

    def test_a_level_that_is_gone_is_a_line(self):
        run = Run()
        run.progress.take({"level": "error", "msg": "WorkflowError:\nlevels/a.glb: is gone\n  File \"/checkout/workflow/origins.py\", line 3, in wait"})
        self.assertEqual(run.text, "levels/a.glb: is gone\n")

    def test_what_fails_after_ctrl_c_says_nothing(self):
        run = Run()
        run.begins(3, "train", representation="mlp")
        # the tool is gone before anybody is told why
        threading.Timer(0.2, run.progress.stopped.set).start()
        run.progress.take({"level": "job_error", "jobid": 3, "name": "train", "output": ["mlp.ckpt"]})
        self.assertEqual(run.text, "")

    def test_the_time_left_follows_what_jobs_took(self):
        run = Run(is_terminal=True)
        run.works(0, "datagen", 7, scene="house_0")
        # two shards of 7 s on two cores where 2 s were planned, and a training that was planned to take 50 s
        self.assertAlmostEqual(run.progress.left_s(), 7 + 7 / 4 * 52, delta=1)  # two seconds of each are its start
        for job in (1, 2):
            run.works(job, "datagen", 7, scene=f"house_{job}")
        run.begins(3, "train", representation="mlp")
        run.time_s += 1e6
        self.assertEqual(run.progress.left_s(), 0)

    def test_times_of_a_run_that_goes_on_add_up(self):
        with tempfile.TemporaryDirectory() as folder:
            path = os.path.join(folder, "times.json")
            for job in range(2):
                run = Run(times=path)
                run.works(job, "datagen", 4, scene=f"house_{job}")
            run.works(3, "train", 60, representation="mlp")
            with open(path) as file:
                self.assertEqual(json.load(file), {"plan": "c", "stages": {"data set": {"jobs": 2, "seconds": 8.0}, "train mlp": {"jobs": 1, "seconds": 60.0}}})
            self.assertEqual(Times(path, {**PLAN, "configuration": "d"}).stages, {})


if __name__ == "__main__":
    unittest.main()

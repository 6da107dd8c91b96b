"""How far a run of the workflow is: snakemake's log handler (--log-handler-script), in place of what it prints itself.

In a terminal one line that rewrites itself: jobs done of all, what is at work and how far its tools are, time left. Where stderr is a file or
a pipe it comes once a minute. Every stage that is over leaves one line with its time. Errors and warnings of snakemake are printed as they are.

NLG_PLAN names the run's plan (plan.py), by which jobs are weighed until one of their rule has shown what it takes here; beside it lies the
folder .progress, in which tools say how far they are (tool/progress.h). NLG_TIMES names the file in which the times of jobs are noted, for the
report.
"""
import json
import os
import re
import shutil
import signal
import sys
import threading
import time
from pathlib import Path

sys.path.insert(0, str(Path(__file__).resolve().parents[1]))  # tool/, which all scripts share
from tool.atomic_file import write_atomically
from tool.duration import duration
from tool.errors import OutputError

TYPICAL_S = 10  # of a job that no plan speaks of
START_S = 2     # of any job: its tool and its files
SLOWEST = 5     # times what was planned: small first jobs say little of the others
OVERRUN = 1.5    # times what was planned
# A signal to all processes of a run ends its tools at once; pipeline.sh, which hears it too, tells us a moment later that it was no failure.
STOP_IS_HEARD_S = 2


def read_json(path):
    """What a file of the run's own holds; nothing where there is none."""
    try:
        with open(path or "") as file:
            found = json.load(file)
        return found if isinstance(found, dict) else {}
    except (OSError, ValueError):
        return {}


def seconds_of_jobs(plan):
    """Rule → seconds of one of its jobs."""
    jobs, seconds = {}, {}
    for stage in plan.get("stages", []):
        jobs[stage["rule"]] = jobs.get(stage["rule"], 0) + stage["jobs"]
        seconds[stage["rule"]] = seconds.get(stage["rule"], 0) + stage["core_s"] / stage["cores"]
    return {rule: START_S + seconds[rule] / count for rule, count in jobs.items()}


class Times:
    """Jobs and their seconds of every stage, in a file: of all runs with one plan together."""

    def __init__(self, path, plan):
        self.path, self.plan = path, plan
        found = read_json(path)
        self.stages = found.get("stages", {}) if found.get("plan") == plan.get("configuration") else {}

    def add(self, rule, of, seconds):
        if not self.path:
            return
        name = next((stage["name"] for stage in self.plan.get("stages", []) if stage["rule"] == rule and (rule != "train" or stage["name"].endswith(f" {of}"))), rule)
        stage = self.stages.setdefault(name, {"jobs": 0, "seconds": 0.0})
        stage["jobs"] += 1
        stage["seconds"] += seconds
        try:
            write_atomically(self.path, json.dumps({"plan": self.plan.get("configuration"), "stages": self.stages}).encode())
        except (OSError, OutputError) as error:
            print(f"times of this run are not noted: {error}", file=sys.stderr)
            self.path = ""


class RunProgress:
    """Takes snakemake's events and says where the run stands.

    write      where text goes; is_terminal: whether a line can rewrite itself there
    now        the clock, in seconds
    plan       what plan.py wrote; times: where times are noted; folder: where tools say how far they are
    """

    def __init__(self, write, is_terminal, now=time.time, cores=os.cpu_count() or 1, plan=None, times="", folder=""):
        self.write, self.is_terminal, self.now, self.cores = write, is_terminal, now, cores
        self.lock = threading.Lock()
        self.started_s = now()
        self.planned = {}      # rule → how many jobs
        self.done = {}         # rule → how many of them are done
        self.spent_s = {}      # rule → seconds of its jobs, together
        self.first_s = {}      # rule → when its first job began
        self.threads = {}      # rule → cores that a job takes
        self.running = {}      # job → (rule, what it is of, when it began)
        self.has_line = False
        self.typical_s = seconds_of_jobs(plan or {})
        self.times = Times(times, plan or {})
        self.folder, self.planned_s = folder, (plan or {}).get("clock_s")
        self.stopped = threading.Event()  # by Ctrl-C or SIGTERM: what then fails says nothing

    def take(self, event):
        with self.lock:
            handle = getattr(self, f"_take_{event['level']}", None)
            if handle:
                handle(event)
                self._draw()

    def tick(self):
        with self.lock:
            left = self.left_s()
            if left is not None and self.planned_s and self.now() - self.started_s + left > OVERRUN * self.planned_s:
                self._print(f"{duration(self.planned_s)} were planned; it will be about {duration(self.now() - self.started_s + left)}")
                self.planned_s = None
            if self.is_terminal:
                self._draw()
            else:
                self._print(self.line())

    def _take_run_info(self, event):
        # snakemake's table of rules and their jobs; it comes again when jobs were added
        rows = re.findall(r"^(\w+)\s+(\d+)(?:\s+\d+)*\s*$", event["msg"] or "", flags=re.MULTILINE)
        self.planned = {rule: int(count) for rule, count in rows if rule not in ("total", "all")}

    def _take_job_info(self, event):
        rule, now = event["name"], self.now()
        if rule == "all":
            return
        self.first_s.setdefault(rule, now)
        self.threads[rule] = event.get("threads") or 1
        self.running[event["jobid"]] = (rule, " ".join(str(value) for value in dict(event.get("wildcards") or {}).values()), now)

    def _take_job_finished(self, event):
        if event["jobid"] not in self.running:
            return
        rule, of, began_s = self.running.pop(event["jobid"])
        self.done[rule] = self.done.get(rule, 0) + 1
        self.spent_s[rule] = self.spent_s.get(rule, 0) + self.now() - began_s
        self.times.add(rule, of, self.now() - began_s)
        if self.done[rule] == self.planned.get(rule):
            jobs = f"{self.done[rule]} jobs, " if self.done[rule] > 1 else ""
            self._print(f"{self._count()} {rule}: {jobs}{duration(self.now() - self.first_s[rule])}")

    def _take_job_error(self, event):
        self.running.pop(event["jobid"], None)
        self._print_failure(f"{event['name']} failed: {', '.join(event.get('output') or [])}")

    def _take_group_error(self, event):
        # many shards in one job of a batch system: what was wrong with it, its status command said
        jobs = event["job_error_info"]
        for job in jobs:
            self.running.pop(job["jobid"], None)
        rules = ", ".join(sorted({job["name"] for job in jobs}))
        self._print_failure(f"{rules} failed: a job that made {len(jobs)} of them")

    def _print_failure(self, text):
        if not self.stopped.wait(STOP_IS_HEARD_S):
            self._print(f"{self._count()} {text}; what its tool said stands above")

    def _take_info(self, event):
        # all else that snakemake says at this level is about itself
        if "Nothing to be done" in event["msg"]:
            self._print("nothing to be done: all of it is there and of this configuration")
        elif event["msg"].startswith("Trying to restart job"):
            self._print("… and is tried once more, with more memory and time")

    def _take_warning(self, event):
        self._print(event["msg"])

    def _take_error(self, event):
        # of what origins.py says the line is enough
        self._print("\n".join(line for line in event["msg"].splitlines() if not re.match(r"WorkflowError:$|  File .*origins\.py", line)))

    def _count(self):
        total = sum(self.planned.values())
        return f"[{str(sum(self.done.values())).rjust(len(str(total)))}/{total}]"

    def left_s(self):
        """Seconds until the end, from what jobs took so far; None before the first is done."""
        known = {rule: self.spent_s[rule] / count for rule, count in self.done.items()}
        guessed = sum(self.typical_s.get(rule, TYPICAL_S) * self.done[rule] for rule in known)
        if not guessed:
            return None
        pace = min(sum(self.spent_s.values()) / guessed, SLOWEST)
        left = 0.0
        for rule, count in self.planned.items():
            took = known.get(rule, pace * self.typical_s.get(rule, TYPICAL_S))
            seconds = took * max(count - self.done.get(rule, 0), 0)
            for name, _, began_s in self.running.values():
                seconds -= min(self.now() - began_s, took) if name == rule else 0
            alone = self.threads.get(rule, 1) > 1 or rule in ("validate", "evaluate", "frontier", "savings", "pca")
            left += seconds / (1 if alone else min(self.cores, max(count, 1)))
        return left

    def line(self):
        at_work = ", ".join(f"{rule} {of}".strip() for rule, of, _ in self.running.values()) or "waiting"
        left = self.left_s()
        ending = f", about {duration(left)} left" if left is not None else ""
        tools = "".join(f"; {text}" for text in self.tools())
        return f"{self._count()} {duration(self.now() - self.started_s)}{ending}: {at_work}{tools}"

    def tools(self):
        """What the tools at work say of themselves; one that ends takes its line with it."""
        for name in sorted(os.listdir(self.folder)) if os.path.isdir(self.folder) else ():
            try:
                with open(os.path.join(self.folder, name)) as file:
                    yield file.read().strip()
            except OSError:
                pass

    def _draw(self):
        if not self.is_terminal or not self.planned:
            return
        # a longer line would wrap, and the next could not rewrite it; the cursor goes back, so that others' lines begin at the margin
        self.write("\r\033[K" + self.line()[: shutil.get_terminal_size().columns - 1] + "\r")
        self.has_line = True

    def _print(self, text):
        if self.stopped.is_set():
            return
        self.write(("\r\033[K" if self.has_line else "") + text + "\n")
        self.has_line = False


def write_stderr(text):
    sys.stderr.write(text)
    sys.stderr.flush()


NLG_PLAN = os.environ.get("NLG_PLAN", "")
progress = RunProgress(write_stderr, sys.stderr.isatty(), plan=read_json(NLG_PLAN), times=os.environ.get("NLG_TIMES", ""), folder=os.path.join(os.path.dirname(NLG_PLAN), ".progress") if NLG_PLAN else "")
# snakemake would print its own lines beside ours; its --quiet would keep the ends of jobs from us as well
if "snakemake.logging" in sys.modules:
    sys.modules["snakemake.logging"].logger.log_handler.clear()


def log_handler(event):
    """What snakemake calls with every event."""
    if event["level"] == "run_info" and not progress.planned:
        threading.Thread(target=keep_time, daemon=True).start()
    progress.take(event)


def keep_time():
    while True:
        time.sleep(1 if progress.is_terminal else 60)
        progress.tick()


def stop(number, frame):
    """SIGINT from pipeline.sh, which says it; what its end makes of the jobs at work is no failure."""
    if not progress.stopped.is_set():
        progress.stopped.set()
        sys.stderr = open(os.devnull, "w")  # also what threads say that are cut off
        raise KeyboardInterrupt


if "snakemake.logging" in sys.modules:
    signal.signal(signal.SIGINT, stop)

#!/usr/bin/env python3
"""Fault injection: kills, injected errors, damaged files and hostile scenes against every tool and the whole pipeline.

    tests/fault_injection/run.py --seed 1 --kills 300 --errors 500 --damage 3000 --scenes 400 --jobs 2 --out build/fault_injection [PART ...]
    tests/fault_injection/run.py --short                         the test fault_injection_short: every part, a few cases of each
    tests/fault_injection/run.py --only damage/grid/17           one case again, its folder kept
    docs/figures/results.py collect-fault-injection build/fault_injection   its table → docs/results/reliability.json and docs: reliability

Parts: findings (of the first run, those that no other part draws), kills, errors, damage, scenes; all of them when none is named. The same seed
gives the same cases. A case is written down when it is over, in OUT/PART.jsonl: a run that was stopped continues, and
parts may be run one after the other. OUT/table.md and table.json sum up what is there. Exit code 6 when something stands in a bad column.
What a case that failed was made of stays in OUT/failed/.
"""
import argparse
import json
import os
import shutil
import subprocess
import sys
import threading
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

sys.dont_write_bytecode = True

import chain
import damage
import errors
import findings
import injector
import kills
import pipeline
import scenes
import table
import trial

PARTS = ("findings", "kills", "errors", "damage", "scenes")
MODULES = {"findings": findings, "kills": kills, "errors": errors, "damage": damage, "scenes": scenes}
NEEDS_INJECTOR = ("findings", "kills", "errors")
SHORT = {"kills": 4, "errors": 8, "damage": 40, "scenes": 12}
SECONDS, SANITIZED = 30.0, 10  # of a tool, at most; times as long under sanitizers
PIPELINE_SECONDS = 600.0
# as workflow/environment.sh sets it for every stage
ENVIRONMENT = {"NLG_PROGRESS": "off", "OPENBLAS_NUM_THREADS": "1", "OMP_NUM_THREADS": "2", "OMP_WAIT_POLICY": "passive", "MPLCONFIGDIR": "/tmp", "LC_ALL": "C.UTF-8"}


class FaultInjection:
    """What every case is given."""

    def __init__(self, arguments):
        self.arguments, self.seed = arguments, arguments.seed
        self.here = str(Path(__file__).resolve().parent)
        self.sources = str(Path(self.here).parents[1])
        build = os.path.abspath(arguments.build)
        self.binaries, self.reader = os.path.join(build, "bin"), os.path.join(build, "tests", "fault_injection", "fault_injection_read")
        self.injector = os.path.join(build, "tests", "fault_injection", "fault_injector.so")
        self.out = os.path.abspath(arguments.out)
        self.store = os.path.join(self.out, "store")  # one of every file that a stage reads
        self.environment = {**injector.clean(os.environ), **ENVIRONMENT, "NLG_BIN": self.binaries}
        self.factor = factor = SANITIZED if arguments.sanitized else 1
        self.limits = trial.Limits(seconds=SECONDS * factor, peak_mb=2000.0 * (3 if arguments.sanitized else 1), address_space=not arguments.sanitized)
        self.pipeline_limits = trial.Limits(seconds=PIPELINE_SECONDS * factor, address_space=not arguments.sanitized)
        self.lock = threading.Lock()

    def make(self, parts, with_pipeline):
        """What the cases start from: one of every file, what undisturbed runs leave, how many calls they make."""
        os.makedirs(self.store, exist_ok=True)
        shutil.copyfile(os.path.join(self.here, chain.CONFIG), os.path.join(self.store, chain.CONFIG))
        self.tools = [tool for tool in chain.tools() if not self.arguments.short or tool.name in chain.SHORT]
        self.made = chain.make(self)
        self.counts = {tool.name: self.count(tool) for tool in self.tools} if set(parts) & set(NEEDS_INJECTOR) else {}
        self.pipeline = pipeline.make(self) if with_pipeline else None

    def count(self, tool):
        """Calls of every class that the injector could strike in."""
        path = os.path.join(self.out, "chain", tool.name.replace(" ", "_"), "counts")
        if not os.path.exists(path):
            folder = path + ".run"
            shutil.rmtree(folder, ignore_errors=True)
            chain.lay_out(self.store, tool, folder)
            ending = trial.run(tool.argv(self), folder, injector.injecting(self, folder, tool.program(), counts=path + ".new"), self.limits)
            if ending.code != 0 or not os.path.exists(path + ".new"):
                raise SystemExit(f"fault injection: {tool.name}: counting its calls must disturb nothing: {ending.words()}")
            os.rename(path + ".new", path)
            shutil.rmtree(folder)
        return injector.read_counts(path)

    def draw_tool(self, random, tools):
        """Each as often, but for those that take seconds."""
        return random.choices(tools, [min(1.0, 1.0 / self.made[tool.name].seconds) for tool in tools])[0]


def revision(injection):
    return subprocess.run([os.path.join(injection.binaries, "nlg-datagen"), "--version"], capture_output=True, text=True, check=True).stdout.strip()


def begin(injection):
    """A folder of this seed and these tools, or a fresh one."""
    origin = {"seed": injection.seed, "revision": revision(injection)}
    path = os.path.join(injection.out, "origin.json")
    if injection.arguments.fresh and os.path.exists(path):
        shutil.rmtree(injection.out)
    if os.path.exists(path):
        with open(path) as file:
            found = json.load(file)
        if found != origin:
            raise SystemExit(f"fault injection: {injection.out}: made with {found}, expected {origin}; --fresh begins anew")
    os.makedirs(injection.out, exist_ok=True)
    with open(path, "w") as file:
        json.dump(origin, file)
    return origin


def done_names(path):
    if not os.path.exists(path):
        return set()
    with open(path) as file:
        return {json.loads(line)["name"] for line in file}


def run_case(injection, part, case, cases):
    folder = os.path.join(injection.out, "work", case.name.replace("/", "_"))
    shutil.rmtree(folder, ignore_errors=True)
    os.makedirs(folder)
    faults = trial.Faults()
    place = os.path.join(folder, "case")
    words = case.run(place, faults)
    record = {"name": case.name, "row": case.row, "cases": cases, "words": words, "faults": faults.found}
    with injection.lock:
        with open(os.path.join(injection.out, f"{part}.jsonl"), "a") as file:
            file.write(json.dumps(record) + "\n")
    for column, why in faults.found:
        print(f"{case.name}: {column}: {why}\n    {words}", flush=True)
    if faults.found or injection.arguments.only:
        kept = os.path.join(injection.out, "failed", case.name.replace("/", "_"))
        shutil.rmtree(kept, ignore_errors=True)
        os.makedirs(os.path.dirname(kept), exist_ok=True)
        shutil.move(folder, kept)
    else:
        shutil.rmtree(folder, ignore_errors=True)


def run_parts(injection, parts, counts):
    with ThreadPoolExecutor(injection.arguments.jobs) as pool:
        waiting = []
        for part in parts:
            known = done_names(os.path.join(injection.out, f"{part}.jsonl"))
            for case, cases in MODULES[part].cases(injection, counts.get(part, 0)):
                if (case.name == injection.arguments.only) if injection.arguments.only else case.name not in known:
                    waiting.append(pool.submit(run_case, injection, part, case, cases))
        for future in waiting:
            future.result()


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("parts", nargs="*", metavar="PART", help=f"{', '.join(PARTS)} (all)")
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--kills", type=int, default=300)
    parser.add_argument("--errors", type=int, default=500)
    parser.add_argument("--damage", type=int, default=3000)
    parser.add_argument("--scenes", type=int, default=400)
    parser.add_argument("--short", action="store_true", help="a few of everything, no whole pipeline")
    parser.add_argument("--sanitized", action="store_true", help="the tools are built with a sanitizer: longer, larger, and nothing is injected")
    parser.add_argument("--jobs", type=int, default=os.cpu_count())
    parser.add_argument("--build", default="build/release")
    parser.add_argument("--out", default="build/fault_injection")
    parser.add_argument("--fresh", action="store_true", help="begin anew where another seed or revision was at work")
    parser.add_argument("--only", metavar="CASE", help="one case, even if it was run before; its folder stays in OUT/failed")
    arguments = parser.parse_args()
    if unknown := set(arguments.parts) - set(PARTS):
        parser.error(f"unknown part {', '.join(sorted(unknown))}: expected some of {', '.join(PARTS)}")
    parts = [arguments.only.split("/")[0]] if arguments.only else arguments.parts or list(PARTS)
    injection = FaultInjection(arguments)
    origin = begin(injection)
    counts = SHORT if arguments.short else {part: getattr(arguments, part) for part in SHORT}
    injection.make(parts, with_pipeline=not arguments.short and bool({"kills", "damage", "findings"} & set(parts)))
    run_parts(injection, parts, counts)
    found = table.collect(injection.out, PARTS, origin)
    table.write(injection.out, found)
    print(table.markdown(found))
    return 6 if table.is_bad(found) else 0


if __name__ == "__main__":
    sys.exit(main())

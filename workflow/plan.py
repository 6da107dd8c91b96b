"""What a run will take, stage by stage, before anything is made: from a sample of its shards, and from what stages cost (costs.py).

    plan.py CONFIG [--levels FOLDER] [--set SECTION.KEY=VALUE]... --bin FOLDER
"""
import argparse
import json
import os
import re
import shlex
import subprocess
import sys
import tempfile
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

sys.path.insert(0, str(Path(__file__).resolve().parents[1]))  # tool/, which all scripts share
from tool.errors import ToolError, run

import configuration
from costs import Costs
from plain_yaml import text_of

SAMPLED_OF_A_KIND, SAMPLED_FUNCTIONS = 4, 100  # scenes; functions of each that are made to find out
WORD_OF = {"training": "trained on", "held_out": "held out", "evaluation": "for the evaluation"}


def duration(seconds):
    return f"{seconds:.0f} s" if seconds < 90 else f"{seconds / 60:.1f} min" if seconds < 5400 else f"{seconds / 3600:.1f} h"


class SampleError(ToolError):
    """A scene that nlg-datagen refuses, in its own line."""

    def __init__(self, line, exit_code):
        super().__init__(line)
        self.exit_code = exit_code


def kind_of(scene, asked):
    """Scenes of one source: procedural ones, or those of a folder."""
    return "procedural" if re.fullmatch(r"[a-z_]+:\d+", asked) else os.path.dirname(os.path.abspath(asked))


def evenly(items, count):
    count = min(len(items), count)
    return [items[(2 * i + 1) * len(items) // (2 * count)] for i in range(count)]


def sampled(of_run):
    """Some scenes of each kind, and for how many shards of a split each of them stands: (split, scene, weight)."""
    kinds = {}
    for split in configuration.SPLITS:
        for scene in getattr(of_run, split):
            kinds.setdefault((split, kind_of(scene, of_run.scenes[scene][0])), []).append(scene)
    for (split, _), scenes in kinds.items():
        jitters = of_run.jitters if split == "training" else 1
        shards = sum(1 if scene in of_run.unjittered else jitters for scene in scenes)
        chosen = evenly(sorted(scenes), SAMPLED_OF_A_KIND)
        for scene in chosen:
            yield split, scene, shards / len(chosen)


def plan_of(binaries, config, of_run, split, scene):
    command = [os.path.join(binaries, "nlg-datagen"), "plan", "--json", f"--sample={SAMPLED_FUNCTIONS}", "--config", config, *shlex.split(of_run.flags_over("datagen", of_run.scene_options(scene))),
               "--scene", of_run.scenes[scene][0], *([] if split == "training" else ["--held-out"])]
    done = subprocess.run(command, capture_output=True, text=True, env={**os.environ, "NLG_PROGRESS": "off"})
    if done.returncode != 0:
        raise SampleError((done.stderr.strip().splitlines() or ["nlg-datagen plan failed"])[-1], done.returncode)
    return json.loads(done.stdout)


def main():
    parser = argparse.ArgumentParser(prog="pipeline.sh --plan")
    configuration.add_arguments(parser)
    parser.add_argument("--bin", required=True)
    arguments = parser.parse_args()
    content = configuration.content_of(arguments)
    of_run = configuration.judge(content, arguments.config)
    sample = list(sampled(of_run))
    cores = len(os.sched_getaffinity(0))
    with tempfile.NamedTemporaryFile("w", suffix=".yaml") as file, ThreadPoolExecutor(cores) as pool:
        file.write(text_of(content))
        file.flush()
        plans = list(pool.map(lambda one: plan_of(arguments.bin, file.name, of_run, one[0], one[1]), sample))

    print(f"{of_run.folder}: {len(of_run.scenes)} scenes")
    functions, total, file_bytes = {}, {"probes": 0.0, "core_s": 0.0}, 0.0
    for split in configuration.SPLITS:
        names = getattr(of_run, split)
        own = [(plan, weight) for plan, (of_split, _, weight) in zip(plans, sample) if of_split == split]
        functions[split] = sum(weight * plan["functions"] for plan, weight in own)
        if not names:
            continue
        probes = sum(weight * plan["visited_probes"] for plan, weight in own)
        total["probes"] += probes
        total["core_s"] += sum(weight * plan["core_seconds"] for plan, weight in own)
        file_bytes += sum(weight * plan["bytes"] for plan, weight in own)
        print(f"  {WORD_OF[split]:19} {len(names)} scenes, {len(of_run.shards(split))} shards, about {probes:,.0f} probes, {functions[split]:,.0f} functions")
        if split != "training":
            print(f"  {'':19} {configuration.listed(names)}")
    cache_bytes = functions["training"] * 11e3
    print(f"  disk                {file_bytes / 1e6:,.0f} MB; while it trains {cache_bytes / 1e6:,.0f} MB more")

    costs = Costs(of_run, functions)
    judged = [("held_out", "validate", "frontier")] + [("evaluation", "evaluate", "frontier of the evaluation")] * bool(of_run.evaluation)
    # name, seconds of one core, cores that it can use
    stages = [("data set", total["core_s"], cores), ("basis", costs.basis(), 1), ("function cache", costs.cache(), 1)]
    trainings = {name: costs.train(name) for name in of_run.representations}
    stages += [(f"train {name}", seconds, 1) for name, seconds in trainings.items()]
    stages += [("export", costs.export() * len(trainings), cores)]
    for split, validate, frontier in judged:
        stages += [(validate, costs.validate(split), cores), (frontier, costs.frontier(split), 1)]
    stages += [("stability", costs.stability(), 1), ("savings", costs.savings(), cores), ("light", costs.light(), cores), ("report", costs.report() * len(judged), 1)]
    stages = [stage for stage in stages if stage[1] > 0]
    # trainings share the cores, and none ends before it is done
    in_turn = sum(seconds / used for name, seconds, used in stages if not name.startswith("train "))
    training = max(max(trainings.values()), sum(trainings.values()) / cores)
    print(f"\n{'stage':28}{'one core':>12}")
    for name, seconds, _ in stages:
        print(f"{name:28}{duration(seconds):>12}")
    print(f"{'all':28}{duration(sum(seconds for _, seconds, _ in stages)):>12}\n")
    print(f"By the clock about {duration(in_turn + training)} on {cores} cores like the one that the sample ran on.")


if __name__ == "__main__":
    sys.exit(run("pipeline.sh", main))

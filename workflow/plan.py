"""What a run will take, stage by stage, before anything is made: from a sample of its shards, and from what stages cost (costs.py).

    plan.py CONFIG [--levels FOLDER] [--set SECTION.KEY=VALUE]... --bin FOLDER [--out PLAN.json]

--out writes the plan beside what the run makes, where run_progress.py and the report find it, and prints one line; a plan of the same
configuration that is there stays.
"""
import signal

signal.signal(signal.SIGINT, signal.SIG_DFL)  # pipeline.sh says that it was stopped

import argparse
import hashlib
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
from tool.atomic_file import write_files
from tool.duration import duration
from tool.errors import ToolError, run

import configuration
from costs import Costs
from plain_yaml import text_of

SAMPLED_OF_A_KIND, SAMPLED_FUNCTIONS = 4, 100  # scenes; functions of each that are made to find out
WORD_OF = {"training": "trained on", "held_out": "held out", "evaluation": "for the evaluation"}


class RefusedError(ToolError):
    """A scene or shard that nlg-datagen refuses, in its own line."""

    def __init__(self, line, exit_code):
        super().__init__(line)
        self.exit_code = exit_code


def told(binaries, *words):
    """What nlg-datagen prints."""
    # a message about a damaged file may quote its bytes
    done = subprocess.run([os.path.join(binaries, "nlg-datagen"), *words], capture_output=True, text=True, errors="backslashreplace", env={**os.environ, "NLG_PROGRESS": "off"})
    if done.returncode != 0:
        raise RefusedError((done.stderr.strip().splitlines() or [f"nlg-datagen {words[0]} failed"])[-1], done.returncode)
    return done.stdout


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
    return json.loads(told(binaries, "plan", "--json", f"--sample={SAMPLED_FUNCTIONS}", "--config", config, *shlex.split(of_run.flags_over("datagen", of_run.scene_options(scene))),
                           "--scene", of_run.scenes[scene][0], *([] if split == "training" else ["--held-out"])))


PARALLEL = ("datagen", "export")  # rules whose jobs run beside each other


def by_the_clock(stages, cores):
    """Trainings share the cores, and none ends before it is done."""
    in_turn = sum(stage.core_s / (cores if stage.rule in PARALLEL else stage.cores) for stage in stages if stage.rule != "train")
    trainings = [stage for stage in stages if stage.rule == "train"]
    return in_turn + max(max(stage.core_s / min(stage.cores, cores) for stage in trainings), sum(stage.core_s for stage in trainings) / cores)


def plan(arguments, content, of_run):
    """What plan.json holds: the run's data and stages."""
    sample = list(sampled(of_run))
    cores = len(os.sched_getaffinity(0))
    with tempfile.NamedTemporaryFile("w", suffix=".yaml") as file, ThreadPoolExecutor(cores) as pool:
        file.write(text_of(content))
        file.flush()
        plans = list(pool.map(lambda one: plan_of(arguments.bin, file.name, of_run, one[0], one[1]), sample))
    splits = {}
    for split in configuration.SPLITS:
        own = [(of_shard, weight) for of_shard, (of_split, _, weight) in zip(plans, sample) if of_split == split]
        total = {name: sum(weight * of_shard[key] for of_shard, weight in own)
                 for name, key in (("probes", "visited_probes"), ("functions", "functions"), ("core_s", "core_seconds"), ("bytes", "bytes"))}
        of_levels = sum(weight * of_shard["functions"] for of_shard, (of_split, scene, weight) in zip(plans, sample) if of_split == split and scene in of_run.own_levels)
        splits[split] = {"scenes": len(getattr(of_run, split)), "shards": len(of_run.shards(split)), **total, "own_functions": of_levels}
    costs = Costs(of_run, {split: data["functions"] for split, data in splits.items()})
    stages = costs.stages(cores, sum(data["core_s"] for data in splits.values()))
    return {"schema_version": 1, "configuration": digest_of(content), "cores": cores, "clock_s": by_the_clock(stages, cores),
            "splits": splits, "stages": [stage._asdict() for stage in stages]}


def digest_of(content):
    return hashlib.sha256(text_of(content).encode()).hexdigest()


def is_of(path, content):
    try:
        with open(path) as file:
            return json.load(file)["configuration"] == digest_of(content)
    except (OSError, ValueError, KeyError, TypeError):
        return False


def text(found, of_run):
    yield f"{of_run.folder}: {len(of_run.scenes)} scenes"
    for split, data in found["splits"].items():
        names = getattr(of_run, split)
        if not names:
            continue
        yield f"  {WORD_OF[split]:19} {len(names)} scenes, {data['shards']} shards, about {data['probes']:,.0f} probes, {data['functions']:,.0f} functions"
        if split != "training":
            yield f"  {'':19} {configuration.listed(names)}"
        elif 0 < data["own_functions"] < data["functions"]:
            yield f"  {'':19} {100 * data['own_functions'] / data['functions']:.0f} % of the functions are of your levels, the others of made scenes (scenes.per_family)"
    if of_run.collected:
        yield f"  {'collected':19} {len(of_run.collected)} shards of functions that failed in bakes: {configuration.listed(map(os.path.basename, of_run.collected))}"
    cache_bytes = found["splits"]["training"]["functions"] * 11e3
    yield f"  disk                {sum(data['bytes'] for data in found['splits'].values()) / 1e6:,.0f} MB; while it trains {cache_bytes / 1e6:,.0f} MB more"
    yield f"\n{'stage':28}{'one core':>12}"
    for stage in found["stages"]:
        yield f"{stage['name']:28}{duration(stage['core_s']):>12}"
    yield f"{'all':28}{duration(sum(stage['core_s'] for stage in found['stages'])):>12}"
    yield f"\nBy the clock about {duration(found['clock_s'])} on {found['cores']} cores like the one that the sample ran on, if nothing is there yet."


def main():
    parser = argparse.ArgumentParser(prog="pipeline.sh --plan")
    configuration.add_arguments(parser)
    parser.add_argument("--bin", required=True)
    parser.add_argument("--out")
    arguments = parser.parse_args()
    content = configuration.content_of(arguments)
    of_run = configuration.judge(content, arguments.config)
    if arguments.out and is_of(arguments.out, content):
        return
    found = plan(arguments, content, of_run)
    if not arguments.out:
        print(*text(found, of_run), sep="\n")
        return
    write_files({arguments.out: json.dumps(found, indent=1).encode()})
    print(f"{of_run.folder}: planned to take about {duration(found['clock_s'])} on {found['cores']} cores; --plan shows the stages", file=sys.stderr)


if __name__ == "__main__":
    sys.exit(run("pipeline.sh", main))

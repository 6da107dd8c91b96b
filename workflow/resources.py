"""What a job of each rule takes: processes, cores, memory and time. Batch systems are told; a run on one machine does not look at it.

Time is that of costs.py, and memory of docs/lab/performance.md, with room to spare, since a job that asks for too little is
killed: three times the time, twice the memory. One that is killed all the same is tried again with twice of both.
"""
import math

from costs import FUNCTION_S, SHARD_S, Costs

ROOM_S, ROOM_MB = 3, 2

START_S = 300  # of a training, an export and what measures: theta0, validations, a node that is slower

# Megabytes. A process with its libraries, and what it holds of all functions at once.
SHARD_MB = 250            # a level of Quake III takes 51, ten million triangles 1,700
BASIS_MB, FUNCTION_MB = 300, 200e-6
TRAIN_MB, HELD_OUT_MB = 700, 12e-3  # two windows of 92 MB among it; held-out functions are in memory as floats
MEASURE_MB = 1500


class Resources:
    """resources of every rule of the Snakefile, for a run that was judged (configuration.py)."""

    def __init__(self, run):
        self.run = run
        costs = Costs(run, {})
        self.functions_a_shard = max(costs.setting("datagen", "max_functions", own) for own in [{}, *run.by_scene.values()])
        self.functions = {split: len(run.shards(split)) * self.functions_a_shard for split in ("training", "held_out", "evaluation")}
        self.functions["training"] += len(run.collected) * self.functions_a_shard
        self.costs = Costs(run, self.functions)
        stages = self.costs.stages(1)
        # of one core, whatever a job can use
        self.seconds = {stage.rule: stage.core_s / stage.jobs for stage in stages}
        self.training_s = {name: stage.core_s / stage.cores for name, stage in zip(run.training_cores, (stage for stage in stages if stage.rule == "train"))}

    def shard(self):
        return job(SHARD_MB, SHARD_S + self.functions_a_shard * FUNCTION_S)

    def basis(self):
        return job(BASIS_MB + FUNCTION_MB * self.functions["training"], self.seconds["pca"])

    def cache(self):
        return job(BASIS_MB + FUNCTION_MB * self.functions["training"], self.seconds["cache"])

    def train(self):
        def seconds(wildcards):
            return START_S + self.training_s[wildcards.representation]

        def megabytes(wildcards):
            processes, _ = self.run.training_cores[wildcards.representation]
            # of a node, on which all processes may lie
            return processes * (TRAIN_MB + HELD_OUT_MB * self.functions["held_out"] + FUNCTION_MB * self.functions["training"])

        return job(megabytes, seconds, tasks=lambda wildcards: str(self.run.training_cores[wildcards.representation][0]))

    def export(self):
        return job(TRAIN_MB + HELD_OUT_MB * self.functions["held_out"], START_S)

    def measure(self, rule, is_alone=True):
        """A stage that measures; alone on its node where it takes times."""
        return job(MEASURE_MB + FUNCTION_MB * sum(self.functions.values()), START_S + self.seconds.get(rule, 0), is_alone=is_alone)


def job(megabytes, seconds, tasks=lambda wildcards: "1", is_alone=False):
    """The resources of a rule, as snakemake takes them: a number, or a function of the wildcards, and twice as much at each attempt.

    tasks   a text: snakemake would add numbers up when it groups jobs
    node    options of sbatch, about the node
    """
    value = lambda amount, wildcards: amount(wildcards) if callable(amount) else amount
    return {
        "mem_mb": lambda wildcards, attempt: math.ceil(ROOM_MB * value(megabytes, wildcards)) * 2 ** (attempt - 1),
        "runtime": lambda wildcards, attempt: math.ceil(ROOM_S * value(seconds, wildcards) / 60) * 2 ** (attempt - 1),
        "tasks": lambda wildcards: tasks(wildcards),
        "node": "--exclusive" if is_alone else "",
    }

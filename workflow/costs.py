"""What the stages of a run take on one core: for the plan (plan.py), for the time that a run has left (run_progress.py), and with room to
spare for batch systems (resources.py).

Measured on two cores of a shared machine (docs/lab/performance.md); each within a factor of 1.5 there.
"""
from collections import namedtuple

from settings import default

# name: as the plan and the report call it; rule: of the Snakefile; core_s: of all its jobs together; cores: that a job can use
Stage = namedtuple("Stage", "name rule jobs core_s cores")

# Seconds. A shard: process, scene and trees, and a function that is kept, with the duplicates that were made on the way to it.
SHARD_S, FUNCTION_S = 0.6, 3e-3
# of a function that is read: its moments for the basis; its coefficients for the cache, or once more for a figure
MOMENTS_S, READ_S = 0.6e-3, 0.25e-3
BASIS_S, CACHE_S, EXPORT_S, REPORT_S = 10, 3, 8, 12
TRAIN_S = 20                      # theta0 and validations while training
STABILITY_S = {"short": 10, "full": 120}

# By representation. A function in a batch of a training, forth and back; a function with a theta through the whole policy; a function of the
# validation's sample and of the frontier, at the tools' own numbers of steps.
SAMPLE_S = {"mlp": 0.25e-3, "tent_mlp": 0.15e-3, "tent_mlp44": 0.21e-3, "tent_mlp4": 0.16e-3, "pf3": 0.12e-3, "pf5": 0.16e-3, "pf7": 0.23e-3,
            "pf9": 0.38e-3, "code": 0.17e-3}
POLICY_S = {"mlp": 15e-3, "tent_mlp": 9e-3, "tent_mlp44": 4.5e-3, "tent_mlp4": 3e-3, "pf3": 3e-3, "pf5": 8e-3, "pf7": 20e-3, "pf9": 40e-3, "code": 1.5e-3}
DIRECT_S = {"mlp": 1.2, "tent_mlp": 1.2, "tent_mlp44": 0.7, "tent_mlp4": 0.5, "pf3": 0.3, "pf5": 1.0, "pf7": 3.0, "pf9": 7.0, "code": 0.6}
FRONTIER_S = {"mlp": 1.0, "tent_mlp": 1.0, "tent_mlp44": 0.6, "tent_mlp4": 0.4, "pf3": 0.3, "pf5": 0.8, "pf7": 2.0, "pf9": 4.0, "code": 0.5}
WITH_THETA = 0.6                  # of all functions, those that the bare tent is not enough for
LIGHT_S = 25                      # of a scene, at a spacing, with the tools' own numbers of places and rays
SAVINGS_S = 20                    # of a scene that is baked, and a representation


def of(table, representation):
    return table.get(representation, table["code"])


class Costs:
    """Seconds of one core that the stages of a run (configuration.py) take.

    functions   of each split
    """

    def __init__(self, run, functions):
        self.run, self.functions = run, functions

    def setting(self, section, key, own=None):
        """A number of a section, or what a scene or a representation has for itself."""
        return int({**self.run.sections[section], **(own or {})}.get(key, default(section, key)))

    def basis(self):
        return BASIS_S + MOMENTS_S * (self.functions["training"] + self.functions["held_out"])

    def cache(self):
        return CACHE_S + READ_S * self.functions["training"]

    def train(self, representation):
        own = self.run.representations[representation]
        return TRAIN_S + of(SAMPLE_S, representation) * self.setting("train", "steps", own) * self.setting("train", "batch", own)

    def validate(self, split):
        """Every function through the policy; long fits of a sample."""
        sample = min(self.setting("validate", "direct_functions"), self.functions[split])
        starts = (1 + self.setting("validate", "direct_restarts")) / (1 + default("validate", "direct_restarts"))
        length = self.setting("validate", "direct_adam_steps") / default("validate", "direct_adam_steps")
        return sum(READ_S * self.functions["training"] + WITH_THETA * of(POLICY_S, name) * self.functions[split] + of(DIRECT_S, name) * sample * starts * length
                   for name in self.run.representations)

    def frontier(self, split):
        sample = min(self.setting("frontier", "functions"), self.functions[split])
        return sum(of(FRONTIER_S, name) * sample for name in self.run.representations)

    def data_set(self):
        shards = sum(len(self.run.shards(split)) for split in self.functions)
        return SHARD_S * shards + FUNCTION_S * sum(self.functions.values())

    def stages(self, cores, data_set_s=None):
        """Every stage of the run that takes time, in its order.

        cores        of the machine
        data_set_s   what a sample of the shards says that they take; None: by the number of functions
        """
        run, judged = self.run, 1 + bool(self.run.evaluation)
        shards = sum(len(run.shards(split)) for split in self.functions)
        stages = [Stage("data set", "datagen", shards, self.data_set() if data_set_s is None else data_set_s, 1),
                  Stage("data card", "data_card", 1, READ_S * sum(self.functions.values()), 1), Stage("basis", "pca", 1, self.basis(), 1),
                  Stage("function cache", "cache", 1, self.cache(), 1)]
        for name, (processes, threads) in run.training_cores.items():
            # two threads are all that a batch of up to 512 keeps busy (train/generator/run/trainer.cpp)
            stages.append(Stage(f"train {name}", "train", 1, self.train(name), processes * min(threads, 2)))
        stages += [Stage("export", "export", len(run.representations), EXPORT_S * len(run.representations), 1),
                   Stage("validate", "validate", 1, self.validate("held_out"), cores)]
        if run.references:
            stages += [Stage("other weights", "references", len(run.references), sum(
                WITH_THETA * of(POLICY_S, name) * self.functions["held_out"] for name in run.representations for _ in run.references), cores)]
        stages += [Stage("evaluate", "evaluate", 1, self.validate("evaluation"), cores)] * bool(run.evaluation)
        stages += [Stage("frontier", "frontier", judged, self.frontier("held_out") + self.frontier("evaluation") * bool(run.evaluation), 1)]
        stages += [Stage("stability", "stability", 1, STABILITY_S[run.report["stability"]], 1),
                   Stage("savings", "savings", len(run.savings), SAVINGS_S * len(run.savings) * len(run.representations), cores),
                   Stage("other bakes", "bakes", len(run.bakes), SAVINGS_S * len(run.bakes) * len(run.representations), cores),
                   Stage("light", "validate_light", len(run.light_scenes), LIGHT_S * len(run.light_scenes) * len(run.light_spacings), cores),
                   Stage("report", "report", 1, REPORT_S, 1)]
        stages += [Stage("report of the evaluation", "evaluation_report", 1, REPORT_S, 1)] * bool(run.evaluation)
        return [stage for stage in stages if stage.jobs]

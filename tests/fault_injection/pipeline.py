"""A whole pipeline in a folder: pipeline.sh of this checkout, without what installs and builds, on tests/fault_injection/fault_injection.yaml."""
import os
import re
import shutil

import chain
import trial

NAME = "fault_injection"
# of a training's validations; those that come faster than pictures have none
PICTURES = re.compile(r"training/\w+/worst-\d+\.png")
# pipeline.sh sources it; packages and binaries are there
SETUP = "install_packages() { :; }\nbuild() { :; }\n"


class Pipeline:
    """A checkout of links, so that locks and snakemake's own records are this run's alone."""

    def __init__(self, injection, folder):
        self.injection, self.folder = injection, folder
        self.checkout, self.results = os.path.join(folder, "checkout"), os.path.join(folder, "out", NAME)
        self.environment = {**injection.environment, "NLG_OUT": os.path.join(folder, "out")}
        lay_out_checkout(injection.sources, self.checkout)
        self.config = os.path.join(self.checkout, chain.CONFIG)
        shutil.copyfile(os.path.join(injection.here, chain.CONFIG), self.config)

    def run(self, kill_after=None, *arguments):
        return trial.run([os.path.join(self.checkout, "pipeline.sh"), *arguments, self.config], self.folder, self.environment, self.injection.pipeline_limits, kill_after)

    def clear(self):
        shutil.rmtree(os.path.dirname(self.results), ignore_errors=True)

    def files(self):
        # Snakemake keeps a log of each start
        return [path for path in chain.files_in(self.results) if not path.startswith(".snakemake/log/")]

    def check_whole(self, made, faults, when):
        """What has a finished file's name is whole."""
        for path in self.files():
            if path in made.listing and not made.is_whole(self.results, path):
                faults.add(trial.TORN, f"{when}: {path} is torn")

    def finish(self, made, faults):
        """Runs to the end: the files of an undisturbed run."""
        ending = self.run()
        trial.judge(ending, self.injection.pipeline_limits, faults, is_quiet=False)
        if ending.code != 0:
            faults.add(trial.ENDING, f"restart: {ending.words()}")
            return ending
        left = set(self.files())
        for path in made.listing:
            if PICTURES.fullmatch(path):
                continue
            if path not in left:
                faults.add(trial.TORN, f"{path} is missing after a restart")
            elif not made.is_final(self.results, path):
                faults.add(trial.TORN, f"{path} is another file after a restart")
        for path in sorted(path for path in left - set(made.listing) if not PICTURES.fullmatch(path)):
            faults.add(trial.LEFT, f"{path} stays after a restart")
        return ending


def lay_out_checkout(sources, checkout):
    os.makedirs(os.path.join(checkout, "workflow"), exist_ok=True)
    for name in os.listdir(sources):
        if name not in ("build", "out", ".git", ".snakemake", "workflow"):
            link(os.path.join(sources, name), os.path.join(checkout, name))
    for name in os.listdir(os.path.join(sources, "workflow")):
        if name != "setup.sh":
            link(os.path.join(sources, "workflow", name), os.path.join(checkout, "workflow", name))
    with open(os.path.join(checkout, "workflow", "setup.sh"), "w") as file:
        file.write(SETUP)


def link(source, place):
    if not os.path.lexists(place):
        os.symlink(source, place)


class MadePipeline(chain.Made):
    def __init__(self, first, again):
        super().__init__(first.results, again.results, [path for path in first.files() if path in set(again.files())], "", 0.0)


def make(injection):
    """Two undisturbed runs; what an earlier call made it takes."""
    runs = [Pipeline(injection, os.path.join(injection.out, "pipeline", name)) for name in ("first", "again")]
    for pipeline in runs:
        done = os.path.join(pipeline.folder, "done")
        if not os.path.exists(done):
            pipeline.clear()
            ending = pipeline.run()
            if ending.code != 0:
                raise SystemExit(f"fault injection: an undisturbed pipeline must succeed: {ending.words()}")
            open(done, "w").close()
    return MadePipeline(*runs)

"""The chain's tools on tests/fault_injection/fault_injection.yaml: what each is called with, what it reads and what it leaves."""
import filecmp
import json
import os
import shutil
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass

import trial

CONFIG = "fault_injection.yaml"
# those whose files all others read, and no more: what the short form tests
SHORT = ("datagen", "datagen held out", "datagen info", "pca", "cache", "train", "curve", "export", "bake", "shader")
# how much work there is, where a damaged configuration no longer says it: half of one asks for minutes of training
TRAIN = ["--steps", "12", "--batch", "4", "--start-candidates", "1", "--width", "16", "--layers", "2"]
LIGHT = ["--spacings", "2.0", "--air-samples", "64", "--surface-samples", "64", "--walks", "4", "--truth-rays", "32", "--probe-rays", "32"]
PICTURE = ["--width", "16", "--height", "12", "--truth-rays", "8"]


@dataclass
class Tool:
    """One call of a program, in a folder that holds its inputs."""
    name: str
    command: list  # the first word is a program of the build's bin/, or a script of the checkout
    inputs: list
    outputs: list
    is_script: bool = False
    result: str = ""  # where its standard output goes: the workflow keeps some

    def program(self):
        return "python3" if self.is_script else self.command[0]

    def argv(self, injection):
        if self.is_script:
            return ["/usr/bin/python3", os.path.join(injection.sources, self.command[0]), *self.command[1:]]
        return [os.path.join(injection.binaries, self.command[0]), *self.command[1:]]


def tools():
    """In the order in which they can run: each reads what those before it left."""
    config = ["--config", CONFIG]
    weights, held_out = "tent_mlp.safetensors", "held_out.h5"
    train = ["nlg-train", *config, *TRAIN, "--representation", "tent_mlp", "--basis", "basis.h5", "--held-out", held_out, "--out", "tent_mlp.ckpt", "--run", "run", "--log", "tent_mlp.csv"]
    return [
        Tool("datagen", ["nlg-datagen", *config, "--scene", "house:0", "--out", "training.h5"], [CONFIG], ["training.h5"]),
        Tool("datagen held out", ["nlg-datagen", *config, "--scene", "house:1", "--held-out", "--out", held_out], [CONFIG], [held_out]),
        Tool("datagen plan", ["nlg-datagen", "plan", "--json", *config, "--scene", "house:0"], [CONFIG], []),
        Tool("datagen info", ["nlg-datagen", "info", "--json", "training.h5"], ["training.h5"], []),
        Tool("datagen geometry", ["nlg-datagen", "geometry", "training.h5"], ["training.h5"], []),
        Tool("shard pictures", ["workflow/shard_pictures.py", "training.h5", "--probe", "0", "--px", "64", "--out", "probe.png"], ["training.h5"], ["probe.png"], is_script=True),
        Tool("pca", ["nlg-pca", *config, "--shards", "training.h5", "--held-out", held_out, "--out", "basis.h5"], [CONFIG, "training.h5", held_out], ["basis.h5"], result="basis.json"),
        Tool("cache", ["nlg-cache", "--basis", "basis.h5", "--shards", "training.h5", "--out", "functions.cache"], ["basis.h5", "training.h5"], ["functions.cache"]),
        Tool("train", [*train, "--cache", "functions.cache"], [CONFIG, "basis.h5", "functions.cache", held_out], ["tent_mlp.ckpt", "run", "tent_mlp.csv"]),
        Tool("curve", ["workflow/training_so_far.py", "--log", "tent_mlp.csv", "--curve", "curve.png"], ["tent_mlp.csv"], ["curve.png"], is_script=True),
        Tool("export", ["nlg-export", *config, "--checkpoint", "tent_mlp.ckpt", "--basis", "basis.h5", "--shards", held_out, "--out", weights, "--onnx", "tent_mlp.onnx"],
             [CONFIG, "tent_mlp.ckpt", "basis.h5", held_out], [weights, "tent_mlp.onnx"]),
        Tool("bake", ["nlg-bake", "house:1", *config, "--weights", weights, "--json", "bake.json", "--out", "grid.safetensors"], [CONFIG, weights], ["grid.safetensors", "bake.json"]),
        Tool("shader", ["nlg-export", "shader", "--grid", "grid.safetensors", "--out", "shader"], ["grid.safetensors"], ["shader"]),
        Tool("engine", ["nlg-export", "engine", "cornell", "--format", "three", "--spacing-m", "1", "--places", "100", "--truth-rays", "8", "--light-rays", "8", "--out", "engine"], [], ["engine"]),
        Tool("render", ["nlg-render", "house:1", *PICTURE, "--out", "picture.png"], [], ["picture.png"]),
        Tool("view", ["nlg-view", "house:1", *config, "--weights", weights, "--truth-views", "1", "--truth-width", "16", "--truth-rays", "8", "--truth-samples", "16", "--out", "view"],
             [CONFIG, weights], ["view"]),
        Tool("validate", ["nlg-validate", *config, "--weights", weights, "--held-out", held_out, "--training", "training.h5", "--out", "validation"],
             [CONFIG, weights, held_out, "training.h5"], ["validation"]),
        Tool("frontier", ["nlg-validate", "frontier", *config, "--weights", weights, "--held-out", held_out, "--out", "frontier"],
             [CONFIG, weights, held_out], ["frontier"]),
        Tool("stability", ["nlg-validate", "stability", "--short", "--only", "functions", "--weights", weights, "--out", "stability.json"], [weights], ["stability.json"]),
        Tool("light", ["nlg-validate", "light", "two_rooms:0", *config, *LIGHT, "--weights", weights, "--out", "light.json"], [CONFIG, weights], ["light.json"]),
        Tool("report", ["validate/report/report.py", "--summary", "validation/summary.json", "--functions", "validation/functions.csv", "--slices", "validation/slices.json",
                        "--logs", "tent_mlp.csv", "--frontier", "frontier/frontier.json", "--stability", "stability.json", "--light", "light.json",
                        "--savings", "bake.json", "--out", "report.html"],
             ["validation", "tent_mlp.csv", "frontier", "stability.json", "light.json", "bake.json"], ["report.html", "slices.png", "verdict.txt"], is_script=True),
    ]


def files_in(folder):
    """Every file below, links as they are; relative paths in order."""
    found = [os.path.relpath(os.path.join(place, name), folder) for place, _, names in os.walk(folder) for name in names]
    return sorted(found)


def is_temporary(path):
    return ".tmp" in os.path.basename(path)


def read(path):
    with open(path, "rb") as file:
        return file.read()


def reads_as_whole(path):
    """Whether a file whose bytes differ from run to run is whole, by its own format's end."""
    data = read(path)
    if path.endswith(".json"):
        try:
            json.loads(data)
        except ValueError:
            return False
        return True
    ends = {".html": b"</html>", ".png": b"IEND\xaeB`\x82", ".csv": b"\n", ".js": b'");\n'}
    return bool(data) and data.endswith(ends.get(os.path.splitext(path)[1], b""))


class Made:
    """What a tool leaves when nothing disturbs it: a folder of its files, and which of them have the same bytes every time."""

    def __init__(self, folder, again, listing, stderr, seconds):
        self.folder, self.listing, self.stderr, self.seconds = folder, listing, stderr, seconds
        self.same = {path for path in listing if read(os.path.join(folder, path)) == read(os.path.join(again, path))}

    def is_final(self, folder, path):
        """Whether a file is what an undisturbed run leaves."""
        here, there = os.path.join(folder, path), os.path.join(self.folder, path)
        if os.path.islink(there):
            return os.path.islink(here) and os.readlink(here) == os.readlink(there)
        if path in self.same:
            return filecmp.cmp(here, there, shallow=False)
        return reads_as_whole(here)

    def is_whole(self, folder, path):
        """Whether a file is one that stood there whole at some time of an undisturbed run: curves grow by lines, links move on, and
        a page is of the grid alone first, which its scene.js says."""
        here, there = os.path.join(folder, path), os.path.join(self.folder, path)
        if os.path.islink(there):
            return os.path.islink(here) and os.path.exists(here)
        if path.endswith(".csv") and path in self.same:
            return read(there).startswith(read(here)) and reads_as_whole(here)
        return self.is_final(folder, path) or path == "view/scene.js" and reads_as_whole(here)


def lay_out(store, tool, folder):
    """A folder with a tool's inputs, as links to what is there."""
    os.makedirs(folder)
    for name in tool.inputs:
        source, place = os.path.join(store, name), os.path.join(folder, name)
        if os.path.isdir(source):
            shutil.copytree(source, place, copy_function=os.link, symlinks=True)
        else:
            os.link(source, place)


def outputs_in(tool, folder):
    """The files that lie where a tool writes, temporaries beside them included."""
    return [path for path in files_in(folder) if path.split(os.sep)[0] not in tool.inputs and path != "stdout"]


def run_in(injection, tool, folder):
    lay_out(injection.store, tool, folder)
    return trial.run(tool.argv(injection), folder, injection.environment, injection.limits)


def make(injection):
    """Runs every tool twice: name → Made. What it finds made by an earlier call it takes."""
    made = {}
    for tool in injection.tools:
        first, again = (os.path.join(injection.out, "chain", tool.name.replace(" ", "_"), run) for run in ("first", "again"))
        record = os.path.join(os.path.dirname(first), "made.json")
        if not os.path.exists(record):
            shutil.rmtree(os.path.dirname(first), ignore_errors=True)
            with ThreadPoolExecutor(2) as pool:
                endings = list(pool.map(lambda folder: run_in(injection, tool, folder), (first, again)))
            for ending in endings:
                if ending.code != 0:
                    raise SystemExit(f"fault injection: {tool.name}: an undisturbed run must succeed: {ending.words()}")
            if tool.result:
                shutil.copyfile(os.path.join(first, "stdout"), os.path.join(injection.store, tool.result))
            for name in tool.outputs:
                place = os.path.join(injection.store, name)
                if os.path.isdir(os.path.join(first, name)):
                    shutil.copytree(os.path.join(first, name), place, copy_function=os.link, symlinks=True, dirs_exist_ok=True)
                elif not os.path.exists(place):
                    os.link(os.path.join(first, name), place)
            with open(record, "w") as file:
                json.dump({"listing": outputs_in(tool, first), "stderr": endings[0].stderr, "seconds": endings[0].seconds}, file)
        with open(record) as file:
            made[tool.name] = Made(first, again, **json.load(file))
    return made

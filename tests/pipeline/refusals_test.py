#!/usr/bin/python3
"""What every tool refuses: one line on stderr that names what is wrong, the documented exit code, nothing left.

    refusals_test.py BIN_FOLDER

Damaged files are the fault injection's, values of options tests/tool/options_test.cpp's, scenes those of tests/scene and tests/fuzz.
"""
import os
import shutil
import sys

sys.dont_write_bytecode = True
os.environ["NLG_PROGRESS"] = "off"  # a stage of more than a second is a line of its own
sys.path.append(os.path.join(os.path.dirname(os.path.abspath(__file__)), ".."))
from tools import CHECK_FAILED, DAMAGED_FILE, INPUT_ERROR, OUTPUT_ERROR, USAGE_ERROR, Tools, run_checks, words_of, write

SETTINGS = """datagen: {max_functions: 12, test_points: 64}
basis: {components: 8}
train: {steps: 4, batch: 4, checkpoint_steps: 2, start_candidates: 1, width: 16, layers: 2}
bake: {spacing_m: 1.5, extent_m: [0, 0, 0, 2, 2, 2], refine_rounds: 0}
validate: {direct_functions: 1, direct_adam_steps: 2, direct_lm_iterations: 1, direct_restarts: 1, refine_first_steps: 2}
"""
# what each tool can be given, with an output of a name that nothing else has; what makes nothing bad in it is a good call
CALLS = {
    "nlg-datagen": "--scene house:1 --out bad.h5",
    "nlg-pca": "--shards training.h5 --out bad.h5",
    "nlg-cache": "--basis basis.h5 --shards training.h5 --out bad.cache",
    "nlg-train": "--representation tent_mlp --basis basis.h5 --shards training.h5 --held-out held_out.h5 --run bad_run --log bad.csv --out bad.ckpt",
    "nlg-export": "--checkpoint run.ckpt --basis basis.h5 --shards held_out.h5 --out bad.safetensors",
    "nlg-bake": "house:1 --weights weights.safetensors --out bad_grid.safetensors",
    "nlg-validate": "--weights weights.safetensors --held-out held_out.h5 --out bad_validation",
    "nlg-render": "house:1 --width 16 --height 16 --truth-rays 8 --out bad.png",
    "nlg-view": "house:1 --weights weights.safetensors --truth-views 1 --truth-width 16 --out bad_view",
}
# the files among them, each with a sound one of another kind
FOREIGN = {"training.h5": "basis.h5", "held_out.h5": "weights.safetensors", "basis.h5": "training.h5", "run.ckpt": "basis.h5", "weights.safetensors": "run.ckpt"}
GRID_READERS = ["nlg-export shader --grid {} --out bad", "nlg-render house:1 --method grid --grid {} --out bad.png", "nlg-view house:1 --grid {} --out bad"]
SECTIONS = {"nlg-datagen": "datagen", "nlg-pca": "basis", "nlg-train": "train", "nlg-export": "export", "nlg-bake": "bake", "nlg-validate": "validate"}
# what else a good call may be given: tool, words added, words of the refusal
ADDED = [
    ("nlg-datagen", "--spacing-min-m 3 --spacing-max-m 2", "spacing_max_m"), ("nlg-datagen", "--spacing-min-m 0.0001 --spacing-max-m 0.0001", ["134217728", "finest spacing"]),
    ("nlg-export", "--onnx bad.bin", ".onnx"), ("nlg-train", "--cache functions.cache", "--cache"), ("nlg-train", "--device cuda", "--device"),
    ("nlg-train", "--dictionary-resolution 6", "dictionary_resolution"), ("nlg-train", "--rank 2 --processes 2", "--rank"), ("nlg-train", "--processes 2", "--rendezvous"), ("nlg-train", "--batch 1 --processes 2 --rendezvous meeting", "processes"),
    ("nlg-bake", "--extent-m=1,2,3", "extent_m"), ("nlg-bake", "--spacing-m 0.0001", ["1000000 probes", "finest spacing"]), ("nlg-bake", "--max-probes 100", "at most 100 probes"),
    ("nlg-render", "--method grid", "--grid"), ("nlg-render", "--show weights", "--show"), ("nlg-render", "--look 1,2,3", "--eye"),
    ("nlg-render", "--bake --grid weights.safetensors", "--bake"), ("nlg-view", "--baselines unity", "unity"), ("nlg-view", "--light none --extent-m=0,0,0,2,2,2", "--light"),
]
# whole calls
REFUSED = [
    *((INPUT_ERROR, scene.partition(":")[0] or "scene", ["nlg-datagen", "--scene", scene, "--out", "bad.h5"]) for scene in ("missing.glb", "castle:3", "folder", "", "missing.pk3:a", "missing.sh3f:flat:1")),
    (INPUT_ERROR, ["hous:1", "FAMILY:SEED"], "nlg-bake hous:1 --weights weights.safetensors --out bad.safetensors"), (USAGE_ERROR, "scene: ", "nlg-datagen --scene house:x --out bad.h5"),
    (INPUT_ERROR, ["run.ckpt", "a checkpoint of nlg-train, of which nlg-export makes weights"], "nlg-bake house:1 --weights run.ckpt --out bad.safetensors"),
    (USAGE_ERROR, ["representation", "'pf4'"], "nlg-bake house:1 --representation pf4 --out bad.safetensors"),
    (USAGE_ERROR, "… and ", f"nlg-bake house:1 --representation {'pf' * 9000} --out bad.safetensors"),
    # words that are mistyped, before the scene is read
    *((USAGE_ERROR, names, f"nlg-bake missing.glb {option} sun --weights weights.safetensors --out bad.safetensors")
      for option, names in (("--light", ["light", "solved, integrated, point or none", "'sun'"]), ("--light-direct", ["--light-direct: expected all, no_suns, none or reflected", "'sun'"]))),
    # outputs that are empty, folders, inputs
    (USAGE_ERROR, ["--out", "empty"], "nlg-datagen --scene house:1 --out ''"), (USAGE_ERROR, ["--out", "not an input"], "nlg-datagen --scene level.glb --out ./level.glb"),
    (USAGE_ERROR, ["--out", "folder"], "nlg-bake house:1 --weights weights.safetensors --out bad.folder/"),
    (USAGE_ERROR, ["--out", "not an input"], "nlg-bake house:1 --weights weights.safetensors --out ./weights.safetensors"),
    (OUTPUT_ERROR, "file: ", "nlg-export shader --grid grid.safetensors --out file"),
    # grids without light; an info of what is no shard
    *((INPUT_ERROR, ["dark.safetensors", "without light"], reader.format("dark.safetensors")) for reader in GRID_READERS[:1]),
    (INPUT_ERROR, "basis.h5", "nlg-datagen info basis.h5"), (DAMAGED_FILE, "weights.safetensors", "nlg-datagen info weights.safetensors"),
]


def call(tool, *more, by={}):
    """A call of a tool; by: {old: new} of its words."""
    return [tool, *(by.get(word, word) for word in words_of(CALLS[tool])), *more]


def configured(tool, *more, by={}):
    return call(tool, "--config", "good.yaml", *more, by=by)


def make_good_files(tools):
    """One of every file that a stage reads, from next to nothing."""
    write("good.yaml", SETTINGS)
    for command in ("nlg-datagen --config good.yaml --scene house:1 --out training.h5", "nlg-datagen --config good.yaml --scene house:2 --held-out --out held_out.h5",
                    "nlg-pca --config good.yaml --shards training.h5 --held-out held_out.h5 --out basis.h5", "nlg-cache --basis basis.h5 --shards training.h5 --out functions.cache",
                    configured("nlg-train", by={"bad.ckpt": "run.ckpt", "bad_run": "run", "bad.csv": "run.csv"}), configured("nlg-export", by={"bad.safetensors": "weights.safetensors"}),
                    "nlg-bake house:1 --config good.yaml --weights weights.safetensors --out grid.safetensors",
                    "nlg-bake house:1 --config good.yaml --weights weights.safetensors --light none --out dark.safetensors"):
        tools.must(command)
    os.mkdir("folder")
    write("file", "")
    write("level.glb", "")


def check_command_lines(tools):
    for tool, words in CALLS.items():
        tools.refuses(USAGE_ERROR, [], tool)
        tools.refuses(USAGE_ERROR, "--no-such-flag", call(tool, "--no-such-flag"))
        # a training run's state and curve stay: the next attempt goes on from there
        tools.refuses(OUTPUT_ERROR, "file/bad", configured(tool, by={words.split()[-1]: "file/bad.out"}), keeps=["bad_run", "bad.csv"])
    for tool, added, names in ADDED:
        tools.refuses(USAGE_ERROR, names, call(tool, *added.split()))
    for code, names, command in REFUSED:
        tools.refuses(code, names, command)
    tools.refuses(CHECK_FAILED, "parity", call("nlg-export", "--parity-tolerance", "0"))


def check_settings(tools):
    """Of the environment, and of a section of each tool."""
    for variables, names, code, command in [
            ({"NLG_SIMD": "sse9"}, ["NLG_SIMD", "sse9"], USAGE_ERROR, call("nlg-bake")),
            # without weights: those that ship, of which this folder has none
            ({"NLG_WEIGHTS": "folder"}, ["--weights", "pf5.safetensors", "folder"], USAGE_ERROR, "nlg-bake house:1 --representation pf5 --out bad.safetensors"),
            ({"TMPDIR": "/nowhere"}, ["/nowhere", "TMPDIR"], OUTPUT_ERROR, "nlg-datagen plan --scene house:1")]:
        tools.refuses(code, names, command, env={**os.environ, **variables})
    for tool, section in SECTIONS.items():
        write("bad.yaml", f"{section}:\n  no_such_key: 1\n")
        tools.refuses(USAGE_ERROR, "bad.yaml:2:3", call(tool, "--config", "bad.yaml"))
        tools.refuses(INPUT_ERROR, "missing.yaml", call(tool, "--config", "missing.yaml"))


def check_inputs(tools):
    """Every input of every tool: missing, and of another kind."""
    for tool, words in CALLS.items():
        for path in set(words.split()) & set(FOREIGN):
            for bad in ("missing" + os.path.splitext(path)[1], FOREIGN[path]):
                tools.refuses(INPUT_ERROR, bad, configured(tool, by={path: bad}))
    for reader in GRID_READERS:
        for bad in ("missing.safetensors", "weights.safetensors"):
            tools.refuses(INPUT_ERROR, bad, reader.format(bad))


def check_files_that_do_not_belong_together(tools):
    for command in ("nlg-datagen --config good.yaml --scene house:2 --held-out --test-points 128 --out other_test.h5",
                    "nlg-pca --config good.yaml --components 7 --shards training.h5 --out other_basis.h5", "nlg-cache --basis other_basis.h5 --shards training.h5 --out other.cache"):
        tools.must(command)
    # nothing is measured twice: two weights of one representation, one shard twice
    shutil.copy("weights.safetensors", "again.safetensors")
    shutil.copy("held_out.h5", "held_out_again.h5")
    twice, both = "--weights weights.safetensors again.safetensors", "two of tent_mlp: weights.safetensors and again.safetensors"
    for command in ("nlg-validate", "nlg-validate frontier"):
        tools.refuses(USAGE_ERROR, both, f"{command} {twice} --held-out held_out.h5 --out bad")
        tools.refuses(USAGE_ERROR, ": held_out.h5 and held_out_again.h5", f"{command} --weights weights.safetensors --held-out held_out.h5 held_out_again.h5 --out bad")
    for command in ("nlg-validate stability", "nlg-bake house:1"):
        tools.refuses(USAGE_ERROR, both, f"{command} {twice} --out bad")
    other_cache = {"--shards": "--cache", "training.h5": "other.cache"}
    for names, command in [(["other_basis.h5", "SHA-256"], call("nlg-export", by={"basis.h5": "other_basis.h5"})), (["training.h5", "--held-out"], call("nlg-validate", by={"held_out.h5": "training.h5"})),
                           ("other_test.h5", "nlg-validate --weights weights.safetensors --held-out held_out.h5 other_test.h5 --out bad"), (["other.cache", "basis"], configured("nlg-train", by=other_cache))]:
        tools.refuses(INPUT_ERROR, names, command)
    # an unfinished run's state of other options is refused unless asked otherwise
    shutil.copytree("run", "other_run", symlinks=True)
    tools.refuses(INPUT_ERROR, "other_run/step-", configured("nlg-train", "--learning-rate", "0.004", by={"bad_run": "other_run"}))
    tools.check(sorted(os.listdir("other_run")) == sorted(os.listdir("run")), f"nlg-train: changed a run that it refused: {os.listdir('other_run')}")


def check_held_out_sets(tools):
    """A held-out set without functions, or of scenes that are trained on, would give figures that mean nothing."""
    write("empty.gltf", '{"asset": {"version": "2.0"}}')
    tools.must("nlg-datagen --config good.yaml --scene empty.gltf --held-out --out empty.h5")
    for tool in ("nlg-train", "nlg-export", "nlg-validate"):
        tools.refuses(INPUT_ERROR, "empty.h5", configured(tool, by={"held_out.h5": "empty.h5"}))
    tools.refuses(INPUT_ERROR, "empty.h5", configured("nlg-pca", "--held-out", "empty.h5"))
    tools.refuses(INPUT_ERROR, ["training.h5", "house_1"], configured("nlg-train", by={"held_out.h5": "training.h5"}))


def check_what_others_wrote(tools):
    """A file that the tool did not write stays as it is; one that it wrote is replaced."""
    os.mkdir("theirs")
    calls = [(call(tool, by={words.split()[-1]: "theirs.bin"}), "theirs.bin") for tool, words in CALLS.items() if tool in ("nlg-datagen", "nlg-pca", "nlg-cache", "nlg-export", "nlg-render")]
    calls += [("nlg-export shader --grid grid.safetensors --out theirs", "theirs/grid.bin"), ("nlg-export shader --grid grid.safetensors --out theirs", "theirs/look_up.glsl"),
              ("nlg-export onnx --weights weights.safetensors --out theirs.onnx", "theirs.onnx")]
    train = {"bad.ckpt": "their.ckpt", "bad.csv": "their.csv", "bad_run": "their_run"}
    calls += [(configured("nlg-train", by=train), out) for out in ("their.ckpt", "their.csv")]
    calls += [(configured("nlg-validate", by={"bad_validation": "theirs"}), f"theirs/{out}") for out in ("summary.json", "functions.csv", "slices.json")]
    measure = "--weights weights.safetensors --out"
    calls += [(f"nlg-validate light house:1 {measure} theirs.json", "theirs.json"), (f"nlg-validate views house:1 {measure} theirs.json", "theirs.json"),
              (f"nlg-validate frontier --held-out held_out.h5 {measure} theirs", "theirs/frontier.json"), (f"nlg-validate stability {measure} theirs.json", "theirs.json")]
    for command, out in calls:
        write(out, "the level's own buffer")
        tools.refuses(USAGE_ERROR, [out, "another kind of file"], command)
        with open(out) as file:
            tools.check(file.read() == "the level's own buffer", f"{command}: wrote over {out}")
        os.remove(out)
    write("theirs.json", '{"asset": {"version": "2.0"}}')
    tools.refuses(USAGE_ERROR, ["NLG_INPUTS", "another kind of file"], call("nlg-datagen"), env={**os.environ, "NLG_INPUTS": "theirs.json"})
    write("theirs.json", '["a.glb"]\n')
    tools.must(calls[-5][0], env={**os.environ, "NLG_INPUTS": "theirs.json"})
    # once into nothing, once over what it wrote
    for command in {" ".join(words_of(command)): command for command, _ in calls[4:-4]}.values():
        tools.must(command)
        tools.must(command)


if __name__ == "__main__":
    checks = (make_good_files, check_command_lines, check_what_others_wrote, check_settings, check_inputs, check_files_that_do_not_belong_together, check_held_out_sets)
    sys.exit(run_checks(Tools(sys.argv[1]), checks))

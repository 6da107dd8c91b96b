#!/usr/bin/python3
"""Every file of every tool missing, damaged, of another kind, or none at all; files that do not belong together.

    bad_files_test.py BIN_FOLDER FOLDER_OF_GOOD_FILES MAKE_NARROW_SHARD short|whole
"""
import json
import os
import shutil
import sys

sys.dont_write_bytecode = True
sys.path.append(os.path.join(os.path.dirname(os.path.abspath(__file__)), ".."))
from good_files import INPUTS, call, damaged_copies
from tools import DAMAGED_FILE, INPUT_ERROR, USAGE_ERROR, Tools, read, run_checks, write

MAKE_NARROW_SHARD = os.path.abspath(sys.argv[3])
FOREIGN = {"training.h5": "basis.h5", "held_out.h5": "weights.safetensors", "basis.h5": "training.h5", "run.ckpt": "basis.h5", "weights.safetensors": "run.ckpt"}
GRID_READERS = ["nlg-export shader --grid {} --out bad_shader", "nlg-export engine --grid {} --format three --out bad_engine",
                "nlg-export used-by --bake {} --weights weights.safetensors --out bad_weights", "nlg-render house:1 --method grid --grid {} --out bad.png",
                "nlg-view house:1 --grid {} --out bad_view"]


def from_cache(name):
    """A training from a function cache."""
    return call("nlg-train", by={"--shards": "--cache", "training.h5": name})


def check_inputs(tools):
    """Every input of every tool: missing, a folder, of another kind, damaged."""
    damaged = {path: damaged_copies(path) for path in FOREIGN}
    for tool, paths in INPUTS.items():
        for path in paths:
            if path in FOREIGN:
                for bad in [*tools.few(["missing" + os.path.splitext(path)[1], "folder", FOREIGN[path]]), *tools.few(damaged[path])]:
                    tools.refuses(INPUT_ERROR, bad, call(tool, "--config", "good.yaml", by={path: bad}))
    for bad in tools.few(["missing.cache", "folder", "basis.h5", *damaged_copies("functions.cache")]):
        tools.refuses(INPUT_ERROR, bad, [*from_cache(bad), "--config", "good.yaml"])


def check_grids(tools):
    """Every reader of a light grid."""
    bad_grids = ["missing.safetensors", "folder", "weights.safetensors", "good.yaml", *damaged_copies("grid.safetensors")]
    for reader in GRID_READERS:
        for bad in tools.few(bad_grids):
            tools.refuses(INPUT_ERROR, bad, reader.format(bad))
    for reader in GRID_READERS[:2]:
        tools.refuses(INPUT_ERROR, ["dark.safetensors", "without light"], reader.format("dark.safetensors"))
    for weights in ("missing.safetensors", "grid.safetensors", "basis.h5"):
        tools.refuses(INPUT_ERROR, weights, f"nlg-export used-by --bake grid.safetensors --weights {weights} --out bad_weights")
    for what, files in (("shader", ["grid.bin"]), ("engine --format three", ["light.bin", "light.json"])):
        line = json.loads(tools.must(f"nlg-export {what} --grid grid.safetensors --out whole"))
        tools.check(line["bytes"] == sum(os.path.getsize(os.path.join("whole", name)) for name in files), f"nlg-export {what} says {line}")
        shutil.rmtree("whole")


def check_shards(tools):
    """nlg-datagen info: damage anywhere, which is told from what the system refuses and from sound files of another kind."""
    for bad in ("missing.h5", "folder", "basis.h5"):
        tools.refuses(INPUT_ERROR, bad, f"nlg-datagen info {bad}")
    for bad in ("weights.safetensors", *damaged_copies("held_out.h5")):
        tools.refuses(DAMAGED_FILE, bad, f"nlg-datagen info {bad}")
    whole = read("training.h5")
    for place in (9, 700, *range(len(whole) // 12, len(whole), len(whole) // 12), len(whole) - 3):
        write("flipped.h5", whole[:place] + bytes([whole[place] ^ 16]) + whole[place + 1:])
        tools.refuses(DAMAGED_FILE, "flipped.h5", "nlg-datagen info --quiet flipped.h5")
    tools.must([MAKE_NARROW_SHARD, "repeating.h5", "repeating"])
    tools.refuses(INPUT_ERROR, ["repeating.h5", "duplicates"], "nlg-datagen info repeating.h5")
    tools.must("nlg-datagen info --json training.h5 held_out.h5")
    # the right pattern's hash but rows of 16 points: nobody may read 8192 of them
    tools.must([MAKE_NARROW_SHARD, "narrow.h5"])
    for tool, path in (("nlg-pca", "training.h5"), ("nlg-cache", "training.h5"), ("nlg-train", "training.h5"), ("nlg-export", "held_out.h5"), ("nlg-validate", "held_out.h5")):
        tools.refuses(INPUT_ERROR, "narrow.h5", call(tool, "--config", "good.yaml", by={path: "narrow.h5"}))


def check_files_that_do_not_belong_together(tools):
    for command in ("nlg-datagen --config good.yaml --scene house:2 --held-out --test-points 128 --out other_test.h5",
                    "nlg-pca --config good.yaml --components 7 --shards training.h5 --out other_basis.h5",
                    "nlg-cache --basis other_basis.h5 --shards training.h5 --out other.cache",
                    call("nlg-export", "--config", "good.yaml", "--dtype", "float32", by={"bad.safetensors": "other_weights.safetensors"})):
        tools.must(command)
    # nothing is measured twice: two weights of one representation, one shard twice
    shutil.copy("weights.safetensors", "again.safetensors")
    shutil.copy("held_out.h5", "held_out_again.h5")
    twice, both = "--weights weights.safetensors again.safetensors", "two of tent_mlp: weights.safetensors and again.safetensors"
    for command in ("nlg-validate", "nlg-validate frontier"):
        tools.refuses(USAGE_ERROR, both, f"{command} {twice} --held-out held_out.h5 --out bad")
        tools.refuses(USAGE_ERROR, ": held_out.h5 and held_out_again.h5", f"{command} --weights weights.safetensors --held-out held_out.h5 held_out_again.h5 --out bad")
    for command in ("nlg-validate stability", "nlg-export used-by --bake grid.safetensors", "nlg-bake house:1"):
        tools.refuses(USAGE_ERROR, both, f"{command} {twice} --out bad")
    for names, command in [(["other_basis.h5", "SHA-256"], call("nlg-export", by={"basis.h5": "other_basis.h5"})),
                           (["training.h5", "--held-out"], call("nlg-validate", by={"held_out.h5": "training.h5"})),
                           ("other_test.h5", "nlg-validate --weights weights.safetensors --held-out held_out.h5 other_test.h5 --out bad"),
                           (["other.cache", "basis"], [*from_cache("other.cache"), "--config", "good.yaml"]),
                           (["other_weights.safetensors", "SHA-256"], "nlg-export used-by --bake grid.safetensors --weights other_weights.safetensors --out bad")]:
        tools.refuses(INPUT_ERROR, names, command)
    # an unfinished run's state of other options is refused unless asked otherwise
    shutil.copytree("run", "other_run", symlinks=True)
    tools.refuses(INPUT_ERROR, "other_run/step-", call("nlg-train", "--config", "good.yaml", "--learning-rate", "0.004", by={"bad_run": "other_run"}))
    tools.check(sorted(os.listdir("other_run")) == sorted(os.listdir("run")), f"nlg-train: changed a run that it refused: {os.listdir('other_run')}")


def check_held_out_sets(tools):
    """A held-out set without functions, or of scenes that are trained on, would give figures that mean nothing."""
    write("empty.gltf", '{"asset": {"version": "2.0"}}')
    tools.must("nlg-datagen --config good.yaml --scene empty.gltf --held-out --out empty.h5")
    for tool in ("nlg-train", "nlg-export", "nlg-validate"):
        tools.refuses(INPUT_ERROR, "empty.h5", call(tool, "--config", "good.yaml", by={"held_out.h5": "empty.h5"}))
    tools.refuses(INPUT_ERROR, "empty.h5", call("nlg-pca", "--config", "good.yaml", "--held-out", "empty.h5"))
    tools.refuses(INPUT_ERROR, ["training.h5", "house_1"], call("nlg-train", "--config", "good.yaml", by={"held_out.h5": "training.h5"}))


if __name__ == "__main__":
    checks = (check_inputs, check_grids, check_shards, check_files_that_do_not_belong_together, check_held_out_sets)
    sys.exit(run_checks(Tools(sys.argv[1], sys.argv[4]), checks, sys.argv[2]))

#!/usr/bin/python3
"""One of every file that a stage reads, from next to nothing: what tests of bad input begin with.

    good_files.py BIN_FOLDER FOLDER
"""
import os
import shutil
import sys

sys.dont_write_bytecode = True
sys.path.append(os.path.join(os.path.dirname(os.path.abspath(__file__)), ".."))
from tools import Tools, words_of, write

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
# the files among them, by tool
INPUTS = {
    "nlg-datagen": ["house:1"], "nlg-pca": ["training.h5"], "nlg-cache": ["basis.h5", "training.h5"], "nlg-train": ["basis.h5", "training.h5", "held_out.h5"],
    "nlg-export": ["run.ckpt", "basis.h5", "held_out.h5"], "nlg-bake": ["house:1", "weights.safetensors"], "nlg-validate": ["weights.safetensors", "held_out.h5"],
    "nlg-render": ["house:1"], "nlg-view": ["house:1", "weights.safetensors"],
}


def call(tool, *more, **replaced):
    """A call of a tool; replaced: by={old: new} of its words."""
    by = replaced.get("by", {})
    return [tool, *(by.get(word, word) for word in words_of(CALLS[tool])), *more]


def damaged_copies(path):
    """Copies of a file: empty, cut short, garbage, and with a hole of other bytes in the middle."""
    with open(path, "rb") as file:
        whole = file.read()
    stem, suffix = os.path.splitext(path)
    middle = len(whole) // 2
    contents = {"empty": b"", "half": whole[:middle], "short": whole[:-1], "garbage": bytes((i * 37 + 11) % 256 for i in range(4096)),
                "hole": whole[:middle] + b"\xa5" * 64 + whole[middle + 64:]}
    # safetensors has no checksum: numbers that are still finite are as good as any
    if suffix == ".safetensors":
        del contents["hole"]
    return [write(f"{stem}_{how}{suffix}", content) for how, content in contents.items()]


def main():
    tools, folder = Tools(sys.argv[1]), sys.argv[2]
    shutil.rmtree(folder, ignore_errors=True)
    os.makedirs(folder)
    os.chdir(folder)
    os.environ["OPENBLAS_NUM_THREADS"] = "1"
    write("good.yaml", SETTINGS)
    for command in ("nlg-datagen --scene house:1 --out training.h5", "nlg-datagen --scene house:2 --held-out --out held_out.h5",
                    "nlg-pca --shards training.h5 --held-out held_out.h5 --out basis.h5",
                    call("nlg-train", by={"bad.ckpt": "run.ckpt", "bad_run": "run", "bad.csv": "run.csv"}),
                    "nlg-cache --basis basis.h5 --shards training.h5 --out functions.cache", call("nlg-export", by={"bad.safetensors": "weights.safetensors"}),
                    "nlg-bake house:1 --weights weights.safetensors --out grid.safetensors",
                    "nlg-bake house:1 --weights weights.safetensors --light none --out dark.safetensors"):
        has_settings = words_of(command)[0] != "nlg-cache"
        tools.must([*words_of(command), *(["--config", "good.yaml"] if has_settings else [])])
    # what is no file at all is among them, too: scenes and weights of the name "folder"
    os.mkdir("folder")


if __name__ == "__main__":
    main()

#!/usr/bin/python3
"""Every tool with bad command lines, configurations and outputs: one line on stderr that names what is wrong, the documented exit code, nothing left.

    bad_settings_test.py BIN_FOLDER FOLDER_OF_GOOD_FILES short|whole
"""
import os
import sys

sys.dont_write_bytecode = True
os.environ["NLG_PROGRESS"] = "off"  # a stage of more than a second is a line of its own
sys.path.append(os.path.join(os.path.dirname(os.path.abspath(__file__)), ".."))
from good_files import CALLS, call
from tools import CHECK_FAILED, INPUT_ERROR, OUTPUT_ERROR, USAGE_ERROR, Tools, run_checks, write

# tool → flags with values that it refuses, by their names
FLAGS = {
    "nlg-datagen": "--max-functions=0 --spacing-min-m=-1 --spacing-min-m=nan --diffusion-passes=99 --jitter=x --scale=inf --seed=-1",
    "nlg-pca": "--components=0 --components=1e3 --components=99999999999999999999",
    "nlg-cache": "",
    "nlg-train": "--theta-share=1 --steps=0 --batch=-5 --learning-rate=nan --width=1000000 --layers=0 --threads=many",
    "nlg-export": "--parity-functions=0 --parity-tolerance=-1",
    "nlg-bake": "--spacing-m=0 --threads=-1 --refine-seconds=nan --simd=sse9",
    "nlg-validate": "--tau-rmse=2 --direct-functions=0 --threads=1.5",
    "nlg-render": "--method=magic --panel=truth,magic --show=smell --width=0 --samples=-1 --exposure=nan --eye=1,2 --eye=1,2,x --slice-y=1e6",
    "nlg-view": "--baselines=magic --baselines=none,ddgi --truth-views=-1 --truth-width=1 --truth-rays=many --truth-samples=-1 --truth-samples=3 --port=70000 --port=8371",
}
# what else a good call may be given: tool, words added, words of the refusal
ADDED = [
    ("nlg-datagen", "--test-points=17", "test_points"), ("nlg-datagen", "--spacing-min-m 3 --spacing-max-m 2", "spacing_max_m"),
    ("nlg-datagen", "--spacing-min-m 0.0001 --spacing-max-m 0.0001", ["134217728", "finest spacing"]),
    *(("nlg-datagen", f"--extent-m={extent}", "extent_m") for extent in ("1,2,3", "0,0,0,1,1,nan", "0,0,0,1,1,-1", "0,0,0,1,1,x")),
    ("nlg-export", "--dtype float8", ["dtype", "float8"]), ("nlg-export", "--onnx bad.bin", ".onnx"),
    ("nlg-train", "--cache functions.cache", "--cache"), ("nlg-train", "--device tpu", "--device"), ("nlg-train", "--device cuda", "--device"),
    ("nlg-train", "--rank 2 --processes 2", "--rank"), ("nlg-train", "--processes 2", "--rendezvous"), ("nlg-train", "--batch 1 --processes 2 --rendezvous meeting", "processes"),
    ("nlg-bake", "--extent-m=1,2,3", "extent_m"), ("nlg-bake", "--spacing-m 0.0001", ["1000000 probes", "finest spacing"]), ("nlg-bake", "--max-probes 100", "at most 100 probes"), ("nlg-bake", "--theta-precision float8", "float8"),
    ("nlg-bake", "--light-error 0.6", "0.6"), ("nlg-bake", "--light-error none", "none"), ("nlg-render", "--camera=none", "--camera"),
    ("nlg-render", "--method grid", "--grid"), ("nlg-render", "--show weights --grid weights.safetensors", "--probe"), ("nlg-render", "--look 1,2,3", "--eye"),
    ("nlg-render", "--bake --grid weights.safetensors", "--bake"), ("nlg-view", "--baselines unity", "unity"), ("nlg-view", "--light none", "--light"),
]
# whole calls
CALLS_REFUSED = [
    *((USAGE_ERROR, "scene: ", ["nlg-datagen", "--scene", f"house:{seed}", "--out", "bad.h5"]) for seed in ("", "x", "-1", "1.5", "9" * 30)),
    (USAGE_ERROR, ".onnx", "nlg-export onnx --weights weights.safetensors --out bad.bin"),
    (INPUT_ERROR, "basis.h5", "nlg-export onnx --weights basis.h5 --out bad.onnx"),
    (INPUT_ERROR, ["run.ckpt", "a checkpoint of nlg-train, of which nlg-export makes weights"], "nlg-bake house:1 --weights run.ckpt --out bad.safetensors"),
    (USAGE_ERROR, ["--representation", "pf4"], call("nlg-train", by={"tent_mlp": "pf4"})),
    (USAGE_ERROR, ["representation", "'pf4'"], "nlg-bake house:1 --representation pf4 --out bad.safetensors"),
    (USAGE_ERROR, [], "nlg-datagen plan"), (USAGE_ERROR, [], "nlg-datagen info"),
    (INPUT_ERROR, "missing.glb", "nlg-datagen plan --scene missing.glb"),
    (USAGE_ERROR, "--max-functions", "nlg-datagen plan --scene house:1 --max-functions=0"), (USAGE_ERROR, "--jitter", "nlg-datagen plan --scene house:1 --jitter -1"),
    # outputs that are empty, folders, inputs
    (USAGE_ERROR, ["--out", "empty"], "nlg-datagen --scene house:1 --out ''"), (USAGE_ERROR, ["--out", "not an input"], "nlg-datagen --scene level.glb --out ./level.glb"),
    (USAGE_ERROR, ["--out", "not an input"], "nlg-datagen view training.h5 --probe 0 --out training.h5"), (USAGE_ERROR, "--probe", "nlg-datagen view training.h5 --probe -1 --out x.png"),
    (USAGE_ERROR, ["--out", "empty"], "nlg-export shader --grid grid.safetensors --out ''"),
    (USAGE_ERROR, ["--out", "empty"], "nlg-validate --weights weights.safetensors --held-out held_out.h5 --out ''"),
    (USAGE_ERROR, ["--out", "folder"], "nlg-bake house:1 --weights weights.safetensors --out bad.folder/"),
    (USAGE_ERROR, ["--out", "not an input"], "nlg-bake house:1 --weights weights.safetensors --out ./weights.safetensors"),
    (OUTPUT_ERROR, "file", call("nlg-view", by={"bad_view": "file"})),
    *((OUTPUT_ERROR, "file: ", f"nlg-export {what} --out file")
      for what in ("used-by --bake grid.safetensors --weights weights.safetensors", "shader --grid grid.safetensors")),
    (OUTPUT_ERROR, "file/light.ktx2", "nlg-export engine --grid grid.safetensors --format ktx2-sh --out file"),
    (CHECK_FAILED, "parity", call("nlg-export", "--parity-tolerance", "0")),
]
SECTIONS = {"nlg-datagen": "datagen", "nlg-pca": "basis", "nlg-train": "train", "nlg-export": "export", "nlg-bake": "bake", "nlg-validate": "validate"}


def check_command_lines(tools):
    for tool, flags in FLAGS.items():
        tools.refuses(USAGE_ERROR, [], tool)
        tools.refuses(USAGE_ERROR, "--no-such-flag", call(tool, "--no-such-flag"))
        for flag in tools.few(flags.split()) if flags else ():
            tools.refuses(USAGE_ERROR, flag.split("=")[0], call(tool, flag))
    for tool, added, names in ADDED:
        tools.refuses(USAGE_ERROR, names, call(tool, *added.split()))


def check_calls(tools):
    write("file", "")
    write("level.glb", "")
    for code, names, command in CALLS_REFUSED:
        tools.refuses(code, names, command)
    for tool, words in CALLS.items():
        # a training run's state and curve stay: the next attempt goes on from there
        tools.refuses(OUTPUT_ERROR, "file/bad", [*call(tool, "--config", "good.yaml", by={words.split()[-1]: "file/bad.out"})], keeps=["bad_run", "bad.csv"])


def check_environment(tools):
    for variables, names, code, command in [
            ({"NLG_SIMD": "sse9"}, ["NLG_SIMD", "sse9"], USAGE_ERROR, call("nlg-bake")),
            # without weights: those that ship, of which this folder has none
            ({"NLG_WEIGHTS": "folder"}, ["--weights", "pf5.safetensors", "folder"], USAGE_ERROR, "nlg-bake house:1 --representation pf5 --out bad.safetensors"),
            ({"TMPDIR": "/nowhere"}, ["/nowhere", "TMPDIR"], OUTPUT_ERROR, "nlg-datagen plan --scene house:1")]:
        tools.refuses(code, names, command, env={**os.environ, **variables})


def check_configurations(tools):
    for tool, section in SECTIONS.items():
        for content, place in tools.few([(f"{section}:\n  no_such_key: 1\n", "bad.yaml:2:3"), (f"no_such_section: 1\n{section}: {{}}\n", "bad.yaml:1:1"),
                                         (f"{section}: [1, 2]\n", "bad.yaml:1"), (f"{section}: {{\n", "bad.yaml")]):
            write("bad.yaml", content)
            tools.refuses(USAGE_ERROR, place, call(tool, "--config", "bad.yaml"))
        tools.refuses(INPUT_ERROR, "missing.yaml", call(tool, "--config", "missing.yaml"))
    for value in ("-3", "three", "1.5", "[1]", "1e99", "''"):
        write("bad.yaml", f"basis:\n  components: {value}\n")
        tools.refuses(USAGE_ERROR, "bad.yaml:2", call("nlg-pca", "--config", "bad.yaml"))
    tools.must("nlg-datagen plan --config good.yaml --scene house:1 --json")


if __name__ == "__main__":
    sys.exit(run_checks(Tools(sys.argv[1], sys.argv[3]), (check_command_lines, check_calls, check_environment, check_configurations), sys.argv[2]))

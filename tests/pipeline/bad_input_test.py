#!/usr/bin/python3
"""Every tool with bad input: one line on stderr that names the file, the documented exit code, no output, no crash.

    bad_input_test.py BIN_FOLDER MAKE_NARROW_SHARD
"""
import json
import os
import resource
import shutil
import signal
import socket
import struct
import subprocess
import sys
import tempfile
import zipfile
import time

sys.dont_write_bytecode = True

USAGE_ERROR, INPUT_ERROR, OUTPUT_ERROR, CHECK_FAILED, DAMAGED_FILE = 2, 3, 5, 6, 7  # tool/error.h

BIN, MAKE_NARROW_SHARD = os.path.abspath(sys.argv[1]), os.path.abspath(sys.argv[2])
TIMEOUT_FACTOR = float(os.environ.get("NLG_TEST_TIMEOUT_FACTOR", "1"))  # of sanitizers, which slow everything down
SOURCES = os.path.dirname(os.path.dirname(os.path.dirname(os.path.abspath(__file__))))
failures = []
cases = 0


def run(tool, *arguments):
    return subprocess.run([os.path.join(BIN, tool), *arguments], capture_output=True, text=True, timeout=60 * TIMEOUT_FACTOR)


def must(tool, *arguments):
    """Runs a tool that has to succeed: what the cases below are made from."""
    result = run(tool, *arguments)
    if result.returncode != 0:
        sys.exit(f"{tool} {' '.join(arguments)}: exit code {result.returncode}\n{result.stderr}")
    return result.stdout


def refuses(exit_code, names, outputs, tool, *arguments, keeps=()):
    """The tool must end with this code, one line that holds every text of `names`, and leave nothing but what it `keeps`."""
    global cases
    cases += 1
    before = set(os.listdir("."))
    command = f"{tool} {' '.join(arguments)}"
    try:
        result = run(tool, *arguments)
    except subprocess.TimeoutExpired as expired:
        failures.append(f"{command}: still running after {expired.timeout} s")
        return
    lines = result.stderr.splitlines()
    # a command of a tool names itself: "nlg-datagen info: error: "
    name = f"{tool} {arguments[0]}" if arguments and arguments[0] in ("info", "plan", "view", "onnx", "used-by", "shader", "engine", "frontier", "stability") else tool
    errors = [line for line in lines if line.startswith(f"{name}: error: ")]
    if result.returncode != exit_code:
        failures.append(f"{command}: exit code {result.returncode}, expected {exit_code}\n    {result.stderr.strip()}")
    elif len(lines) != 1 or len(errors) != 1:
        failures.append(f"{command}: expected one line on stderr, got {len(lines)}\n    {result.stderr.strip()}")
    for name in names:
        if name not in result.stderr:
            failures.append(f"{command}: stderr does not name '{name}'\n    {result.stderr.strip()}")
    for output in outputs:
        if os.path.exists(output):
            failures.append(f"{command}: left {output} behind")
            shutil.rmtree(output) if os.path.isdir(output) else os.remove(output)
    for path in set(os.listdir(".")) - before - set(outputs) - set(keeps):
        failures.append(f"{command}: left {path} behind")


def write(path, content):
    with open(path, "wb" if isinstance(content, bytes) else "w") as file:
        file.write(content)
    return path


def damaged_copies(path):
    """Copies of a file: empty, cut short, garbage, and with a hole of other bytes in the middle."""
    whole = open(path, "rb").read()
    stem, suffix = os.path.splitext(path)
    yield write(f"{stem}_empty{suffix}", b"")
    yield write(f"{stem}_half{suffix}", whole[: len(whole) // 2])
    yield write(f"{stem}_short{suffix}", whole[:-1])
    yield write(f"{stem}_garbage{suffix}", bytes((i * 37 + 11) % 256 for i in range(4096)))
    middle = len(whole) // 2
    # safetensors has no checksum: numbers that are still finite are as good as any
    if suffix != ".safetensors":
        yield write(f"{stem}_hole{suffix}", whole[:middle] + b"\xa5" * 64 + whole[middle + 64 :])


def make_good_files():
    write("good.yaml", "datagen: {max_functions: 12, test_points: 64}\nbasis: {components: 8}\n"
          "train: {steps: 4, batch: 4, checkpoint_steps: 2, start_candidates: 1, width: 16, layers: 2}\n"
          "bake: {spacing_m: 1.5, extent_m: [0, 0, 0, 2, 2, 2], refine_rounds: 0}\n"
          "validate: {direct_functions: 1, direct_adam_steps: 2, direct_lm_iterations: 1, direct_restarts: 1, refine_first_steps: 2}\n")
    must("nlg-datagen", "--config", "good.yaml", "--scene", "house:1", "--out", "training.h5")
    must("nlg-datagen", "--config", "good.yaml", "--scene", "house:2", "--held-out", "--out", "held_out.h5")
    must("nlg-pca", "--config", "good.yaml", "--shards", "training.h5", "--held-out", "held_out.h5", "--out", "basis.h5")
    must("nlg-train", "--config", "good.yaml", *TRAIN_INPUTS, "--out", "run.ckpt", "--run", "run", "--log", "run.csv")
    must("nlg-cache", *CACHE_INPUTS, "--out", "functions.cache")
    must("nlg-export", "--config", "good.yaml", *EXPORT_INPUTS, "--out", "weights.safetensors")
    must("nlg-validate", "--config", "good.yaml", "--weights", "weights.safetensors", "--held-out", "held_out.h5", "--out", "validation")


TRAIN_INPUTS = ["--representation", "tent_mlp", "--basis", "basis.h5", "--shards", "training.h5", "--held-out", "held_out.h5"]
EXPORT_INPUTS = ["--checkpoint", "run.ckpt", "--basis", "basis.h5", "--shards", "held_out.h5"]
CACHE_INPUTS = ["--basis", "basis.h5", "--shards", "training.h5"]
TRAIN_OUTPUTS = ["bad.ckpt", "bad_run", "bad.csv"]

# tool → what it needs beside --out, and what it would write
TOOLS = {
    "nlg-datagen": (["--scene", "house:1"], ["bad.h5"]),
    "nlg-pca": (["--shards", "training.h5"], ["bad.h5"]),
    "nlg-cache": (CACHE_INPUTS, ["bad.cache"]),
    "nlg-train": (TRAIN_INPUTS + ["--run", "bad_run", "--log", "bad.csv"], TRAIN_OUTPUTS),
    "nlg-export": (EXPORT_INPUTS, ["bad.safetensors"]),
    "nlg-bake": (["house:1", "--weights", "weights.safetensors"], ["bad_grid.safetensors"]),
    "nlg-validate": (["--weights", "weights.safetensors", "--held-out", "held_out.h5"], ["bad_validation"]),
    "nlg-render": (["house:1", "--width", "16", "--height", "16", "--truth-rays", "8"], ["bad.png"]),
    "nlg-view": (["house:1", "--weights", "weights.safetensors", "--truth-views", "1", "--truth-width", "16"], ["bad_view"]),
}


def arguments_of(tool, replaced=None):
    """The good arguments of a tool, some of them replaced."""
    arguments, outputs = TOOLS[tool]
    arguments = [(replaced or {}).get(argument, argument) for argument in arguments]
    return [*arguments, "--out", outputs[0]], outputs


def check_command_lines():
    flags = {
        "nlg-datagen": [("--max-functions", "0"), ("--spacing-min-m", "-1"), ("--spacing-min-m", "nan"), ("--diffusion-passes", "99"),
                        ("--test-points", "17"), ("--jitter", "minus one"), ("--scale", "inf"), ("--seed", "-1")],
        "nlg-pca": [("--components", "0"), ("--components", "1e3"), ("--components", "99999999999999999999")],
        "nlg-cache": [],
        "nlg-train": [("--theta-share", "1"), ("--steps", "0"), ("--batch", "-5"), ("--learning-rate", "nan"), ("--width", "1000000"), ("--layers", "0"),
                      ("--threads", "many")],
        "nlg-export": [("--parity-functions", "0"), ("--parity-tolerance", "-1")],
        "nlg-bake": [("--spacing-m", "0"), ("--threads", "-1"), ("--refine-seconds", "nan"), ("--simd", "sse9"), ("--extent-m", "1,2,3")],
        "nlg-validate": [("--tau-rmse", "2"), ("--direct-functions", "0"), ("--threads", "1.5")],
        "nlg-render": [("--method", "magic"), ("--panel", "truth,magic"), ("--show", "smell"), ("--width", "0"), ("--samples", "-1"), ("--exposure", "nan"),
                       ("--eye", "1,2"), ("--eye", "1,2,x"), ("--camera", "none such"), ("--slice-y", "1e6")],
        "nlg-view": [("--rivals", "magic"), ("--rivals", "none,ddgi"), ("--truth-views", "0"), ("--truth-width", "1"), ("--truth-rays", "many"), ("--places", "-1")],
    }
    for tool in TOOLS:
        arguments, outputs = arguments_of(tool)
        refuses(USAGE_ERROR, [], [], tool)
        refuses(USAGE_ERROR, ["--no-such-flag"], outputs, tool, *arguments, "--no-such-flag")
        for flag, value in flags[tool]:
            # "=" so that a negative number is no flag of its own
            refuses(USAGE_ERROR, [flag.lstrip("-").replace("-", "_") if flag in ("--test-points", "--extent-m") else flag], outputs, tool, *arguments, f"{flag}={value}")
    arguments, outputs = arguments_of("nlg-datagen")
    refuses(USAGE_ERROR, ["spacing_max_m"], outputs, "nlg-datagen", *arguments, "--spacing-min-m", "3", "--spacing-max-m", "2")
    refuses(USAGE_ERROR, ["134217728", "finest spacing"], outputs, "nlg-datagen", *arguments, "--spacing-min-m", "0.0001", "--spacing-max-m", "0.0001")
    for extent in ["1,2,3", "0,0,0,1,1,nan", "0,0,0,1,1,-1", "0,0,0,1,1,x"]:
        refuses(USAGE_ERROR, ["extent_m"], outputs, "nlg-datagen", *arguments, f"--extent-m={extent}")
    for seed in ["", "x", "-1", "1.5", "9" * 30]:
        refuses(USAGE_ERROR, ["scene: "], outputs, "nlg-datagen", "--scene", f"house:{seed}", "--out", "bad.h5")
    arguments, outputs = arguments_of("nlg-export")
    refuses(USAGE_ERROR, ["dtype", "float8"], outputs, "nlg-export", *arguments, "--dtype", "float8")
    refuses(USAGE_ERROR, [".onnx"], ["bad.safetensors", "bad.bin"], "nlg-export", *arguments, "--onnx", "bad.bin")
    refuses(USAGE_ERROR, [".onnx"], ["bad.bin"], "nlg-export", "onnx", "--weights", "weights.safetensors", "--out", "bad.bin")
    refuses(INPUT_ERROR, ["basis.h5"], ["bad.onnx"], "nlg-export", "onnx", "--weights", "basis.h5", "--out", "bad.onnx")
    arguments, outputs = arguments_of("nlg-train", {"tent_mlp": "pf4"})
    refuses(USAGE_ERROR, ["--representation", "pf4"], outputs, "nlg-train", *arguments)
    arguments, outputs = arguments_of("nlg-train")
    for place, more in [("--cache", ["--cache", "functions.cache"]), ("--device", ["--device", "tpu"]), ("--device", ["--device", "cuda"]),
                        ("--rank", ["--rank", "2", "--processes", "2"]), ("--rendezvous", ["--processes", "2"]),
                        ("processes", ["--batch", "1", "--processes", "2", "--rendezvous", "meeting"])]:
        refuses(USAGE_ERROR, [place], outputs, "nlg-train", *arguments, *more)


def check_configurations():
    section = {"nlg-datagen": "datagen", "nlg-pca": "basis", "nlg-train": "train", "nlg-export": "export", "nlg-bake": "bake",
               "nlg-validate": "validate"}
    for tool in section:
        arguments, outputs = arguments_of(tool)
        name = section[tool]
        for content, place in [
            (f"{name}:\n  no_such_key: 1\n", "bad.yaml:2:3"),
            (f"no_such_section: 1\n{name}: {{}}\n", "bad.yaml:1:1"),
            (f"{name}: [1, 2]\n", "bad.yaml:1"),
            (f"{name}: {{\n", "bad.yaml"),
        ]:
            write("bad.yaml", content)
            refuses(USAGE_ERROR, [place], outputs, tool, *arguments, "--config", "bad.yaml")
        refuses(INPUT_ERROR, ["missing.yaml"], outputs, tool, *arguments, "--config", "missing.yaml")
    arguments, outputs = arguments_of("nlg-pca")
    for value in ["-3", "three", "1.5", "[1]", "1e99", "''"]:
        write("bad.yaml", f"basis:\n  components: {value}\n")
        refuses(USAGE_ERROR, ["bad.yaml:2"], outputs, "nlg-pca", *arguments, "--config", "bad.yaml")


def check_inputs():
    """Every input of every tool: missing, a folder, damaged, of another kind."""
    os.mkdir("folder")
    inputs = {
        "nlg-pca": ["training.h5"],
        "nlg-cache": ["basis.h5", "training.h5"],
        "nlg-train": ["basis.h5", "training.h5", "held_out.h5"],
        "nlg-export": ["run.ckpt", "basis.h5", "held_out.h5"],
        "nlg-bake": ["weights.safetensors"],
        "nlg-validate": ["weights.safetensors", "held_out.h5"],
    }
    foreign = {"training.h5": "basis.h5", "held_out.h5": "weights.safetensors", "basis.h5": "training.h5", "run.ckpt": "basis.h5",
               "weights.safetensors": "run.ckpt"}
    damaged = {path: list(damaged_copies(path)) for path in foreign}
    for tool, paths in inputs.items():
        for path in paths:
            for bad in ["missing" + os.path.splitext(path)[1], "folder", foreign[path], *damaged[path]]:
                arguments, outputs = arguments_of(tool, {path: bad})
                refuses(INPUT_ERROR, [bad], outputs, tool, "--config", "good.yaml", *arguments)
    arguments, outputs = arguments_of("nlg-train", {"--shards": "--cache"})
    for bad in ["missing.cache", "folder", "basis.h5", *damaged_copies("functions.cache")]:
        refuses(INPUT_ERROR, [bad], outputs, "nlg-train", "--config", "good.yaml",
                *[bad if argument == "training.h5" else argument for argument in arguments])


def make_strange_files():
    """What has a file's name and is none, by what it is: opened as a file, a pipe would keep its reader waiting for ever."""
    os.makedirs("folder", exist_ok=True)
    os.mkfifo("pipe")
    os.symlink("ring", "ring")
    listening = socket.socket(socket.AF_UNIX)
    listening.bind("socket")
    listening.close()
    return {"pipe": "a pipe", "socket": "a socket", "ring": "Too many levels of symbolic links", "/dev/zero": "a device", "folder": "a directory",
            "x" * 300: "File name too long"}


def check_strange_files():
    """Every reader of every tool with each of them: refused at once, by what it is."""
    strange = make_strange_files()
    inputs = {
        "nlg-datagen": ["house:1"],
        "nlg-pca": ["training.h5"],
        "nlg-cache": ["basis.h5", "training.h5"],
        "nlg-train": ["basis.h5", "training.h5", "held_out.h5"],
        "nlg-export": ["run.ckpt", "basis.h5", "held_out.h5"],
        "nlg-bake": ["house:1", "weights.safetensors"],
        "nlg-validate": ["weights.safetensors", "held_out.h5"],
        "nlg-render": ["house:1"],
        "nlg-view": ["house:1", "weights.safetensors"],
    }
    for name, what in strange.items():
        for tool, paths in inputs.items():
            for path in paths:
                arguments, outputs = arguments_of(tool, {path: name})
                refuses(INPUT_ERROR, [name, what], outputs, tool, *arguments)
            arguments, outputs = arguments_of(tool)
            refuses(INPUT_ERROR, [name, what], outputs, tool, *arguments, "--config", name)
        arguments, outputs = arguments_of("nlg-train", {"--shards": "--cache", "training.h5": name})
        refuses(INPUT_ERROR, [name, what], outputs, "nlg-train", *arguments)
        refuses(INPUT_ERROR, [name, what], [], "nlg-datagen", "info", name)
        refuses(INPUT_ERROR, [name, what], ["bad.png"], "nlg-datagen", "view", name, "--probe", "0", "--out", "bad.png")
        refuses(INPUT_ERROR, [name, what], ["bad.png"], "nlg-render", "house:1", "--grid", name, "--panel", "grid", "--out", "bad.png")
        refuses(INPUT_ERROR, [name, what], ["bad_shader"], "nlg-export", "shader", "--grid", name, "--out", "bad_shader")
        refuses(INPUT_ERROR, [name, what], ["bad_frontier"], "nlg-validate", "frontier", "--weights", name, "--held-out", "held_out.h5", "--out", "bad_frontier")
        code, text = in_time(["/usr/bin/python3", os.path.join(SOURCES, "workflow", "configuration.py"), name])
        if code != USAGE_ERROR or what not in text or len(text.splitlines()) != 1:
            failures.append(f"configuration.py {name}: {code}\n    {text.strip()}")
        code, text = in_time(["/usr/bin/python3", os.path.join(SOURCES, "validate", "report", "report.py"), "--summary", name, "--functions", name, "--slices", name,
                               "--basis", name, "--logs", name, "--out", "bad.html"])
        if code != INPUT_ERROR or what not in text or len(text.splitlines()) != 1:
            failures.append(f"report.py {name}: {code}\n    {text.strip()}")
    # inside of what is whole: buffers and material libraries
    for name, what in strange.items():
        if name.startswith("/"):
            continue
        write("strange.gltf", json.dumps({"asset": {"version": "2.0"}, "buffers": [{"uri": name, "byteLength": 3}]}))
        refuses(INPUT_ERROR, ["strange.gltf", "buffer", what], ["bad.h5"], "nlg-datagen", "--scene", "strange.gltf", "--out", "bad.h5")
        write("strange.obj", f"mtllib {name}\nv 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n")
        refuses(INPUT_ERROR, ["strange.obj", "mtllib", what], ["bad.h5"], "nlg-datagen", "--scene", "strange.obj", "--out", "bad.h5")
    # a file that comes by way of a link, or of the shell, is as good as any
    os.symlink("good.yaml", "link.yaml")
    must("nlg-datagen", "plan", "--config", "link.yaml", "--scene", "house:1")
    with open("good.yaml") as file:
        result = subprocess.run([os.path.join(BIN, "nlg-datagen"), "plan", "--config", "/dev/stdin", "--scene", "house:1"], stdin=file, capture_output=True,
                                text=True, timeout=60 * TIMEOUT_FACTOR)
    if result.returncode != 0:
        failures.append(f"a configuration from /dev/stdin: {result.stderr.strip()}")


def in_time(command):
    """A command's exit code and words."""
    try:
        result = subprocess.run(command, capture_output=True, text=True, timeout=60 * TIMEOUT_FACTOR)
    except subprocess.TimeoutExpired:
        return None, f"still running after {60 * TIMEOUT_FACTOR} s"
    return result.returncode, result.stdout + result.stderr


def sequential_jpeg(side, scans):
    """A JPEG of three channels whose first is in every scan, and each of them empty."""
    def segment(marker, data):
        return bytes([255, marker]) + struct.pack(">H", 2 + len(data)) + data

    tables = [segment(0xC4, bytes([kind, 1]) + bytes(16)) for kind in (0x00, 0x10)]
    frame = struct.pack(">BHHB", 8, side, side, 3) + bytes([1, 0x11, 0, 2, 0x11, 0, 3, 0x11, 0])
    return b"\xff\xd8" + segment(0xDB, b"\0" + b"\1" * 64) + segment(0xC0, frame) + b"".join(tables) + segment(0xDA, bytes([1, 1, 0, 0, 63, 0])) * scans + b"\xff\xd9"


def small_level(shaders):
    """A .bsp with a floor of 100 x 100 units for each shader."""
    lumps = [b""] * 17
    lumps[0] = b'{ "classname" "worldspawn" }'
    for i, name in enumerate(shaders):
        lumps[1] += name.encode().ljust(64, b"\0") + bytes(8)
        lumps[13] += struct.pack("<8I", i, 0xFFFFFFFF, 1, 4 * i, 4, 6 * i, 6, 0xFFFFFFFD) + bytes(72)
        for x, y in [(0, 0), (0, 100), (100, 100), (100, 0)]:
            lumps[10] += struct.pack("<3f", 100 * i + x, y, 0) + bytes(32)
        lumps[11] += struct.pack("<6I", 0, 1, 2, 0, 2, 3)
    lumps[7] = bytes(24) + struct.pack("<4I", 0, len(shaders), 0, 0)
    header, at = b"IBSP" + struct.pack("<I", 46), 144
    for lump in lumps:
        header += struct.pack("<2I", at, len(lump))
        at += len(lump)
    return header + b"".join(lumps)


def check_budgets():
    """Small files that ask for much; all but the last are refused by the budget, the last is read, in time."""
    write_archive("scans.pk3", {"maps/a.bsp": small_level(["a"]), "a.jpg": sequential_jpeg(2048, 20000)})
    refuses(INPUT_ERROR, ["scans.pk3: a.jpg", "pixels of textures, times their scans"], ["bad.h5"], "nlg-datagen", "--scene", "scans.pk3:a", "--out", "bad.h5")
    write("zeros.gltf", json.dumps({"asset": {"version": "2.0"}, "scenes": [{"nodes": [0]}], "nodes": [{"mesh": 0}],
                                    "meshes": [{"primitives": [{"attributes": {"POSITION": 0}}] * 14}],
                                    "accessors": [{"componentType": 5126, "count": 1 << 20, "type": "VEC3"}]}).replace("1048576", "1048575"))
    refuses(INPUT_ERROR, ["zeros.gltf", "mesh 0, primitive 1", "elements of accessors without a buffer view", "2097150"], ["bad.h5"],
            "nlg-datagen", "--scene", "zeros.gltf", "--out", "bad.h5")
    buffers = [{"uri": f"{i}.bin", "byteLength": 3 << 30} for i in range(4)]
    for buffer in buffers:
        open(buffer["uri"], "wb").close()
        os.truncate(buffer["uri"], 3 << 30)
    write("four.gltf", json.dumps({"asset": {"version": "2.0"}, "buffers": buffers}))
    refuses(INPUT_ERROR, ['four.gltf: buffer "1.bin"', "at most 4294967295 bytes"], ["bad.h5"], "nlg-datagen", "--scene", "four.gltf", "--out", "bad.h5")
    for buffer in buffers:
        os.remove(buffer["uri"])
    shaders = [f"s{i}" for i in range(200)]
    image = struct.pack("<3B9x2H2B", 0, 0, 10, 4096, 4096, 24, 0) + b"\xff\x10\x20\x30" * (4096 * 4096 // 128)
    write_archive("shared.pk3", {"maps/a.bsp": small_level(shaders), "big.tga": image,
                                 "scripts/a.shader": "".join(f"{name}\n{{\n{{\nmap big.tga\n}}\n}}\n" for name in shaders)})
    must("nlg-datagen", "plan", "--scene", "shared.pk3:a")
    for tool, *command in [("nlg-datagen",), ("nlg-datagen", "plan"), ("nlg-datagen", "view"), ("nlg-bake",), ("nlg-render",), ("nlg-view",), ("nlg-validate", "light"),
                           ("nlg-validate", "look-up")]:
        if "33554432 triangles" not in must(tool, *command, "--help"):
            failures.append(f"{tool} {' '.join(command)} --help does not say what one scene may take")


def check_control_characters():
    """What a level calls itself must not steer a terminal, nor look like a line of the tool's own."""
    global cases
    for name in ["a\033[2J.obj", "a\x9b2J.obj", "a\nforged.obj"]:
        cases += 1
        write(name, "mtllib none.mtl\nv 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n")
        for command in [["nlg-datagen", "--scene", name, "--max-functions", "2", "--out", "steered.h5"], ["nlg-datagen", "info", "steered.h5"],
                        ["nlg-datagen", "plan", "--scene", name], ["nlg-bake", name, "--weights", "weights.safetensors", "--out", "steered.safetensors"]]:
            result = run(*command)
            shown = result.stderr + (result.stdout if command[1] in ("info", "plan") else "")
            if result.returncode not in (0, INPUT_ERROR) or any(ord(c) < 32 and c not in "\n\t" or 127 <= ord(c) < 160 for c in shown):
                failures.append(f"{command}: {result.returncode}, {shown!r}")
            if "\nforged" in shown:
                failures.append(f"{command}: two lines of one name: {shown!r}")
        for path in [name, "steered.h5", "steered.safetensors"]:
            if os.path.exists(path):
                os.remove(path)


def check_scenes():
    triangle = ('{"asset":{"version":"2.0"},"scene":0,"scenes":[{"nodes":[0]}],"nodes":[{"mesh":0}],'
                '"meshes":[{"primitives":[{"attributes":{"POSITION":0}}]}],'
                '"accessors":[{"bufferView":0,"componentType":5126,"count":%d,"type":"VEC3","min":[0,0,0],"max":[1,1,1]}],'
                '"bufferViews":[{"buffer":0,"byteLength":36}],"buffers":[{"uri":"%s","byteLength":36}]}')
    write("scene.bin", b"\0" * 36)
    scenes = {
        "no_json.gltf": "{",
        "empty.gltf": "",
        "outside.gltf": triangle % (3, "../scene.bin"),
        "absolute.gltf": triangle % (3, "/etc/hostname"),
        "remote.gltf": triangle % (3, "http://localhost/scene.bin"),
        "absent_buffer.gltf": triangle % (3, "nowhere.bin"),
        "too_many.gltf": triangle % (300, "scene.bin"),
        "garbage.glb": b"glTF\x02\0\0\0\xff\xff\xff\x7f garbage",
    }
    for name, content in scenes.items():
        write(name, content)
        refuses(INPUT_ERROR, [name], ["bad.h5"], "nlg-datagen", "--scene", name, "--out", "bad.h5")
    for name in ["missing.glb", "castle:3", "folder", ""]:
        refuses(INPUT_ERROR, [name], ["bad.h5"], "nlg-datagen", "--scene", name, "--out", "bad.h5")


def write_archive(path, entries):
    with zipfile.ZipFile(path, "w", zipfile.ZIP_DEFLATED) as archive:
        for name, content in entries.items():
            archive.writestr(name, content)
    return path


def check_levels():
    """Levels and archives that are none: tests/scene has the many, here are the few that a user meets."""
    write("garbage.bsp", b"IBSP" + b"\xff" * 400)
    write("other.bsp", b"VBSP" + b"\0" * 400)
    write("text.pk3", "no archive")
    write_archive("levels.pk3", {"maps/broken.bsp": b"IBSP.\0\0\0", "maps/empty.bsp": b""})
    write_archive("outside.pk3", {"../maps/a.bsp": b""})
    write("text.sh3f", "no archive")
    write_archive("bare.sh3f", {"a.txt": b""})
    write_archive("wrong.sh3f", {"PluginFurnitureCatalog.properties": b"name#1=Chair\n"})
    whole = open("levels.pk3", "rb").read()
    write("short.pk3", whole[: len(whole) - 30])
    os.makedirs("no_archives", exist_ok=True)
    for scene, names in [("missing.bsp", ["missing.bsp"]), ("garbage.bsp", ["garbage.bsp", "version 46"]), ("other.bsp", ["other.bsp", "IBSP"]),
                         ("missing.pk3:a", ["missing.pk3"]), ("text.pk3:a", ["text.pk3"]), ("short.pk3:broken", ["short.pk3"]),
                         ("outside.pk3:a", ["outside.pk3", "a name inside the archive"]), ("no_archives:a", ["no_archives", ".pk3 files"]),
                         ("levels.pk3:absent", ["absent", "broken, empty"]), ("levels.pk3:", ["levels.pk3"]),
                         ("missing.sh3f:flat:1", ["missing.sh3f"]), ("text.sh3f:flat:1", ["text.sh3f", "ZIP"]), ("bare.sh3f:flat:1", ["bare.sh3f", "PluginFurnitureCatalog"]),
                         ("wrong.sh3f:flat:1", ["wrong.sh3f", "piece 1"]), ("levels.pk3:broken", ["levels.pk3:broken", "header"]), ("levels.pk3:empty", ["levels.pk3:empty", "header"])]:
        refuses(INPUT_ERROR, names, ["bad.h5"], "nlg-datagen", "--scene", scene, "--out", "bad.h5")


def judged(command, scenes, split, report, more):
    """Whether a command takes a configuration, and its words. Absolute folders of archives lie in this one."""
    write("workflow.yaml", f"name: run\nrepresentations: [mlp]\nscenes: {{{scenes}}}\nsplit: {{{split}}}\nreport: {report}\n{more}\n")
    result = subprocess.run([*command, os.path.abspath("workflow.yaml")], capture_output=True, text=True, timeout=120 * TIMEOUT_FACTOR, cwd=SOURCES,
                            env={**os.environ, "NLG_OUT": os.path.abspath("out"), "NLG_LEVELS": "", "NLG_ARCHIVE_ROOT": os.getcwd()})
    return result.returncode, result.stdout + result.stderr


def workflow(scenes, split, report="{}", more=""):
    """Whether snakemake takes a configuration, and its words: a dry run."""
    code, text = judged(["/usr/bin/snakemake", "-n", "-p", "-s", os.path.join(SOURCES, "workflow", "Snakefile"), "--cores", "1", "--nolock", "--configfile"],
                        scenes, split, report, more)
    return code == 0, text


def refuses_configuration(scenes, split, report, words, more=""):
    """pipeline.sh's judgement, which is snakemake's too: one line that holds the words, exit code 2."""
    global cases
    cases += 1
    code, text = judged(["/usr/bin/python3", "workflow/configuration.py"], scenes, split, report, more)
    if code != USAGE_ERROR or words not in text or len(text.splitlines()) != 1 or "workflow.yaml: " not in text:
        failures.append(f"configuration with {scenes}, {split}, {report}, {more}: expected a refusal with '{words}', got {code} and\n    {text.strip()[-600:]}")


def ends_in_one_line(exit_code, words, *command, environment=None):
    """A script that must end with this code and one line that holds the words."""
    global cases
    cases += 1
    result = subprocess.run(command, capture_output=True, text=True, timeout=120 * TIMEOUT_FACTOR, cwd=SOURCES, env={**os.environ, **(environment or {})})
    if result.returncode != exit_code or len(result.stderr.splitlines()) != 1 or words not in result.stderr or "Traceback" in result.stderr:
        failures.append(f"{' '.join(command)}: expected exit code {exit_code} and one line with '{words}', got {result.returncode} and\n    {result.stderr.strip()[-600:]}")


def check_broken_configurations():
    """Files that are no configuration, by the script, by pipeline.sh and by Snakemake: one line, with line and column where there is one."""
    broken = {"empty": (b"", "bad.yaml: top level"), "null": (b"null\n", "bad.yaml: top level"), "map": (b"{}\n", "'name'"), "list": (b"- 1\n", "bad.yaml: top level"),
              "nameless": (b"representations: [mlp]\n", "missing key 'name'"), "cut": (b"name: x\nscenes: [1,\n", "bad.yaml:3:1"), "bytes": (b"name: x\n#\xff", "bad.yaml:2:2"),
              "control": (b"name: x\nsplit: \x01\n", "bad.yaml:2:8"), "date": (b"\nname: 2020-13-45\n", "bad.yaml:2:7"), "digits": (b"name: " + b"9" * 5000, "bad.yaml:1:7"),
              "surrogate": (b'name: "a\\ud800"\n', "name"), "deep": (b"[" * 100000, "bad.yaml"), "loop": (b"&a [*a]\n", "bad.yaml"), "key": (b"? [a]\n: b\n", "bad.yaml:1:3"),
              "twice": (b"name: a\nname: b\n", "bad.yaml:2:1"), "two": (b"a: b\n---\nc: d\n", "bad.yaml:2:1"), "tag": (b"a: !!python/object:os.system x\n", "bad.yaml:1:4")}
    path = os.path.abspath("bad.yaml")
    snakemake = ["/usr/bin/snakemake", "-n", "-s", os.path.join(SOURCES, "workflow", "Snakefile"), "--cores", "1", "--nolock"]
    for name, (content, words) in broken.items():
        write(path, content)
        ends_in_one_line(USAGE_ERROR, words, "/usr/bin/python3", "workflow/configuration.py", path)
        if name in ("empty", "cut"):
            ends_in_one_line(USAGE_ERROR, words, *snakemake, "--config", f"file={path}")
    # what Snakemake takes for a configuration, and we do not
    write(path, "{}\n")
    ends_in_one_line(USAGE_ERROR, "'name'", *snakemake, "--configfile", path)
    ends_in_one_line(USAGE_ERROR, "'name'", *snakemake, "--configfile", "configs/smoke.yaml", "--config", "name=other")
    os.mkfifo("pipe.yaml")
    ends_in_one_line(USAGE_ERROR, "pipe.yaml", "/usr/bin/python3", "workflow/configuration.py", os.path.abspath("pipe.yaml"))
    ends_in_one_line(USAGE_ERROR, "CONFIG", "/usr/bin/python3", "workflow/configuration.py")
    for arguments, words in [(["-x"], "unknown option -x"), (["--plan", "--plam"], "unknown option --plam"), (["a", "b", "c"], "got 3 arguments"),
                             (["none.yaml"], "none.yaml"), (["configs/smoke.yaml", "none"], "none")]:
        ends_in_one_line(USAGE_ERROR, words, "./pipeline.sh", *arguments)


def check_tables_of_scripts():
    """JSON and CSV that the workflow's scripts read: one line that names the file. tests/tool/scripts_test.py has what may be wrong in them."""
    path = os.path.abspath(write("many_digits.json", b'{"cases": [{"ran": ' + b"9" * 400 + b"}]}"))
    for script in (["workflow/failed_cases.py", path], ["workflow/plan.py", "--training", "1", path, "--held-out", "1", path],
                   ["workflow/training_curve.py", "--log", path, "--title", "x", "--out", os.path.abspath("bad.png")]):
        ends_in_one_line(INPUT_ERROR, "many_digits.json", "/usr/bin/python3", *script)
    if os.path.exists("bad.png"):
        failures.append("a refused curve left a picture")


def check_workflow():
    global cases
    os.makedirs("game", exist_ok=True)
    # two levels; one of them in both archives counts once, and what lies in a folder below is none
    write_archive("game/a.pk3", {"maps/one.bsp": b"", "maps/Two.bsp": b"", "maps/sub/three.bsp": b""})
    write_archive("game/b.pk3", {"maps/TWO.bsp": b"", "textures/two.tga": b""})
    os.makedirs("bad_game", exist_ok=True)
    write_archive("bad_game/a.pk3", {"maps/a b.bsp": b""})
    os.makedirs("text_game", exist_ok=True)
    write("text_game/a.pk3", "no archive")
    basis = "families: [house], per_family: 3, folder: '', jitters: 1"
    game = basis + ", archives: [{folder: /game, maps: ['*']}]"
    held_out = "held_out: [house_2]"
    # what the configuration needs of an archive of furniture is that it is there
    os.makedirs("homes", exist_ok=True)
    write("homes/Big Shop.sh3f", "")
    homes = basis.replace("jitters: 1", "jitters: 3") + ", furniture: [{archives: [/homes/Big Shop.sh3f], plans: [flat, villa], seeds: 2, first_seed: 5}]"

    accepted = [
        (homes, held_out + ", evaluation: ['villa_*_big-shop']",
         ["/homes/Big Shop.sh3f:flat:5", "dataset/training/flat_6_big-shop.0.h5", "dataset/training/house_0.2.h5", "dataset/evaluation/villa_6_big-shop.0.h5"]),
        (basis, held_out, ["--scene house:0"]),
        (game, held_out + ", evaluation: [two]", ["/game:one", "dataset/evaluation/two.0.h5", "dataset/training/one.0.h5", "/game:two --jitter 0 --held-out"]),
        # one scene of each split in the reports' tables of savings, with what a bake can take of the scene's options
        (game + ", by_scene: {'*': {max_functions: 3, extent_m: [0, 0, 0, 3, 3, 3]}}", held_out + ", evaluation: [two, house_1]",
         ["nlg-bake house:2 ", "nlg-bake house:1 ", "--extent-m=0,0,0,3,3,3 --weights", "out/run/evaluation/report.html", "--scene two_rooms ", "--scene table "]),
        (basis + ", by_scene: {'house_*': {max_functions: 3, scale: 0.5}, house_1: {max_functions: 4, extent_m: [0, 0, 0, 3, 3, 3]}}", held_out,
         ["--max-functions=3 --scale=0.5", "--extent-m=0,0,0,3,3,3 --max-functions=4 --scale=0.5"]),
    ]
    for scenes, split, words in accepted:
        cases += 1
        is_taken, text = workflow(scenes, split)
        for word in [] if is_taken else ["a configuration that is taken"]:
            failures.append(f"workflow with {scenes}, {split}: expected {word}, got\n    {text}")
        for word in words:
            if is_taken and word not in text:
                failures.append(f"workflow with {scenes}, {split}: its commands do not hold '{word}'")
        if is_taken and any(word in text for word in ("dataset/training/villa", "big-shop.1.h5")):
            failures.append(f"workflow with {scenes}, {split}: trains on a plan of the evaluation, or on a variant of an interior")
        if is_taken and "dataset/training/two" in text:
            failures.append(f"workflow with {scenes}, {split}: trains on a scene of the evaluation")

    for report, words, absent in [("{small_scenes: [], savings: [], stability: short}", ["stability --short"], ["nlg-solve", "nlg-bake", "training_cases", "--hierarchy", "--needs"]),
                                  ("{stability: long, savings: ['*_2'], savings_rounds: 3}", ["stability --long", "--measure-savings 3", "training_cases"], [])]:
        cases += 1
        is_taken, text = workflow(basis, held_out, report)
        if not is_taken or any(word not in text for word in words) or any(word in text for word in absent):
            failures.append(f"workflow with report {report}: expected {words} and no {absent}, got\n    {text.strip()[-1500:]}")
    # a short run, and the full one by one key: what `full` holds goes over the file's own, a representation's or scene's own over that
    full = "full: {train: {steps: 77}, datagen: {max_functions: 9, scale: 0.5}, scenes: {per_family: 5}, report: {stability: long, savings: []}}"
    options = (basis + ", by_scene: {house_1: {max_functions: 4}}", held_out, "{stability: short, savings: [house_2]}")
    for effort, words, absent in [("", ["stability --short", "--measure-savings", "--max-functions=4"], ["--steps", "--scale", "house:4"]),
                                  ("effort: full\n", ["stability --long", "--steps=77", "--max-functions=4 --scale=0.5", "--max-functions=9 --scale=0.5", "house:4"],
                                   ["--measure-savings"])]:
        cases += 1
        is_taken, text = workflow(*options, more=effort + full)
        if not is_taken or any(word not in text for word in words) or any(word in text for word in absent):
            failures.append(f"workflow with {effort}: expected {words} and no {absent}, got\n    {text.strip()[-1500:]}")
    for more, words in [("effort: half", "short or full, got 'half'"), ("effort: [full]", "short or full"), ("full: {name: x}", "unknown key 'name'"), ("full: 3", "full: expected keys"),
                        ("full: {train: {Steps: 1}}", "options of that section"), ("train: [steps]", "a map of options"), ("colour: red", "unknown key 'colour'"),
                        ("train: {steps: 2001-01-01}", "a text, a number"), ("train: {1: 2}", "keys that are texts"), ("train: {a: 1, a: 2}", "each key once"),
                        ("effort: full\nfull: {report: {savings: [house_0]}}", "held out or for the evaluation")]:
        # a place in the file, where the YAML itself is at fault
        if words == "each key once":
            code, text = judged(["/usr/bin/python3", "workflow/configuration.py"], basis, held_out, "{}", more)
            if code != USAGE_ERROR or "workflow.yaml:6:15: " not in text or words not in text:
                failures.append(f"a key twice: {code}, {text}")
            continue
        refuses_configuration(basis, held_out, "{}", words, more)
    for light, words in [("{colour: red}", "unknown key 'colour'"), ("{scenes: 'cornell:0'}", "a list of scenes"), ("{scenes: ['cornell:0', 'cornell:0']}", "names of their own"),
                         ("{scenes: ['::']}", "names of their own"), ("{spacings: []}", "1 to 16 distances"), ("{spacings: [0]}", "1 to 16 distances"), ("{spacings: [true]}", "1 to 16 distances"),
                         ("{air_places: 4}", "an integer from 8 to 10000000, got 4"), ("{walks: 1.5}", "an integer from 1"), ("{look_up_seconds: -1}", "a number from 0 to 600")]:
        refuses_configuration(basis, held_out, "{}", words, f"validate_light: {light}")
    cases += 1
    is_taken, text = workflow(basis, held_out, more="validate_light: {scenes: ['cornell:0'], spacings: [1, 0.5], walks: 3}")
    for word in ("nlg-validate light cornell:0", "--walks=3", "--spacings 1 0.5 --pictures", "light/cornell_0_places", "light/cornell_0.json", "--light "):
        if not is_taken or word not in text:
            failures.append(f"workflow with light: expected '{word}', got\n    {text.strip()[-1500:]}")
    for report, words in [("{colour: red}", "unknown key 'colour'"), ("[a]", "report: expected a map"), ("{savings: house_2}", "a list of names or patterns"),
                          ("{savings: [house_0]}", "held out or for the evaluation, got 'house_0'"), ("{savings_rounds: 1.5}", "an integer from 0 to 99, got 1.5"),
                          ("{needs: [house_2]}", "called 'savings' now"),
                          ("{savings_rounds: true}", "an integer from 0 to 99"), ("{small_scenes: [cellar]}", "a list out of two_rooms"),
                          ("{small_scenes: column}", "a list out of two_rooms"), ("{stability: brief}", "one of short, full, long, got 'brief'"),
                          ("{stability: [full]}", "one of short, full, long")]:
        refuses_configuration(basis, held_out, report, words)

    def archives(text):
        return f"{basis}, archives: [{text}]", held_out

    def furniture(text):
        return f"{basis}, furniture: [{text}]", held_out

    shop = "archives: [/homes/Big Shop.sh3f]"
    refused = [
        (*furniture("homes"), "furniture: 0: expected keys"),
        (*furniture(f"{{{shop}, plans: [flat]}}"), "missing key 'seeds'"),
        (*furniture(f"{{{shop}, plans: [flat], seeds: 1, colour: red}}"), "unknown key 'colour'"),
        (*furniture(f"{{{shop}, plans: [castle], seeds: 1}}"), "a list out of flat, townhouse, office, villa"),
        (*furniture(f"{{{shop}, plans: [], seeds: 1}}"), "a list out of flat"),
        (*furniture(f"{{{shop}, plans: [flat], seeds: 0}}"), "an integer from 1"),
        (*furniture(f"{{{shop}, plans: [flat], seeds: true}}"), "an integer from 1"),
        (*furniture(f"{{{shop}, plans: [flat], seeds: 1, first_seed: -1}}"), "an integer from 0"),
        (*furniture(f"{{{shop}, plans: [flat], seeds: 1000000000}}"), "at most 1000000 scenes"),
        (*furniture(f"{{{shop}, plans: [flat, flat], seeds: 1}}"), "flat_0_big-shop twice"),
        (*furniture("{archives: [/game/a.pk3], plans: [flat], seeds: 1}"), "a list of .sh3f files"),
        (*furniture("{archives: [/nowhere/A.sh3f], plans: [flat], seeds: 1, install: apt install some-furniture}"),
         "nowhere/A.sh3f, got none; install it: apt install some-furniture"),
        (basis + ", furniture: shop", held_out, "furniture: expected a list"),
        (basis + ", colour: red", held_out, "unknown key 'colour'"),
        (basis, held_out + ", tests: []", "unknown key 'tests'"),
        (basis, held_out + ", test: []", "it is called 'evaluation' now"),
        (basis, held_out + ", evaluation: [castle_*]", "expected a pattern of some scene, got 'castle_*'"),
        (basis, held_out + ", evaluation: [house_2]", "house_2 in both"),
        (basis, held_out + ", evaluation: house_1", "a list of names or patterns"),
        (basis.replace("per_family: 3", "per_family: 200000, jitters: 200").replace(", jitters: 1", ""), held_out, "at most 1000000 shards"),
        (*archives("{folder: /game, maps: ['*'], colour: red}"), "unknown key 'colour'"),
        (*archives("{folder: /game}"), "missing key 'maps'"),
        (*archives("game"), "archives: 0"),
        (*archives("{folder: /game, maps: one}"), "a list of names or patterns"),
        (*archives("{folder: /game, maps: [four]}"), "got 'four'"),
        (*archives("{folder: /game, maps: ['*'], without: [four]}"), "got 'four'"),
        (*archives("{folder: /game, maps: ['*']}, {folder: /game, maps: [one]}"), "names of their own"),
        (*archives("{folder: /nowhere, maps: ['*'], install: apt install some-game}"), "nowhere, got none; install them: apt install some-game"),
        (*archives("{folder: /bad_game, maps: ['*']}"), "a b"),
        (*archives("{folder: /text_game, maps: ['*']}"), "text_game/a.pk3"),
        (basis + ", by_scene: {castle: {max_functions: 3}}", held_out, "expected a pattern of some scene, got 'castle'"),
        (basis + ", by_scene: {house_1: {out: x}}", held_out, "an option of the datagen section"),
        (basis + ", by_scene: {house_1: {seed: [x]}}", held_out, "a number, a text or a list of numbers"),
        (basis + ", by_scene: {house_1: 3}", held_out, "options of nlg-datagen"),
    ]
    for scenes, split, words in refused:
        refuses_configuration(scenes, split, "{}", words)
    for value in ["0", "4097", "two", "true", "1.5", "null"]:
        refuses_configuration(basis, held_out, "{}", "train: processes: expected an integer from 1 to 4096", more=f"train: {{processes: {value}}}")
    # processes of a training are started where they are asked for, on a core each
    is_taken, text = workflow(basis, held_out, more="train: {processes: 3, threads: 2}")
    if not is_taken or "workflow/train_together.sh 3 " not in text:
        failures.append(f"three processes that train together: {text}")
    # snakemake ends with the same words
    is_taken, text = workflow(basis, held_out + ", tests: []")
    if is_taken or "unknown key 'tests'" not in text:
        failures.append(f"snakemake takes what pipeline.sh refuses: {text}")


def check_shards():
    """nlg-datagen info: every damage, anywhere, which is told from what the system refuses and from sound files of another kind."""
    for bad in ["missing.h5", "folder", "basis.h5"]:
        refuses(INPUT_ERROR, [bad], [], "nlg-datagen", "info", bad)
    for bad in ["weights.safetensors", *damaged_copies("held_out.h5")]:
        refuses(DAMAGED_FILE, [bad], [], "nlg-datagen", "info", bad)
    whole = open("training.h5", "rb").read()
    for place in [9, 700, *range(len(whole) // 12, len(whole), len(whole) // 12), len(whole) - 3]:
        write("flipped.h5", whole[:place] + bytes([whole[place] ^ 16]) + whole[place + 1 :])
        refuses(DAMAGED_FILE, ["flipped.h5"], [], "nlg-datagen", "info", "--quiet", "flipped.h5")
    subprocess.run([MAKE_NARROW_SHARD, "repeating.h5", "repeating"], check=True)
    refuses(INPUT_ERROR, ["repeating.h5", "duplicates"], [], "nlg-datagen", "info", "repeating.h5")
    refuses(USAGE_ERROR, [], [], "nlg-datagen", "info")
    must("nlg-datagen", "info", "--json", "training.h5", "held_out.h5")


def check_bakes():
    """What only nlg-bake can be given: several weights, weights for its output, scenes with nothing in them, a machine's SIMD."""
    write("bare.gltf", '{"asset": {"version": "2.0"}}')
    shutil.copy("weights.safetensors", "again.safetensors")
    out = ["--out", "bad_grid.safetensors"]
    refuses(USAGE_ERROR, ["--weights", "two of tent_mlp: weights.safetensors and again.safetensors"], ["bad_grid.safetensors"], "nlg-bake", "house:1", "--weights", "weights.safetensors", "again.safetensors", *out)
    refuses(USAGE_ERROR, ["--out", "no input"], [], "nlg-bake", "house:1", "--weights", "weights.safetensors", "--out", "./weights.safetensors")
    # without weights: those that ship, of which this folder has none
    os.environ["NLG_WEIGHTS"] = "folder"
    refuses(USAGE_ERROR, ["--weights", "pf5.safetensors", "folder"], ["bad_grid.safetensors"], "nlg-bake", "house:1", "--representation", "pf5", *out)
    refuses(USAGE_ERROR, ["representation", "'pf4'"], ["bad_grid.safetensors"], "nlg-bake", "house:1", "--representation", "pf4", *out)
    del os.environ["NLG_WEIGHTS"]
    arguments, outputs = arguments_of("nlg-bake", {"house:1": "bare.gltf"})
    refuses(INPUT_ERROR, ["bare.gltf", "triangle"], outputs, "nlg-bake", *arguments)
    for rounds in ["-1", "100", "x"]:
        arguments, outputs = arguments_of("nlg-bake")
        refuses(USAGE_ERROR, ["--measure-savings"], outputs, "nlg-bake", *arguments, f"--measure-savings={rounds}")
    for scene in ["missing.glb", "castle:3", "folder"]:
        arguments, outputs = arguments_of("nlg-bake", {"house:1": scene})
        refuses(INPUT_ERROR, [scene], outputs, "nlg-bake", *arguments)
    arguments, outputs = arguments_of("nlg-bake")
    for flag, value in [("theta_precision", "float8"), ("light_form", "sh3"), ("light_form", "none"), ("generator_precision", "int3")]:
        refuses(USAGE_ERROR, [flag, value], outputs, "nlg-bake", *arguments, f"--{flag.replace('_', '-')}", value)
    refuses(USAGE_ERROR, ["134217728"], outputs, "nlg-bake", *arguments, "--spacing-m", "0.0001")
    os.environ["NLG_SIMD"] = "sse9"
    refuses(USAGE_ERROR, ["NLG_SIMD", "sse9"], outputs, "nlg-bake", *arguments)
    del os.environ["NLG_SIMD"]


def check_renders():
    """What only nlg-render is given: light grids, and methods that need one."""
    for bad in ["missing.safetensors", "folder", "weights.safetensors", "basis.h5"]:
        refuses(INPUT_ERROR, [bad], ["bad.png"], "nlg-render", "house:1", "--method", "grid", "--grid", bad, "--out", "bad.png")
    for arguments, place in [(["--method", "grid"], "--grid"), (["--show", "weights", "--grid", "weights.safetensors"], "--probe"),
                             (["--look", "1,2,3"], "--eye"), (["--bake", "--grid", "weights.safetensors"], "--bake")]:
        refuses(USAGE_ERROR, [place], ["bad.png"], "nlg-render", "house:1", *arguments, "--out", "bad.png")


def check_views():
    """What only nlg-view is given: light grids, rivals that a scene does not have, folders that are none."""
    for bad in ["missing.safetensors", "folder", "weights.safetensors", "basis.h5"]:
        refuses(INPUT_ERROR, [bad], ["bad_view"], "nlg-view", "house:1", "--grid", bad, "--out", "bad_view")
    arguments, outputs = arguments_of("nlg-view")
    refuses(USAGE_ERROR, ["--rivals", "quake-grid"], outputs, "nlg-view", *arguments, "--rivals", "quake-grid")
    refuses(USAGE_ERROR, ["--light"], outputs, "nlg-view", *arguments, "--light", "none")
    write("file", "")
    refuses(OUTPUT_ERROR, ["file"], [], "nlg-view", *arguments[:-1], "file")
    refuses(USAGE_ERROR, ["--out"], [], "nlg-view", *arguments[:-1], "")


def check_weights_used_by():
    """nlg-export used-by: no bake, damaged ones, weights that are none or that the bake was not given."""
    must("nlg-bake", "house:1", "--weights", "weights.safetensors", "--config", "good.yaml", "--out", "grid.safetensors")
    for bake in ["missing.safetensors", "missing.json", "folder", "weights.safetensors", "good.yaml", *damaged_copies("grid.safetensors")]:
        refuses(INPUT_ERROR, [bake], ["bad_weights"], "nlg-export", "used-by", "--bake", bake, "--weights", "weights.safetensors", "--out", "bad_weights")
    for weights in ["missing.safetensors", "grid.safetensors", "basis.h5"]:
        refuses(INPUT_ERROR, [weights], ["bad_weights"], "nlg-export", "used-by", "--bake", "grid.safetensors", "--weights", weights, "--out", "bad_weights")
    must("nlg-export", "--config", "good.yaml", *EXPORT_INPUTS, "--dtype", "float32", "--out", "other_weights.safetensors")
    refuses(INPUT_ERROR, ["other_weights.safetensors", "SHA-256"], ["bad_weights"], "nlg-export", "used-by", "--bake", "grid.safetensors",
            "--weights", "other_weights.safetensors", "--out", "bad_weights")
    refuses(USAGE_ERROR, ["two of tent_mlp: weights.safetensors and again.safetensors"], ["bad_weights"], "nlg-export", "used-by", "--bake", "grid.safetensors",
            "--weights", "weights.safetensors", "again.safetensors", "--out", "bad_weights")
    write("file", "")
    refuses(OUTPUT_ERROR, ["file: "], [], "nlg-export", "used-by", "--bake", "grid.safetensors", "--weights", "weights.safetensors", "--out", "file")


def check_shader():
    """nlg-export shader: no grid, damaged ones, one without light; a folder that is a file."""
    for grid in ["missing.safetensors", "folder", "weights.safetensors", "good.yaml", *damaged_copies("grid.safetensors")]:
        refuses(INPUT_ERROR, [grid], ["bad_shader"], "nlg-export", "shader", "--grid", grid, "--out", "bad_shader")
    must("nlg-bake", "house:1", "--weights", "weights.safetensors", "--config", "good.yaml", "--light", "none", "--out", "dark.safetensors")
    refuses(INPUT_ERROR, ["dark.safetensors", "without light"], ["bad_shader"], "nlg-export", "shader", "--grid", "dark.safetensors", "--out", "bad_shader")
    refuses(OUTPUT_ERROR, ["file: "], [], "nlg-export", "shader", "--grid", "grid.safetensors", "--out", "file")
    for command in (["nlg-export", "shader", "--grid", "grid.safetensors"], ["nlg-validate", "--weights", "weights.safetensors", "--held-out", "held_out.h5"]):
        refuses(USAGE_ERROR, ["--out", "empty"], [], *command, "--out", "")
    refuses(USAGE_ERROR, ["--out", "folder"], [], "nlg-bake", "house:1", "--weights", "weights.safetensors", "--out", "bad.folder/")
    refuses(INPUT_ERROR, ["hous:1", "FAMILY:SEED"], [], "nlg-bake", "hous:1", "--weights", "weights.safetensors", "--out", "bad.out")
    line = json.loads(must("nlg-export", "shader", "--grid", "grid.safetensors", "--out", "shader"))
    if line["bytes"] != os.path.getsize("shader/grid.bin") or line["bytes"] <= line["tree_bytes"] + line["light_bytes"] + line["theta_bytes"]:
        failures.append(f"nlg-export shader says {line}")


def check_engine():
    """nlg-export engine: no grid, damaged ones, one without light; a folder that is a file. Settings: tests/export/engine/engine_files_test.py."""
    for grid in ["missing.safetensors", "folder", "weights.safetensors", "good.yaml", *damaged_copies("grid.safetensors")]:
        refuses(INPUT_ERROR, [grid], ["bad_engine"], "nlg-export", "engine", "--grid", grid, "--format", "three", "--out", "bad_engine")
    refuses(INPUT_ERROR, ["dark.safetensors", "without light"], ["bad_engine"], "nlg-export", "engine", "--grid", "dark.safetensors", "--format", "bevy",
            "--out", "bad_engine")
    refuses(USAGE_ERROR, ["c-header", "unity"], ["bad_engine"], "nlg-export", "engine", "--grid", "grid.safetensors", "--format", "unity", "--out", "bad_engine")
    refuses(OUTPUT_ERROR, ["file/light.ktx2"], [], "nlg-export", "engine", "--grid", "grid.safetensors", "--format", "bevy", "--out", "file")
    line = json.loads(must("nlg-export", "engine", "--grid", "grid.safetensors", "--format", "three", "--out", "three"))
    if line["bytes"] != sum(os.path.getsize(os.path.join("three", name)) for name in ["light.bin", "light.json"]):
        failures.append(f"nlg-export engine says {line}")


def check_plans():
    refuses(USAGE_ERROR, [], [], "nlg-datagen", "plan")
    refuses(INPUT_ERROR, ["missing.glb"], [], "nlg-datagen", "plan", "--scene", "missing.glb")
    refuses(USAGE_ERROR, ["--max-functions"], [], "nlg-datagen", "plan", "--scene", "house:1", "--max-functions=0")
    refuses(USAGE_ERROR, ["--jitter"], [], "nlg-datagen", "plan", "--scene", "house:1", "--jitter", "-1")
    os.environ["TMPDIR"] = "/nowhere"
    refuses(OUTPUT_ERROR, ["/nowhere", "TMPDIR"], [], "nlg-datagen", "plan", "--scene", "house:1")
    del os.environ["TMPDIR"]
    must("nlg-datagen", "plan", "--config", "good.yaml", "--scene", "house:1", "--json")


def check_full_disk():
    """A shard larger than any file may be: nothing stays, and the line says what it needs."""
    def limit():
        signal.signal(signal.SIGXFSZ, signal.SIG_IGN)
        resource.setrlimit(resource.RLIMIT_FSIZE, (300000, 300000))

    before = set(os.listdir("."))
    result = subprocess.run([os.path.join(BIN, "nlg-datagen"), "--scene", "house:1", "--out", "large.h5"], capture_output=True, text=True,
                            preexec_fn=limit, timeout=60 * TIMEOUT_FACTOR)
    if result.returncode != OUTPUT_ERROR or set(os.listdir(".")) != before:
        failures.append(f"file size limit: exit code {result.returncode}, left {set(os.listdir('.')) - before}")
    for words in ["large.h5", "it needs", "are free"]:
        if words not in result.stderr:
            failures.append(f"file size limit: stderr does not say '{words}'\n    {result.stderr.strip()}")
    # whatever is at work on it then, HDF5 included: the user asked for no temporary file
    for size in (0, 3000, 100000):
        result = subprocess.run([os.path.join(BIN, "nlg-datagen"), "--scene", "house:1", "--out", "large.h5"], capture_output=True, text=True,
                                preexec_fn=lambda: (signal.signal(signal.SIGXFSZ, signal.SIG_IGN), resource.setrlimit(resource.RLIMIT_FSIZE, (size, size))),
                                timeout=60 * TIMEOUT_FACTOR)
        if result.returncode != OUTPUT_ERROR or ".tmp." in result.stderr or len(result.stderr.splitlines()) != 1:
            failures.append(f"file size limit {size}: exit code {result.returncode}\n    {result.stderr.strip()}")


def check_killed_run():
    """kill -9 midway: no shard, no half of one under its name; the next run sweeps up what was left."""
    process = subprocess.Popen([os.path.join(BIN, "nlg-datagen"), "--scene", "cave:1", "--spacing-min-m", ".7", "--spacing-max-m", ".7",
                                "--max-functions", "1000000", "--out", "killed/shard.h5"], stdout=subprocess.DEVNULL)
    for _ in range(600):
        if os.path.isdir("killed") and os.listdir("killed"):
            break
        time.sleep(0.05)
    process.kill()
    process.wait()
    left = os.listdir("killed")
    if "shard.h5" in left or not left:
        failures.append(f"killed run: left {left}, expected a temporary file alone")
    must("nlg-datagen", "--config", "good.yaml", "--scene", "house:1", "--out", "killed/shard.h5")
    if os.listdir("killed") != ["shard.h5"]:
        failures.append(f"after a killed run: {os.listdir('killed')}")


def check_inputs_that_do_not_belong_together():
    must("nlg-datagen", "--config", "good.yaml", "--scene", "house:2", "--held-out", "--test-points", "128", "--out", "other_test.h5")
    must("nlg-pca", "--config", "good.yaml", "--components", "7", "--shards", "training.h5", "--out", "other_basis.h5")
    write("empty.yaml", "datagen: {max_functions: 1, spacing_min_m: 50, spacing_max_m: 50}\n")
    arguments, outputs = arguments_of("nlg-export", {"basis.h5": "other_basis.h5"})
    refuses(INPUT_ERROR, ["other_basis.h5", "SHA-256"], outputs, "nlg-export", *arguments)
    arguments, outputs = arguments_of("nlg-validate", {"held_out.h5": "training.h5"})
    refuses(INPUT_ERROR, ["training.h5", "--held-out"], outputs, "nlg-validate", *arguments)
    # nothing is measured twice: two weights of one representation, one shard twice
    shutil.copy("weights.safetensors", "again.safetensors")
    shutil.copy("held_out.h5", "held_out_again.h5")
    twice, both = ["--weights", "weights.safetensors", "again.safetensors"], ["two of tent_mlp: weights.safetensors and again.safetensors"]
    once, shards = ["--weights", "weights.safetensors", "--held-out"], [": held_out.h5 and held_out_again.h5"]
    for command in [["nlg-validate"], ["nlg-validate", "frontier"]]:
        refuses(USAGE_ERROR, both, ["bad_validation"], *command, *twice, "--held-out", "held_out.h5", "--out", "bad_validation")
        refuses(USAGE_ERROR, shards, ["bad_validation"], *command, *once, "held_out.h5", "held_out_again.h5", "--out", "bad_validation")
    refuses(USAGE_ERROR, both, ["bad.json"], "nlg-validate", "stability", *twice, "--out", "bad.json")
    refuses(USAGE_ERROR, both, ["bad_solved"], "nlg-solve", "--scene", "doorway", *twice, "--out-dir", "bad_solved")
    refuses(INPUT_ERROR, ["other_test.h5"], ["bad_validation"], "nlg-validate", "--weights", "weights.safetensors",
            "--held-out", "held_out.h5", "other_test.h5", "--out", "bad_validation")
    # an unfinished run's state of other options is refused unless asked otherwise
    shutil.copytree("run", "other_run", symlinks=True)
    refuses(INPUT_ERROR, ["other_run/step-"], ["bad.ckpt", "bad.csv"], "nlg-train", "--config", "good.yaml", "--steps", "5", *TRAIN_INPUTS,
            "--out", "bad.ckpt", "--run", "other_run", "--log", "bad.csv")
    if sorted(os.listdir("other_run")) != sorted(os.listdir("run")):
        failures.append(f"nlg-train: changed a run that it refused: {os.listdir('other_run')}")
    must("nlg-cache", "--basis", "other_basis.h5", "--shards", "training.h5", "--out", "other.cache")
    arguments, outputs = arguments_of("nlg-train", {"--shards": "--cache", "training.h5": "other.cache"})
    refuses(INPUT_ERROR, ["other.cache", "basis"], outputs, "nlg-train", "--config", "good.yaml", *arguments)


def check_held_out_sets():
    """A held-out set without functions, or of scenes that are trained on, would give figures that mean nothing."""
    write("empty.gltf", '{"asset": {"version": "2.0"}}')
    must("nlg-datagen", "--config", "good.yaml", "--scene", "empty.gltf", "--held-out", "--out", "empty.h5")
    for tool in ["nlg-train", "nlg-export", "nlg-validate"]:
        arguments, outputs = arguments_of(tool, {"held_out.h5": "empty.h5"})
        refuses(INPUT_ERROR, ["empty.h5"], outputs, tool, "--config", "good.yaml", *arguments)
    refuses(INPUT_ERROR, ["empty.h5"], ["bad.h5"], "nlg-pca", "--config", "good.yaml", "--shards", "training.h5", "--held-out", "empty.h5",
            "--out", "bad.h5")
    arguments, outputs = arguments_of("nlg-train", {"held_out.h5": "training.h5"})
    refuses(INPUT_ERROR, ["training.h5", "house_1"], outputs, "nlg-train", "--config", "good.yaml", *arguments)


def check_shards_whose_width_lies():
    """A shard with the right pattern hash but rows of 16 points: nobody may read 8192 of them."""
    subprocess.run([MAKE_NARROW_SHARD, "narrow.h5"], check=True)
    for tool, path in [("nlg-pca", "training.h5"), ("nlg-cache", "training.h5"), ("nlg-train", "training.h5"), ("nlg-export", "held_out.h5"), ("nlg-validate", "held_out.h5")]:
        arguments, outputs = arguments_of(tool, {path: "narrow.h5"})
        refuses(INPUT_ERROR, ["narrow.h5"], outputs, tool, "--config", "good.yaml", *arguments)


def check_outputs():
    write("file", "")
    refuses(USAGE_ERROR, ["--out", "empty"], [], "nlg-datagen", "--scene", "house:1", "--out", "")
    write("level.glb", "")
    refuses(USAGE_ERROR, ["--out", "no input"], [], "nlg-datagen", "--scene", "level.glb", "--out", "./level.glb")
    refuses(USAGE_ERROR, ["--out", "no input"], [], "nlg-datagen", "view", "training.h5", "--probe", "0", "--out", "training.h5")
    refuses(USAGE_ERROR, ["--probe"], [], "nlg-datagen", "view", "training.h5", "--probe", "-1", "--out", "x.png")
    for tool in TOOLS:
        if tool == "nlg-validate":
            arguments = arguments_of(tool)[0][:-1] + ["file/bad"]
        else:
            arguments = arguments_of(tool)[0][:-1] + ["file/bad.out"]
        # a training run's state and curve stay: the next attempt goes on from there
        refuses(OUTPUT_ERROR, ["file/bad"], [], tool, "--config", "good.yaml", *arguments, keeps=TRAIN_OUTPUTS)
    arguments, outputs = arguments_of("nlg-export")
    refuses(CHECK_FAILED, ["parity"], outputs, "nlg-export", *arguments, "--parity-tolerance", "0")


def main():
    for variable in ["OPENBLAS_NUM_THREADS", "OMP_NUM_THREADS"]:
        os.environ[variable] = "1"
    with tempfile.TemporaryDirectory() as folder:
        os.chdir(folder)
        make_good_files()
        check_command_lines()
        check_configurations()
        check_inputs()
        check_strange_files()
        check_scenes()
        check_budgets()
        check_control_characters()
        check_levels()
        check_workflow()
        check_broken_configurations()
        check_tables_of_scripts()
        check_shards()
        check_bakes()
        check_renders()
        check_views()
        check_weights_used_by()
        check_shader()
        check_engine()
        check_plans()
        check_full_disk()
        check_killed_run()
        check_inputs_that_do_not_belong_together()
        check_held_out_sets()
        check_shards_whose_width_lies()
        check_outputs()
        os.chdir("/")
    for failure in failures:
        print("FAILED:", failure)
    print(f"{cases} cases, {len(failures)} failures")
    return 1 if failures else 0


if __name__ == "__main__":
    sys.exit(main())

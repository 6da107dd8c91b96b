#!/usr/bin/python3
"""What nlg-export shader and nlg-export engine write, read by readers that share nothing with it; and what it refuses.

    engine_files_test.py BIN_FOLDER ENGINE_CASES KTX_PARSE

KTX2 and three.js's bytes are read here, by their specifications. With KTX_PARSE, a folder of
workflow/install_from_npm.sh, the KTX2 files are read by ktx-parse instead and nothing else is done; exit code 77, a skipped test,
where it is not there.
"""
import json
import os
import re
import shutil
import struct
import subprocess
import sys
import tempfile

sys.dont_write_bytecode = True
sys.path.append(os.path.join(os.path.dirname(os.path.abspath(__file__)), "..", ".."))
from tools import INPUT_ERROR, OUTPUT_ERROR, USAGE_ERROR, Tools

TOOLS, CASES = Tools(sys.argv[1]), os.path.abspath(sys.argv[2])
KTX_PARSE = os.path.abspath(sys.argv[3]) if len(sys.argv) > 3 else None
FEW = ["--spacing-m", "0.8", "--places", "400", "--truth-rays", "64", "--light-rays", "64"]


def must(condition, message):
    if not condition:
        sys.exit(f"engine_files_test: {message}")


def engine(format_name, folder, *options, scene="two_rooms:0"):
    return TOOLS.run(["nlg-export", "engine", scene, "--format", format_name, "--out", folder, *FEW, *options])


def exported(format_name):
    """Lit from the scene, for the engine's own look-up: what is shipped errs no more than texels with the light of their own place."""
    result = engine(format_name, format_name)
    must(result.returncode == 0, f"{format_name}: exit code {result.returncode}\n{result.stderr}")
    line, record = json.loads(result.stdout), json.load(open(os.path.join(format_name, "light.json")))
    for key in ["low_m", "high_m", "resolution", "texture_size", "mean_radiance", "error"]:
        must(record[key] == line[key], f"{format_name}: light.json and the line differ in {key}")
    texels_m = [(high - low) / count for low, high, count in zip(record["low_m"], record["high_m"], record["resolution"])]
    nx, ny, nz = record["resolution"]
    must(all(0 < texel_m <= 1 for texel_m in texels_m) and record["texture_size"] == [nx, ny, 7 * (nz + 2)], f"{format_name}: {record}")
    # a record that came last would leave texels behind a kill that the next run does not know as its own
    written = {name: os.stat(os.path.join(format_name, name)).st_ctime_ns for name in os.listdir(format_name)}
    must(min(written, key=written.get) == "light.json" and len(written) == 2, f"{format_name}: written {written}")
    must(all(0 < radiance < 10 for radiance in record["mean_radiance"]), f"{format_name}: {record['mean_radiance']}")
    shipped, placed = line["error"][line["shipped"]], line["error"]["placed"]
    must(line["shipped"] != "placed" and all(shipped[group] < placed[group] for group in ("air", "surface")), f"{format_name}: {line}")
    return line


def read_ktx2(path):
    """KTX 2.0, section 3: header, level index, data format descriptor, key and value data, one level."""
    data = open(path, "rb").read()
    must(data[:12] == b"\xabKTX 20\xbb\r\n\x1a\n", f"{path}: identifier")
    vk_format, type_size, width, height, depth, layers, faces, levels, scheme = struct.unpack_from("<9I", data, 12)
    dfd_place, dfd_bytes, kvd_place, kvd_bytes, sgd_place, sgd_bytes = struct.unpack_from("<4I2Q", data, 48)
    place, count, uncompressed = struct.unpack_from("<3Q", data, 80)
    must((layers, faces, levels, scheme, sgd_place, sgd_bytes) == (0, 1, 1, 0, 0, 0), f"{path}: one level of no array")
    must(dfd_place == 104 and dfd_place + dfd_bytes == kvd_place, f"{path}: nothing between index, descriptor and texts")
    total, vendor, version, block, model, primaries, transfer, flags = struct.unpack_from("<IIHHBBBB", data, dfd_place)
    must((total, vendor, version, block) == (dfd_bytes, 0, 2, dfd_bytes - 4), f"{path}: descriptor's header")
    must((model, primaries, transfer, flags) == (1, 1, 1, 0), f"{path}: linear RGB of BT.709")
    must(data[dfd_place + 16 : dfd_place + 20] == bytes(4), f"{path}: a block of one texel")
    texel = data[dfd_place + 20]
    samples = [struct.unpack_from("<HBBIII", data, dfd_place + 28 + 16 * i) for i in range((block - 24) // 16)]
    must(place % max(texel, 4) == 0, f"{path}: level at {place}")
    must(count == uncompressed == texel * width * height * depth and place + count == len(data), f"{path}: {count} bytes of texels")
    texts, at = {}, kvd_place
    while at < kvd_place + kvd_bytes:
        (length,) = struct.unpack_from("<I", data, at)
        key, _, value = data[at + 4 : at + 4 + length].partition(b"\0")
        must(value.endswith(b"\0"), f"{path}: value of {key}")
        texts[key.decode()] = value[:-1].decode()
        at += 4 + (length + 3) // 4 * 4
    return {"format": vk_format, "type_size": type_size, "size": [width, height, depth], "samples": samples, "texts": texts, "texels": data[place:]}


def check_ktx2(line):
    file = read_ktx2("ktx2-sh/light.ktx2")
    one, minus_one = (struct.unpack("<I", struct.pack("<f", x))[0] for x in (1.0, -1.0))
    must((file["format"], file["type_size"], file["size"]) == (97, 2, line["texture_size"]), f"ktx2-sh: {file['format']}, {file['size']}")
    must(file["samples"] == [(16 * i, 15, channel | 0xC0, 0, minus_one, one) for i, channel in enumerate([0, 1, 2, 15])], f"ktx2-sh: {file['samples']}")
    numbers = {key: [float(number) for number in file["texts"]["nlg." + key].split()] for key in ("low_m", "high_m", "resolution")}
    must(all(numbers[key] == line[key] for key in numbers), f"ktx2-sh: {file['texts']}")
    must(len(file["texels"]) == os.path.getsize("three/light.bin"), "ktx2-sh and three hold other numbers of texels")


def check_three(line):
    data = open("three/light.bin", "rb").read()
    nx, ny, nz = line["resolution"]
    must(len(data) == 8 * nx * ny * 7 * (nz + 2), f"three: {len(data)} bytes")
    slices = [data[i * 8 * nx * ny : (i + 1) * 8 * nx * ny] for i in range(7 * (nz + 2))]
    for volume in range(7):
        first = volume * (nz + 2)
        must(slices[first] == slices[first + 1] and slices[first + nz + 1] == slices[first + nz], f"three: padding of volume {volume}")
    must(all(slices[6 * (nz + 2)][i : i + 2] == b"\0\0" for i in range(6, 8 * nx * ny, 8)), "three: the last number of a texel is 0")


def shader(format_name, folder, *options, grid="grid.safetensors"):
    return TOOLS.run(["nlg-export", "shader", "--grid", grid, "--format", format_name, "--out", folder, *options])


def check_shader():
    files = {"glsl": ["grid.bin", "look_up.glsl", "resample.comp", "resampled.glsl"], "c-header": ["grid.bin", "nlg_light_grid.h"],
             "three-per-pixel": ["grid.bin", "look_up.glsl", "three_light_grid.js", "three_light_grid_webgpu.js"]}
    for name, expected in files.items():
        must(shader(name, name).returncode == 0 and sorted(os.listdir(name)) == expected, f"{name}: its files")
        must(open(f"{name}/grid.bin", "rb").read() == open("glsl/grid.bin", "rb").read(), f"{name} holds another grid than glsl")
    # positions of engines are floats: a level far from its origin is moved
    lines = [json.loads(shader("c-header", "moved", *origin).stdout) for origin in ([], ["--origin-m=-2,10000,1"])]
    must(all(0 <= line["corner_error_m"] < 1e-3 for line in lines) and lines[1]["origin_m"] == [-2, 10000, 1], f"says {lines}")
    must(all(abs(moved + by - low) < 1e-9 and low < high for low, high, moved, by in zip(lines[0]["low_m"], lines[0]["high_m"], lines[1]["low_m"], [-2, 10000, 1])), f"its box: {lines}")
    must(all(0 < channel < 1e6 for channel in lines[0]["mean_radiance"]), f"its light: {lines[0]}")


def check_grid_beside():
    """The grid whose error is measured, too: of the same scene and light, or a line says that it is not."""
    baked = TOOLS.run(["nlg-bake", "two_rooms:0", "--out", "rooms.safetensors", "--spacing-m", "0.8", "--light-rays", "64", "--draft"])
    must(baked.returncode == 0, f"bake: {baked.stderr}")
    for options, said in ([], ""), (["--sky", ".3,.4,.5"], "rooms.safetensors: baked with other light"):
        result = engine("three", "beside", "--grid", "rooms.safetensors", *options)
        must(result.returncode == 0 and "the light grid" in json.loads(result.stdout)["error"], f"--grid: {result.stderr}")
        must((said in result.stderr) if said else ("baked" not in result.stderr), f"--grid {options}: {result.stderr}")
    result = engine("three", "beside", "--grid", "rooms.safetensors", scene="two_rooms:1")
    must("rooms.safetensors: baked from two_rooms_0, and this is two_rooms_1" in result.stderr, f"another scene: {result.stderr}")
    TOOLS.refuses(INPUT_ERROR, ["three/light.bin", "light grid"], ["nlg-export", "engine", "no_such.glb", "--format", "three", "--out", "bad", "--grid", "three/light.bin"])


def check_refusals():
    grid = ["nlg-export", "shader", "--out", "bad", "--grid"]
    TOOLS.refuses(USAGE_ERROR, ["glsl, three-per-pixel, c-header", "unity"], [*grid, "grid.safetensors", "--format", "unity"])
    TOOLS.refuses(INPUT_ERROR, ["dark.safetensors"], [*grid, "dark.safetensors"])
    TOOLS.refuses(USAGE_ERROR, ["--origin-m"], [*grid, "grid.safetensors", "--origin-m", "1,2"])
    TOOLS.refuses(INPUT_ERROR, ["grid.safetensors", "--origin-m"], [*grid, "grid.safetensors", "--origin-m=5000000.13,0,0"])
    scene = ["nlg-export", "engine", "two_rooms:0", *FEW, "--format"]
    TOOLS.refuses(USAGE_ERROR, ["three, ktx2-sh, quake3-lightgrid", "unity"], [*scene, "unity", "--out", "bad"])
    TOOLS.refuses(INPUT_ERROR, ["two_rooms"], [*scene, "quake3-lightgrid", "--out", "bad"])
    TOOLS.refuses(USAGE_ERROR, ["light", "solved", "none"], [*scene, "three", "--out", "bad", "--light", "none"])
    TOOLS.refuses(USAGE_ERROR, ["intensity", "32768"], [*scene, "three", "--out", "bad", "--intensity", "1e6"])
    open("file", "w").close()
    TOOLS.refuses(OUTPUT_ERROR, ["file/light.bin"], [*scene, "three", "--out", "file"])
    # a stranger's file under the name of an output, and our own once more
    os.mkdir("folder")
    with open("folder/light.bin", "w", encoding="ascii") as file:
        file.write("a level's own buffer")
    TOOLS.refuses(USAGE_ERROR, ["light.bin"], [*scene, "three", "--out", "folder"])
    must(os.listdir("folder") == ["light.bin"], "something was written beside what was not replaced")
    before = open("three/light.bin", "rb").read()
    must(engine("three", "three").returncode == 0 and open("three/light.bin", "rb").read() == before, "other texels the second time")


def check_ktx_parse():
    if shutil.which("node") is None or not os.path.isdir(os.path.join(KTX_PARSE, "node_modules", "ktx-parse")):
        print(f"SKIPPED: ktx-parse is not installed; workflow/install_from_npm.sh ktx-parse {KTX_PARSE} says why not")
        sys.exit(77)
    script = os.path.join(os.path.dirname(os.path.abspath(__file__)), "read_ktx2.mjs")
    exported("ktx2-sh")
    ours = read_ktx2("ktx2-sh/light.ktx2")
    result = subprocess.run(["node", script, KTX_PARSE, "ktx2-sh/light.ktx2", "texels"], capture_output=True, text=True)
    must(result.returncode == 0, f"ktx-parse: {result.stderr}")
    theirs = json.loads(result.stdout)
    samples = [list(sample[:3]) + list(sample[4:]) for sample in ours["samples"]]
    must(theirs["format"] == ours["format"] and theirs["size"] == ours["size"], f"ktx2-sh: {theirs}")
    must(theirs["samples"] == samples, f"ktx2-sh: ktx-parse says {theirs['samples']}, not {samples}")
    must(theirs["texts"] == ours["texts"], f"ktx2-sh: {theirs['texts']}")
    must(open("texels", "rb").read() == ours["texels"], "ktx2-sh: other texels")


work = tempfile.mkdtemp(prefix="nlg_engine_files_")
try:
    os.chdir(work)
    subprocess.run([CASES, work], check=True)
    if KTX_PARSE is not None:
        check_ktx_parse()
    else:
        check_three(exported("three"))
        check_ktx2(exported("ktx2-sh"))
        check_shader()
        check_grid_beside()
        check_refusals()
        must(TOOLS.end() == 0, "what is refused")
finally:
    os.chdir("/")
    shutil.rmtree(work)

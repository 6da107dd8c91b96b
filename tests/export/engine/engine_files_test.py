#!/usr/bin/python3
"""What nlg-export engine and nlg-export texels write, read by readers that share nothing with it; and what it refuses.

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
BOX = ["--extent-m=-2,10001,2,6,10007,12", "--spacing-m", "1"]  # 8 x 6 x 10 texels
WITHOUT_TEXELS = ["three-per-pixel", "c-header"]
RESOLUTION, SH_SIZE = [8, 6, 10], [8, 6, 7 * 12]


def must(condition, message):
    if not condition:
        sys.exit(f"engine_files_test: {message}")


def export(*arguments):
    return TOOLS.run(["nlg-export", "engine", *arguments])


def exported(format_name):
    result = export("--grid", "grid.safetensors", "--format", format_name, "--out", format_name, "--error-samples", "2000", *([] if format_name in WITHOUT_TEXELS else BOX))
    must(result.returncode == 0, f"{format_name}: exit code {result.returncode}\n{result.stderr}")
    line = json.loads(result.stdout)
    files = [os.path.join(format_name, name) for name in os.listdir(format_name)]
    must(line["bytes"] == sum(map(os.path.getsize, files)), f"{format_name}: says {line['bytes']} bytes")
    must(line["error"]["places"] > 1000 and 0 < line["error"]["rmse"] < 1, f"{format_name}: says {line['error']}")
    if format_name not in WITHOUT_TEXELS:
        place = json.load(open(os.path.join(format_name, "light.json")))
        for key in ["low_m", "high_m", "resolution", "texture_size"]:
            must(place[key] == line[key], f"{format_name}: light.json and the line differ in {key}")
        must(place["low_m"] == [-2, 10001, 2] and place["high_m"] == [6, 10007, 12], f"{format_name}: {place}")
        must(place["resolution"] == RESOLUTION, f"{format_name}: {place}")
        must(place["texture_size"] == SH_SIZE, f"{format_name}: {place}")
        must(line["texels"]["lit"] + line["texels"]["filled"] == 8 * 6 * 10, f"{format_name}: {line['texels']}")
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


def check_ktx2():
    file = read_ktx2("ktx2-sh/light.ktx2")
    one, minus_one = (struct.unpack("<I", struct.pack("<f", x))[0] for x in (1.0, -1.0))
    must((file["format"], file["type_size"], file["size"]) == (97, 2, SH_SIZE), f"ktx2-sh: {file['format']}, {file['size']}")
    must(file["samples"] == [(16 * i, 15, channel | 0xC0, 0, minus_one, one) for i, channel in enumerate([0, 1, 2, 15])], f"ktx2-sh: {file['samples']}")
    must(file["texts"]["nlg.low_m"] == "-2.0 10001.0 2.0" and file["texts"]["nlg.resolution"] == "8 6 10", f"ktx2-sh: {file['texts']}")
    must(file["texels"] == open("three/light.bin", "rb").read(), "ktx2-sh and three hold different texels")


def check_three():
    data = open("three/light.bin", "rb").read()
    nx, ny, nz = RESOLUTION
    must(len(data) == 8 * nx * ny * 7 * (nz + 2), f"three: {len(data)} bytes")
    slices = [data[i * 8 * nx * ny : (i + 1) * 8 * nx * ny] for i in range(7 * (nz + 2))]
    for volume in range(7):
        first = volume * (nz + 2)
        must(slices[first] == slices[first + 1] and slices[first + nz + 1] == slices[first + nz], f"three: padding of volume {volume}")
    must(all(slices[6 * (nz + 2)][i : i + 2] == b"\0\0" for i in range(6, 8 * nx * ny, 8)), "three: the last number of a texel is 0")


def refuses(exit_code, names, *arguments):
    TOOLS.refuses(exit_code, names, ["nlg-export", "engine", *arguments])


def check_refusals():
    good = ["--grid", "grid.safetensors", "--format", "three", "--out", "bad"]
    refuses(USAGE_ERROR, ["three, ktx2-sh, three-per-pixel, or c-header", "unity"], "--grid", "grid.safetensors", "--format", "unity", "--out", "bad")
    for format_name in ["three", *WITHOUT_TEXELS]:
        refuses(INPUT_ERROR, ["dark.safetensors", "without light"], "--grid", "dark.safetensors", "--format", format_name, "--out", "bad")
    refuses(INPUT_ERROR, ["bright.safetensors", "32768", "--intensity"], "--grid", "bright.safetensors", "--format", "three", "--out", "bad", *BOX)
    refuses(USAGE_ERROR, ["extent_m", "light"], *good, "--extent-m=0,0,0,1,1,1", "--spacing-m", "1")
    for asked in ["dusk", "day=-1"]:
        refuses(USAGE_ERROR, ["light_groups", "day, night/lamp", asked], "--grid", "sets.safetensors", "--format", "three", "--out", "bad", *BOX, "--light-groups", asked)
    refuses(USAGE_ERROR, ["c-header", "light_groups"], "--grid", "sets.safetensors", "--format", "c-header", "--out", "bad", "--light-groups", "day")
    open("file", "w").close()
    refuses(OUTPUT_ERROR, ["file/light.bin"], "--grid", "grid.safetensors", "--format", "three", "--out", "file", *BOX)
    # an input under the name of an output
    os.mkdir("folder")
    shutil.copy("grid.safetensors", "folder/light.bin")
    refuses(USAGE_ERROR, ["not an input"], "--grid", "folder/light.bin", "--format", "three", "--out", "folder", *BOX)
    must(open("folder/light.bin", "rb").read() == open("grid.safetensors", "rb").read(), "an input was replaced")
    must(os.listdir("folder") == ["light.bin"], "something was written beside an input that was not replaced")


def check_intensity():
    result = export("--grid", "grid.safetensors", "--format", "three", "--out", "half", "--error-samples", "2000", "--intensity", "0.5", *BOX)
    must(result.returncode == 0 and json.loads(result.stdout)["intensity"] == 0.5, f"half as bright: {result.stderr}")
    must(json.load(open("half/light.json"))["intensity"] == 0.5, "light.json says no intensity")
    must(json.load(open("three/light.json"))["intensity"] == 1, "light.json says another intensity")
    whole, half = (struct.unpack(f"<{len(data) // 2}e", data) for data in (open(f"{name}/light.bin", "rb").read() for name in ("three", "half")))
    # a half float's own half, but for what is too small to be halved exactly
    must(all(abs(h - 0.5 * w) <= 2**-24 for w, h in zip(whole, half)), "not half of the light")
    refused = export("--grid", "bright.safetensors", "--format", "three", "--out", "bright", *BOX)
    fits = re.search(r"--intensity (\S+) makes them fit", refused.stderr)
    result = export("--grid", "bright.safetensors", "--format", "three", "--out", "bright", "--error-samples", "2000", "--intensity", fits[1], *BOX)
    must(result.returncode == 0, f"the intensity that fits does not: {result.stderr}")


def check_origin():
    """What is written is moved, whatever the format: positions of engines are floats."""
    result = export("--grid", "grid.safetensors", "--format", "three", "--out", "moved", "--error-samples", "2000", "--origin-m=-2,10000,1", "--extent-m=0,1,1,8,7,11", "--spacing-m", "1")
    must(result.returncode == 0, f"--origin-m: {result.stderr}")
    place = json.load(open("moved/light.json"))
    must(place["origin_m"] == [-2, 10000, 1] and place["low_m"] == [0, 1, 1], f"moved: {place}")
    must(open("moved/light.bin", "rb").read() == open("three/light.bin", "rb").read(), "moved: other light")
    lines = [json.loads(export("--grid", "grid.safetensors", "--format", "c-header", "--out", "moved", "--error-samples", "2000", *origin).stdout) for origin in ([], ["--origin-m=-2,10000,1"])]
    must(all(0 <= line["corner_error_m"] < 1e-3 for line in lines), f"says {lines}")
    refuses(USAGE_ERROR, ["--origin-m"], "--grid", "grid.safetensors", "--format", "three", "--out", "bad", "--origin-m", "1,2", *BOX)
    refuses(INPUT_ERROR, ["grid.safetensors", "--origin-m"], "--grid", "grid.safetensors", "--format", "c-header", "--out", "bad", "--origin-m=5000000.13,0,0")


def check_light_groups():
    def three(*groups):
        result = export("--grid", "sets.safetensors", "--format", "three", "--out", "sets", "--error-samples", "2000", *groups, *BOX)
        must(result.returncode == 0, f"{groups}: {result.stderr}")
        must(json.load(open("sets/light.json"))["light_groups"] == json.loads(result.stdout)["light_groups"], "light.json says other groups")
        data = open("sets/light.bin", "rb").read()
        return json.loads(result.stdout)["light_groups"], struct.unpack(f"<{len(data) // 2}e", data)

    groups, day = three()
    must(groups == {"day": 1, "night/lamp": 0}, f"begins with {groups}")
    groups, night = three("--light-groups", "night=2")
    must(groups == {"day": 0, "night/lamp": 2}, f"night is {groups}")
    largest = max(map(abs, day))
    must(all(abs(n - 0.5 * d) < 2e-2 * largest for n, d in zip(night, day)), "the lamp at 2 is not half of the day")
    must(three("--light-groups", "day,night")[0] == {"day": 1, "night/lamp": 1}, "both sets")
    result = export("--grid", "sets.safetensors", "--format", "c-header", "--out", "sets_c", "--error-samples", "2000", "--intensity", "0.5")
    must(result.returncode == 0 and json.loads(result.stdout)["error"]["rmse"] < 1e-4, f"half of all sets: {result.stdout}{result.stderr}")


def check_texels():
    """Lit from the scene, for the engine's own look-up: what is shipped errs no more than texels with the light of their own place."""
    arguments = ["nlg-export", "texels", "two_rooms:0", "--format", "ktx2-sh", "--out", "texels", "--spacing-m", "1", "--places", "400", "--truth-rays", "64"]
    lines = []
    for _ in range(2):  # the second time over its own files
        result = TOOLS.run(arguments)
        must(result.returncode == 0, f"texels: exit code {result.returncode}\n{result.stderr}")
        lines.append(json.loads(result.stdout))
    line, file, record = lines[0], read_ktx2("texels/light.ktx2"), json.load(open("texels/light.json"))
    must(lines[1] == line, "texels: another line the second time")
    must(record["resolution"] == line["resolution"] and file["size"] == line["texture_size"], f"texels: {line}")
    shipped, placed = line["error"][line["shipped"]], line["error"]["placed"]
    must(line["shipped"] != "placed" and all(shipped[group] < placed[group] for group in ("air", "surface")), f"texels: {line}")
    TOOLS.refuses(USAGE_ERROR, ["three, ktx2-sh, quake3-lightgrid", "unity"], ["nlg-export", "texels", "two_rooms:0", "--format", "unity", "--out", "bad"])
    TOOLS.refuses(INPUT_ERROR, ["two_rooms"], ["nlg-export", "texels", "two_rooms:0", "--format", "quake3-lightgrid", "--out", "bad"])


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
        lines = {name: exported(name) for name in ["three", "ktx2-sh", *WITHOUT_TEXELS]}
        for name in WITHOUT_TEXELS:
            must(lines[name]["error"]["rmse"] < 1e-4, f"{name}: {lines[name]}")
        must(sorted(os.listdir("three-per-pixel")) == ["grid.bin", "look_up.glsl", "three_light_grid.js", "three_light_grid_webgpu.js"], "three-per-pixel: its files")
        must(open("three-per-pixel/grid.bin", "rb").read() == open("c-header/grid.bin", "rb").read(), "three-per-pixel and c-header hold different grids")
        check_three()
        check_ktx2()
        check_intensity()
        check_origin()
        check_light_groups()
        check_texels()
        check_refusals()
        must(TOOLS.end() == 0, "what is refused")
finally:
    os.chdir("/")
    shutil.rmtree(work)

#!/usr/bin/python3
"""Scenes that are none, ask for too much, or call themselves something that steers a terminal: what a user meets; tests/scene has the many.

    bad_scenes_test.py BIN_FOLDER FOLDER_OF_GOOD_FILES
"""
import os
import sys
import zipfile

sys.dont_write_bytecode = True
sys.path.append(os.path.join(os.path.dirname(os.path.abspath(__file__)), ".."))
from good_files import call
from tools import INPUT_ERROR, Tools, read, run_checks, write

TRIANGLE = ('{"asset":{"version":"2.0"},"scene":0,"scenes":[{"nodes":[0]}],"nodes":[{"mesh":0}],'
            '"meshes":[{"primitives":[{"attributes":{"POSITION":0}}]}],'
            '"accessors":[{"bufferView":0,"componentType":5126,"count":%d,"type":"VEC3","min":[0,0,0],"max":[1,1,1]}],'
            '"bufferViews":[{"buffer":0,"byteLength":36}],"buffers":[{"uri":"%s","byteLength":36}]}')
FILES = {
    "no_json.gltf": "{", "empty.gltf": "", "outside.gltf": TRIANGLE % (3, "../elsewhere.bin"), "absolute.gltf": TRIANGLE % (3, "/etc/hostname"),
    "remote.gltf": TRIANGLE % (3, "http://localhost/elsewhere.bin"), "absent_buffer.gltf": TRIANGLE % (3, "nowhere.bin"), "too_many.gltf": TRIANGLE % (300, "scene.bin"),
    "garbage.glb": b"glTF\x02\0\0\0\xff\xff\xff\x7f garbage",
}
# scene → what its refusal names
LEVELS = {
    "missing.glb": "missing.glb", "castle:3": "castle:3", "folder": "folder", "": "scene", "missing.bsp": "missing.bsp", "garbage.bsp": ["garbage.bsp", "version 46"],
    "other.bsp": ["other.bsp", "IBSP"], "missing.pk3:a": "missing.pk3", "text.pk3:a": "text.pk3", "short.pk3:broken": "short.pk3",
    "outside.pk3:a": ["outside.pk3", "a name inside the archive"], "folder:a": ["folder", ".pk3 files"], "levels.pk3:absent": ["absent", "broken, empty"],
    "levels.pk3:": "levels.pk3", "missing.sh3f:flat:1": "missing.sh3f", "text.sh3f:flat:1": ["text.sh3f", "ZIP"],
    "bare.sh3f:flat:1": ["bare.sh3f", "PluginFurnitureCatalog"], "wrong.sh3f:flat:1": ["wrong.sh3f", "piece 1"],
    "levels.pk3:broken": ["levels.pk3:broken", "header"], "levels.pk3:empty": ["levels.pk3:empty", "header"],
}


def write_archive(path, entries):
    with zipfile.ZipFile(path, "w", zipfile.ZIP_DEFLATED) as archive:
        for name, content in entries.items():
            archive.writestr(name, content)


def check_scenes(tools):
    write("scene.bin", b"\0" * 36)
    for name, content in FILES.items():
        write(name, content)
        tools.refuses(INPUT_ERROR, name, f"nlg-datagen --scene {name} --out bad.h5")
    write("garbage.bsp", b"IBSP" + b"\xff" * 400)
    write("other.bsp", b"VBSP" + b"\0" * 400)
    write("text.pk3", "no archive")
    write("text.sh3f", "no archive")
    write_archive("levels.pk3", {"maps/broken.bsp": b"IBSP.\0\0\0", "maps/empty.bsp": b""})
    write_archive("outside.pk3", {"../maps/a.bsp": b""})
    write_archive("bare.sh3f", {"a.txt": b""})
    write_archive("wrong.sh3f", {"PluginFurnitureCatalog.properties": b"name#1=Chair\n"})
    write("short.pk3", read("levels.pk3")[:-30])
    for scene, names in LEVELS.items():
        tools.refuses(INPUT_ERROR, names, ["nlg-datagen", "--scene", scene, "--out", "bad.h5"])
    # other readers of scenes
    for scene in ("missing.glb", "castle:3", "folder"):
        tools.refuses(INPUT_ERROR, scene, call("nlg-bake", by={"house:1": scene}))
    tools.refuses(INPUT_ERROR, ["hous:1", "FAMILY:SEED"], call("nlg-bake", by={"house:1": "hous:1"}))
    write("bare.gltf", '{"asset": {"version": "2.0"}}')
    tools.refuses(INPUT_ERROR, ["bare.gltf", "triangle"], call("nlg-bake", by={"house:1": "bare.gltf"}))


def check_control_characters(tools):
    """What a level calls itself must not steer a terminal, nor look like a line of the tool's own."""
    for name in ("a\033[2J.obj", "a\x9b2J.obj", "a\nforged.obj"):
        tools.cases += 1
        write(name, "mtllib none.mtl\nv 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n")
        for command in (["nlg-datagen", "--scene", name, "--max-functions", "2", "--out", "steered.h5"], ["nlg-datagen", "info", "steered.h5"],
                        ["nlg-datagen", "plan", "--scene", name], ["nlg-bake", name, "--weights", "weights.safetensors", "--out", "steered.safetensors"]):
            result = tools.run(command)
            shown = result.stderr + (result.stdout if command[1] in ("info", "plan") else "")
            is_plain = not any(ord(c) < 32 and c not in "\n\t" or 127 <= ord(c) < 160 for c in shown) and "\nforged" not in shown
            tools.check(result.returncode in (0, INPUT_ERROR) and is_plain, f"{command}: {result.returncode}, {shown!r}")


if __name__ == "__main__":
    sys.exit(run_checks(Tools(sys.argv[1]), (check_scenes, check_control_characters), sys.argv[2]))

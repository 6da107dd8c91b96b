#!/usr/bin/python3
"""What a run makes again after a change: what the change is about and what follows from it, and nothing else.

    changes_test.py BIN_FOLDER short|whole          (from the source folder)    short: every fourth change

A run is made once as far as its weights. Each change is then made to a copy of it and of its levels, and Snakemake is asked what it would
make. Three of them together are run, and their bytes compared with those of a run made afresh.
"""
import contextlib
import json
import os
import re
import shutil
import struct
import subprocess
import sys
import tempfile
from pathlib import Path

sys.dont_write_bytecode = True
ROOT = Path(__file__).resolve().parents[2]
sys.path += [str(ROOT / "tests"), str(ROOT / "workflow")]
import yaml  # noqa: E402
from tools import png, room  # noqa: E402

BIN, IS_SHORT = Path(sys.argv[1]).resolve(), sys.argv[2] == "short"
CONFIGURATION = {
    "name": "run", "scenes": {"families": ["house"], "per_family": 1, "folder": "levels", "jitters": 1}, "split": {"held_out": ["held"]},
    "representations": {"tent_mlp4": {}}, "datagen": {"max_functions": 40, "test_points": 512, "spacing_min_m": 1.0, "spacing_max_m": 2.0},
    "basis": {"components": 16}, "train": {"steps": 10, "batch": 8, "start_candidates": 4, "width": 16, "layers": 2}, "export": {"parity_tolerance": 1.0},
    "validate_light": {"scenes": []}, "report": {"stability": "short", "savings": []}}
STAGES = ("datagen", "pca", "data_card", "train", "export")  # in their order


def faces(text):
    """Of a room in an OBJ file: its corners, and the corners of its triangles from 0."""
    lines = [line.split() for line in text.splitlines()]
    corners = [[float(x) for x in line[1:]] for line in lines if line[0] == "v"]
    return corners, [i for line in lines if line[0] == "f" for quad in [[int(i) - 1 for i in line[1:]]] for i in (quad[0], quad[1], quad[2], quad[0], quad[2], quad[3])]


def gltf(text, uri):
    """The same room as glTF, and the buffer beside it."""
    corners, indices = faces(text)
    positions, triangles = b"".join(struct.pack("<3f", *corner) for corner in corners), struct.pack(f"<{len(indices)}H", *indices)
    accessor = lambda view, kind, component, count, **more: {"bufferView": view, "type": kind, "componentType": component, "count": count, **more}
    level = {"asset": {"version": "2.0"}, "buffers": [{"uri": uri, "byteLength": len(positions + triangles)}],
             "bufferViews": [{"buffer": 0, "byteLength": len(positions)}, {"buffer": 0, "byteOffset": len(positions), "byteLength": len(triangles)}],
             "accessors": [accessor(0, "VEC3", 5126, len(corners), min=list(map(min, zip(*corners))), max=list(map(max, zip(*corners)))), accessor(1, "SCALAR", 5123, len(indices))],
             "meshes": [{"primitives": [{"attributes": {"POSITION": 0}, "indices": 1}]}], "nodes": [{"mesh": 0}], "scenes": [{"nodes": [0]}], "scene": 0}
    return json.dumps(level).encode(), positions + triangles


def write_collected(path):
    """A shard as a bake collects one."""
    subprocess.run([BIN / "nlg-datagen", "--scene", "maze:1", "--max-functions", "30", "--spacing-min-m", "1", "--out", path], check=True, capture_output=True)


def write_levels(folder):
    for path in ("data", "mats"):
        (folder / path).mkdir(parents=True)
    (folder / "plain.obj").write_text(room(0))
    (folder / "held.obj").write_text(room(1))
    (folder / "beside.gltf").write_bytes(gltf(room(2), "data/beside.dat")[0])
    (folder / "data/beside.dat").write_bytes(gltf(room(2), "")[1])
    (folder / "screen.obj").write_text("mtllib mats/screen.mtl\nusemtl screen\n" + room(3))
    (folder / "mats/screen.mtl").write_text("newmtl screen\nmap_d fence.png\n")
    (folder / "mats/fence.png").write_bytes(png((255, 255, 255, 255)))


class World:
    """A run with its levels in a folder of its own, as the changes see it."""

    def __init__(self, folder):
        self.folder, self.levels, self.out, self.run = folder, folder / "levels", folder / "out", folder / "out/run"
        self.configuration, self.tools, self.root = json.loads(json.dumps(CONFIGURATION)), BIN, ROOT
        self.hard = folder / "hard/maze_1.collected.h5"
        self.set("scenes", collected=[str(folder / "hard")])

    def set(self, section, **values):
        self.configuration.setdefault(section, {}).update(values)

    def write(self):
        self.configuration["scenes"]["folder"] = str(self.levels)
        (self.folder / "run.yaml").write_text(yaml.safe_dump(self.configuration, sort_keys=False))

    def command(self, *more):
        return ["/usr/bin/snakemake", str(self.run / "weights/tent_mlp4.safetensors"), str(self.run / "dataset.json"), "-s", str(self.root / "workflow/Snakefile"), "--configfile",
                str(self.folder / "run.yaml"), "--directory", str(self.run), "--cores", "2", "--nolock", "--rerun-incomplete", *more]

    def environment(self):
        return {**os.environ, "NLG_BIN": str(self.tools), "NLG_OUT": str(self.out)}

    def check(self):
        """What check_artefacts.py says."""
        done = subprocess.run(["/usr/bin/python3", str(self.root / "workflow/check_artefacts.py"), str(self.folder / "run.yaml"), str(self.tools)], env=self.environment(), capture_output=True, text=True, check=True, cwd=self.root)
        return done.stderr

    def make(self):
        self.write()
        self.run.mkdir(parents=True, exist_ok=True)
        done = subprocess.run(self.command(), env=self.environment(), capture_output=True, text=True)
        assert done.returncode == 0, done.stderr[-3000:]

    def asked_again(self):
        """The first stage that would be made, and of which scenes where it is the data set."""
        self.write()
        said = self.check()
        done = subprocess.run(self.command("-n"), env=self.environment(), capture_output=True, text=True)
        assert done.returncode == 0, done.stdout + done.stderr
        rules = re.findall(r"^(?:local)?rule (\w+):", done.stdout + done.stderr, re.M)
        scenes = sorted(set(re.findall(r"dataset/\w+/(\w+)\.\d+\.h5\n", "\n".join(re.findall(r"^    output: (.*\n)", done.stdout + done.stderr, re.M)))))
        found = [f"datagen {' '.join(scenes)}"] if scenes else [rule for rule in STAGES if rule in rules][:1]
        # what follows is made again as well
        assert not found or "export" in rules, rules
        return (found or [""])[0], said


@contextlib.contextmanager
def times_kept(path):
    status = os.stat(path)
    yield
    os.utime(path, ns=(status.st_atime_ns, status.st_mtime_ns))


def flip(path, times=False):
    """One bit, the size kept; the time too, if asked."""
    data = bytearray(path.read_bytes())
    data[len(data) // 2] ^= 1
    with times_kept(path) if times else contextlib.nullcontext():
        path.write_bytes(data)


def older(path, data):
    path.write_bytes(data)
    os.utime(path, (10**9, 10**9))


def swap(a, b):
    data = a.read_bytes(), b.read_bytes()
    b.write_bytes(data[0])
    a.write_bytes(data[1])


def link_to(path, target):
    shutil.move(path, target)
    path.symlink_to(target)


def tree(folder, when):
    for path in folder.rglob("*"):
        if path.is_file():
            os.utime(path, (when, when))


def elsewhere(world, what):
    place = world.folder / "elsewhere"
    shutil.move(getattr(world, what), place)
    return place


def other_checkout(world):
    world.root = world.folder / "checkout"
    for name in ("workflow", "tool", "validate"):
        shutil.copytree(ROOT / name, world.root / name)


def other_revision(world):
    world.tools = world.folder / "bin"
    world.tools.mkdir()
    for tool in BIN.glob("nlg-*"):
        (world.tools / tool.name).symlink_to(tool)
    (world.tools / "nlg-datagen").unlink()
    (world.tools / "nlg-datagen").write_text(f'#!/bin/sh\n[ "$1" != --version ] || exec echo another\nexec {BIN}/nlg-datagen "$@"\n')
    (world.tools / "nlg-datagen").chmod(0o755)


ALL = "datagen beside held house_0 plain screen"
# what is changed: → what is made again first; "said: …": nothing, but that
CHANGES = {
    "nothing": (lambda w: None, ""),
    "a level": (lambda w: flip(w.levels / "plain.obj"), "datagen plain"),
    "a level, its time kept": (lambda w: flip(w.levels / "plain.obj", times=True), "datagen plain"),
    "a level, by one with an older time": (lambda w: older(w.levels / "plain.obj", room(4).encode()), "datagen plain"),
    "a held-out level": (lambda w: flip(w.levels / "held.obj"), "datagen held"),
    "two levels change places": (lambda w: swap(w.levels / "plain.obj", w.levels / "held.obj"), "datagen held plain"),
    "a level is gone": (lambda w: (w.levels / "plain.obj").unlink(), "pca"),
    "a level is new": (lambda w: (w.levels / "new.obj").write_text(room(5)), "datagen new"),
    "a level gets another name": (lambda w: (w.levels / "plain.obj").rename(w.levels / "other.obj"), "datagen other"),
    "a level becomes a link to itself": (lambda w: link_to(w.levels / "plain.obj", w.folder / "linked.obj"), ""),
    "… to another level": (lambda w: (link_to(w.levels / "plain.obj", w.folder / "linked.obj"), (w.folder / "linked.obj").write_text(room(4))), "datagen plain"),
    "a level's time, in the future": (lambda w: os.utime(w.levels / "plain.obj", (4 * 10**9, 4 * 10**9)), ""),
    "a level's time, long ago": (lambda w: os.utime(w.levels / "plain.obj", (10**9, 10**9)), ""),
    "a level's rights": (lambda w: (w.levels / "plain.obj").chmod(0o600), ""),
    "a level is saved again as it was": (lambda w: (w.levels / "plain.obj").write_text(room(0)), ""),
    "all levels are unpacked anew": (lambda w: tree(w.levels, 1.5e9), ""),
    "the folder of levels has moved": (lambda w: setattr(w, "levels", elsewhere(w, "levels")), ""),
    "… and is reached by a link": (lambda w: w.levels.symlink_to(elsewhere(w, "levels")), ""),
    "a buffer in a folder, not named .bin": (lambda w: flip(w.levels / "data/beside.dat"), "datagen beside"),
    "… its time kept": (lambda w: flip(w.levels / "data/beside.dat", times=True), "datagen beside"),
    "… becomes a link to another": (lambda w: (link_to(w.levels / "data/beside.dat", w.levels / "data/x.dat"), flip(w.levels / "data/x.dat")), "datagen beside"),
    "an alpha image": (lambda w: (w.levels / "mats/fence.png").write_bytes(png((255, 255, 255, 0))), "datagen screen"),
    "an alpha image is gone": (lambda w: (w.levels / "mats/fence.png").unlink(), "datagen screen"),
    "materials in a folder": (lambda w: (w.levels / "mats/screen.mtl").write_text("newmtl screen\nd 1\n"), "datagen screen"),
    "materials are gone": (lambda w: (w.levels / "mats/screen.mtl").unlink(), "datagen screen"),
    "a file that nothing reads": (lambda w: (w.levels / "data/other.bin").write_text("x"), ""),
    "notes beside the levels": (lambda w: (w.levels / "notes.txt").write_text("x"), ""),
    "a hidden level": (lambda w: (w.levels / ".plain.obj").write_text(room(4)), ""),
    "train.steps": (lambda w: w.set("train", steps=11), "train"),
    "train.batch": (lambda w: w.set("train", batch=9), "train"),
    "train.learning_rate": (lambda w: w.set("train", learning_rate=0.001), "train"),
    "train.seed": (lambda w: w.set("train", seed=2), "train"),
    "train.checkpoint_steps": (lambda w: w.set("train", checkpoint_steps=5), "train"),
    "an option of a representation": (lambda w: w.set("representations", tent_mlp4={"width": 24}), "train"),
    "train.threads": (lambda w: w.set("train", threads=2), ""),
    "train.seed, as the tool has it": (lambda w: w.set("train", seed=1), ""),
    "a number written otherwise": (lambda w: w.set("train", learning_rate="3e-3"), ""),
    "basis.components": (lambda w: w.set("basis", components=12), "pca"),
    "datagen.max_functions": (lambda w: w.set("datagen", max_functions=41), ALL),
    "datagen.spacing_max_m": (lambda w: w.set("datagen", spacing_max_m=1.5), ALL),
    "datagen.in_solid": (lambda w: w.set("datagen", in_solid=1), ALL),
    "datagen.seed": (lambda w: w.set("datagen", seed=2), ALL),
    "datagen.threads": (lambda w: w.set("datagen", threads=2), ""),
    "an option of one scene": (lambda w: w.set("scenes", by_scene={"plain": {"max_functions": 30}}), "datagen plain"),
    "an option of no scene's shard": (lambda w: w.set("scenes", by_scene={"plain": {"max_functions": 40}}), ""),
    "more variants": (lambda w: w.set("scenes", jitters=2), "datagen beside house_0 plain screen"),
    "more procedural scenes": (lambda w: w.set("scenes", per_family=2), "datagen house_1"),
    "another family": (lambda w: w.set("scenes", families=["maze"]), "datagen maze_0"),
    "another level is held out": (lambda w: w.set("split", held_out=["plain"]), "datagen held plain"),
    "two levels are held out": (lambda w: w.set("split", held_out=["held", "plain"]), "datagen plain"),
    "export.dtype": (lambda w: w.set("export", dtype="float32"), "export"),
    "export.parity_functions": (lambda w: w.set("export", parity_functions=7), "export"),
    "a section of a later stage": (lambda w: w.set("bake", spacing_m=3), ""),
    "effort: full": (lambda w: w.configuration.update(effort="full", full={"train": {"steps": 12}}), "train"),
    "effort: full of nothing": (lambda w: w.configuration.update(effort="full"), ""),
    "the order of the file": (lambda w: setattr(w, "configuration", dict(reversed(w.configuration.items()))), ""),
    "another shard in the place of one": (lambda w: shutil.copy(w.run / "dataset/training/house_0.0.h5", w.run / "dataset/training/plain.0.h5"), "datagen plain"),
    "a bit of a shard": (lambda w: flip(w.run / "dataset/held_out/held.0.h5", times=True), "datagen held"),
    "a shard is gone": (lambda w: (w.run / "dataset/training/plain.0.h5").unlink(), "datagen plain"),
    "a bit of the basis": (lambda w: flip(w.run / "basis.h5", times=True), "pca"),
    "a checkpoint is cut short": (lambda w: os.truncate(w.run / "training/tent_mlp4.ckpt", 1000), "train"),
    "a curve is gone": (lambda w: (w.run / "training/tent_mlp4/curve.png").unlink(), "train"),
    "other weights": (lambda w: shutil.copy(ROOT / "weights/tent_mlp4.safetensors", w.run / "weights/tent_mlp4.safetensors"), "export"),
    "a line of a table": (lambda w: (w.run / "training/tent_mlp4.csv").write_text("step\n"), "train"),
    "a record is gone": (lambda w: (w.run / ".origins/dataset/training/plain.0.h5.json").unlink(), "datagen plain"),
    "a record is damaged": (lambda w: os.truncate(w.run / ".origins/basis.h5.json", 20), "pca"),
    "all times of the results": (lambda w: tree(w.run, 4e9), ""),
    "what Snakemake keeps is gone": (lambda w: shutil.rmtree(w.run / ".snakemake"), ""),
    "a cache of a killed run": (lambda w: ((w.run / "training").mkdir(exist_ok=True), (w.run / "training/functions.cache").write_text("x")), ""),
    "the results have moved": (lambda w: (setattr(w, "out", elsewhere(w, "out")), setattr(w, "run", w.out / "run")), ""),
    "another checkout": (other_checkout, ""),
    "another script in it": (lambda w: (other_checkout(w), (w.root / "workflow/training_so_far.py").open("a").write("# x\n")), "train"),
    "tools of another revision": (other_revision, "said: of revision"),
    "a collected shard": (lambda w: flip(w.hard), "pca"),
    "a collected shard, its time kept": (lambda w: flip(w.hard, times=True), "pca"),
    "a collected shard gets another name": (lambda w: w.hard.rename(w.folder / "hard/maze.collected.h5"), "pca"),
    "one more is collected": (lambda w: shutil.copy(w.hard, w.folder / "hard/more.collected.h5"), "pca"),
    "one of a held-out level is collected": (lambda w: shutil.copy(w.hard, w.folder / "hard/held.collected.h5"), ""),
    "nothing is collected": (lambda w: w.set("scenes", collected=[]), "pca"),
    "a shard of no run": (lambda w: shutil.copy(w.run / "dataset/training/plain.0.h5", w.run / "dataset/training/left.0.h5"), "said: left.0.h5"),
}


def results(run):
    return {path: (run / path).read_bytes() for path in [*(str(shard.relative_to(run)) for shard in run.glob("dataset/*/*.h5")), "dataset.json", "basis.h5", "training/tent_mlp4.ckpt", "training/tent_mlp4.csv",
                                                        "training/tent_mlp4/curve.png", "weights/tent_mlp4.safetensors"]}


def changed(base, folder):
    shutil.copytree(base, folder, symlinks=True)
    return World(folder)


def shared_data(folder):
    """A run that shares another's data makes its own basis where weights bring one, and replaces nothing of the other."""
    world = changed(folder / "base", folder / "shared")
    shutil.copytree(world.run / "weights", world.folder / "weights")
    world.run = world.out / "second"
    world.run.mkdir()
    world.configuration.update(name="second", data="run")

    def asked():
        world.write()
        done = subprocess.run([world.command("-n")[0], *world.command("-n")[1:2], *world.command("-n")[3:]], env=world.environment(), capture_output=True, text=True)
        return done.returncode, re.findall(r"^    output: (.*)$", done.stdout + done.stderr, re.M), done.stderr
    code, outputs, said = asked()
    if code or any("dataset" in output or "basis" in output for output in outputs):
        yield f"shared data: {code}, {outputs}, {said}"
    world.configuration["init"] = str(world.folder / "weights")
    code, outputs, said = asked()
    if code or not any(str(world.run / "basis.h5") in output for output in outputs) or any(str(world.out / "run") in output for output in outputs):
        yield f"shared data and init: {code}, {outputs}, {said}"
    flip(world.levels / "plain.obj")
    code, outputs, said = asked()
    if code != 2 or "run run again" not in said or len(said.strip().splitlines()) != 1:
        yield f"shared data of another level: {code}, {outputs}, {said}"


def main():
    with tempfile.TemporaryDirectory() as folder:
        folder, failures, changes = Path(folder), [], list(CHANGES.items())[:: 4 if IS_SHORT else 1]
        world = World(folder / "base")
        write_levels(world.levels)
        write_collected(world.hard)
        world.make()
        for number, (name, (change, expected)) in enumerate(changes):
            world = changed(folder / "base", folder / f"{number}")
            change(world)
            again, said = world.asked_again()
            wanted, said_wanted = ("", expected.removeprefix("said: ")) if expected.startswith("said: ") else (expected, "")
            if again != wanted or said_wanted not in said:
                failures.append(f"{name}: again: {again!r}, expected {expected!r}; {said}")
            shutil.rmtree(folder / f"{number}")
        failures += shared_data(folder)
        # a level that is saved while its shard is made
        world = changed(folder / "base", folder / "saved")
        other_revision(world)
        (world.tools / "nlg-datagen").write_text(f'#!/bin/bash\n{BIN}/nlg-datagen "$@" || exit\n[[ "$*" != *plain.obj* ]] || echo "# x" >> {world.levels}/plain.obj\n[[ "$*" != *beside.gltf* ]] || echo >> {world.levels}/data/beside.dat\n')
        for scene in ("plain", "beside"):
            (world.run / f"dataset/training/{scene}.0.h5").unlink()
        world.make()
        again, _ = world.asked_again()
        if again != "datagen beside plain":
            failures.append(f"saved while their shards were made: again: {again!r}")
        # together, and afresh
        world, fresh = changed(folder / "base", folder / "together"), World(folder / "afresh")
        for name in ("a level, by one with an older time", "an alpha image", "basis.components"):
            CHANGES[name][0](world)
        shutil.copytree(world.levels, fresh.levels)
        shutil.copytree(world.hard.parent, fresh.hard.parent)
        fresh.configuration = json.loads(json.dumps(world.configuration))
        fresh.set("scenes", collected=[str(fresh.hard.parent)])
        for one in (world, fresh):
            one.make()
        found, wanted = results(world.run), results(fresh.run)
        failures += [f"{path}: other bytes than made afresh" for path in sorted({*found} | {*wanted}) if found.get(path) != wanted.get(path) and path != "dataset.json"]
        print("\n".join(failures) or f"{len(changes)} changes: all holds")
        return 1 if failures else 0


if __name__ == "__main__":
    sys.exit(main())

#!/usr/bin/env python3
"""Holds our path tracer against Blender's Cycles, on scenes of what artists bring, as Blender's own exporter writes them.

    docs/figures/cycles/compare.py [--out FOLDER] [--bin FOLDER] [--points N] [--samples N] [--rays N] [SCENE …]

Of every scene: Blender models it, exports it and bakes irradiance at sample points (scenes.py), nlg-render irradiance traces the file that was exported,
and the means are compared (ratios.py) → FOLDER/SCENE.result.json, and a line on stdout. What is there of the same settings and scripts is not made
again by Blender. docs/figures/results.py collect-cycles FOLDER makes the page of it. Scenes: images mask blend emission transmission sum; SCENE@means is a
scene whose images have been replaced by their means.
"""
import argparse
import json
import os
import re
import shutil
import subprocess
import sys
from pathlib import Path

sys.dont_write_bytecode = True
ROOT = Path(__file__).resolve().parents[3]
sys.path[:0] = [str(ROOT), str(ROOT / "docs" / "figures")]
from ratios import compare
from tool.atomic_file import write_atomically
from tool.errors import InputError, ToolError, UsageError, run
from tool.input_file import parse_number, read_columns, read_json

SCENES = ("images", "mask", "blend", "emission", "transmission", "sum")
PLACE = ("x", "y", "z", "nx", "ny", "nz")


def last_words(text):
    """What a Python script inside Blender ended with, or the last line."""
    lines = [line for line in text.splitlines() if line.strip()]
    return next((line for line in reversed(lines) if re.match(r"\w*(Error|Exception): ", line) and not line.startswith("Error: ")), lines[-1] if lines else "nothing")


def printed(command, what, **more):
    done = subprocess.run([str(word) for word in command], capture_output=True, text=True, **more)
    if done.returncode != 0:
        raise ToolError(f"{what} ended with {done.returncode}: {last_words(done.stdout + done.stderr)}")
    return done.stdout


def blender():
    """Blender 3.4's program: another's exporter writes other files."""
    found = shutil.which("blender")
    if found is None:
        raise UsageError("blender", "Blender 3.4 on the PATH (apt-get install --no-install-recommends blender python3-numpy)", "none")
    version = printed([found, "--version"], found).partition("\n")[0]
    if not re.match(r"Blender 3\.4\.", version):
        raise UsageError(found, "Blender 3.4, as in Debian 12", version or "no version")
    return found


def baked(scene, folder, places, samples):
    """What scenes.py wrote, made by it unless it is there."""
    path = folder / f"{scene}.json"
    wanted = {"places": places, "samples": samples}
    scripts = [Path(__file__).with_name(name) for name in ("scenes.py", "model.py")]
    if path.exists() and (folder / f"{scene}.glb").exists() and path.stat().st_mtime > max(script.stat().st_mtime for script in scripts):
        found = read_json(path).value
        if {"places": len(found["places"]), "samples": found["samples"]} == wanted:
            return found
    command = [blender(), "-b", "--factory-startup", "--python-exit-code", "1", "--python", scripts[0], "--", scene, folder, places, samples]
    # Debian's Blender takes whichever python3 the PATH has for its own
    printed(command, f"Blender, of {scene},", env={**os.environ, "PATH": "/usr/bin:/bin"})
    return read_json(path).value


def traced(scene, folder, found, tools, rays):
    """Irradiance by run, sample point and channel, of nlg-render: as many runs as Cycles has, of other seeds."""
    places = folder / f"{scene}.places.csv"
    rows = [",".join(f"{number:.9g}" for number in place) for place in found["places"]]
    write_atomically(places, "\n".join([",".join(PLACE), *rows, ""]).encode())
    sky = "0" if not any(found["sky"]) else ",".join(map(str, found["sky"]))
    columns = (*PLACE, "r", "g", "b", "dr", "dg", "db")
    runs = []
    for seed in range(1, len(found["runs"]) + 1):
        out = folder / f"{scene}.{seed}.csv"
        printed([tools / "nlg-render", "irradiance", folder / f"{scene}.glb", "--points", places, "--out", out, "--rays", rays, "--seed", seed, f"--sky={sky}"], f"nlg-render, of {scene},")
        runs.append([[parse_number(out, line, *cell) for cell in zip(columns[6:9], row[6:9])] for line, row in read_columns(out, columns)])
        if len(runs[-1]) != len(found["places"]):
            raise InputError(out, "rows", str(len(found["places"])), str(len(runs[-1])))
    return runs


def measure(scene, arguments):
    found = baked(scene, arguments.out, arguments.points, arguments.samples)
    revision = printed([arguments.bin / "nlg-render", "--version"], "nlg-render").strip()
    channels = compare(traced(scene, arguments.out, found, arguments.bin, arguments.rays), found["runs"])
    result = {"scene": scene, "revision": revision, "blender": found["blender"], "places": len(found["places"]), "runs": len(found["runs"]), "samples": found["samples"], "rays": arguments.rays, "channels": channels}
    write_atomically(arguments.out / f"{scene}.result.json", (json.dumps(result, indent=1) + "\n").encode())
    print(f"{scene:14}" + "  ".join(f"{name} {c['ratio']:.4f} ± {c['error']:.4f} (sample points differ by {c['difference']:.4f}, noise {c['noise']:.4f})" for name, c in channels.items()), flush=True)


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("scenes", nargs="*", metavar="SCENE", help="scenes to compare. None: all six")
    parser.add_argument("--out", type=Path, default=Path("out/cycles"), help="folder to write (%(default)s)")
    parser.add_argument("--bin", type=Path, default=ROOT / "build/release/bin", help="folder of nlg-render (%(default)s)")
    parser.add_argument("--points", type=int, default=600, help="number of sample points (%(default)s)")
    parser.add_argument("--samples", type=int, default=2048, help="samples of Cycles per sample point and run (%(default)s)")
    parser.add_argument("--rays", type=int, default=4096, help="rays of nlg-render per sample point and run (%(default)s)")
    arguments = parser.parse_args()
    for scene in arguments.scenes:
        if scene.removesuffix("@means") not in SCENES:
            raise UsageError("SCENE", f"one of {' '.join(SCENES)}, with or without @means", scene)
    arguments.out.mkdir(parents=True, exist_ok=True)
    for scene in arguments.scenes or SCENES:
        measure(scene, arguments)


if __name__ == "__main__":
    sys.exit(run("compare.py", main))

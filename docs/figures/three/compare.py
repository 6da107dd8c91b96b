#!/usr/bin/env python3
"""Holds our LightProbeGrid of a level against the one that three.js bakes itself, in the same box with as many texels.

    docs/figures/three/compare.py [--out FOLDER] [--bin FOLDER] [--three FOLDER] [--sky R,G,B] [--spacing-m M] [--extent-m …] SCENE.glb …

nlg-export engine makes ours, page.js has three.js bake its own in headless Chromium, three.js's shader reads both at sample points, and nlg-render
irradiance traces the truth there → FOLDER/SCENE/result.json, a picture by each grid, and a line on stdout. Both hold the sky, what shines and reflected
light; direct light of lamps and suns is left to shadow maps. Errors are RMSE of irradiance over its RMS, at
points that light reaches. Needs Chromium, and three.js as workflow/install_from_npm.sh three build/three installs it.
"""
import argparse
import base64
import functools
import glob
import http.server
import json
import math
import os
import resource
import subprocess
import sys
import tempfile
import threading
from pathlib import Path

sys.dont_write_bytecode = True
ROOT = Path(__file__).resolve().parents[3]
sys.path[:0] = [str(ROOT), str(ROOT / "tests"), str(ROOT / "tests" / "export" / "engine")]
from browser import Browser, complaints, find_browser
from three_test import IMPORTS, OPTIONS, QuietHandler
from tool.atomic_file import write_atomically
from tool.errors import ToolError, UsageError, run
from tool.input_file import parse_number, read_columns, read_json

PLACE = ("x", "y", "z", "nx", "ny", "nz")


def printed(*command):
    done = subprocess.run([str(word) for word in command], capture_output=True, text=True)
    if done.returncode != 0:
        raise ToolError(f"{command[0]} ended with {done.returncode}: {done.stderr}")
    return done.stdout


def group_seconds(group):
    """Processor seconds of the processes of a group."""
    ticks = 0
    for path in glob.glob("/proc/[0-9]*/stat"):
        try:
            fields = Path(path).read_text(errors="replace").rpartition(")")[2].split()
        except (FileNotFoundError, ProcessLookupError):
            continue  # it ended meanwhile
        ticks += (int(fields[2]) == group) * (int(fields[11]) + int(fields[12]))
    return ticks / os.sysconf("SC_CLK_TCK")


def child_seconds():
    used = resource.getrusage(resource.RUSAGE_CHILDREN)
    return used.ru_utime + used.ru_stime


def error(shown, truth):
    return math.sqrt(sum((a - b) ** 2 for s, t in zip(shown, truth) for a, b in zip(s, t)) / sum(b * b for t in truth for b in t))


def in_browser(folder, place, arguments):
    """What page.js finds: sample points, irradiance there by both grids, seconds of three.js's bake."""
    browser = Browser(find_browser(), folder / "profile", [*OPTIONS, "--disable-gpu-watchdog"])
    server = http.server.ThreadingHTTPServer(("127.0.0.1", 0), functools.partial(QuietHandler, directory=folder))
    threading.Thread(target=server.serve_forever, daemon=True).start()

    def call(name, *values):
        return browser.value(f"import('./page.js').then((page) => page.{name}({', '.join(map(json.dumps, values))}))")

    try:
        browser.open(f"http://127.0.0.1:{server.server_address[1]}/page.html")
        call("load", arguments.sky)
        places = call("points", arguments.points)
        before = group_seconds(browser.process.pid)
        wall_ms = call("bake", place, {"cubemapSize": arguments.cube, "near": 0.01, "far": 1000, "bounces": arguments.bounces})
        seconds = group_seconds(browser.process.pid) - before
        call("loadOurs", place)
        found = {"places": places, "seconds": seconds, "wall_seconds": wall_ms / 1000, **call("read", places)}
        found["pictures"] = call("pictures", 0.5 / max(place["mean_radiance"]))
        if complaints(browser.events):
            raise ToolError(f"the page complains: {complaints(browser.events)}")
        return found
    finally:
        browser.close()
        server.shutdown()


def measure(scene, arguments):
    light = ["--light-unit", "watt", "--light-direct", "none", f"--sky={','.join(map(str, arguments.sky))}"]
    out = arguments.out / scene.stem
    before = child_seconds()
    more = [f"--extent-m={arguments.extent_m}"] if arguments.extent_m else []
    printed(arguments.bin / "nlg-export", "engine", scene, "--format", "three", "--out", out, "--spacing-m", arguments.spacing_m, *more, *light)
    seconds = child_seconds() - before
    place = read_json(out / "light.json").value
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        links = {"three": arguments.three / "node_modules" / "three", "level.glb": scene, "light.bin": out / "light.bin", "page.js": Path(__file__).with_name("page.js")}
        for link, target in links.items():
            (folder / link).symlink_to(target.resolve())
        (folder / "page.html").write_text(f"<!doctype html><meta charset=utf-8><link rel=icon href=data:,><script type=importmap>{json.dumps({'imports': IMPORTS})}</script>")
        found = in_browser(folder, place, arguments)
    for name, picture in zip(("own", "ours"), found.pop("pictures")):
        write_atomically(out / f"{name}.png", base64.b64decode(picture.partition(",")[2]))
    points, traced = out / "points.csv", out / "truth.csv"
    write_atomically(points, "\n".join([",".join(PLACE), *(",".join(f"{number:.9g}" for number in row) for row in found["places"]), ""]).encode())
    printed(arguments.bin / "nlg-render", "irradiance", scene, "--points", points, "--out", traced, "--rays", arguments.rays, *light)
    columns = (*PLACE, "r", "g", "b", "dr", "dg", "db")
    truth = [[parse_number(traced, line, *cell) for cell in zip(columns[6:9], row[6:9])] for line, row in read_columns(traced, columns)]
    lit = [i for i, rgb in enumerate(truth) if max(rgb) > 0]  # the others lie in closed hollows
    groups = {"air": [i for i in lit if i < len(truth) // 2], "surface": [i for i in lit if i >= len(truth) // 2]}
    errors = {who: {group: error([found[who][i] for i in part], [truth[i] for i in part]) for group, part in groups.items()} for who in ("ours", "own")}
    write_atomically(out / "shown.json", json.dumps({who: found[who] for who in errors}).encode())
    mean = {who: sum(sum(found[who][i]) for i in lit) / sum(map(sum, truth)) for who in errors}
    result = {"scene": scene.stem, "revision": printed(arguments.bin / "nlg-export", "--version").strip(), "resolution": place["resolution"], "shipped": place["shipped"],
              "tool_error": place["error"], "error": errors, "mean_over_truth": mean, "seconds": {"ours": seconds, "own": found["seconds"], "own_wall": found["wall_seconds"]},
              "bounces": arguments.bounces, "cube": arguments.cube, "rays": arguments.rays, "points": {group: len(part) for group, part in groups.items()}}
    write_atomically(out / "result.json", (json.dumps(result, indent=1) + "\n").encode())
    said = "; ".join(f"{group} ours {errors['ours'][group]:.3f}, its own {errors['own'][group]:.3f}, ratio {errors['ours'][group] / errors['own'][group]:.2f}" for group in groups)
    print(f"{scene.stem} {place['resolution']} ({place['shipped']}): {said}; processor seconds {seconds:.0f}, {found['seconds']:.0f}", flush=True)


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("scenes", nargs="+", type=Path, metavar="SCENE.glb")
    parser.add_argument("--out", type=Path, default=Path("out/three"), help="folder to write (%(default)s)")
    parser.add_argument("--bin", type=Path, default=ROOT / "build/release/bin", help="folder of our tools (%(default)s)")
    parser.add_argument("--three", type=Path, default=ROOT / "build/three", help="folder of three.js (%(default)s)")
    parser.add_argument("--sky", type=lambda text: [float(word) for word in text.split(",")], default=[0.55, 0.75, 1.0], help="radiance of the sky (%(default)s)")
    parser.add_argument("--spacing-m", default="0", help="of nlg-export engine (%(default)s)")
    parser.add_argument("--extent-m", help="of nlg-export engine")
    parser.add_argument("--points", type=int, default=2000, help="number of sample points, half of them before surfaces (%(default)s)")
    parser.add_argument("--rays", type=int, default=4096, help="rays of truth per sample point (%(default)s)")
    parser.add_argument("--bounces", type=int, default=6, help="of three.js's bake (%(default)s)")
    parser.add_argument("--cube", type=int, default=16, help="pixels of a face in three.js's bake (%(default)s)")
    arguments = parser.parse_args()
    if find_browser() is None:
        raise UsageError("chromium", "a browser on the PATH", "none")
    for scene in arguments.scenes:
        measure(scene, arguments)


if __name__ == "__main__":
    sys.exit(run("compare.py", main))

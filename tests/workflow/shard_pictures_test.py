#!/usr/bin/python3
"""Pictures of shards: values that are known, walls that carry nothing, closed cuts; and the three pictures of a shard.

    shard_pictures_test.py BIN_FOLDER
"""
import importlib.util
import os
import sys
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]
sys.dont_write_bytecode = True
sys.path[:0] = [str(ROOT / "workflow"), str(ROOT / "tests")]
if importlib.util.find_spec("h5py") is None or importlib.util.find_spec("matplotlib") is None:
    print("h5py or matplotlib is missing")
    sys.exit(77)

import numpy as np
import shard_pictures
from shard_pictures import DIFFUSED, SEEN
from tools import INPUT_ERROR, USAGE_ERROR, Tools, run_checks

TOOLS = Tools(sys.argv[1])
check = TOOLS.check


def places(count, seed):
    return np.random.default_rng(seed).uniform(-1, 1, (count, 3))


def check_values(_):
    """A linear function is exact but at the border; nothing is carried through a sheet."""
    points, pixels = places(8192, 1), places(200, 2) * 0.75
    nothing = shard_pictures.planes_of(np.zeros((0, 3, 3)))
    kind, value, _ = shard_pictures.sampled(pixels, points, 0.5 + points @ [0.2, -0.15, 0.1], np.full(8192, SEEN), nothing)
    check((kind == SEEN).all() and np.abs(value - 0.5 - pixels @ [0.2, -0.15, 0.1]).max() < 0.01, "a linear function")
    sheet = shard_pictures.planes_of(np.array([[[0.31, -9, -9], [0.31, 9, -9], [0.31, 0, 9]]], float))
    behind = points[:, 0] > 0.31
    near_wall = pixels * [0, 1, 1] + [0.3, 0, 0]
    kind, value, _ = shard_pictures.sampled(near_wall, points, 1.0 - behind, np.where(behind, DIFFUSED, SEEN), sheet)
    check((kind == SEEN).all() and (value == 1).all(), "a pixel 1 cm before a sheet takes what lies behind it")


def check_cut(_):
    """Every end of a cut through a closed solid is the end of two segments."""
    corners = np.array([[0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1]], float)
    ends, which = shard_pictures.cut(corners[[[0, 2, 1], [0, 1, 3], [0, 3, 2], [1, 2, 3]]], 1, 0.3)
    _, counts = np.unique(ends.reshape(-1, 3).round(9), axis=0, return_counts=True)
    check(len(which) == 3 and (counts == 2).all(), f"the cut of a tetrahedron: {ends}")


def check_pictures(tools):
    """All three are drawn, twice with the same bytes; what cannot be drawn is refused."""
    os.environ["NLG_BIN"] = tools.folder
    script = str(ROOT / "workflow/shard_pictures.py")
    tools.run(["nlg-datagen", "--scene", "house:1", "--spacing-min-m", "2", "--spacing-max-m", "2", "--max-functions", "3", "--out", "a.h5"])
    for which in (["--probe", "0"], ["--atlas"], ["--top"]):
        pictures = []
        for name in ("a.png", "b.png"):
            done = tools.run(["/usr/bin/python3", script, "a.h5", *which, "--px", "64", "--out", name])
            check(done.returncode == 0, f"{which}: {done.stderr}")
            pictures.append(Path(name).read_bytes())
        check(pictures[0] == pictures[1] and pictures[0].startswith(b"\x89PNG"), f"{which}: other bytes")
    for code, words, arguments in [(USAGE_ERROR, "0 to 2", ["a.h5", "--probe", "3"]), (USAGE_ERROR, "--height", ["a.h5", "--top", "--height", "high"]), (INPUT_ERROR, "a.png", ["a.png", "--atlas"]),
                                   (INPUT_ERROR, "none.glb", ["a.h5", "--atlas", "--scene", "none.glb"])]:
        done = tools.run(["/usr/bin/python3", script, *arguments, "--out", "x.png"])
        check(done.returncode == code and words in done.stderr and not os.path.exists("x.png"), f"{arguments}: {done.returncode} {done.stderr}")
    done = tools.run(["/usr/bin/python3", script, "a.h5", "--atlas", "--out", "./a.h5"])
    check(done.returncode == USAGE_ERROR and "not an input" in done.stderr, f"an input is replaced: {done.stderr}")


if __name__ == "__main__":
    sys.exit(run_checks(TOOLS, (check_values, check_cut, check_pictures)))

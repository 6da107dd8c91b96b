"""README's first pictures: one view of a scene by trilinear probes, by DDGI, by the light grid, and path traced.

    docs/figures/first_pictures.py --bin build/release/bin [--out docs/images]

All with the same probes and the same exposure; below each its bytes a probe and its error, the RMSE of irradiance over truth's RMS. Some ten
minutes on two cores. The levels are those of Debian's packages (docs/guide/levels.md).
"""
import argparse
import json
import subprocess
import sys
import tempfile
from pathlib import Path

import matplotlib

matplotlib.use("Agg")
import matplotlib.pyplot as plt

sys.path.insert(0, str(Path(__file__).resolve().parents[2]))  # tool/, which all scripts share
from tool.errors import run as run_script

LEVELS = "/usr/share/games/openarena/baseoa"
VIEWS = {"leaks_house": ("house:3", []), "leaks_level": (f"{LEVELS}:oa_dm1", ["--camera", "0"])}  # picture: scene, options of the view
METHODS = {"trilinear": "trilinear probes, as most engines have them", "ddgi": "DDGI, probes relocated", "grid": "this light grid", "truth": "path tracing"}
BYTES = {"trilinear": 8, "ddgi": 1288}  # a probe: docs/guide/techniques.md
TRUTH_RAYS, WIDTH = "1024", "480"


def rendered(tool, scene, options, out):
    """One picture; what the tool says of it."""
    done = subprocess.run([tool, scene, *options, "--width", WIDTH, "--truth-rays", TRUTH_RAYS, "--out", out], check=True, stdout=subprocess.PIPE)
    return json.loads(done.stdout)


def figure(bins, scene, view, out):
    with tempfile.TemporaryDirectory() as folder:
        grid = f"{folder}/grid.safetensors"
        subprocess.run([bins / "nlg-bake", scene, "--out", grid], check=True, stdout=subprocess.DEVNULL)
        known = subprocess.run([bins / "nlg-datagen", "info", grid], check=True, stdout=subprocess.PIPE, text=True)
        said = rendered(bins / "nlg-render", scene, [*view, "--grid", grid, "--panel", *METHODS], f"{folder}/panel.png")
        errors = {picture["method"]: picture.get("rmse") for picture in said["pictures"]}
        _, axes = plt.subplots(1, len(METHODS), figsize=(20, 4.6), layout="constrained")
        for axis, (method, title) in zip(axes, METHODS.items()):
            rendered(bins / "nlg-render", scene, [*view, "--grid", grid, "--method", method, "--exposure", str(said["exposure"])], f"{folder}/{method}.png")
            axis.imshow(plt.imread(f"{folder}/{method}.png"))
            axis.set_title(title, fontsize=16)
            axis.set_axis_off()
        plt.savefig(out, dpi=100)
    return known, errors

"""README's first pictures: one view of a scene by trilinear probes, by DDGI, by the light grid, and path traced.

    docs/figures/first_pictures.py --bin build/release/bin [--out docs/images] [PICTURE ...]

All have the same probes and the same exposure, that of the light grid. Above each stand its bytes a probe. Some minutes a picture. The level is one of Debian's packages (docs/guide/levels.md).
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

VIEWS = {"leaks_house": ("house:3", []), "leaks_level": ("/usr/share/games/openarena/baseoa:aggressor", ["--camera", "0"])}  # options of nlg-render
TITLES = {"trilinear": "trilinear probes", "ddgi": "DDGI, relocated", "grid": "this light grid", "truth": "path tracing"}
BYTES = {"trilinear": 8, "ddgi": 1288}  # a probe: docs/guide/techniques.md


def draw(bins, scene, view, out):
    def tool(name, *arguments):
        return subprocess.run([bins / name, scene, *arguments], check=True, stdout=subprocess.PIPE).stdout

    with tempfile.TemporaryDirectory() as folder:
        grid, report = f"{folder}/grid.safetensors", f"{folder}/bake.json"
        tool("nlg-bake", "--out", grid, "--json", report)
        bytes_a_probe = {**BYTES, "grid": json.loads(Path(report).read_text())["bytes_per_probe"]}
        options = [*view, "--grid", grid, "--width", "480", "--truth-rays", "192"]
        exposure = json.loads(tool("nlg-render", *options, "--method", "grid", "--out", f"{folder}/grid.png"))["exposure"]
        figure, axes = plt.subplots(1, len(TITLES), figsize=(19.2, 4.2), layout="constrained")
        for axis, (method, title) in zip(axes, TITLES.items()):
            tool("nlg-render", *options, "--method", method, "--exposure", str(exposure), "--out", f"{folder}/{method}.png")
            axis.imshow(plt.imread(f"{folder}/{method}.png"))
            axis.set_title(title + (f": {bytes_a_probe[method]:,.0f} bytes a probe" if method in bytes_a_probe else ""), fontsize=17)
            axis.set_axis_off()
        figure.savefig(out, dpi=80, bbox_inches="tight", pad_inches=0.05)


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--bin", type=Path, required=True)
    parser.add_argument("--out", type=Path, default=Path("docs/images"))
    parser.add_argument("pictures", nargs="*", default=list(VIEWS))
    arguments = parser.parse_args()
    for name in arguments.pictures:
        draw(arguments.bin.resolve(), *VIEWS[name], arguments.out / f"{name}.png")


if __name__ == "__main__":
    sys.exit(run_script("first_pictures", main))

#!/usr/bin/env python3
"""Pictures and tables of docs/lab/weighting_functions.md from what nlg-solve wrote: FOLDER/SCENE.json and FOLDER/SCENE.csv.

usage: weighting_slices.py FOLDER IMAGE_FOLDER    draws IMAGE_FOLDER/weighting_SCENE.png, prints the table of means as Markdown
"""
import io
import pathlib
import sys

sys.dont_write_bytecode = True

import packages

packages.need("weighting_slices.py", "matplotlib", "numpy")

import matplotlib
import numpy as np

matplotlib.use("Agg")
import matplotlib.pyplot as plt

from tool.atomic_file import write_atomically
from tool.errors import run
from tool.input_file import as_documented, read_json, read_rows

WEIGHT_MAP = matplotlib.colormaps["inferno"]
DIFFERENCE_MAP = matplotlib.colormaps["PuOr_r"]  # orange: the generated function lets more in than the solved one
KINDS = ("seen tent", "present", "falloff 1", "path", "solved")
TITLES = {"seen tent": "seen tent (no pass)", "present": "generated: present rule", "falloff 1": "generated: falloff 1",
          "path": "generated: path⁸", "solved": "solved"}
DIFFERENCE_LIMIT = 0.5
PROBES_A_SCENE = 3
REACH_M = 1.15  # shown on each side of the probe: its support is one metre
CELL = 2.1  # inches
FIGURES = ("rmse", "rmse_occluded", "unlit_share", "leak", "step_p99", "distance_solved")


def picture(scene, values, colours, low, high):
    """The slice as RGB, hatched grey in solid; rows downwards from high v to low v."""
    size = scene["pixel_m"]
    u0, u1, v0, v1 = scene["room"]
    columns = np.floor(np.array(scene["u"]) / size).astype(int) - int(np.floor(u0 / size))
    rows = np.floor(np.array(scene["v"]) / size + 1e-4).astype(int) - int(np.floor(v0 / size))
    shape = (int(np.ceil((v1 - v0) / size)) + 1, int(np.ceil((u1 - u0) / size)) + 1)
    row, column = np.indices(shape)
    image = np.where(((row + column) % 4 < 1)[..., None], [0.62, 0.65, 0.68], [0.86, 0.88, 0.89])
    image[rows, columns] = colours(np.clip((np.array(values) - low) / (high - low), 0, 1))[:, :3]
    return image[::-1]


def draw(scene):
    """The picture's bytes."""
    functions = scene["functions"][:PROBES_A_SCENE]
    u0, _, v0, _ = scene["room"]
    count = len(KINDS) + 1
    figure, grid = plt.subplots(len(functions), count, figsize=(CELL * count, CELL * len(functions) + 0.3), squeeze=False,
                                layout="constrained")
    size = scene["pixel_m"]
    left, bottom = np.floor(u0 / size) * size, np.floor(v0 / size) * size
    for row, (axes_row, function) in enumerate(zip(grid, functions)):
        images = [(TITLES[kind], picture(scene, np.sqrt(function[kind]), WEIGHT_MAP, 0, 1)) for kind in KINDS]
        difference = np.array(function["present"]) - np.array(function["solved"])
        images.append(("present − solved", picture(scene, difference, DIFFERENCE_MAP, -DIFFERENCE_LIMIT, DIFFERENCE_LIMIT)))
        for axes, (title, image) in zip(axes_row, images):
            axes.imshow(image, extent=(left, left + image.shape[1] * size, bottom, bottom + image.shape[0] * size),
                        interpolation="nearest")
            axes.plot(*function["at"], "o", markersize=6, markerfacecolor="none", markeredgecolor="black", markeredgewidth=2.4)
            axes.plot(*function["at"], "o", markersize=6, markerfacecolor="none", markeredgecolor="white", markeredgewidth=1.0)
            axes.set(xlim=(function["at"][0] - REACH_M, function["at"][0] + REACH_M), xticks=[], yticks=[],
                     ylim=(function["at"][1] - REACH_M, function["at"][1] + REACH_M), facecolor="#dbe0e4")
            if row == 0:
                axes.set_title(title, fontsize=10)
    data = io.BytesIO()
    figure.savefig(data, format="png", dpi=80, facecolor="white", metadata={"Software": None})
    plt.close(figure)
    return data.getvalue()


def read_tables(folder):
    """{rule and constants: {scene: figures}}"""
    table = {}
    for path in sorted(folder.glob("*.csv")):
        with as_documented(path):
            (_, header), *rows = read_rows(path)
            for row in (dict(zip(header, values)) for _, values in rows):
                key = (row["rule"], row["passes"], row["sigma"], row["falloff"], row["path_power"])
                table.setdefault(key, {})[row["scene"]] = [float(row[name]) for name in FIGURES]
    return table


def name_of(key):
    rule, passes, sigma, falloff, power = key
    if not passes:
        return rule
    constants = f"power {power}" if rule == "path" else f"σ {sigma}, falloff {falloff}"
    return f"{rule}, {passes} {'pass' if passes == '1' else 'passes'}, {constants}"


def main():
    folder, images = map(pathlib.Path, sys.argv[1:3])
    for path in sorted(folder.glob("*.json")):
        with as_documented(path):
            picture_data = draw(read_json(path).value)
        write_atomically(images / f"weighting_{path.stem}.png", picture_data)
    table = read_tables(folder)
    scenes = sorted(next(iter(table.values())))
    rows = sorted(((np.mean([table[key][s] for s in scenes], axis=0), key) for key in table), key=lambda row: row[0][1])
    print("| rule | " + " | ".join(FIGURES) + " | " + " | ".join(scenes) + " |\n" + "|---" * (1 + len(FIGURES) + len(scenes)) + "|")
    for means, key in rows:
        numbers = [f"{value:.4f}" for value in means] + [f"{table[key][s][1]:.3f}" for s in scenes]
        print(f"| {name_of(key)} | " + " | ".join(numbers) + " |")


if __name__ == "__main__":
    sys.exit(run("weighting_slices.py", main))

#!/usr/bin/env python3
"""Error of light against bytes, indirect light, by kind of scene: the light grid, whole and thinned, and what it is held against.

    light_front.py --results docs/results/light.json --out docs/images/light_against_bytes.png
"""
import argparse
import logging
import sys

sys.dont_write_bytecode = True
logging.getLogger("matplotlib").setLevel(logging.ERROR)

import packages

packages.need("light_front.py", "matplotlib", "numpy")

import plots
from decision import bytes_text
from light_figures import GROUP_NAMES, GROUPS, SCENE_KINDS
from light_section import COLOURS, LIGHT_STYLES
from matplotlib.ticker import FuncFormatter, LogLocator, NullFormatter
from tool.atomic_file import write_files
from tool.errors import run
from tool.input_file import as_documented, read_json

BASELINES = (("valid trilinear", "point"), ("trilinear", "solved"), ("APV", "point"), ("APV", "solved"), ("DDGI as shipped, relocated", "own"), ("DDGI's weights", "solved"))
KINDS = ("levels", "furnished", "daylight")
PANEL = (3.9, 2.9)  # inches


def draw_panel(axes, lines, ours, group):
    """Baselines: a line each through its spacings. Ours: a point a grid, filled where it is whole, and the front of them."""
    for colour, method in zip(COLOURS[2:], BASELINES):
        line = sorted((point["bytes"], point[group]) for point in lines if (point["weights"], point["light"]) == method)
        if line:
            axes.plot(*zip(*line), color=colour, linestyle=LIGHT_STYLES[method[1]], marker="o", markersize=3.5, linewidth=1.1, label=f"{method[0]}, {method[1]}", zorder=2)
    colour = plots.representation_colour(ours)
    mine = [point for point in lines if point["is_ours"]]
    front = plots.pareto([(point["bytes"], point[group]) for point in mine])
    axes.plot(*zip(*front), color=colour, linewidth=1.6, zorder=4)
    for thinned, fill in ((False, colour), (True, "white")):
        some = [(point["bytes"], point[group]) for point in mine if point["light"] == "solved" and (point["weights"] != ours) == thinned]
        if some:
            axes.plot(*zip(*some), linestyle="", marker="o", color=colour, markerfacecolor=fill, markersize=5 if not thinned else 3.5, markeredgewidth=0.9, zorder=5,
                      label=f"light grid, {'thinned' if thinned else ours}")
    axes.set_xscale("log")
    axes.xaxis.set_major_locator(LogLocator())
    axes.xaxis.set_major_formatter(FuncFormatter(lambda value, _: bytes_text(value)))
    axes.xaxis.set_minor_formatter(NullFormatter())
    errors = [point[group] for point in lines]
    plots.log_error_axis(axes.yaxis, 0.85 * min(errors), 1.2 * max(errors))
    axes.grid(True)


def draw(results):
    found, ours = results["indirect"]["against_bytes"], results["ours"].text()
    shown = [(kind, [{key: node.value for key, node in point.entries()} for point in found[kind].items()]) for kind in KINDS if kind in found]
    height = PANEL[1] * len(shown)
    figure, panels = plots.plt.subplots(len(shown), len(GROUPS), figsize=(PANEL[0] * len(GROUPS), height + 0.6), squeeze=False)
    for row, (kind, lines) in zip(panels, shown):
        for axes, group in zip(row, GROUPS):
            draw_panel(axes, lines, ours, group)
        row[0].set_ylabel(f"{SCENE_KINDS[kind]}\nRMSE over truth’s root mean square")
    for group, top, bottom in zip(GROUPS, panels[0], panels[-1]):
        top.set_title(GROUP_NAMES[group])
        bottom.set_xlabel("bytes of a scene")
    figure.tight_layout(rect=(0.0, 0.6 / (height + 0.6), 1.0, 1.0))
    figure.legend(*panels[0][0].get_legend_handles_labels(), loc="lower center", ncol=5)
    return plots.png(figure)


def main():
    parser = argparse.ArgumentParser(description="Draws error of indirect light against bytes, geometric means over the scenes of a kind.")
    parser.add_argument("--results", required=True, help="docs/results/light.json")
    parser.add_argument("--out", required=True, help="picture to write (.png)")
    arguments = parser.parse_args()

    def make():
        results = read_json(arguments.results)
        with as_documented(arguments.results):
            return {arguments.out: draw(results)}
    return run("light_front.py", lambda: write_files(make()))


if __name__ == "__main__":
    sys.exit(main())

#!/usr/bin/env python3
"""Light over scenes: what nlg-validate light measured of each, summed up by method, and error against bytes.

    light.py --light out/light/*.json --out out/light/summary

Writes summary.json (docs/reference/formats.md) and error_against_bytes.png into the folder --out.
"""
import argparse
import json
import logging
import os
import sys

sys.dont_write_bytecode = True
logging.getLogger("matplotlib").setLevel(logging.ERROR)

import packages

packages.need("light.py", "matplotlib", "numpy")

from matplotlib.ticker import FuncFormatter, LogLocator, NullFormatter

import plots
from decision import bytes_text
from light_figures import GROUP_NAMES, GROUPS, NOT_STORED, methods_of, read_all, summary
from light_section import COLOURS, LIGHT_STYLES
from tool.atomic_file import write_files
from tool.errors import run

LEGEND_COLUMNS = 4


def fronts(points):
    """A panel a scene and group: error against bytes, one line a method through its spacings. Target functions, which nobody stores, are left out."""
    points = [point for point in points if point.method[0] != NOT_STORED]
    scenes = sorted({point.scene for point in points})
    colours = {weights: COLOURS[i % len(COLOURS)] for i, weights in enumerate(dict.fromkeys(point.method[0] for point in points))}
    rows = -(-len(set(point.method for point in points)) // LEGEND_COLUMNS)
    height, key = 2.9 * len(scenes), 0.18 * rows + 0.2
    figure, axes = plots.plt.subplots(len(scenes), len(GROUPS), figsize=(4.2 * len(GROUPS), height + key), squeeze=False)
    for row, scene in enumerate(scenes):
        for column, group in enumerate(GROUPS):
            axis = axes[row][column]
            for method in methods_of(points):
                line = sorted(((point.bytes, point.rmse[group]) for point in points if point.scene == scene and point.method == method))
                if line:
                    axis.plot(*zip(*line), color=colours[method[0]], linestyle=LIGHT_STYLES[method[1]], marker="o" if method[1] == "solved" else ".", markersize=4, linewidth=1.1,
                              label=", ".join(method))
            axis.set_xscale("log")
            axis.set_yscale("log")
            axis.xaxis.set_major_locator(LogLocator())
            axis.xaxis.set_major_formatter(FuncFormatter(lambda value, _: bytes_text(value)))
            axis.yaxis.set_major_locator(LogLocator(subs=(1, 2, 5)))
            axis.yaxis.set_major_formatter(FuncFormatter(lambda value, _: f"{value:g}"))
            for ticks in (axis.xaxis, axis.yaxis):
                ticks.set_minor_formatter(NullFormatter())
            axis.grid(True, which="both")
            axis.set_title(f"{scene}, {GROUP_NAMES[group]}")
            axis.set_ylabel("RMSE / truth's RMS" if column == 0 else "")
            axis.set_xlabel("bytes")
    figure.tight_layout(rect=(0.0, key / (height + key), 1.0, 1.0))
    handles, labels = axes[0][0].get_legend_handles_labels()
    figure.legend(handles, labels, loc="lower center", ncol=LEGEND_COLUMNS)
    return plots.png(figure)


def make(arguments):
    points = read_all(arguments.light)
    return {os.path.join(arguments.out, "summary.json"): (json.dumps(summary(points), indent=1) + "\n").encode(),
            os.path.join(arguments.out, "error_against_bytes.png"): fronts(points)}


def main():
    parser = argparse.ArgumentParser(description="Sums up what nlg-validate light measured of several scenes, and draws error against bytes.")
    parser.add_argument("--light", required=True, nargs="+", help="results of nlg-validate light")
    parser.add_argument("--out", required=True, help="folder to write")
    arguments = parser.parse_args()
    return run("light.py", lambda: write_files(make(arguments)))


if __name__ == "__main__":
    sys.exit(main())

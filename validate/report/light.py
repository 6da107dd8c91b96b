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
from dataclasses import dataclass

sys.dont_write_bytecode = True
logging.getLogger("matplotlib").setLevel(logging.ERROR)

import packages

packages.need("light.py", "matplotlib", "numpy")

import numpy as np
from matplotlib.ticker import FuncFormatter, LogLocator, NullFormatter

import inputs
import output
import plots

SCHEMA_VERSION = 1
REFERENCE = ("valid trilinear", "point")
GROUPS = ("air", "surface", "turned")
GROUP_NAMES = {"air": "in air", "surface": "5–50 cm before surfaces", "turned": "the same, any normal"}
RESAMPLES, SEED = 4000, 1
LEGEND_COLUMNS = 4
LIGHT_STYLES = {"point": (0, (1.5, 1.5)), "solved": "-", "own": (0, (4, 1.5))}
COLOURS = ["#7a828a", "#1d232a", "#0072B2", "#E69F00", "#CC79A7", "#D55E00", "#009E73", "#56B4E9", "#9b6a8f", "#6b2d0f", "#7a3fb0", "#c08a00"]


@dataclass
class Point:
    """A method in one scene at one spacing."""
    scene: str
    spacing_m: float
    method: tuple  # weights, light
    rmse: dict     # by group
    smape: float
    colour: float
    dark: float
    jump_mean: float
    jump_largest: float
    unlit: float
    outside: float
    bytes: int


def read_points(path):
    result = inputs.read_json(path)
    if result["schema_version"].number() != SCHEMA_VERSION:
        result["schema_version"].refuse(str(SCHEMA_VERSION), str(result["schema_version"].value))
    points = []
    for spacing in result["spacings"].items():
        for method in spacing["methods"].items():
            air, jumps = method["air"], method["jumps"]
            points.append(Point(result["scene"].text(), spacing["spacing_m"].number(), (method["weights"].text(), method["light"].text()),
                                {group: method[group]["rmse"].number() for group in GROUPS}, air["smape"].number(0.0, 1.0), air["colour"]["mean"].number(),
                                method["dark"]["excess"].number(low=-np.inf), jumps["mean"].number(), jumps["largest"].number(), air["unlit"].number(0.0, 1.0),
                                air["outside"].number(0.0, 1.0), method["bytes"]["total"].count()))
    return points


def interval(values, reduce):
    """The 95 % interval of a figure over scenes, by bootstrap; None with fewer than three scenes."""
    if len(values) < 3:
        return None
    values = np.asarray(values)
    drawn = np.random.default_rng(SEED).integers(0, len(values), (RESAMPLES, len(values)))
    low, high = np.percentile([reduce(values[row]) for row in drawn], (2.5, 97.5))
    return [float(low), float(high)]


def figure(values, reduce=np.mean):
    return {"mean": float(reduce(np.asarray(values))), "interval": interval(values, reduce)}


def geometric_mean(values):
    return float(np.exp(np.mean(np.log(values))))


def method_figures(points, references):
    """points: of one method at one spacing; references: scene → the reference's point."""
    figures = {"scenes": sorted(point.scene for point in points)}
    for group in GROUPS:
        figures[group] = figure([point.rmse[group] for point in points])
        ratios = [point.rmse[group] / references[point.scene].rmse[group] for point in points if point.scene in references and references[point.scene].rmse[group] > 0.0 and point.rmse[group] > 0.0]
        if ratios:
            figures[group]["ratio"] = figure(ratios, geometric_mean)
    for name in ("smape", "colour", "dark", "jump_mean", "jump_largest", "unlit", "outside"):
        figures[name] = figure([getattr(point, name) for point in points])
    figures["bytes"] = int(sum(point.bytes for point in points))
    return figures


def summary(points):
    spacings = []
    for spacing_m in sorted({point.spacing_m for point in points}):
        of_spacing = [point for point in points if point.spacing_m == spacing_m]
        references = {point.scene: point for point in of_spacing if point.method == REFERENCE}
        methods = []
        for method in dict.fromkeys(point.method for point in of_spacing):
            methods.append({"weights": method[0], "light": method[1], **method_figures([point for point in of_spacing if point.method == method], references)})
        spacings.append({"spacing_m": spacing_m, "methods": methods})
    return {"schema_version": SCHEMA_VERSION, "scenes": sorted({point.scene for point in points}), "reference": {"weights": REFERENCE[0], "light": REFERENCE[1]}, "spacings": spacings}


def bytes_text(value):
    for unit, name in ((1e9, "GB"), (1e6, "MB"), (1e3, "kB")):
        if value >= unit:
            return f"{value / unit:g} {name}"
    return f"{value:g} B"


def fronts(points):
    """A panel a scene and group: error against bytes, one line a method through its spacings. Target functions, which nobody stores, are left out."""
    points = [point for point in points if point.method[0] != "target functions"]
    scenes = sorted({point.scene for point in points})
    colours = {weights: COLOURS[i % len(COLOURS)] for i, weights in enumerate(dict.fromkeys(point.method[0] for point in points))}
    rows = -(-len(set(point.method for point in points)) // LEGEND_COLUMNS)
    height, key = 2.9 * len(scenes), 0.18 * rows + 0.2
    figure, axes = plots.plt.subplots(len(scenes), len(GROUPS), figsize=(4.2 * len(GROUPS), height + key), squeeze=False)
    for row, scene in enumerate(scenes):
        for column, group in enumerate(GROUPS):
            axis = axes[row][column]
            for method in dict.fromkeys(point.method for point in points):
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
    points = [point for path in arguments.light for point in read_points(path)]
    return {os.path.join(arguments.out, "summary.json"): (json.dumps(summary(points), indent=1) + "\n").encode(),
            os.path.join(arguments.out, "error_against_bytes.png"): fronts(points)}


def main():
    parser = argparse.ArgumentParser(description="Sums up what nlg-validate light measured of several scenes, and draws error against bytes.")
    parser.add_argument("--light", required=True, nargs="+", help="results of nlg-validate light")
    parser.add_argument("--out", required=True, help="the folder to write to")
    arguments = parser.parse_args()
    return output.run("light.py", arguments.out, lambda: make(arguments))


if __name__ == "__main__":
    sys.exit(main())

#!/usr/bin/env python3
"""Blend RMSE against run time: every method of nlg-validate's frontier, and the front that nothing beats.

    frontier.py --frontier out/frontier/frontier.json --out docs/images/error_against_time.png

The report shows the same figure, and one of the same kind a scene.
"""
import argparse
import logging
import sys
from dataclasses import dataclass

sys.dont_write_bytecode = True
logging.getLogger("matplotlib").setLevel(logging.ERROR)

import packages

packages.need("frontier.py", "matplotlib", "numpy")

import numpy as np
from matplotlib.ticker import FuncFormatter, LogLocator, NullFormatter

import plots
import proof_inputs
import verdict
from tool.atomic_file import write_atomically
from tool.errors import run

# marker, filled, size, words
MARKS = {"network": ("o", True, 6.5, "network"), "corrected": ("s", True, 5.5, "corrected"), "fitted": ("D", True, 5, "fitted"), "stored": ("P", True, 6.5, "stored"),
         "stages": (".", True, 5.5, "other stages"), "lm": ("^", True, 5, "+ LM"), "adam": ("v", True, 5, "+ Adam"), "direct_lm": ("^", False, 5.5, "LM alone"),
         "direct_adam": ("v", False, 5.5, "Adam alone")}
FAMILIES = {"stages": "stages", "lm_from_corrected": "lm", "adam_from_corrected": "adam",
            "lm_from_theta0": "direct_lm", "lm_from_random": "direct_lm", "adam_from_theta0": "direct_adam", "adam_from_random": "direct_adam"}
BAND = "#0072B2"
RUNAWAY = 1.0  # φ lies in 0 to 1: a mean blend RMSE from here on is some θ that left all measure. Such a point lies above the plot of all scenes, and is named there
KEY_HEIGHTS = (0.965, 0.925)  # of the two rows of the key, shares of the figure


@dataclass
class View:
    """The functions that a plot of the whole set is over."""
    population: str
    words: str
    tent: float       # mean blend RMSE of the bare tent
    sentence: str

    def spread(self, point):
        return point.over(self.population)

    def on_front(self, point):
        return point.fronts[self.population]


def views(frontier):
    """Functions that take a theta, then the hard ones of them."""
    return [View(population, f"{frontier.functions[population]} {words}", frontier.tent[population], frontier.sentences[population])
            for population, words in (("theta", "functions that take a θ"), ("hard", "hard functions")) if frontier.functions[population]]


def stage_points(frontier, representation):
    """Stages' titles → the point after each: what a stage of the policy costs and gains."""
    return {point.label: point for point in frontier.points if point.family == "stages" and point.budget is None and point.representation == representation} if frontier else {}


def kind_of(point):
    """Which mark: the last of its words, or its family."""
    if point.words:
        return point.words[-1]
    return FAMILIES[point.family.removesuffix("_gated")]


def is_chain(point):
    """Whether a line joins the budgets of the point's family."""
    return point.family != "stages" or point.budget is None


def look(point):
    return MARKS[kind_of(point)]


def figure_text(point, spread):
    return (f"{point.representation}: {point.label}\n{plots.duration(spread.us)} a function\n"
            f"blend RMSE {spread.mean:.4f}, p5–p95 {spread.p5:.4f} to {spread.p95:.4f}; RMSE {spread.rmse:.4f}")


def front_of(frontier, view):
    """(point, its spread) of the front by rising time, as nlg-validate marked it."""
    members = [(point, view.spread(point)) for point in frontier.points if view.on_front(point)]
    return sorted(members, key=lambda member: (member[1].us, member[1].mean))


def front_of_scene(frontier, scene):
    """The same of one scene, by mean blend RMSE. Left out is what is no better than the bare tent, which takes no time."""
    some = [(p.by_scene[scene].us, p.by_scene[scene].mean, i) for i, p in enumerate(frontier.points)
            if scene in p.by_scene and p.by_scene[scene].us > 0 and p.by_scene[scene].mean < frontier.tent_by_scene.get(scene, float("inf"))]
    members = [(frontier.points[i], frontier.points[i].by_scene[scene]) for _, _, i in plots.pareto(some)]
    return sorted(members, key=lambda member: (member[1].us, member[1].mean))


def limits_of(spreads, members):
    """((time from, to), (error from, to)) around all points but runaways; the bands of fronts are cut at the edge."""
    times = [s.us for s in spreads if s.us > 0]
    errors = [s.mean for s in spreads if 0 < s.mean < RUNAWAY] or [1e-3]
    bands = [value for s in members for value in (s.p5, s.p95) if value > 0] or errors
    return (min(times) / 1.6, max(times) * 1.9), (max(min(errors + bands) / 1.25, max(errors) / 2000), max(errors + bands) * 1.3)


def time_axis(axes, low, high):
    axes.set(xscale="log", xlim=(low, high))
    axes.xaxis.set_major_locator(LogLocator(subs=(1,), numticks=20))
    axes.xaxis.set_major_formatter(FuncFormatter(lambda v, _: plots.duration(v)))
    axes.xaxis.set_minor_formatter(NullFormatter())


def draw_front(axes, front, bounds):
    clipped = lambda values: np.clip(values, *bounds)
    times = [s.us for _, s in front]
    axes.fill_between(times, clipped([s.p5 for _, s in front]), clipped([s.p95 for _, s in front]), color=BAND, alpha=0.13, linewidth=0, zorder=1)
    for key in ("p5", "p95"):
        axes.plot(times, clipped([getattr(s, key) for _, s in front]), color=BAND, linewidth=0.7, alpha=0.55, zorder=1)
    axes.plot(times, clipped([s.mean for _, s in front]), color=plots.INK, linewidth=1.8, zorder=4)


def draw_tent(axes, error, bounds):
    """What costs nothing: whatever lies above this line is worth nothing."""
    if bounds[0] < error < bounds[1]:
        axes.axhline(error, color=plots.COLOURS["tent"], linewidth=1.1, linestyle=(0, (5, 3)), zorder=3)
        axes.annotate("bare tent, no network", (0.995, error), xycoords=("axes fraction", "data"), xytext=(0, 3), textcoords="offset points", ha="right", va="bottom",
                      fontsize=8, color=plots.COLOURS["tent"], zorder=8)


def draw_chains(axes, frontier, view, bounds):
    """Thin lines through the growing budgets of one method."""
    chains = {}
    for point in frontier.points:
        spread = view.spread(point)
        if is_chain(point) and spread.mean > 0:
            chains.setdefault((point.representation, point.family), []).append((spread.us, spread.mean))
    for (representation, family), line in sorted(chains.items()):
        axes.plot(*zip(*sorted(line)), color=plots.representation_colour(representation), linewidth=0.7, alpha=0.4,
                  linestyle=(0, (3, 2)) if verdict.is_direct(family) else "-", zorder=2)


def draw_whole(frontier, view, name):
    """(figure, gid → text that hovering shows). Members of the front are numbered by rising time."""
    figure, axes = plots.plt.subplots(figsize=(9.8, 5.6), layout="constrained")
    figure.get_layout_engine().set(rect=(0, 0, 1, 0.92))  # the key stands above, wider than the axes
    axes.grid(True)
    front, hover = front_of(frontier, view), {}
    # what random starts are after a few steps would take half of the height: it lies above the plot
    settled = [(point, view.spread(point)) for point in frontier.points if not ("random" in point.family or point.family.startswith("adam_from_theta0"))]
    time_limits, bounds = limits_of([spread for _, spread in settled], [spread for _, spread in front])
    time_axis(axes, *time_limits)
    plots.log_error_axis(axes.yaxis, *bounds)
    axes.set(xlabel="time per function, median (log)", ylabel=f"blend RMSE, mean over {view.words} (log)")
    draw_tent(axes, view.tent, bounds)
    draw_front(axes, front, bounds)
    draw_chains(axes, frontier, view, bounds)
    for index, point in enumerate(frontier.points):
        spread, on_front = view.spread(point), view.on_front(point)
        marker, filled, size, _ = look(point)
        shade = plots.representation_colour(point.representation)
        is_default = bool(point.words)
        axes.plot(spread.us, spread.mean, marker, color=shade, gid=f"{name}-point-{index}",
                  markersize=size * (1.5 if on_front else 1.25 if is_default else 0.8), alpha=1 if on_front or is_default else 0.6,
                  markerfacecolor=shade if filled else "white", markeredgecolor=plots.INK if on_front else shade,
                  markeredgewidth=1.1, zorder=7 if on_front else 6 if is_default else 5 if filled else 3)
        hover[f"{name}-point-{index}"] = figure_text(point, spread)
    for line, (point, spread) in enumerate((point, spread) for point, spread in settled if spread.mean >= RUNAWAY):
        axes.annotate(f"↑ {spread.mean:.2g}: {point.representation}, {point.label}", (spread.us, bounds[1]), xytext=(0, -4 - 12 * line), textcoords="offset points",
                      ha="left" if spread.us**2 < time_limits[0] * time_limits[1] else "right", va="top", fontsize=8,
                      color=plots.representation_colour(point.representation), zorder=9, bbox={"facecolor": "white", "edgecolor": "none", "alpha": 0.9, "pad": 1.5})
    key(axes, frontier)
    # below the front there is nothing: numbers stand there and cover no point
    for number, (_, spread) in enumerate(front, 1):
        axes.annotate(str(number), (spread.us, spread.mean), xytext=(-3, -6), textcoords="offset points", ha="right", va="top",
                      fontsize=9, fontweight="bold", color=plots.INK, zorder=8)
    return figure, hover


def list_members(figure, frontier, view):
    """What the numbers mean, under a figure that stands without its table."""
    front = front_of(frontier, view)
    above, line = figure.get_figheight(), 0.19
    height = above + line * (len(front) + 1.5)
    share = 1 - above / height
    figure.set_figheight(height)
    figure.get_layout_engine().set(rect=(0, share, 1, 1 - share - 0.08 * above / height))
    for legend, y in zip(figure.legends, KEY_HEIGHTS):
        legend.set_bbox_to_anchor((0.005, share + y * (1 - share)))
    head = ("", "on the front, from the fastest", "time a function", "blend RMSE, mean", "p5", "p95")
    rows = [head] + [(str(n), f"{point.representation}: {point.label}", plots.duration(s.us), f"{s.mean:.4f}", f"{s.p5:.4f}", f"{s.p95:.4f}")
                     for n, (point, s) in enumerate(front, 1)]
    shades = [plots.MUTED] + [plots.representation_colour(point.representation) for point, _ in front]
    for index, (row, shade) in enumerate(zip(rows, shades)):
        for text, x, side in zip(row, (0.03, 0.045, 0.66, 0.78, 0.87, 0.96), ("right", "left", *["right"] * 4)):
            figure.text(x, share - line * (index + 0.9) / height, text, fontsize=8.5, ha=side, color=shade if side == "left" or index == 0 else plots.INK,
                        fontweight="bold" if x == 0.03 else "normal")


def key(axes, frontier):
    line = plots.plt.Line2D
    present = {kind_of(point) for point in frontier.points}
    marks = [line([], [], linewidth=0, marker=marker, markersize=size, color=plots.MUTED, markerfacecolor=plots.MUTED if filled else "white", label=words)
             for name, (marker, filled, size, words) in MARKS.items() if name in present]
    shades = [line([], [], linewidth=0, marker="o", markersize=5, color=plots.representation_colour(name), label=name)
              for name in dict.fromkeys(point.representation for point in frontier.points)]
    band = [line([], [], color=plots.INK, linewidth=1.8, label="Pareto front"),
            plots.plt.Rectangle((0, 0), 1, 1, color=BAND, alpha=0.2, linewidth=0, label="its p5–p95")]
    for handles, y in zip((shades, band + marks), KEY_HEIGHTS):
        legend = axes.figure.legend(handles=handles, loc="lower left", bbox_to_anchor=(0.005, y), ncol=len(handles), borderpad=0, borderaxespad=0,
                                    columnspacing=1.2, handletextpad=0.4, handlelength=1.2)
        legend.set_in_layout(False)


def draw_scene(frontier, scene, time_limits, bounds):
    figure, axes = plots.plt.subplots(figsize=(3.5, 2.75), layout="constrained")
    axes.set_title(scene if len(scene) <= 30 else scene[:29] + "…")
    axes.grid(True)
    time_axis(axes, *time_limits)
    plots.log_error_axis(axes.yaxis, *bounds)
    axes.tick_params(labelsize=7.5)
    axes.set(xlabel="time per function", ylabel="blend RMSE, mean")
    some = [(p, p.by_scene[scene]) for p in frontier.points if scene in p.by_scene]
    axes.scatter([s.us for _, s in some], np.clip([s.mean for _, s in some], *bounds), s=7, linewidths=0, alpha=0.45, rasterized=True, zorder=2,
                 c=[plots.representation_colour(p.representation) for p, _ in some])
    front, hover = front_of_scene(frontier, scene), {}
    draw_tent(axes, frontier.tent_by_scene.get(scene, 0.0), bounds)
    draw_front(axes, front, bounds)
    for index, (point, spread) in enumerate(front):
        marker, filled, size, _ = look(point)
        shade = plots.representation_colour(point.representation)
        axes.plot(spread.us, np.clip(spread.mean, *bounds), marker, color=shade, markersize=size, markeredgewidth=1.0, gid=f"front-{index}",
                  markerfacecolor=shade if filled else "white", markeredgecolor=plots.INK, zorder=5)
        hover[f"front-{index}"] = figure_text(point, spread)
    return figure, hover


def whole_svgs(frontier):
    svgs = []
    for index, view in enumerate(views(frontier)):
        name = f"whole{index}"
        figure, hover = draw_whole(frontier, view, name)
        svgs.append(plots.finish(figure, f"frontier-{name}", f"Blend RMSE against run time, {view.words}", hover))
    return svgs


def scene_svgs(frontier, order):
    """One panel a scene, in this order where it names the scene, then as the file has them; all with the same axes."""
    scenes = [s for s in order if s in frontier.scenes] + [s for s in frontier.scenes if s not in order]
    scenes = [s for s in scenes if any(s in p.by_scene for p in frontier.points)]
    axes = limits_of([s for point in frontier.points for s in point.by_scene.values()],
                     [spread for scene in scenes for _, spread in front_of_scene(frontier, scene)])
    return [plots.finish(figure, f"frontier-{index}", f"Blend RMSE against run time, {scene}", hover)
            for index, scene in enumerate(scenes) for figure, hover in [draw_scene(frontier, scene, *axes)]]


def png(frontier):
    view = views(frontier)[0]
    figure, _ = draw_whole(frontier, view, "whole")
    list_members(figure, frontier, view)
    return plots.png(figure)


def main():
    parser = argparse.ArgumentParser(description="Draws blend RMSE against run time, and the front that no method beats.")
    parser.add_argument("--frontier", required=True, help="frontier.json of nlg-validate frontier")
    parser.add_argument("--out", required=True, help="picture to write (.png)")
    arguments = parser.parse_args()
    return run("frontier.py", lambda: write_atomically(arguments.out, png(proof_inputs.read_frontier(arguments.frontier))))


if __name__ == "__main__":
    sys.exit(main())

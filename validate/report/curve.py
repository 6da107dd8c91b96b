#!/usr/bin/env python3
"""What a representation costs and what it says: blend RMSE against bytes a function and against evaluation time, all of them in one figure.

    curve.py --summary out/NAME/evaluation/summary.json --out docs/images/error_against_bytes.png

The page shows the same figure. Of every representation the functions of the sample that take a θ: what its numbers can say (best known)
and what a grid holds of them (stored), with the network's and the corrected on the way there.
"""
import argparse
import logging
import sys
from dataclasses import dataclass

sys.dont_write_bytecode = True
logging.getLogger("matplotlib").setLevel(logging.ERROR)

import packages

packages.need("curve.py", "matplotlib", "numpy")

import inputs as inputs_module
import plots
from matplotlib.ticker import FuncFormatter, LogLocator, NullFormatter

from tool.atomic_file import write_files
from tool.errors import run

TALK = "mlp"
FRONTS = {"stored": (0, (4, 2)), "best_known": (0, (1, 2))}  # dashed, dotted
SHOWN = (*inputs_module.WORDS, "best_known")
POINT_COUNT = 8192  # that evaluate_us is the time of


@dataclass
class Cost:
    """One representation: what a function costs and how wrong it is."""
    name: str
    bytes: float        # of one θ, as the summary's functions are stored: of codes, which end where they may, the mean
    evaluate_us: float  # 0: not measured
    mean: dict          # word → mean blend RMSE over the functions of the sample that take a θ


def costs(summary):
    result, precision = [], summary["theta_precision"].text()
    for name, node in summary["representations"].entries():
        size = node["stored_bytes_mean"].number() if name.startswith("code") else node["theta_bytes"][precision].count()
        result.append(Cost(name, size, node["evaluate_us"].number(), {word: node["sample"][word]["theta"]["blend_rmse"]["mean"].number() for word in SHOWN}))
    return result


def decade_axis(axis, values, text):
    """Plain numbers, a tick at 1, 2 and 5 of every decade."""
    axis.axes.set(xscale="log", xlim=(min(values) / 1.6, max(values) * 1.6))
    axis.set_major_locator(LogLocator(subs=(1, 2, 5), numticks=30))
    axis.set_major_formatter(FuncFormatter(lambda v, _: text(v)))
    axis.set_minor_formatter(NullFormatter())


def draw_panel(axes, some, x_of, limits):
    """Filled: stored, open: best known, a thin line from there up to the network, ticks where it passes the network and the corrected;
    dashed and dotted: Pareto fronts of stored and best known.
    """
    for cost in some:
        x, shade, shape = x_of(cost), plots.representation_colour(cost.name), plots.representation_marker(cost.name)
        errors = cost.mean
        axes.plot([x, x], [min(errors.values()), max(errors.values())], color=shade, linewidth=1.0, alpha=0.6, zorder=3)
        for word, size in (("network", 9), ("corrected", 6)):
            axes.plot(x, errors[word], "_", color=shade, markersize=size, markeredgewidth=1.2, alpha=0.8, zorder=3)
        axes.plot(x, errors["best_known"], shape, color=shade, markerfacecolor="white", markersize=6.5, markeredgewidth=1.4, zorder=4)
        axes.plot(x, errors["stored"], shape, color=shade, markersize=7.5, markeredgecolor="white", markeredgewidth=0.6, zorder=5)
    for word, style in FRONTS.items():
        front = plots.pareto([(x_of(c), c.mean[word]) for c in some])
        axes.plot(*zip(*front), color=plots.INK, linewidth=1.0, linestyle=style, zorder=2, alpha=0.7)
    plots.log_error_axis(axes.yaxis, *limits)


def draw(summary):
    """The figure of both panels; the second stays empty, and says so, where the summary has no times."""
    some = costs(summary)
    errors = [c.mean[word] for c in some for word in SHOWN]
    limits = (0.75 * min(errors), 1.35 * max(errors))
    figure, (left, right) = plots.plt.subplots(1, 2, figsize=(10.6, 4.4), layout="constrained", sharey=True)
    figure.get_layout_engine().set(rect=(0, 0, 0.86, 1))  # the names stand beside
    for axes in (left, right):
        axes.grid(True)
    draw_panel(left, some, lambda c: c.bytes, limits)
    decade_axis(left.xaxis, [c.bytes for c in some], plots.short)
    left.set(xlabel=f"bytes a function, θ in {summary['theta_precision'].text()}", ylabel=f"blend RMSE of a function that takes a θ, mean")
    right.set_xlabel(f"evaluation time of {POINT_COUNT} points, one core")
    timed = [c for c in some if c.evaluate_us > 0]
    if timed:
        draw_panel(right, timed, lambda c: c.evaluate_us, limits)
        decade_axis(right.xaxis, [c.evaluate_us for c in timed], plots.duration)
    else:
        right.set_xticks([])
        right.annotate("not measured in this run", (0.5, 0.5), xycoords="axes fraction", ha="center", color=plots.MUTED)
    key(left, right)
    figure.legend(handles=[plots.plt.Line2D([], [], linewidth=0, marker=plots.representation_marker(c.name), color=plots.representation_colour(c.name), markersize=6,
                                            label=c.name + (" (the talk's)" if c.name == TALK else "")) for c in some], loc="center right")
    return figure


def key(left, right):
    """What marks mean above one panel, what lines mean above the other."""
    mark = lambda label, **look: plots.plt.Line2D([], [], marker="o", color=plots.MUTED, linewidth=0, label=label, **look)
    line = lambda label, style: plots.plt.Line2D([], [], color=plots.INK, linewidth=1.0, linestyle=style, label=label)
    for axes, handles in ((left, [mark("stored", markersize=7), mark("best known", markersize=6.5, markerfacecolor="white", markeredgewidth=1.4),
                                  plots.plt.Line2D([], [], marker="_", markersize=9, color=plots.MUTED, linewidth=0, label="network, corrected")]),
                          (right, [line("Pareto front of what is stored", FRONTS["stored"]), line("of the best known", FRONTS["best_known"])])):
        axes.legend(handles=handles, loc="lower left", bbox_to_anchor=(0.0, 1.0), ncol=len(handles), borderaxespad=0.3, columnspacing=1.4, handlelength=2.0)


def main():
    parser = argparse.ArgumentParser(description="Draws blend RMSE against bytes a function and against evaluation time.")
    parser.add_argument("--summary", required=True, help="summary.json of nlg-validate")
    parser.add_argument("--out", required=True, help="picture to write (.png)")
    arguments = parser.parse_args()
    return run("curve.py", lambda: write_files({arguments.out: plots.png(draw(inputs_module.read_summary(arguments.summary)))}))


if __name__ == "__main__":
    sys.exit(main())

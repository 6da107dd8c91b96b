#!/usr/bin/env python3
"""What a representation costs and what it says: error against bytes a function and against evaluation time, all of them in one figure.

    curve.py --summary out/NAME/test/summary.json --out docs/images/error_against_bytes.png

The page shows the same figure. Of every representation the functions that direct optimisation ran on: what its numbers can say (direct)
and what its generator finds (all that comes before Adam or Levenberg–Marquardt).
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
import output
import plots
from matplotlib.ticker import FuncFormatter, LogLocator, NullFormatter

TALK = "mlp"
FRONTS = {"generator": (0, (4, 2)), "direct": (0, (1, 2))}  # dashed, dotted
POINT_COUNT = 8192  # that evaluate_us is the time of


@dataclass
class Cost:
    """One representation: what a function costs and how wrong it is, by every statistic of the summary."""
    name: str
    bytes_float32: int
    evaluate_us: float  # 0: the summary has none
    generator: dict
    direct: dict


def costs(summary, times=None):
    """times: the summary that evaluate_us is taken from; null: the same."""
    result = []
    for name, node in summary["representations"].entries():
        rmse = lambda method: {q: node[method]["rmse"][q].number() for q in inputs_module.QUANTILES}
        timed = times["representations"][name] if times else node
        evaluate_us = timed["evaluate_us"].number() if times or "evaluate_us" in node.value else 0.0
        result.append(Cost(name, node["bytes"].count(), evaluate_us, rmse("generator_chosen"), rmse("direct")))
    return result


def decade_axis(axis, values, text):
    """Plain numbers, a tick at 1, 2 and 5 of every decade, and room for names at both ends."""
    axis.axes.set(xscale="log", xlim=(min(values) / 1.6, max(values) * 1.6))
    axis.set_major_locator(LogLocator(subs=(1, 2, 5), numticks=30))
    axis.set_major_formatter(FuncFormatter(lambda v, _: text(v)))
    axis.set_minor_formatter(NullFormatter())


def draw_panel(figure, axes, some, statistic, x_of, limits, tent, more_lines=()):
    """Filled: generator, open: direct optimisation, a thin line between them; dashed and dotted: their Pareto fronts.

    more_lines   what is drawn besides; returns what writes the names, once the axes have their limits
    """
    labels, lines = [], [*more_lines]
    for cost in some:
        x, shade, shape = x_of(cost), plots.representation_colour(cost.name), plots.representation_marker(cost.name)
        generated, direct = cost.generator[statistic], cost.direct[statistic]
        axes.plot([x, x], [direct, generated], color=shade, linewidth=1.0, alpha=0.6, zorder=3)
        axes.plot(x, direct, shape, color=shade, markerfacecolor="white", markersize=6.5, markeredgewidth=1.4, zorder=4)
        axes.plot(x, generated, shape, color=shade, markersize=7.5, markeredgecolor="white", markeredgewidth=0.6, zorder=5)
        labels.append((x, generated, cost.name + (" (the talk's)" if cost.name == TALK else ""), shade))
        lines.append([(x, direct), (x, generated)])
    for method, style in FRONTS.items():
        front = plots.pareto([(x_of(c), getattr(c, method)[statistic]) for c in some])
        axes.plot(*zip(*front), color=plots.INK, linewidth=1.0, linestyle=style, zorder=2, alpha=0.7)
        lines.append(front)
    reach = [x_of(c) for c in some]
    lines.append([(min(reach) / 1.6, tent), (3.2 * max(reach), tent)])
    axes.axhline(tent, color=plots.colour("tent"), linewidth=1.0, linestyle=(0, (8, 3)), zorder=1)
    name = axes.annotate("bare tent", (1.0, tent), xycoords=axes.get_yaxis_transform(), xytext=(-2, 2), textcoords="offset points",
                         ha="right", fontsize=7.5, color=plots.colour("tent"))
    plots.log_error_axis(axes.yaxis, *limits)
    return lambda: plots.place_labels(figure, axes, labels, lines, [name])


def draw(summary, statistic="mean", times=None):
    """The figure of both panels; the second stays empty, and says so, where the summary has no times."""
    some = costs(summary, times)
    tent = next(node for _, node in summary["representations"].entries())["tent_chosen"]["rmse"][statistic].number()
    errors = [getattr(c, method)[statistic] for c in some for method in ("generator", "direct")] + [tent]
    limits = (0.75 * min(errors), 1.35 * max(errors))
    figure, (left, right) = plots.plt.subplots(1, 2, figsize=(9.8, 4.4), layout="constrained", sharey=True)
    for axes in (left, right):
        axes.grid(True)
    to_float32 = [[(c.bytes_float32 / 2, c.generator[statistic]), (c.bytes_float32, c.generator[statistic])] for c in some]
    place = [draw_panel(figure, left, some, statistic, lambda c: c.bytes_float32 / 2, limits, tent, to_float32)]
    decade_axis(left.xaxis, [c.bytes_float32 / 2 for c in some] + [c.bytes_float32 for c in some], plots.short)
    for cost, line in zip(some, to_float32):  # where the function stands when its numbers are stored as float32
        left.plot(*zip(*line), linewidth=0.9, alpha=0.45, color=plots.representation_colour(cost.name), marker="|", markevery=[1],
                  markersize=7, zorder=2)
    left.set(xlabel="bytes a function: float16 (tick to the right: float32)", ylabel=f"RMSE of a function, {statistic}")
    right.set_xlabel(f"evaluation time of {POINT_COUNT} points, one core")
    timed = [c for c in some if c.evaluate_us > 0]
    if timed:
        place.append(draw_panel(figure, right, timed, statistic, lambda c: c.evaluate_us, limits, tent))
        decade_axis(right.xaxis, [c.evaluate_us for c in timed], plots.duration)
    else:
        right.set_xticks([])
        right.annotate("not measured in this run", (0.5, 0.5), xycoords="axes fraction", ha="center", color=plots.MUTED)
    key(left, right)
    for place_names in place:
        place_names()
    return figure


def key(left, right):
    """What marks mean above one panel, what lines mean above the other."""
    mark = lambda label, **look: plots.plt.Line2D([], [], marker="o", color=plots.MUTED, linewidth=0, label=label, **look)
    line = lambda label, style: plots.plt.Line2D([], [], color=plots.INK, linewidth=1.0, linestyle=style, label=label)
    for axes, handles in ((left, [mark("generator, nothing refined", markersize=7),
                                  mark("direct optimisation", markersize=6.5, markerfacecolor="white", markeredgewidth=1.4)]),
                          (right, [line("Pareto front of generators", FRONTS["generator"]), line("of direct optimisation", FRONTS["direct"])])):
        axes.legend(handles=handles, loc="lower left", bbox_to_anchor=(0.0, 1.0), ncol=2, borderaxespad=0.3, columnspacing=1.4, handlelength=2.0)


def png(summary, statistic, times):
    figure = draw(summary, statistic, times)
    return plots.png(figure)


def main():
    parser = argparse.ArgumentParser(description="Draws error against bytes a function and against evaluation time.")
    parser.add_argument("--summary", required=True, help="summary.json of nlg-validate")
    parser.add_argument("--times", help="another summary.json, of the same representations: evaluation times are taken from it")
    parser.add_argument("--statistic", choices=inputs_module.QUANTILES, default="mean", help="of the RMSE over functions; default: mean")
    parser.add_argument("--out", required=True, help="the .png to write")
    arguments = parser.parse_args()

    def make():
        summary = inputs_module.read_json(arguments.summary)
        inputs_module.check_summary(summary)
        times = inputs_module.read_json(arguments.times) if arguments.times else None
        return {arguments.out: png(summary, arguments.statistic, times)}
    return output.run("curve.py", arguments.out, make)


if __name__ == "__main__":
    sys.exit(main())

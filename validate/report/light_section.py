"""The report's section on light: methods over scenes, error against bytes and against the bake's time, by distance, and the worst places.

Read are points of light_figures. Of several scenes the tables have medians; plots have geometric means, so that large scenes do not
outweigh small ones.
"""
import base64
import math

import numpy as np

import plots
from decision import bytes_text, seconds_text
from findings import bracket, percent, plural
from light_figures import GROUP_NAMES, GROUPS, LIGHTS, NOT_STORED, geometric_mean, interval, methods_of, of_method, spacings_of
from tool.errors import InputError
from tool.input_file import read_bytes

COLOURS = ("#7a828a", "#1d232a", "#0072B2", "#E69F00", "#CC79A7", "#D55E00", "#009E73", "#56B4E9", "#9b6a8f", "#6b2d0f", "#7a3fb0", "#c08a00", "#2f6b3a", "#b3261e")  # of baselines
SENTENCE_NAMES = {"air": "in air", "surface": "before surfaces", "turned": "there with any normal"}
LIGHT_STYLES = {"point": (0, (1.5, 1.5)), "own": (0, (4, 1.5)), "solved": "-"}
LIGHT_WORDS = {"point": "gathered at the probe", "own": "in the method’s own form", "solved": "solved for"}
WORST_COUNT = 10
PNG_SIGNATURE = b"\x89PNG\r\n\x1a\n"
SQUARE = (4.3, 3.4)  # inches
COSTS = {"bytes": ("bytes of a scene", bytes_text), "seconds": ("seconds of the bake, weights and light", seconds_text)}


def error(value):
    return f"{value:.3f}"


def position(values):
    return ", ".join(f"{value:.2f}" for value in values)


def data_uri(png):
    return "data:image/png;base64," + base64.b64encode(png).decode()


def png_uri(path):
    data = read_bytes(path)
    if not data.startswith(PNG_SIGNATURE):
        raise InputError(path, "byte 0", "a PNG file", "other bytes")
    return data_uri(data)


def one_of(points, spacing_m):
    return [point for point in points if point.spacing_m == spacing_m]


class LightSection:
    """points: of all scenes and methods; leader: the generator that the page looks at first."""

    def __init__(self, points, leader):
        self.points, self.scenes, self.spacings, self.methods = points, sorted({point.scene for point in points}), spacings_of(points), methods_of(points)
        names = list(dict.fromkeys(name for name, _ in self.methods))
        baselines = [name for name in names if name not in plots.REPRESENTATIONS]
        self.colours = {name: plots.representation_colour(name) if name in plots.REPRESENTATIONS else COLOURS[baselines.index(name) % len(COLOURS)] for name in names}
        self.ours = (leader if leader in names else names[-1], "solved")
        if self.ours not in self.methods:
            self.ours = next(method for method in reversed(self.methods) if method[0] == self.ours[0])

    def sentence(self):
        spacing_m = self.spacings[0]
        here = one_of(self.points, spacing_m)
        medians = {method: [float(np.median([point.rmse[group] for point in of_method(here, method)])) for group in GROUPS] for method in methods_of(here) if method[0] != NOT_STORED}
        text = f"{plural(len(self.scenes), 'scene')}, probes {' and '.join(f'{value:g}' for value in self.spacings)} m apart. "
        if self.ours in medians:
            said = ", ".join(f"{error(value)} {SENTENCE_NAMES[group]}" for group, value in zip(GROUPS, medians[self.ours]))
            text += f"At {spacing_m:g} m {self.ours[0]} with light {LIGHT_WORDS[self.ours[1]]} has an RMSE of {said}, by median over scenes. "
        best = {group: min(medians, key=lambda method: medians[method][i]) for i, group in enumerate(GROUPS)}
        named = dict.fromkeys(best.values())
        return text + "The least has " + "; ".join(f"{method[0]}, {LIGHT_WORDS[method[1]]} ({', '.join(SENTENCE_NAMES[group] for group in GROUPS if best[group] == method)})" for method in named) + "."

    # ---- the tables

    def row(self, points):
        cells = []
        for group in GROUPS:
            values = [point.rmse[group] for point in points]
            cells.append({"text": error(np.median(values)), "interval": bracket(interval(values, np.median), error) if len(values) >= 3 else ""})
        median = lambda key: float(np.median([getattr(point, key) for point in points]))
        return {"weights": points[0].method[0], "light": points[0].method[1], "colour": self.colours[points[0].method[0]], "is_ours": points[0].method == self.ours, "cells": cells,
                "others": [f"{median('dark'):+.4f}".replace("-", "−"), f"{median('jump_mean'):.4f}", f"{median('jump_largest'):.2f}", percent(max(point.unlit for point in points)),
                           bytes_text(median("bytes")), f"{median('per_probe'):,.0f}", seconds_text(median("seconds"))]}

    def tables(self):
        """(spacing, groups of rows): light gathered and in own forms first, solved light behind it."""
        for spacing_m in self.spacings:
            here = one_of(self.points, spacing_m)
            kinds = [("Without solved light", ("point", "own")), ("With solved light", ("solved",))]
            yield f"{spacing_m:g} m", [(title, [self.row(of_method(here, method)) for method in methods_of(here) if method[1] in lights]) for title, lights in kinds]

    def distances(self):
        """(heads, rows): RMSE by distance to a surface at the finest spacing, medians over scenes."""
        here = one_of(self.points, self.spacings[0])
        classes = [(low, high) for low, high, _ in here[0].by_distance]
        rows = []
        for method in methods_of(here):
            values = [[rmse for _, _, rmse in point.by_distance] for point in of_method(here, method) if len(point.by_distance) == len(classes)]
            if values:
                rows.append({"weights": method[0], "light": method[1], "colour": self.colours[method[0]], "texts": [error(value) for value in np.median(values, axis=0)]})
        return [f"{100 * low:g}–{100 * high:g} cm" for low, high in classes], rows

    def worst(self):
        """Of ours, the places that are farthest from truth, over all scenes at the finest spacing, with their pictures where there are any."""
        places = [place for point in of_method(one_of(self.points, self.spacings[0]), self.ours) for place in point.worst]
        worst = sorted(places, key=lambda place: -place.error)[:WORST_COUNT]
        return [{"number": number, "scene": place.scene, "where": GROUP_NAMES.get(place.group, place.group), "position": position(place.position_m), "normal": position(place.normal),
                 "truth": position(place.truth), "answer": position(place.answer), "error": f"{place.error:.2f}", "picture": png_uri(place.picture) if place.picture else ""}
                for number, place in enumerate(worst, 1)]

    # ---- the plots

    def line_of(self, method, cost, group):
        """One point a spacing, where all scenes were measured; the finest last."""
        line = []
        for spacing_m in reversed(self.spacings):
            some = of_method(one_of(self.points, spacing_m), method)
            values = [max(getattr(point, cost), 1e-3 if cost == "seconds" else 1) for point in some]
            if some and all(point.rmse[group] > 0 for point in some):
                line.append((geometric_mean(values), geometric_mean([point.rmse[group] for point in some]), spacing_m))
        return line

    def panel(self, cost, group):
        axis_words, text = COSTS[cost]
        figure, axes = plots.start(GROUP_NAMES[group], SQUARE, axis_words, "RMSE over truth’s root mean square")
        hover, lines = {}, []
        for method in self.methods:
            line = self.line_of(method, cost, group) if method[0] != NOT_STORED else []
            if not line:
                continue
            lines.append(line)
            is_ours = method == self.ours
            axes.plot([x for x, _, _ in line], [y for _, y, _ in line], color=self.colours[method[0]], linestyle=LIGHT_STYLES[method[1]], linewidth=2.2 if is_ours else 1.1, zorder=4 if is_ours else 2)
            for x, y, spacing_m in line:
                gid = f"p{len(hover)}"
                hover[gid] = f"{method[0]}, light {LIGHT_WORDS[method[1]]}\n{spacing_m:g} m apart: RMSE {error(y)}, {text(x)}"
                axes.plot(x, y, "o", color=self.colours[method[0]], markersize=6.5 if is_ours else 4.5, markerfacecolor=self.colours[method[0]] if method[1] == "solved" else "white", gid=gid, zorder=5)
        name, title = f"light-{cost}-{group}", f"Error {GROUP_NAMES[group]} against {axis_words}"
        if not lines:
            # a level in the dark: an error over truth's mean is none
            axes.text(0.5, 0.5, "truth has no light here", transform=axes.transAxes, ha="center", va="center")
            return plots.finish(figure, name, title, hover)
        errors, costs = ([point[i] for line in lines for point in line] for i in (1, 0))
        plots.log_error_axis(axes.yaxis, 0.8 * min(errors), 1.25 * max(errors))
        axes.set(xscale="log", xlim=(min(costs) / 1.5, max(costs) * 1.5))
        axes.xaxis.set_major_formatter(plots.FuncFormatter(lambda value, _: text(value)))
        axes.xaxis.set_minor_formatter(plots.NullFormatter())
        if math.log10(max(costs) / min(costs)) < 1.2:
            axes.xaxis.set_major_locator(plots.LogLocator(subs=(1, 2, 5)))
        return plots.finish(figure, name, title, hover)

    def panels(self, cost):
        return [self.panel(cost, group) for group in GROUPS]

    def key(self):
        """(name, colour) of what is drawn."""
        return [(name, colour) for name, colour in self.colours.items() if name != NOT_STORED]

    def lights(self):
        return [(light, LIGHT_WORDS[light]) for light in LIGHTS if any(method[1] == light for method in self.methods)]

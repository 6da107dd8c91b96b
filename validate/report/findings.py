"""What the page says in numbers: the tables of the four words, what was left out, and one sentence below every plot."""
import re

import numpy as np

from curve import SHOWN, costs
from inputs import ERRORS, FITS, INTERVALS, POPULATIONS, QUANTILES, RATIOS, WORDS, interval_of
from plots import NAMES, POPULATION_NAMES, duration, pareto
from verdict import estimate, share_of

TALK_FITTED = "4–13\u00a0%"  # of its functions the talk gave to Adam after the network
NONE = {"text": "–", "over": False, "interval": ""}
# an option of nlg-validate that says how much a long fit was given, and how the page says it
BUDGETS = (("direct_adam_steps", "{} steps of Adam a start"), ("direct_lm_iterations", "{} iterations of LM a start"), ("direct_restarts", "{} random starts"))


def error(value):
    return f"{value:.4f}"


def percent(share, digits=None):
    """Never a rounded 0 or 100 for what is neither."""
    value = 100.0 * share
    if digits is None:
        digits = 0 if 10 <= value <= 90 else 1
    if 0 < value < 0.05:
        return "<\u00a00.1\u00a0%"
    if 99.95 <= value < 100:
        return ">\u00a099.9\u00a0%"
    text = f"{value:.{digits}f}"
    return (text[:-2] if text.endswith(".0") else text) + "\u00a0%"


def grouped(count):
    return f"{count:,}".replace(",", "\u2009")


def plural(count, noun):
    return f"{grouped(count)} {noun}{'' if count == 1 else 's'}"


def factor(value):
    """A ratio to three figures at most."""
    return f"{value:.2f}" if value < 10 else grouped(int(float(f"{value:.3g}")))


def bracket(interval, text):
    """A 95 % interval, as short as it can be: .0118–.0145, 5–7 %, 1.02–1.27; empty where there is none, or no width to it."""
    if not interval or interval[0] == interval[1]:
        return ""
    if interval[1] is None:
        return f"{text(interval[0])} or more"
    low, high = (text(value) for value in interval)
    for unit in ("\u00a0%", " ×"):
        if high.endswith(unit):
            return f"{low.removesuffix(unit)}–{high}"
    return "–".join(re.sub(r"^0\.", ".", value) for value in (low, high))


def quantile_cells(quantiles, limit=float("inf")):
    """Quantiles as texts with their intervals; errors above the limit are marked. Dashes where no function stands behind them."""
    if quantiles["functions"].count() == 0:
        return [NONE] * len(QUANTILES)
    cells = []
    for q in QUANTILES:
        value = quantiles[q].number()
        interval = interval_of(quantiles["interval"][q]) if q in INTERVALS else None
        cells.append({"text": error(value), "over": value > limit, "interval": bracket(interval, error)})
    return cells


def share_cell(figures, key):
    value, interval = share_of(figures, key)
    return NONE if value is None else {"text": percent(value), "over": False, "interval": bracket(interval, percent)}


def ratio_cell(ratio):
    value, interval = estimate(ratio)
    return NONE if value is None else {"text": f"{factor(value)}\u00a0×", "over": False, "interval": bracket(interval, factor)}


def figures_row(word, figures, population, tau):
    """One row of a table of errors: one word (or fit) over one population. tau: error → what the check allows."""
    row = {"label": NAMES[word], "word": word, "population": POPULATION_NAMES[population], "cells": quantile_cells(figures["blend_rmse"], tau["blend_rmse"]), "rmse": NONE,
           "test_points": NONE, "occluded": NONE, "failing": NONE, "fitted": NONE, "leak_mean": "–", "leak_p99": "–", "time": "–", "functions": "0"}
    if figures["functions"].count() == 0:
        row["cells"] = [NONE] * len(QUANTILES)
        return row
    row |= {"rmse": quantile_cells(figures["rmse"], tau["rmse"])[QUANTILES.index("mean")], "functions": grouped(figures["functions"].count()), "failing": share_cell(figures, "share_failing_check"),
            "fitted": share_cell(figures, "share_fitted"), "leak_mean": error(figures["leak"]["mean"].number()),
            "leak_p99": f"{figures['leak']['p99'].number():.3f}", "time": duration(figures["us_per_function"].number()) if word != "tent" else "none",
            "test_points": quantile_cells(figures["rmse_test_points"])[0], "occluded": quantile_cells(figures["rmse_occluded"])[0]}
    return row


class Findings:
    def __init__(self, inputs):
        self.inputs = inputs
        summary = inputs.summary
        # summaries of before 27 November know nothing outside
        self.functions = {"outside": 0, **{key: node.count() for key, node in summary["functions"].entries()}}
        self.tau = {key: node.number() for key, node in summary["tau"].entries()}
        self.limits = {error: self.tau[key] for error, key in zip(ERRORS, ("blend", "rmse"))}  # what the check allows
        self.precision = summary["theta_precision"].text()
        self.sample_theta_count = len(inputs.sampled(inputs.representations[0], "best_known"))

    def summary_of(self, representation):
        return self.inputs.summary["representations"][representation]

    def stored(self, representation):
        return self.inputs.over(representation, "stored")

    def each(self, text_of):
        """The same sentence about every representation: (name, text)."""
        return [(name, text_of(name) + ".") for name in self.inputs.representations]

    # ---- the four words

    def population_sentence(self):
        f = self.functions
        known = f" ({percent(f['held_out_in_training'] / f['held_out'])} of them occur in the training set, too)" if f["held_out_in_training"] else ""
        return (f"{plural(f['held_out'], 'distinct function')} of {plural(f['held_out_scenes'], 'scene')} that were held out of training{known}; {grouped(f['take_theta'])} of them take a θ "
                f"(for the others the bare tent is enough), and {grouped(f['hard'])} are hard")

    def lead(self):
        def text(name):
            node = self.summary_of(name)["stored"]
            if node["theta"]["functions"].count() == 0:
                return "no function takes a θ"
            blend = node["theta"]["blend_rmse"]
            return (f"of the functions that take a θ, half are stored with a blend RMSE below {error(blend['median'].number())} and 95 % below {error(blend['p95'].number())}; "
                    f"{percent(node['theta']['share_fitted']['value'].number())} of them took a fit ({percent(node['all']['share_fitted']['value'].number())} of all distinct functions), "
                    f"and {percent(node['theta']['share_failing_check']['value'].number())} fail the check as they are stored")
        return self.each(text)

    def bytes_text(self, node):
        """Of one theta; a code takes as many numbers as its function needs."""
        if "stored_bytes_mean" in node.value:
            return f"{node['stored_bytes_mean'].number():.0f} bytes in the mean"
        return f"{grouped(node['theta_bytes'][self.precision].count())} bytes"

    def generators(self):
        """One group of rows a representation: its four words over every population; the bare tent last."""
        groups = []
        for name in self.inputs.representations:
            node = self.summary_of(name)
            rows = [figures_row(word, node[word][population], population, self.limits) | {"first": word == WORDS[0], "main": population == POPULATIONS[0]}
                    for population in POPULATIONS for word in WORDS]
            groups.append({"name": name, "note": f"{grouped(node['parameters'].count())} parameters, {self.bytes_text(node)} a function in {self.precision}. The generator: "
                           f"{grouped(round(node['weights_bytes'].count() / 1000))} kB.", "rows": rows})
        tent = self.inputs.summary["tent"]
        groups.append({"name": "bare tent", "note": "No network at all and the same for every probe: this is what a generator has to beat.",
                       "rows": [figures_row("tent", tent[population], population, self.limits) | {"first": True, "main": population == POPULATIONS[0]} for population in POPULATIONS]})
        return groups

    def failing_reasons(self):
        def text(name):
            samples = self.stored(name)
            if not len(samples):
                return "no function takes a θ"
            by_blend = samples.fails_check & (samples.blend_rmse > self.tau["blend"])
            return f"{percent(np.mean(by_blend))} by their blend RMSE, {percent(np.mean(samples.fails_check & ~by_blend))} by their RMSE alone"
        return self.each(text)

    # ---- the sample, which long fits ran on

    def budgets(self):
        """What each long fit was given, from validate's own options; what these do not name is left out."""
        options = self.inputs.summary["provenance"]["options"]
        some = [words.format(grouped(options[key].count())) for key, words in BUDGETS if key in options.value]
        return f"Long fits were given {', '.join(some)}." if some else ""

    def sample_tables(self):
        """Every way to a θ on the same functions, one table a representation; how far each word is above the best known, function by function."""
        tables = []
        for name in self.inputs.representations:
            sample = self.summary_of(name)["sample"]
            rows = []
            for word in WORDS + FITS:
                row = figures_row(word, sample[word]["theta"], "theta", self.limits)
                row["hard"] = quantile_cells(sample[word]["hard"]["blend_rmse"])[0]
                row["ratios"] = [ratio_cell(sample["ratios"][word]["to_best_known"][key]) for key in RATIOS] if word in WORDS else [NONE] * len(RATIOS)
                rows.append(row)
            tables.append({"name": name, "rows": rows})
        return tables

    # ---- what was left out

    def left_out(self):
        counts = self.functions
        visited = max(1, counts["visited_probes"])
        kinds = (("distinct", "distinct functions", "#0072B2"), ("free_space", "free space: no geometry near, the bare tent", "#56B4E9"),
                 ("in_solid", "in solid: nothing is lit from there", "#7a828a"), ("duplicates", "duplicates of a distinct function", "#E69F00"),
                 ("empty", "empty: the probe reaches no point", "#CC79A7"), ("outside", "outside the level's hull", "#009E73"))
        return [{"count": grouped(counts[key]), "share": 100.0 * counts[key] / visited, "text": percent(counts[key] / visited), "label": label,
                 "colour": colour} for key, label, colour in kinds]

    def left_out_sentence(self):
        counts = self.functions
        visited = counts["visited_probes"]
        spared = counts["free_space"] + counts["in_solid"] + counts["duplicates"] + counts["empty"] + counts["outside"]
        text = (f"Of {plural(visited, 'probe')} visited (of {grouped(counts['grid_probes'])} on the grids), {grouped(spared)} needed no function "
                f"of their own: {percent(spared / max(1, visited))} of the probes were spared fitting and storage")
        unaccounted = visited - spared - counts["distinct"]
        return text + (f"; {grouped(abs(unaccounted))} are unaccounted for." if unaccounted else ".")

    # ---- one sentence a plot

    def slices(self):
        def text(name):
            worst = next(s for s in self.inputs.slices if s.representation == name and s.which == "worst")
            difference = worst.difference[worst.valid]
            bias = f"; in its plane {percent(np.mean(difference > self.tau['leak']))} of the valid pixels are too bright by more than {self.tau['leak']:g}" if len(difference) else ""
            return f"the worst {'hard ' if self.functions['hard'] else ''}function is no. {worst.function} of {worst.scene}, blend RMSE {error(worst.blend_rmse)}, RMSE {error(worst.rmse)}{bias}"
        return self.each(text)

    def curve(self):
        """Who is best by bytes and by blend RMSE, as stored, over the functions of the sample that take a θ."""
        some = costs(self.inputs.summary)
        front = [name for _, _, name in pareto([(c.bytes, c.mean["stored"], c.name) for c in some])]
        best = min(some, key=lambda c: c.mean["stored"])
        text = (f"The lowest mean blend RMSE of what is stored has {best.name}, {error(best.mean['stored'])} at {best.bytes} bytes in {self.precision} "
                f"(best known: {error(best.mean['best_known'])}). On the front of bytes and blend RMSE: {', '.join(front)}.")
        return [("", text)]

    def curve_table(self):
        """By bytes: the mean blend RMSE of every word, and the time that what is stored took."""
        rows = []
        for c in sorted(costs(self.inputs.summary), key=lambda c: (c.bytes, c.mean["stored"])):
            sample = self.summary_of(c.name)["sample"]
            mean_of = lambda word: quantile_cells(sample[word]["theta"]["blend_rmse"])[QUANTILES.index("mean")]
            time_of = lambda word: duration(sample[word]["theta"]["us_per_function"].number())
            rows.append({"name": c.name, "bytes": grouped(c.bytes), "time": duration(c.evaluate_us) if c.evaluate_us > 0 else "–",
                         "cells": [(mean_of(word), time_of(word)) for word in SHOWN], "fitted": share_cell(sample["stored"]["theta"], "share_fitted")})
        return rows

    def training(self):
        def text(name):
            log = self.inputs.logs[name]
            last = log.held_out[-1]
            # the last validation before the last fifth of the run
            at = max(0, int(np.searchsorted(log.step, 0.8 * log.step[-1], side="right")) - 1)
            before, since = log.held_out[at], grouped(int(log.step[at]))
            lowest = int(np.argmin(log.held_out))
            trend = ("it was measured this once" if len(log.step) == 1 else f"since step {since} it fell by {percent(1 - last / before)}" if last < before else
                     f"since step {since} it no longer fell (lowest: {error(log.held_out[lowest])} at step {grouped(int(log.step[lowest]))})")
            alone = f" (network: {error(log.held_out_network[-1])})" if log.held_out_network[-1] != last else ""
            return f"the held-out blend RMSE ends at {error(last)}{alone} after {plural(int(log.step[-1]), 'step')}; {trend}"
        return self.each(text)

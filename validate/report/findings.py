"""What the page says in numbers: the verdict's rows, what was left out, and one sentence below every plot."""
import numpy as np

from curve import costs
from inputs import METHODS, QUANTILES
from plots import NAMES, duration, pareto


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


def times(factor):
    """A factor to two or three figures."""
    return f"{factor:.1f}" if factor < 10 else grouped(int(float(f"{factor:.2g}")))


def plural(count, noun):
    return f"{grouped(count)} {noun}{'' if count == 1 else 's'}"


def method_cells(method, key, tau):
    """Quantiles as text; errors above tau are marked. Dashes where no function stands behind them."""
    if method[key]["functions"].count() == 0:
        return [("–", False)] * len(QUANTILES)
    values = [method[key][q].number() for q in QUANTILES]
    return [(error(v), v > tau) for v in values]


def over_tau(samples, tau_rmse, tau_leak):
    return (samples.rmse > tau_rmse) | (samples.leak_p99 > tau_leak)


class Findings:
    def __init__(self, inputs):
        self.inputs = inputs
        summary = inputs.summary
        self.functions = {key: node.count() for key, node in summary["functions"].entries()}
        self.tau_rmse, self.tau_leak = summary["tau"]["rmse"].number(), summary["tau"]["leak_p99"].number()
        self.chosen_count = len(inputs.samples[inputs.representations[0], "direct"])

    def summary_of(self, representation):
        return self.inputs.summary["representations"][representation]

    def generated(self, representation):
        return self.inputs.samples[representation, "generator"]

    def each(self, text_of):
        """The same sentence about every representation: (name, text)."""
        return [(name, text_of(name) + ".") for name in self.inputs.representations]

    # ---- verdict

    def lead(self):
        def text(name):
            rmse = self.summary_of(name)["generator"]["rmse"]
            left = self.summary_of(name)["refined"]["share_over_tau"].number()
            return (f"half of the functions come out below RMSE {error(rmse['median'].number())}, 95 % below "
                         f"{error(rmse['p95'].number())}; {percent(self.summary_of(name)['share_refined'].number())} are over τ and refined, "
                         f"{percent(left)} stay over τ even then")
        return self.each(text)

    def verdict(self):
        groups = []
        for name in self.inputs.representations:
            node = self.summary_of(name)
            ratio = node["generator_to_direct"]
            direct_hard = int(self.inputs.samples[name, "direct"].hard.sum())
            corrected = self.inputs.is_corrected(name)
            alone = lambda key: f" (network alone {node['uncorrected_to_direct'][key].number():.2f} ×)" if corrected else ""
            ratios = [(f"{ratio['median'].number():.2f} ×",
                       f"the error of direct optimisation{alone('median')}, median over {plural(self.chosen_count, 'chosen function')}")]
            if direct_hard:
                ratios.append((f"{ratio['median_hard'].number():.2f} ×", f"over the {grouped(direct_hard)} hard ones of them{alone('median_hard')}"))
            if ratio["median_shadow_hard"].number() > 0:
                ratios.append((f"{ratio['median_shadow_hard'].number():.2f} ×", f"at shadow points of these{alone('median_shadow_hard')}"))
            rows = [row for method, label in (("uncorrected", NAMES["uncorrected"]), ("generator", "generator"), ("refined", "refined where over τ"))
                    if corrected or method != "uncorrected" for row in self.pair(node[method], self.inputs.samples[name, method], label, method)]
            groups.append({"name": name, "parameters": node["parameters"].count(), "bytes": node["bytes"].count(), "ratios": ratios,
                           "weights_bytes": grouped(round(node["weights_bytes"].count() / 1000)), "steps": node["correction_steps"].count(),
                           "reference": ratio["reference"].text(), "rows": rows})
        tent = self.inputs.summary["tent"]
        groups.append({"name": "bare tent", "note": "no network at all, the same for every probe: what a generator has to beat", "rows":
                       self.pair(tent, self.inputs.samples["tent", "tent"], "bare tent", "tent")})
        return groups

    def pair(self, method, samples, label, key):
        """Two rows: all functions and hard ones. Leak and time exist for all functions only."""
        over = over_tau(samples, self.tau_rmse, self.tau_leak)
        hard = samples.hard
        share_hard = percent(over[hard].mean()) if hard.any() else "–"
        time = duration(method["us_per_function"].number()) if key != "tent" else "–"
        return [{"label": label, "method": key, "first": True, "scope": "all", "cells": method_cells(method, "rmse", self.tau_rmse),
                 "over": percent(method["share_over_tau"].number()), "leak_mean": error(method["leak"]["mean"].number()),
                 "leak_p99": f"{method['leak']['p99'].number():.3f}", "time": time},
                {"label": label, "method": key, "first": False, "scope": "hard", "cells": method_cells(method, "rmse_hard", self.tau_rmse),
                 "over": share_hard}]

    def over_reasons(self):
        def text(name):
            samples = self.generated(name)
            rmse, leak = samples.rmse > self.tau_rmse, samples.leak_p99 > self.tau_leak
            return f"{percent(np.mean(rmse))} by RMSE, {percent(np.mean(leak))} by leak, {percent(np.mean(rmse & leak))} by both"
        return self.each(text)

    def budgets(self):
        """What each fit was given, from validate's own options."""
        option_value = lambda key: self.inputs.summary["provenance"]["options"][key].count()
        option = lambda key: grouped(option_value(key))
        return (f"{NAMES['refined']}: for those functions only, up to {plural(option_value('refine_rounds'), 'round')} of Adam, the first of "
                f"{option('refine_first_steps')} steps and each {option('refine_growth')} times as long as the one before; {NAMES['refined_adam']}: "
                f"{option('adam_refine_steps')} steps for every function; {NAMES['refined_lm']}: {option('lm_refine_iterations')} iterations; "
                f"{NAMES['adam_theta0']} and {NAMES['adam_random']}: {option('direct_adam_steps')} steps; {NAMES['lm_theta0']}: "
                f"{option('direct_lm_iterations')} iterations; direct: the best of LM from θ₀, Adam from θ₀ and Adam from "
                f"{plural(option_value('direct_restarts'), 'random start')}, both polished by LM.")

    # ---- what was left out

    def left_out(self):
        counts = self.functions
        visited = max(1, counts["visited_probes"])
        kinds = (("distinct", "stored functions", "#0072B2"), ("free_space", "free space: no geometry near, the bare tent", "#56B4E9"),
                 ("in_solid", "in solid: nothing is lit from there", "#7a828a"), ("duplicates", "duplicates of a stored function", "#E69F00"),
                 ("empty", "empty: the probe reaches no point", "#CC79A7"))
        return [{"count": grouped(counts[key]), "share": 100.0 * counts[key] / visited, "text": percent(counts[key] / visited), "label": label,
                 "colour": colour} for key, label, colour in kinds]

    def left_out_sentence(self):
        counts = self.functions
        visited = counts["visited_probes"]
        spared = counts["free_space"] + counts["in_solid"] + counts["duplicates"] + counts["empty"]
        text = (f"Of {plural(visited, 'probe')} visited (of {grouped(counts['grid_probes'])} on the grids), {grouped(spared)} needed no function "
                f"of their own: {percent(spared / max(1, visited))} of the probes were spared fitting and storage")
        unaccounted = visited - spared - counts["distinct"]
        return text + (f"; {grouped(abs(unaccounted))} are unaccounted for." if unaccounted else ".")

    # ---- one sentence a plot

    def slices(self):
        def text(name):
            worst = next(s for s in self.inputs.slices if s.representation == name and s.which == "worst")
            difference = worst.difference[worst.valid]
            bias = f"; in its plane {percent(np.mean(difference > self.tau_leak))} of the valid pixels are too bright by more than {self.tau_leak:g}" if len(difference) else ""
            return f"the worst {'hard ' if self.functions['hard'] else ''}function is no. {worst.function} of {worst.scene}, RMSE {error(worst.rmse)}{bias}"
        return self.each(text)

    def curve(self):
        """Who is best by bytes and by error: over the chosen functions, generators with all that comes before Adam or LM."""
        some = costs(self.inputs.summary)
        front = [name for _, _, name in pareto([(c.bytes_float32, c.generator["mean"], c.name) for c in some])]
        best = min(some, key=lambda c: c.generator["mean"])
        text = (f"The lowest mean error of a generator has {best.name}, {error(best.generator['mean'])} at {best.bytes_float32 // 2} bytes in float16 "
                f"(direct optimisation: {error(best.direct['mean'])}); on the front of bytes: {', '.join(front)}.")
        return [("", text)]

    def curve_table(self):
        rows = []
        for c in sorted(costs(self.inputs.summary), key=lambda c: (c.bytes_float32, c.generator["mean"])):
            rows.append({"name": c.name, "bytes": (grouped(c.bytes_float32 // 2), grouped(c.bytes_float32)),
                         "time": duration(c.evaluate_us) if c.evaluate_us > 0 else "–",
                         "cells": [error(some[q]) for some in (c.generator, c.direct) for q in ("median", "mean", "p95")]})
        return rows

    def histogram(self):
        def text(name):
            tent, generator = self.inputs.samples["tent", "tent"].rmse, self.generated(name).rmse
            return (f"the generator is better than the bare tent on {percent(np.mean(generator < tent))} of the functions, and brings the "
                    f"95th percentile from {error(np.quantile(tent, 0.95))} to {error(np.quantile(generator, 0.95))}")
        return self.each(text)

    def run_time(self):
        def text(name):
            medians = {m: np.median(self.inputs.chosen(name, m).rmse) for m in METHODS}
            elapsed = {m: float(np.mean(self.inputs.chosen(name, m).elapsed_us)) for m in METHODS}
            front = [m for _, _, m in pareto([(elapsed[m], medians[m], m) for m in METHODS])]
            best = min(medians, key=medians.get)
            faster = elapsed["direct"] / max(elapsed["generator"], 1e-9)
            return (f"the generator takes {duration(elapsed['generator'])} a function, direct optimisation {duration(elapsed['direct'])} "
                    f"({times(faster)} times as long) for a median of {error(medians['direct'])} instead of {error(medians['generator'])}; "
                    f"lowest median: {NAMES[best]}, {error(medians[best])}; on the front: {', '.join(NAMES[m] for m in front)}")
        return self.each(text)

    def unseen_points(self):
        def text(name):
            samples = self.generated(name)
            some = samples.rmse > 0
            ratio = samples.rmse_unseen[some] / samples.rmse[some]
            if not len(ratio):
                return f"no error to compare"
            return (f"the error on unseen points is {np.median(ratio):.2f} times that on seen ones (median), above 1.5 times for "
                    f"{percent(np.mean(ratio > 1.5))} of the functions")
        return self.each(text)

    def shadow(self):
        def text(name):
            samples = self.generated(name)
            samples = samples.only(np.isfinite(samples.rmse_shadow))
            if not len(samples):
                return f"no function has shadow points"
            tent = self.inputs.samples["tent", "tent"].rmse_shadow
            middle = np.median(samples.rmse_shadow)
            return (f"median {error(middle)} in the shadow against {error(np.median(samples.rmse))} over all valid points of the same "
                    f"functions; the bare tent has {error(np.nanmedian(tent))} there")
        return self.each(text)

    def training(self):
        def text(name):
            log = self.inputs.logs[name]
            last = log.held_out_rmse[-1]
            # the last validation before the last fifth of the run
            at = max(0, int(np.searchsorted(log.step, 0.8 * log.step[-1], side="right")) - 1)
            before, since = log.held_out_rmse[at], grouped(int(log.step[at]))
            lowest = int(np.argmin(log.held_out_rmse))
            trend = ("it was measured this once" if len(log.step) == 1 else f"since step {since} it fell by {percent(1 - last / before)}" if last < before else
                     f"since step {since} it no longer fell (lowest: {error(log.held_out_rmse[lowest])} at step {grouped(int(log.step[lowest]))})")
            alone = f" ({error(log.held_out_network[-1])} before corrections)" if log.held_out_network[-1] != last else ""
            return f"the held-out error ends at {error(last)}{alone} after {plural(int(log.step[-1]), 'step')}; {trend}"
        return self.each(text)

    def spectrum(self):
        basis = self.inputs.basis
        components = basis["components"].count()
        kept = {int(name): node.number() for name, node in basis["held_out_variance_kept"].entries()}
        at = max([c for c in kept if c <= components], default=min(kept))
        return (f"{plural(basis['functions'].count(), 'training function')} (mirror images not counted) gave {plural(components, 'component')}; "
                f"the first {at} keep {percent(kept[at], 1)} of the variance of held-out functions, so the generator never sees the other "
                f"{percent(1 - kept[at], 1)}.")

    # ---- all methods on the chosen functions

    def methods_table(self):
        tables = []
        for name in self.inputs.representations:
            rows = []
            for method in METHODS:
                # of all, only what ran on the chosen functions can be compared
                samples = self.inputs.chosen(name, method)
                values = [np.median(samples.rmse), np.mean(samples.rmse), *np.quantile(samples.rmse, (0.95, 0.99)), np.max(samples.rmse)]
                hard = samples.rmse[samples.hard]
                unseen, shadow = np.median(samples.rmse_unseen), samples.rmse_shadow[np.isfinite(samples.rmse_shadow)]
                rows.append({"label": NAMES[method], "method": method, "cells": [error(v) for v in values],
                             "hard": error(np.median(hard)) if len(hard) else "–", "unseen": error(unseen),
                             "shadow": error(np.median(shadow)) if len(shadow) else "–",
                             "over": percent(over_tau(samples, self.tau_rmse, self.tau_leak).mean()), "time": duration(float(np.mean(samples.elapsed_us)))})
            tables.append({"name": name, "rows": rows})
        return tables

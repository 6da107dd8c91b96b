"""What a lead reads first, as texts: the verdict with its three figures, scenes by trouble, the suite's cases, what scenes do without."""
import math

import numpy as np

import plots
import proof_inputs
import verdict
from findings import error, grouped, over_tau, percent, plural
from frontier import front_of
from plots import duration

GROUP_NAMES = {"functions": "Functions", "optimisers": "Optimisers", "pca": "Principal components", "generator": "Generator", "scenes": "Scenes",
               "training": "Training"}


def factor(value):
    """A ratio to three figures at most."""
    return f"{value:.2f}" if value < 10 else grouped(int(float(f"{value:.3g}")))


def joined(names):
    return names[0] if len(names) == 1 else f"{', '.join(names[:-1])} and {names[-1]}"


CASE_STATES = ("fails", "explained", "holds", "not-run")  # in the order of the table


def case_state(case):
    return "not-run" if not case.ran else "holds" if case.passes else "explained" if case.note.strip() else "fails"


def equal_error_words(judgement):
    equal = judgement.equal
    if equal is None:
        return "not measured: this page was drawn without a frontier (--frontier)"
    text = f"{judgement.representation}, {duration(equal.generator_us)} corrected, against {duration(equal.direct_us)} of "
    return text + (f"the fastest direct fit of no larger mean error ({equal.label})" if equal.label else "the longest direct fit, whose mean error is still larger")


class Decision:
    """The first screen and the tables behind it.

    inputs     inputs.Inputs
    limits     verdict.Limits
    cases      proof_inputs.Case, or None where the suite's file was not given
    frontier   proof_inputs.Frontier, or None likewise: then no time is judged
    """

    def __init__(self, inputs, limits, cases, frontier=None):
        self.inputs, self.limits, self.cases = inputs, limits, cases
        self.judgements = verdict.judge(inputs, limits, frontier)
        self.leader = verdict.leader(inputs, self.judgements)
        self.blocked = bool(cases) and bool(verdict.unexplained(cases))
        self.tau_rmse, self.tau_leak = (inputs.summary["tau"][key].number() for key in ("rmse", "leak_p99"))

    # ---- the first screen

    @property
    def state(self):
        """For the headline's colour: good, mixed or bad."""
        ships = [j.verdict == verdict.SHIPS for j in self.judgements]
        return "bad" if self.blocked or not any(ships) else "good" if all(ships) else "mixed"

    def headline(self):
        ships = [j.representation for j in self.judgements if j.verdict == verdict.SHIPS]
        count = len(self.judgements)
        if self.blocked:
            return f"Nothing may ship: {plural(len(verdict.unexplained(self.cases)), 'stability case')} failed without an explanation"
        if not ships:
            return "No generator may ship"
        if len(ships) == count:
            return f"{ships[0]} may ship" if count == 1 else f"All {count} generators may ship"
        return f"{joined(ships)} may ship; {count - len(ships)} of {count} generators may not"

    def objections(self):
        """One sentence a generator that may not ship."""
        limits = self.limits
        result = []
        for j in self.judgements:
            said = []
            if j.refined.value is None or not j.refined.passes:
                said.append(f"{percent(j.refined.value)} of its functions need refinement (limit {percent(limits.share_refined)})")
            if j.hard.value is None:
                said.append("no hard function to compare with direct optimisation, so it stays undecided")
            elif not j.hard.passes:
                said.append(f"{factor(j.hard.value)} × the error of direct optimisation on hard functions (limit {limits.error_hard:g} ×)")
            if j.speedup.value is None:
                said.append("no frontier was given that times direct fits of the same error, so it stays undecided")
            elif not j.speedup.passes:
                said.append(f"{factor(j.speedup.value)} × as fast as a direct fit of no larger error (at least {limits.speedup:g} × is asked for)")
            if said:
                result.append((j.representation, "; ".join(said) + "."))
        return result

    def cards(self):
        lead = next(j for j in self.judgements if j.representation == self.leader)
        node = self.inputs.summary["representations"][self.leader]
        hard = int(self.inputs.samples[self.leader, "direct"].hard.sum())
        limits = self.limits
        return [
            self.card("Functions that need refinement", lambda j: j.refined, percent, f"at most {percent(limits.share_refined)}", limits.share_refined,
                      f"of {self.leader}’s fail the bake’s check and are fitted on; {percent(node['refined']['share_over_tau'].number())} fail even then", lead),
            self.card("Error on hard functions", lambda j: j.hard, lambda v: f"{factor(v)} ×", f"at most {limits.error_hard:g} ×", limits.error_hard,
                      f"that of direct optimisation: {self.leader}, before refinement, median over {plural(hard, 'hard function')}", lead),
            self.card("Speed at equal error", lambda j: j.speedup, lambda v: f"{factor(v)} ×", f"at least {limits.speedup:g} ×", limits.speedup,
                      equal_error_words(lead), lead, logarithmic=True)]

    def card(self, title, figure_of, text_of, limit_text, limit, meaning, lead, logarithmic=False):
        """One figure: large for the leader, a bar for every generator, and the limit as a line across the bars."""
        shown = lambda figure: "–" if figure.value is None else text_of(figure.value)
        values = [figure_of(j).value for j in self.judgements if figure_of(j).value is not None]
        top = 1.08 * max([limit * (1.5 if logarithmic else 1.15), *values])
        low = 0.5 * min([limit, *values])  # bars of logarithms begin here
        place = (lambda v: max(0.0, math.log(max(v, low) / low) / math.log(top / low))) if logarithmic else lambda v: v / top
        rows = [{"name": j.representation, "text": shown(figure_of(j)), "passes": figure_of(j).passes,
                 "width": 100 * place(figure_of(j).value) if figure_of(j).value is not None else 0.0} for j in self.judgements]
        return {"title": title, "big": shown(figure_of(lead)), "passes": figure_of(lead).passes, "meaning": meaning, "limit": limit_text,
                "at": 100 * place(limit), "rows": rows}

    # ---- scenes

    def scene_rows(self):
        """Scenes by falling share of the leader's functions over τ, then by its 95th percentile."""
        rows = []
        for scene in sorted(set(self.inputs.samples[self.leader, "generator"].scene)):
            part = {key: self.inputs.samples[key].only(self.inputs.samples[key].scene == scene)
                    for key in [(name, m) for name in self.inputs.representations for m in ("generator", "refined")]}
            share = {key: float(over_tau(some, self.tau_rmse, self.tau_leak).mean()) for key, some in part.items()}
            lead = part[self.leader, "generator"]
            high = float(np.quantile(lead.rmse, 0.95))
            cells = [(error(v), v > self.tau_rmse) for v in (float(np.median(lead.rmse)), high, float(lead.rmse.max()))]
            rows.append({"key": (-share[self.leader, "generator"], -high, scene), "scene": scene, "functions": grouped(len(lead)),
                         "hard": grouped(int(lead.hard.sum())), "cells": cells, "left": percent(share[self.leader, "refined"]),
                         "is_left": share[self.leader, "refined"] > 0,
                         "shares": [self.heat(share[name, "generator"]) for name in [self.leader, *self.others()]]})
        return sorted(rows, key=lambda row: row["key"])

    def others(self):
        return [name for name in self.inputs.representations if name != self.leader]

    def heat(self, share):
        """Text, how strongly to shade it, and whether it is above what a generator may have."""
        return percent(share), round(min(0.75, 0.3 * share / max(self.limits.share_refined, 1e-9)), 3), share > self.limits.share_refined

    def scene_sentence(self):
        rows = self.scene_rows()
        over = [row["scene"] for row in rows if row["shares"][0][2]]
        limit = percent(self.limits.share_refined)
        if not over:
            return f"In every scene at most {limit} of {self.leader}’s functions are over τ; most are in {rows[0]['scene']}, {rows[0]['shares'][0][0]}."
        named = joined(over) if len(over) <= 3 else f"{', '.join(over[:2])} and {len(over) - 2} more"
        return f"In {len(over)} of {plural(len(rows), 'scene')} more than {limit} of {self.leader}’s functions are over τ: {named}."

    # ---- stability

    def stability_groups(self):
        """(group's name, how many of its cases hold, (state, case)), failing cases first, otherwise as the suite has them."""
        groups = []
        for group in proof_inputs.GROUPS:
            rows = sorted(((case_state(case), case) for case in self.cases if case.group == group), key=lambda row: CASE_STATES.index(row[0]))
            left = sum(state == "not-run" for state, _ in rows)
            held = f"{sum(state == 'holds' for state, _ in rows)} of {len(rows) - left} hold" + (f", {left} not run" if left else "")
            groups += [(GROUP_NAMES[group], held, rows)] if rows else []
        return groups

    @property
    def stability_state(self):
        """For the colour: good only where every case was run and holds."""
        states = {case_state(case) for case in self.cases}
        return "bad" if "fails" in states else "good" if states == {"holds"} else "mixed"

    def stability_sentence(self):
        failed, ran = verdict.failed(self.cases), [case for case in self.cases if case.ran]
        text = f"{len(ran) - len(failed)} of {plural(len(ran), 'case')} hold"
        unexplained = len(verdict.unexplained(self.cases))
        explained = len(failed) - unexplained
        if explained:
            text += f"; {explained} {'fails and is' if explained == 1 else 'fail and are'} explained"
        if unexplained:
            text += f"; {unexplained} {'fails' if unexplained == 1 else 'fail'} without an explanation"
        left = len(self.cases) - len(ran)
        return text + (f"; {left} {'was' if left == 1 else 'were'} not run." if left else ".")


# ---- the frontier's rows


def front_rows(frontier, view):
    """Members of a view's front by rising time, numbered as in its plot."""
    rows = []
    for number, (point, spread) in enumerate(front_of(frontier, view), 1):
        f = point.figures
        rows.append({"number": number, "representation": point.representation, "label": point.label, "time": duration(spread.us),
                     "spread": f"{duration(f['us_p25'])}–{duration(f['us_p75'])}", "errors": [error(v) for v in (spread.median, view.mean(point), spread.p5, spread.p95)],
                     "all": [error(f[key]) for key in ("rmse_median", "rmse_mean")], "leak": f"{f['leak_p99']:.3f}"})
    return rows


def front_summary(frontier, view, rows):
    """Where a front begins and ends, and between which times each representation is on it."""
    if not rows:
        return view.sentence
    spans = {}
    for row in rows:
        spans.setdefault(row["representation"], []).append(row["time"])
    parts = [f"{name} from {times[0]} to {times[-1]}" if len(times) > 1 else f"{name} at {times[0]}" for name, times in spans.items()]
    return (f"Over {view.words}, {len(rows)} of {grouped(len(frontier.points))} ways to a θ are beaten by none in time and median error: {joined(parts)}. "
            f"The error falls from {rows[0]['errors'][0]} to {rows[-1]['errors'][0]}; the bare tent’s is {error(view.tent)}.")


def plain(value):
    """Any value of a table that this page does not know by name."""
    if value is None:
        return "–"
    if isinstance(value, bool):
        return "yes" if value else "no"
    if isinstance(value, int):
        return grouped(value)
    return value if isinstance(value, str) else f"{value:.3g}" if abs(value) < 1e-3 or abs(value) >= 1e4 else f"{value:.4g}"


def table(rows):
    """(column names, rows of (text, is a number)) of objects that may differ in their keys."""
    columns = list(dict.fromkeys(key for row in rows for key in row))
    is_number = lambda value: isinstance(value, (int, float)) and not isinstance(value, bool)
    # a null stands where its column's numbers do
    numeric = {c for c in columns if any(is_number(row.get(c)) for row in rows)}
    aligned = lambda row, c: is_number(row.get(c)) or (row.get(c) is None and c in numeric)
    return [c.replace("_", " ") for c in columns], [[(plain(row.get(c)), aligned(row, c)) for c in columns] for row in rows]


# ---- needs


def bytes_text(value):
    sign, value = ("−" if value < 0 else ""), abs(value)
    for unit, scale in (("B", 1), ("kB", 1e3), ("MB", 1e6)):
        if value < 999.5 * scale:
            return f"{sign}{value / scale:.3g} {unit}"
    return f"{sign}{value / 1e9:.3g} GB"


def seconds_text(value):
    return ("−" if value < 0 else "") + duration(abs(value) * 1e6) if value else "0 s"


LEFT, NOT_YET, NOTHING, FOREIGN = range(4)  # in the order of the table


def need_state(row):
    """NOTHING: a bake would leave such a thing out, and this scene has none; FOREIGN: this bake cannot tell."""
    if row.left_out is None:
        return FOREIGN
    return NOTHING if row.count == 0 else LEFT if row.left_out else NOT_YET


def need_groups(needs):
    """(scene, rows): what is left out first, by falling time saved, then what is not yet, then what this bake has none of."""
    groups = []
    for scene, rows in needs:
        ordered = sorted(rows, key=lambda r: (need_state(r), -(r.seconds_saved or 0)))
        groups.append((scene, [{"what": r.what, "state": need_state(r), "count": grouped(r.count), "of": grouped(r.of), "share": percent(r.count / r.of) if r.of else "–",
                                "seconds": "–" if r.seconds_saved is None else seconds_text(r.seconds_saved),
                                "bytes": "–" if r.bytes_saved is None else bytes_text(r.bytes_saved),
                                "same": {None: "–", True: "same result", False: "differs"}[r.same_result], "differs": r.same_result is False, "note": r.note}
                               for r in ordered]))
    return groups


def needs_sentence(needs):
    """Lines overlap (all probes together, and each kind by itself), so nothing is added up: the one that saves most speaks."""
    rows = [(scene, r) for scene, some in needs for r in some]
    left, not_yet = ([(s, r) for s, r in rows if need_state(r) == state] for state in (LEFT, NOT_YET))
    text = f"{plural(len(needs), 'scene')}, {plural(len(rows), 'line')}: {len(left)} left out"
    timed = [(s, r) for s, r in left if r.seconds_saved is not None and r.seconds_saved > 0]
    if timed:
        scene, best = max(timed, key=lambda pair: pair[1].seconds_saved)
        text += f", of which “{best.what}” saves most time, {seconds_text(best.seconds_saved)} in {scene}"
    return text + (f"; {len(not_yet)} could be left out and {'is' if len(not_yet) == 1 else 'are'} not yet." if not_yet else ".")

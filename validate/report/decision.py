"""What a lead reads first, as texts: the verdict with its three figures and its rule, scenes by trouble, the suite's cases, what bakes leave out."""
import math
import os

import numpy as np

import proof_inputs
import verdict
from findings import bracket, error, factor, figures_row, grouped, percent, plural
from frontier import front_of, stage_points
from inputs import ERRORS, WORDS
from plots import NAMES, duration
from tool.errors import InputError

GROUP_NAMES = {"functions": "Functions", "codes": "Codes", "generator": "Generator"}


def joined(names):
    return names[0] if len(names) == 1 else f"{', '.join(names[:-1])} and {names[-1]}"


CASE_STATES = ("fails", "fails-check", "holds")  # in the order of the table


def case_state(case):
    return "fails" if not case.holds else "fails-check" if case.fails_check else "holds"


def equal_error_words(judgement):
    equal, name = judgement.equal, judgement.representation
    if equal is None:
        return "not measured: this page was drawn without a frontier that times it (--frontier)"
    if equal.ratio is None:
        return f"there is no ratio, because {equal.reason}"
    if equal.label is None:
        return f"at least: the longest direct fit takes so many times as long as {name} fitted, and its mean blend RMSE is still larger"
    return (f"{name} fitted, over the fastest direct fit to the same mean blend RMSE ({equal.label}); "
            f"{percent(equal.failing)} and {percent(equal.direct_failing)} of the functions that were timed fail the check")


BAKES = {"these": "with these weights", "without": "without a generator"}
WEIGHTS = {"supplied": "the supplied weights", "init": "the weights that it started from"}


def comparison(inputs, representation, folder):
    """Whether a generator is better than other weights, by what is stored of the same functions: the paired test of compare.py."""
    from compare import FALSE_ALARMS, mean_change, read_run, trend_beyond  # which takes SciPy, and time to be loaded
    other = read_run(folder, is_folder=False)
    name = representation if representation in other.names() else other.names()[0]
    before, after = (samples[one, "stored"].of("theta") for samples, one in ((other.samples, name), (inputs.samples, representation)))
    theirs, ours = (samples[one, "network"].of("theta").blend_rmse.mean() for samples, one in ((other.samples, name), (inputs.samples, representation)))
    if len(before) != len(after) or (before.function != after.function).any() or (before.scene != after.scene).any():
        raise InputError(folder, "functions.csv", "the functions that the run is validated on", "others")
    change = mean_change(before.blend_rmse, after.blend_rmse, before.scene)
    trend = trend_beyond(change["old"], change["new"]) if change.get("chance", 1.0) <= FALSE_ALARMS else "same"
    word = {"better": "Better than", "worse": "Worse than", "same": "No difference found from"}[trend]
    of = "" if name == representation else f", {name}"
    return f"{word} {WEIGHTS.get(os.path.basename(folder), folder)}: {representation} has a mean blend RMSE of {error(change['new'])}, they {error(change['old'])}{of}, after fits on the same {plural(len(after), 'function')}; before fits {error(ours)} and {error(theirs)}"


NEAR_COPY, FEWEST_OF_COPY = 0.5, 5


def near_copies(summary):
    """Held-out scenes most of whose functions stand in the training set."""
    if "in_training" not in summary.value:
        return []
    return [scene for scene, node in summary["in_training"].entries() if node["take_theta"].count() >= FEWEST_OF_COPY and node["in_training"].count() > NEAR_COPY * node["take_theta"].count()]


class Decision:
    """The first screen and the tables behind it.

    inputs     inputs.Inputs
    limits     verdict.Limits
    cases      proof_inputs.Case, or None where the suite's file was not given
    frontier   proof_inputs.Frontier, or None likewise: then no time is judged
    against    folders of nlg-validate's results of other weights on the same functions
    bakes      name of weights → proof_inputs.Bake of one scene: "these", and others that it is compared with
    """

    def __init__(self, inputs, limits, cases, frontier=None, against=(), bakes=None):
        self.inputs, self.limits, self.cases, self.bakes = inputs, limits, cases, bakes or {}
        self.judgements = verdict.judge(inputs, limits, frontier)
        self.leader = verdict.leader(inputs, self.judgements)
        self.blocked = bool(cases) and bool(verdict.failed(cases))
        self.comparisons = [comparison(inputs, self.leader, folder) for folder in against]
        self.copies = near_copies(inputs.summary)
        self.tau = {error: inputs.summary["tau"][key].number() for error, key in zip(ERRORS, ("blend", "rmse"))}

    # ---- the first screen

    @property
    def state(self):
        """For the headline's colour: good, mixed or bad."""
        ships = [j.verdict == verdict.SHIPS and not self.copies for j in self.judgements]
        if self.blocked:
            return "bad"
        if all(ships):
            return "good"
        return "mixed" if any(ships) or any(j.verdict == verdict.UNDECIDED for j in self.judgements) else "bad"

    def headline(self):
        """Whether it is better than what there is, where that was measured, and whether it may ship."""
        return "; ".join([*self.comparisons, self.shipping()])

    def shipping(self):
        if self.copies:
            return f"Undecided: {joined(self.copies)} {'is a near copy' if len(self.copies) == 1 else 'are near copies'} of what was trained on"
        ships = [j.representation for j in self.judgements if j.verdict == verdict.SHIPS]
        count = len(self.judgements)
        if self.blocked:
            return f"Nothing may ship: {plural(len(verdict.failed(self.cases)), 'stability case')} failed"
        undecided = [j.representation for j in self.judgements if j.verdict == verdict.UNDECIDED]
        if count > 1 and len(ships) == count:
            return f"All {count} generators may ship"
        parts = [f"{joined(names)} {words}" for names, words in ((ships, "may ship"), (undecided, "undecided")) if names]
        left = count - len(ships) - len(undecided)
        if not parts:
            return "No generator may ship"
        return "; ".join([*parts, f"{left} of {count} generators may not"] if left else parts)

    def bake_sentence(self):
        """What a lead asks first: how long a level bakes, and how wrong its light is; empty where no bake was measured."""
        if not self.bakes:
            return ""
        with_words = lambda name: BAKES.get(name, f"with {WEIGHTS.get(name, name)}")
        scene = next(iter(self.bakes.values())).scene
        text = f"A whole bake of {scene} takes " + ", ".join(f"{duration(1e6 * bake.seconds)} {with_words(name)}" for name, bake in self.bakes.items())
        lit = [f"{percent(bake.light_error).lstrip('<' + chr(160))} {with_words(name)}" for name, bake in self.bakes.items() if bake.light_error]
        return text + (f"; the light of half of its sample points errs by at most {', '.join(lit)}" if lit else "") + "."

    def rule(self):
        return [sentence.replace("*", "") for sentence in verdict.rule(self.limits, self.tau["rmse"], self.tau["blend_rmse"])]

    @property
    def undecided_when(self):
        return verdict.UNDECIDED_WHEN

    def text(self):
        """The verdict for a terminal: the headline, every generator's three figures, where the rule stands."""
        shown = lambda j, figure, write: "–" if figure.value is None else write(figure.value) + (f" ({bracket(figure.interval, write)})" if bracket(figure.interval, write) else "") + {"good": "", "mixed": " (?)", "bad": " (!)"}[j.state(figure)]
        lines = [self.headline(), *filter(None, [self.bake_sentence()])]
        for j in self.judgements:
            lines.append(f"  {j.representation}, {j.verdict}: {shown(j, j.failing, percent)} of stored functions fail the check; {shown(j, j.hard, factor)} times the best known blend RMSE on hard ones; "
                         f"{shown(j, j.speedup, factor)} times as fast as a fit without it")
        marks = {"(!)": "outside its limit", "(?)": "the limit lies in its interval, or too few functions or scenes stand behind it"}
        lines.append("".join(f"{mark}: {meaning}. " for mark, meaning in marks.items() if any(mark in line for line in lines)) + "The rule stands in the report, and in docs/guide/training.md#may-it-ship.")
        return "\n".join(lines).replace("\u00a0", " ") + "\n"

    def objections(self):
        """One sentence a generator that may not ship, or is undecided."""
        limits = self.limits
        result = []
        for j in self.judgements:
            said = []
            so = "" if j.verdict == verdict.FAILS else ", so it stays undecided"
            if 0 < j.functions < verdict.FEWEST_FUNCTIONS:
                said.append(f"{plural(j.functions, 'function')} that take a θ decide nothing, so it stays undecided: hold out more scenes")
            if j.scenes < verdict.FEWEST_SCENES:
                said.append(f"{plural(j.scenes, 'held-out scene')} {'decides' if j.scenes == 1 else 'decide'} nothing, so it stays undecided: hold out {verdict.FEWEST_SCENES} or more")
            if j.failing.value is None:
                said.append(f"no function takes a θ{so}")
            elif not j.failing.passes and not j.failing.is_open:
                said.append(f"{percent(j.failing.value)} of its functions that take a θ fail the check as they are stored (limit {percent(limits.share_failing)})")
            if j.hard.value is None:
                said.append(f"no hard function to compare with the best known{so}")
            elif not j.hard.passes and not j.hard.is_open:
                said.append(f"{factor(j.hard.value)} × the best known blend RMSE on hard functions (limit {limits.error_hard:g} ×)")
            if j.speedup.value is None:
                said.append((f"no speed at equal error, because {j.equal.reason}" if j.equal else "no frontier was given that times direct fits of the same blend RMSE") + so)
            elif not j.speedup.passes and not j.speedup.is_open:
                said.append(f"{factor(j.speedup.value)} × as fast as a direct fit of the same mean blend RMSE (at least {limits.speedup:g} × is asked for)")
            near = [what for figure, what in ((j.failing, "share that fails"), (j.hard, "error of hard functions"), (j.speedup, "speed")) if figure.is_open]
            if near:
                said.append(f"the interval of its {joined(near)} holds the limit: more held-out levels, or more functions of them, decide")
            if said:
                result.append((j.representation, "; ".join(said) + "."))
        return result

    def next_steps(self):
        """What to do about it, a sentence each; by the reader's own figures (docs/guide/training.md)."""
        steps = []
        ships = [j.representation for j in self.judgements if j.verdict == verdict.SHIPS]
        if ships:
            steps.append(f"Use weights/{ships[0]}.safetensors: nlg bake LEVEL --weights …; --use-generator 0 shows a level without it.")
        if any(j.functions < verdict.FEWEST_FUNCTIONS for j in self.judgements):
            steps.append("Hold out more scenes: so few functions decide nothing.")
        mean = lambda populations: populations["theta"]["blend_rmse"]["mean"].number()
        untrained = [j.representation for j in self.judgements if j.functions and mean(self.inputs.summary["representations"][j.representation]["network"]) >= mean(self.inputs.summary["tent"])]
        if untrained:
            steps.append(f"{joined(untrained)} {'predicts' if len(untrained) == 1 else 'predict'} no better than the bare tent: training failed. See the curve below; a lower train.learning_rate is the first thing to try.")
        if any(j.failing.value is not None and not j.failing.passes for j in self.judgements):
            steps.append("Where functions fail, a larger representation or longer fits help (refine_rounds, refine_first_steps); training longer does not.")
        if any(j.hard.value is not None and not j.hard.passes for j in self.judgements):
            steps.append("Where hard functions are far above the best known, look at them below; scenes like those that hold them are what the training lacks.")
        if any(j.speedup.value is not None and not j.speedup.passes for j in self.judgements):
            steps.append("Where a fit from scratch is as fast, train longer (train.steps) or on more levels, or do without a generator.")
        return steps

    def cards(self):
        lead = next(j for j in self.judgements if j.representation == self.leader)
        node = self.inputs.summary["representations"][self.leader]
        limits, sample = self.limits, node["sample"]
        failing = [percent(node[word]["theta"]["share_failing_check"]["value"].number()) for word in WORDS] if node["stored"]["theta"]["functions"].count() else []
        above = [factor(sample["ratios"][word]["to_best_known"]["median_hard"]["value"].number()) + " ×" for word in WORDS] if lead.hard.value else []
        along = lambda texts: " Stage by stage: " + ", ".join(f"{NAMES[word]} {text}" for word, text in zip(WORDS, texts)) + "." if texts else ""
        return [
            self.card("Stored functions that fail the check", lambda j: j.failing, percent, f"at most {percent(limits.share_failing)}", limits.share_failing,
                      f"of {self.leader}’s functions that take a θ.{along(failing)}", lead),
            self.card("Blend RMSE on hard functions", lambda j: j.hard, lambda v: f"{factor(v)} ×", f"at most {limits.error_hard:g} ×", limits.error_hard,
                      f"the best known: {self.leader} as stored, median over the {plural(sample['hard'].count(), 'hard function')} of the sample.{along(above)}", lead),
            self.card("Speed at equal blend RMSE", lambda j: j.speedup, lambda v: f"{factor(v)} ×", f"at least {limits.speedup:g} ×", limits.speedup,
                      equal_error_words(lead) + ".", lead, logarithmic=True)]

    def four_words(self):
        """The leader's four words over the functions that take a θ: the table that the first screen ends with."""
        node = self.inputs.summary["representations"][self.leader]
        of_all = lambda word: figures_row(word, node[word]["all"], "all", self.tau)["fitted"]
        return [figures_row(word, node[word]["theta"], "theta", self.tau) | {"fitted_of_all": of_all(word), "hard": figures_row(word, node[word]["hard"], "hard", self.tau)["cells"][0]}
                for word in WORDS]

    def card(self, title, figure_of, text_of, limit_text, limit, meaning, lead, logarithmic=False):
        """One figure: large for the leader, a bar for every generator, and the limit as a line across the bars."""
        shown = lambda figure: "–" if figure.value is None else text_of(figure.value)
        values = [figure_of(j).value for j in self.judgements if figure_of(j).value is not None]
        top = 1.08 * max([limit * (1.5 if logarithmic else 1.15), *values])
        low = 0.5 * min([limit, *values])  # bars of logarithms begin here
        place = (lambda v: max(0.0, math.log(max(v, low) / low) / math.log(top / low))) if logarithmic else lambda v: v / top
        rows = [{"name": j.representation, "text": shown(figure_of(j)), "state": j.state(figure_of(j)),
                 "width": 100 * place(figure_of(j).value) if figure_of(j).value is not None else 0.0} for j in self.judgements]
        return {"title": title, "big": shown(figure_of(lead)), "interval": bracket(figure_of(lead).interval, text_of), "state": lead.state(figure_of(lead)), "meaning": meaning, "limit": limit_text,
                "at": 100 * place(limit), "rows": rows}

    # ---- stages

    def stage_tables(self, frontier):
        """What each representation goes through, by the policy's own list; what a stage costs and gains where the frontier has its point."""
        tables = []
        for name in [self.leader, *self.others()]:
            points, rows = stage_points(frontier, name), []
            for stage in self.inputs.summary["representations"][name]["stages"].items():
                title, takes, word = (stage[key].text() for key in ("title", "takes", "word"))
                point = points.get(title)
                figures = point and point.figures["theta"]
                rows.append({"name": title, "budget": stage["budget"].value or "–", "takes": "all functions that take a θ" if takes == "all functions" else takes,
                             "word": word, "label": NAMES[word], "errors": [error(figures[f"blend_rmse_{q}"]) for q in ("median", "mean", "p95")] + [error(figures["rmse_mean"])] if figures else ["–"] * 4,
                             "failing": percent(figures["share_failing_check"]) if figures else "–",
                             "fitted": percent(figures["share_fitted"]) if figures else "–", "time": duration(figures["us_median"]) if figures else "–"})
            tables.append({"name": name, "rows": rows, "has_points": bool(points)})
        return tables

    # ---- scenes

    def scene_rows(self):
        """Scenes by falling share of the leader's stored functions that fail the check, then by their 95th percentile of the blend RMSE; functions that take a θ."""
        rows, inputs, lead = [], self.inputs, self.leader
        every = {key: inputs.over(*key) for key in [(name, word) for name in inputs.representations for word in WORDS]}
        for scene in sorted(set(inputs.samples[lead, "stored"].scene)):
            part = {key: some.only(some.scene == scene) for key, some in every.items()}
            stored = part[lead, "stored"]
            if not len(stored):
                rows.append({"key": (0.0, 0.0, scene), "scene": scene, "functions": "0", "hard": "0", "cells": [("–", False)] * 4, "fitted": "–",
                             "shares": [("–", 0.0, False)] * (len(WORDS) + len(self.others()))})
                continue
            share = {key: float(some.fails_check.mean()) for key, some in part.items()}
            high = float(np.quantile(stored.blend_rmse, 0.95))
            values = [("blend_rmse", v) for v in (float(np.median(stored.blend_rmse)), high, float(stored.blend_rmse.max()))] + [("rmse", float(stored.rmse.max()))]
            cells = [(error(v), v > self.tau[which]) for which, v in values]
            rows.append({"key": (-share[lead, "stored"], -high, scene), "scene": scene, "functions": grouped(len(stored)),
                         "hard": grouped(int(stored.hard.sum())), "cells": cells, "fitted": percent(float(stored.fitted.mean())),
                         "shares": [self.heat(share[lead, word], word == "stored") for word in WORDS] + [self.heat(share[name, "stored"]) for name in self.others()]})
        return sorted(rows, key=lambda row: row["key"])

    def others(self):
        return [name for name in self.inputs.representations if name != self.leader]

    def heat(self, share, is_judged=True):
        """Text, how strongly to shade it, and whether it is above what a generator may store."""
        return percent(share), round(min(0.6, 0.12 * share / max(self.limits.share_failing, 1e-9)), 3), is_judged and share > self.limits.share_failing

    def scene_sentence(self):
        rows = self.scene_rows()
        stored = WORDS.index("stored")
        over = [row["scene"] for row in rows if row["shares"][stored][2]]
        limit = percent(self.limits.share_failing)
        whose = f"{self.leader}’s functions that take a θ"
        if not over:
            return f"In every scene at most {limit} of {whose} fail the check as they are stored; the most do in {rows[0]['scene']}, {rows[0]['shares'][stored][0]}."
        named = joined(over) if len(over) <= 3 else f"{', '.join(over[:2])} and {len(over) - 2} more"
        return f"In {len(over)} of {plural(len(rows), 'scene')} more than {limit} of {whose} fail the check as they are stored: {named}."

    # ---- stability

    def stability_groups(self):
        """(group's name, how many of its cases hold, (state, case)), failing cases first, otherwise as the suite has them."""
        groups = []
        for group in proof_inputs.GROUPS:
            rows = sorted(((case_state(case), case) for case in self.cases if case.group == group), key=lambda row: CASE_STATES.index(row[0]))
            checked = sum(state == "fails-check" for state, _ in rows)
            held = f"{sum(state in ('holds', 'fails-check') for state, _ in rows)} of {len(rows)} hold"
            held += (f"; in {checked} of them a function fails the bake’s check" if checked else "")
            groups += [(GROUP_NAMES[group], held, rows)] if rows else []
        return groups

    @property
    def stability_state(self):
        """For the colour: good only where every case holds and passes the bake's check."""
        states = {case_state(case) for case in self.cases}
        return "bad" if "fails" in states else "good" if states == {"holds"} else "mixed"

    def stability_sentence(self):
        text = f"{sum(case.holds for case in self.cases)} of {plural(len(self.cases), 'case')} hold"
        checked = sum(case_state(case) == "fails-check" for case in self.cases)
        return text + (f"; in {checked} of them a function fails the bake’s check, and its error is what the case allows." if checked else ".")


# ---- the frontier's rows


def front_rows(frontier, view):
    """Members of a view's front by rising time, numbered as in its plot."""
    rows = []
    for number, (point, spread) in enumerate(front_of(frontier, view), 1):
        f = point.figures[view.population]
        rows.append({"number": number, "representation": point.representation, "label": point.label, "words": ", ".join(point.words) or "–", "time": duration(spread.us),
                     "spread": f"{duration(f['us_p25'])}–{duration(f['us_p75'])}", "errors": [error(f[f"blend_rmse_{q}"]) for q in ("median", "mean", "p5", "p95")] + [error(f["rmse_mean"])],
                     "failing": percent(f["share_failing_check"]), "fitted": percent(f["share_fitted"]), "leak": f"{f['leak_p99']:.3f}"})
    return rows


def front_summary(frontier, view, rows):
    """Where a front begins and ends, and between which times each representation is on it."""
    if not rows:
        return view.sentence
    spans = {}
    for row in rows:
        spans.setdefault(row["representation"], []).append(row["time"])
    parts = [f"{name} from {times[0]} to {times[-1]}" if len(times) > 1 else f"{name} at {times[0]}" for name, times in spans.items()]
    return (f"Over {view.words}, {len(rows)} of {grouped(len(frontier.points))} ways to a θ are beaten by none in time and mean blend RMSE: {joined(parts)}. "
            f"It falls from {rows[0]['errors'][1]} to {rows[-1]['errors'][1]}; the bare tent’s is {error(view.tent)}.")


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


# ---- savings


def bytes_text(value):
    sign, value = ("−" if value < 0 else ""), abs(value)
    for unit, scale in (("B", 1), ("kB", 1e3), ("MB", 1e6)):
        if value < 999.5 * scale:
            return f"{sign}{value / scale:.3g} {unit}"
    return f"{sign}{value / 1e9:.3g} GB"


def seconds_text(value):
    return ("−" if value < 0 else "") + duration(abs(value) * 1e6) if value else "0 s"


def saving_groups(savings):
    """(scene, rows): what saves time first, by falling time; what this bake has none of last."""
    groups = []
    for scene, rows in savings:
        ordered = sorted(rows, key=lambda r: (r.count == 0, -(r.seconds_saved or 0)))
        groups.append((scene, [{"what": r.what, "is_left_out": r.count > 0, "count": grouped(r.count), "of": grouped(r.of), "share": percent(r.count / r.of) if r.of else "–",
                                "seconds": "–" if r.seconds_saved is None else seconds_text(r.seconds_saved),
                                "bytes": "–" if r.bytes_saved is None else bytes_text(r.bytes_saved), "note": r.note}
                               for r in ordered]))
    return groups


def savings_sentence(savings):
    """Lines overlap (theta of what was not made, and bits of theta), so nothing is added up: the one that saves most speaks."""
    left = [(scene, r) for scene, some in savings for r in some if r.count > 0]
    text = f"{plural(len(savings), 'scene')}: {plural(len(left), 'kind')} of work and data left out"
    timed = [(s, r) for s, r in left if r.seconds_saved is not None and r.seconds_saved > 0]
    if timed:
        scene, best = max(timed, key=lambda pair: pair[1].seconds_saved)
        text += f", of which “{best.what}” saves most time, {seconds_text(best.seconds_saved)} in {scene}"
    return text + "."

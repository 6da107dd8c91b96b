#!/usr/bin/python3
"""Runs on the same held-out functions: which options differ, and what got better or worse, beyond noise.

    nlg compare OLD NEW ...        (or compare.py)

Each is a run's folder, or a summary.json of nlg-validate. Every further run is compared with the first. Of a folder the validation is taken, and
its trainings' options and where their curves end are shown besides.
Functions are paired by the functions.csv beside both. Errors are blend RMSEs of the same functions in both runs, so the noise is that of
the choice of scenes and functions: would another held-out set of the same kind say the same? Another seed of the training is no such
noise. docs/reference/json.md says how each figure is judged. Exit code 0: nothing is worse; 6: something is, or a representation is gone.
"""
import argparse
import dataclasses
import json
import math
import os
import sys
from dataclasses import dataclass

sys.dont_write_bytecode = True

import packages

packages.need("compare.py", "numpy", "scipy")

import numpy as np
from scipy import stats

from inputs import WORDS, check_counts, read_functions, read_summary
from tool.errors import CHECK_FAILED, InputError, run, say
from tool.input_file import read_json
from verdict import FEWEST_SCENES

WORDS_BY_SCENE = ("network", "stored")  # what training makes, and what ships
FALSE_ALARMS = 0.05     # the chance that noise alone makes any figure count as changed
SMALLEST_CHANGE = 0.01  # that counts, as a share of the old value
FEWEST_P99 = 500        # functions, of which ten may be above the percentile of both runs
WORST_FACTOR = 2.0      # of a function's blend RMSE over its old one: what is above it, and above tau, is worse


@dataclass
class Run:
    path: str
    summary: object  # Node
    samples: dict    # of inputs.read_functions

    def names(self):
        return [name for name, _ in self.summary["representations"].entries()]


@dataclass
class Change:
    """One figure in both runs; lower is better."""
    representation: str
    scene: str                  # empty: all held-out functions that the figure is of
    figure: str
    old: float
    new: float
    standard_error: float = 0.0  # of new - old; 0: not known
    chance: object = None        # that noise alone makes so large a difference; None: judged by a factor, or not at all
    note: str = ""
    trend: str = "same"          # better, worse, same, or shown: not judged. Where there is a chance: "same" until all figures are judged together


def summary_of(path):
    return os.path.join(path, "validation", "summary.json") if os.path.isdir(path) else path


def trainings_of(path):
    """Of a run's folder: representation → its options, and what the curve ends with. Empty where it is none."""
    found = {}
    folder = os.path.join(path, "training")
    for name in sorted(os.listdir(folder)) if os.path.isdir(folder) else []:
        config, result = os.path.join(folder, name, "config.json"), os.path.join(folder, f"{name}.json")
        if os.path.isfile(config) and os.path.isfile(result):
            found[name] = {key: node.value for key, node in read_json(config).entries()}
            # as many digits as mean anything
            found[name] |= {f"curve: {key}": f"{node.number():.5g}" for key, node in read_json(result).entries() if key.endswith("blend_rmse")}
    return found


def training_lines(old, new):
    """What two runs were told, and where their curves end."""
    before, after = trainings_of(old), trainings_of(new)
    for name in sorted({*before} & {*after}):
        for key in sorted({*before[name]} | {*after[name]}):
            values = before[name].get(key, "none"), after[name].get(key, "none")
            if values[0] != values[1]:
                yield f"  {name}, {key}: {values[0]} -> {values[1]}"


def read_run(path, is_folder=True):
    """is_folder   a run's folder or its summary.json; otherwise the folder of nlg-validate's results"""
    path = summary_of(path) if is_folder else os.path.join(path, "summary.json")
    summary = read_summary(path)
    functions = os.path.join(os.path.dirname(path), "functions.csv")
    samples = read_functions(functions, [name for name, _ in summary["representations"].entries()])
    check_counts(functions, samples, summary)
    return Run(path, summary, samples)


def refuse_other_runs(old, new):
    def must_be_equal(node, expected):
        if node.value != expected.value:
            node.refuse(f"{expected.value} as in {old.path}", node.value)
    must_be_equal(new.summary["provenance"]["inputs"]["held_out"], old.summary["provenance"]["inputs"]["held_out"])
    must_be_equal(new.summary["theta_precision"], old.summary["theta_precision"])
    for key, value in old.summary["tau"].entries():
        must_be_equal(new.summary["tau"][key], value)


# ---- what is more than chance


def sign_chance(risen, fallen):
    """Of risen + fallen changes, each up or down alike: the chance that so many or more go the way that most went."""
    return 1.0 if risen == fallen else min(1.0, 2.0 * float(stats.binom.cdf(min(risen, fallen), risen + fallen, 0.5)))


def beyond_chance(chances, level):
    """Holm's method: which of many figures changed, so that noise alone makes one or more of them pass with at most this chance."""
    beyond = [False] * len(chances)
    for rank, index in enumerate(sorted(range(len(chances)), key=lambda i: chances[i])):
        if chances[index] > level / (len(chances) - rank):
            break
        beyond[index] = True
    return beyond


def student_chance(mean, error, degrees):
    """Both tails of Student's t."""
    return 2.0 * float(stats.t.sf(abs(mean) / error if error else math.inf, degrees))


def over_scenes(differences, scenes, error, chance):
    """Standard error of the mean difference, and the chance of it, where scenes are drawn: functions of one scene err alike (the cluster-robust
    estimate, Liang and Zeger 1986). Of fewer than FEWEST_SCENES what is known of functions alone: error, chance."""
    names, which = np.unique(scenes, return_inverse=True)
    if len(names) < FEWEST_SCENES:
        return error, chance
    mean = float(differences.mean())
    sums = np.bincount(which, differences - mean)
    error = math.sqrt(len(names) / (len(names) - 1) * float((sums ** 2).sum())) / len(differences)
    return error, max(chance, student_chance(mean, error, len(names) - 1))


def trend_beyond(old, new):
    """By more than SMALLEST_CHANGE."""
    return "same" if abs(new - old) <= SMALLEST_CHANGE * old else "better" if new < old else "worse"


# ---- one figure of the same functions in both runs, as fields of a Change


def mean_change(old, new, scenes=()):
    """A mean. Never below 2^(1 - pairs), the chance that so many go the same way: t alone believes a few pairs that agree more than that.
    scenes   of each function; of FEWEST_SCENES and more the chance is no less than that of drawing other scenes"""
    if not len(old):
        return {"old": 0.0, "new": 0.0}
    differences, pairs = new - old, len(old)
    change = {"old": float(old.mean()), "new": float(new.mean()), "chance": 1.0}
    if pairs == 1 or not differences.mean():
        return change
    mean, error = float(differences.mean()), float(differences.std(ddof=1)) / math.sqrt(pairs)
    error, chance = over_scenes(differences, scenes, error, max(student_chance(mean, error, pairs - 1), 2.0 ** (1 - pairs)))
    return change | {"standard_error": error, "chance": chance}


def crossings(old, new, threshold, scenes=()):
    before, after = old > threshold, new > threshold
    risen, fallen = int((after & ~before).sum()), int((before & ~after).sum())
    chance = sign_chance(risen, fallen)
    if risen != fallen:
        _, chance = over_scenes(after.astype(float) - before, scenes, 0.0, chance)
    return {"chance": chance, "note": f"{risen} rose above it, {fallen} fell below" if risen + fallen else ""}


def p99_change(old, new, scenes=()):
    """Judged at the 99th percentile of both runs' values together, which favours neither run. At most a fiftieth of the functions can have risen
    above it: of fewer than FEWEST_P99 no rise is more than chance."""
    if not len(old):
        return {"old": 0.0, "new": 0.0}
    change = {"old": float(np.quantile(old, 0.99)), "new": float(np.quantile(new, 0.99))}
    if len(old) < FEWEST_P99:
        return change | {"trend": "shown", "note": "too few functions to judge"}
    return change | crossings(old, new, np.quantile(np.concatenate([old, new]), 0.99), scenes)


def failing_change(old, new, scenes=()):
    if not len(old):
        return {"old": 0.0, "new": 0.0}
    return {"old": float(old.mean()), "new": float(new.mean())} | crossings(old.astype(float), new.astype(float), 0.5, scenes)


def worst_change(old, new, tau):
    """A function leaps when its blend RMSE is above so many times its error in the other run, and tau. What these very functions do is no matter of chance."""
    risen, fallen = new.blend_rmse > WORST_FACTOR * np.maximum(old.blend_rmse, tau), old.blend_rmse > WORST_FACTOR * np.maximum(new.blend_rmse, tau)
    change = {"old": float(old.blend_rmse.max(initial=0.0)), "new": float(new.blend_rmse.max(initial=0.0))}
    if risen.any():
        # the figures are then those of the function that leapt highest: another one may be the worst of all
        highest = int(np.argmax(np.where(risen, new.blend_rmse, -1.0)))
        return {"old": float(old.blend_rmse[highest]), "new": float(new.blend_rmse[highest]), "note": f"{risen.sum()} leapt; the errors are those of the highest, function {new.function[highest]} of {new.scene[highest]}", "trend": "worse"}
    return change | ({"note": f"{fallen.sum()} no longer so high", "trend": "better"} if fallen.any() else {})


def costs(old, new):
    """The mean RMSE, how many functions took a fit, and the time, which a busy machine changes: they are shown and never judged."""
    shown = lambda old, new: {"old": old, "new": new, "trend": "shown"}
    yield "mean RMSE", shown(*(node["theta"]["rmse"]["mean"].number() if node["theta"]["functions"].count() else 0.0 for node in (old, new)))
    yield "share that took a fit", shown(*(node["theta"]["share_fitted"]["value"].number() for node in (old, new)))
    yield "µs a function", shown(*(node["theta"]["us_per_function"].number() for node in (old, new)))


# ---- all figures


def changes_of(name, old, new):
    """(scene, figure, fields of a Change)"""
    tau = new.summary["tau"]["blend"].number()
    pairs = {}
    for word in WORDS:
        a, b = pairs[word] = old.samples[name, word], new.samples[name, word]
        if len(a) != len(b) or any((getattr(a, key) != getattr(b, key)).any() for key in ("function", "scene", "takes_theta", "hard")):
            raise InputError(new.path, f"rows of '{name}', '{word}' in functions.csv beside it", "the functions of the old run, in its order", "other functions")
        (theta_a, hard_a), (theta_b, hard_b) = [(some.of("theta"), some.of("hard")) for some in (a, b)]
        yield "", f"{word}, mean blend RMSE", mean_change(theta_a.blend_rmse, theta_b.blend_rmse, theta_a.scene)
        yield "", f"{word}, mean blend RMSE of hard functions", mean_change(hard_a.blend_rmse, hard_b.blend_rmse, hard_a.scene)
        yield "", f"{word}, p99 of blend RMSE", p99_change(theta_a.blend_rmse, theta_b.blend_rmse, theta_a.scene)
        yield "", f"{word}, worst blend RMSE", worst_change(theta_a, theta_b, tau)
        yield "", f"{word}, share that fails the check", failing_change(theta_a.fails_check, theta_b.fails_check, theta_a.scene)
        yield "", f"{word}, mean leak of a function", mean_change(theta_a.leak_mean, theta_b.leak_mean, theta_a.scene)
        for figure, fields in costs(old.summary["representations"][name][word], new.summary["representations"][name][word]):
            yield "", f"{word}, {figure}", fields
    for scene in dict.fromkeys(old.samples[name, WORDS[0]].scene):
        for word in WORDS_BY_SCENE:
            a, b = [some.only(some.takes_theta & (some.scene == scene)) for some in pairs[word]]
            yield scene, f"{word}, mean blend RMSE", mean_change(a.blend_rmse, b.blend_rmse)
            yield scene, f"{word}, worst blend RMSE", worst_change(a, b, tau)
            yield scene, f"{word}, share that fails the check", failing_change(a.fails_check, b.fails_check)


@dataclass
class Comparison:
    lost: list   # representations that only the old run has
    added: list  # … only the new one
    changes: list
    judged_by_chance: int = 0
    scenes: int = 0  # that are held out

    def of(self, trend):
        return [change for change in self.changes if change.trend == trend]

    def worse_count(self):
        return len(self.of("worse")) + len(self.lost)


def compare(old, new):
    refuse_other_runs(old, new)
    names = old.names(), new.names()
    both = [name for name in names[0] if name in names[1]]
    if not both:
        raise InputError(new.path, "representations", f"at least one of {old.path}", "none")
    changes = [Change(name, scene, figure, **fields) for name in both for scene, figure, fields in changes_of(name, old, new)]
    # all figures that have a chance, of all representations, are one family
    judged = [change for change in changes if change.chance is not None]
    for change, is_beyond in zip(judged, beyond_chance([change.chance for change in judged], FALSE_ALARMS)):
        if is_beyond:
            change.trend = trend_beyond(change.old, change.new)
    return Comparison([name for name in names[0] if name not in names[1]], [name for name in names[1] if name not in names[0]], changes, len(judged), len(set(old.samples[both[0], WORDS[0]].scene)))


# ---- what is printed


def line_of(change):
    where = (f"{change.scene}: " if change.scene else "") + change.figure
    line = f"  {change.trend:<7}{where:<48} {change.old:>10.5g} -> {change.new:<10.5g}"
    if change.old:
        line += f" {100 * (change.new - change.old) / change.old:+.1f} %"
        line += f" (standard error {100 * change.standard_error / change.old:.1f} %)" if change.standard_error else ""
    if change.chance is not None and change.old != change.new:
        line += f", chance {change.chance:.2g}"
    return line + (f"; {change.note}" if change.note else "")


def text_of(comparison, all_scenes):
    yield (f"of functions that take a theta; better and worse are corrected for {comparison.judged_by_chance} tests: with other {'functions of the same scenes' if comparison.scenes < FEWEST_SCENES else 'scenes and functions'}"
           f" the chance of any false alarm is at most {FALSE_ALARMS:g}. Changes below {100 * SMALLEST_CHANGE:g} % of the old value are the same. Another"
           " seed of the training alone changes errors by 1 to 5 %")
    representation = None
    for change in comparison.changes:
        if change.scene and change.trend == "same" and not all_scenes:
            continue
        if change.representation != representation:
            representation = change.representation
            yield f"\n{representation}"
        yield line_of(change)
    yield ""
    yield from (f"worse: {name} is in the old run only" for name in comparison.lost)
    yield from (f"{name} is in the new run only" for name in comparison.added)
    yield f"{len(comparison.of('better'))} better, {comparison.worse_count()} worse, {len(comparison.of('same'))} the same"


def json_of(comparison):
    return json.dumps({"schema_version": 1, **dataclasses.asdict(comparison)}, ensure_ascii=False)


def parse_arguments():
    parser = argparse.ArgumentParser(description="Says what got better or worse between two validations of the same held-out functions, beyond noise; exit code 6 where something is worse.")
    parser.add_argument("old", help="folder or summary.json of the run to compare with")
    parser.add_argument("new", nargs="+", help="folders or summary.json of the runs to judge. Functions are paired by the functions.csv beside each summary.json")
    parser.add_argument("--all-scenes", action="store_true", help="also print scenes where nothing changed")
    parser.add_argument("--json", action="store_true", help="print one line of JSON per comparison")
    return parser.parse_args()


def main():
    options = parse_arguments()

    def work():
        old, worse = read_run(options.old), []
        for path in options.new:
            comparison = compare(old, read_run(path))
            if options.json:
                print(json_of(comparison))
            else:
                lines = [f"{options.old} -> {path}", *training_lines(options.old, path), *text_of(comparison, options.all_scenes)]
                print("\n".join("".join(c if c.isprintable() or c == "\n" else " " for c in line) for line in lines))
            worse += [f"{name} is gone" for name in comparison.lost] + [", ".join(filter(None, (change.representation, change.scene))) + f": {change.figure}" for change in comparison.of("worse")]
        if not worse:
            return 0
        say("compare.py", f"the new run is worse than the old one beyond noise in {len(worse)} figures; the first: {worse[0]}")
        return CHECK_FAILED
    return run("compare.py", work)


if __name__ == "__main__":
    sys.exit(main())

"""Whether a generator may ship: three figures against three limits, and no failure of the stability suite left unexplained.

Judged is what a grid holds in the end (*stored*), by how often it fails the check and how far its error is above the best known; and
whether the generator is worth its name, by the time that a fit without it takes to the same error. How many functions took a fit is
shown beside these and not judged: that some do is the policy, and what the fits cost is in the times. The limits are defaults of
report.py's flags, and stand on the page beside what was measured.
"""
from dataclasses import dataclass

DIRECT = ("lm_from_theta0", "lm_from_random", "adam_from_theta0", "adam_from_random")  # families of the frontier; each may stand with a gate as well
SHIPS, FAILS, UNDECIDED = "may ship", "may not ship", "undecided"


@dataclass(frozen=True)
class Limits:
    share_failing: float = 0.02  # of the functions that take a theta, as stored
    error_hard: float = 2.0      # of what is stored over the best known, median over hard functions
    speedup: float = 1.0


@dataclass
class Figure:
    """One of the three, of one generator."""
    value: object  # None: it could not be measured
    passes: bool
    interval: object = None  # (low, high), 95 %


@dataclass
class Judgement:
    representation: str
    failing: Figure   # share of stored functions that fail the check, of those that take a theta
    hard: Figure      # stored error over the best known, median over hard functions of the sample
    equal: object     # EqualError, or None
    speedup: Figure   # its ratio: time of the fastest direct fit to exactly the mean error that is stored, over that of the policy

    @property
    def figures(self):
        return self.failing, self.hard, self.speedup

    @property
    def verdict(self):
        if any(figure.value is None for figure in self.figures):
            return UNDECIDED
        return SHIPS if all(figure.passes for figure in self.figures) else FAILS


@dataclass
class EqualError:
    """What a generator is worth in time: what is fitted, against the fastest direct fit to the same mean error."""
    fitted_us: float
    direct_us: object  # None: not known
    label: object      # of that fit; None: no budget reaches the error, and direct_us is the longest's
    ratio: object
    interval: object   # (low, high), 95 %; high None: no bound
    reason: object     # why there is no ratio of exactly equal errors


def is_direct(family):
    return family.removesuffix("_loosely").removesuffix("_gated") in DIRECT


def at_equal_error(frontier, representation):
    """None without a frontier, or where it says nothing of the representation."""
    speed = frontier.speeds.get(representation, {}).get("fitted") if frontier else None
    if speed is None:
        return None
    if speed.ratio is not None:
        return EqualError(speed.time_us, speed.rival_us, speed.rival, speed.ratio, (speed.low, speed.high), None)
    fits = [point.over("theta") for point in frontier.points if point.representation == representation and is_direct(point.family) and point.figures["theta"]]
    error = [point.over("theta").mean for point in frontier.points if point.representation == representation and "fitted" in point.words and point.figures["theta"]]
    if fits and error and all(fit.mean > error[0] for fit in fits):  # the longest fit's time is what it takes at least
        longest = max(fit.us for fit in fits)
        return EqualError(speed.time_us, longest, None, longest / speed.time_us, None, speed.reason)
    return EqualError(speed.time_us, None, None, None, None, speed.reason)


def estimate(node):
    """(value, (low, high)) of an estimate; (None, None) where no function stands behind it."""
    if not node["value"].value:
        return None, None
    return node["value"].number(), (node["low"].number(), node["high"].number())


def share_of(figures, key):
    """The same of a share, which may well be 0."""
    if figures["functions"].count() == 0:
        return None, None
    return figures[key]["value"].number(), (figures[key]["low"].number(), figures[key]["high"].number())


def at_most(measured, limit):
    value, interval = measured
    return Figure(value, value is not None and value <= limit, interval)


def judge(inputs, limits, frontier=None):
    """One judgement a generator, in the summary's order."""
    judgements = []
    for name in inputs.representations:
        node = inputs.summary["representations"][name]
        equal = at_equal_error(frontier, name)
        judgements.append(Judgement(name, at_most(share_of(node["stored"]["theta"], "share_failing_check"), limits.share_failing),
                                    at_most(estimate(node["sample"]["ratios"]["stored"]["to_best_known"]["median_hard"]), limits.error_hard), equal,
                                    Figure(equal and equal.ratio, bool(equal and equal.ratio and equal.ratio >= limits.speedup), equal and equal.interval)))
    return judgements


def failed(cases):
    return [case for case in cases if case.ran and not case.holds]


def unexplained(cases):
    return [case for case in failed(cases) if not case.note.strip()]


def leader(inputs, judgements):
    """The generator that the page looks at first: the first of the summary that may ship, or the first where none may. A run names
    its representations in the order in which they matter to it."""
    return next((j.representation for j in judgements if j.verdict == SHIPS), inputs.representations[0])

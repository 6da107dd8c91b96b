"""Whether a generator may ship: three figures against three limits, and no failure of the stability suite.

Judged is what a grid holds in the end (*stored*), by how often it fails the check and how far its blend RMSE is above the best known; and
whether the generator is worth its name, by the time that a fit without it takes to the same mean blend RMSE. How many functions took a fit
is shown beside these and not judged: that some do is the policy, and what the fits cost is in the times. The limits are defaults of
report.py's flags. `rule` says in words what `judge` does: on the page, at the end of pipeline.sh and in the documentation.
"""
from dataclasses import dataclass

DIRECT = ("lm_from_theta0", "lm_from_random", "adam_from_theta0", "adam_from_random")  # families of the frontier; each may stand with a gate as well
SHIPS, FAILS, UNDECIDED = "may ship", "may not ship", "undecided"
FEWEST_FUNCTIONS = 20  # that take a theta: fewer decide nothing
FEWEST_SCENES = 3      # that are held out: of fewer no interval over scenes says anything


@dataclass(frozen=True)
class Limits:
    share_failing: float = 0.1   # of the functions that take a theta, as stored: up to there light is that of exact functions (docs/lab/training.md)
    error_hard: float = 2.0      # of what is stored over the best known, median over hard functions
    speedup: float = 1.0


def short(value):
    """.02 of 0.02."""
    return f"{value:g}".removeprefix("0") or "0"


def rule(limits, tau_rmse, tau_blend):
    """The rule in plain words, a sentence a limit. The taus are those of the check."""
    return [
        f"Stored functions: of those that take a θ, at most {100 * limits.share_failing:g} % fail the check. A function fails it when its RMSE is above {short(tau_rmse)} or its blend RMSE above {short(tau_blend)}.",
        f"Hard functions: what is stored has at most {limits.error_hard:g} times the best known blend RMSE, the lowest that any long fit found (median over the sample).",
        f"Time: to the same mean blend RMSE, the fastest fit without a generator takes at least {limits.speedup:g} × the time of the bake's fits (up to *fitted*).",
        "Stability: every case of the suite holds."]


UNDECIDED_WHEN = (f"A generator is undecided where fewer than {FEWEST_FUNCTIONS} functions take a θ or fewer than {FEWEST_SCENES} scenes are held out. It is undecided, too, where no figure fails, but one could "
                  "not be measured or its 95 % interval (over scenes and functions) holds its limit.")


@dataclass
class Figure:
    """One of the three, of one generator."""
    value: object  # None: it could not be measured
    passes: bool
    interval: object = None  # (low, high), 95 %; high None: no bound
    limit: object = None

    @property
    def is_open(self):
        """Whether other functions may well put it on the other side of its limit."""
        return self.value is not None and self.interval is not None and self.interval[0] < self.limit and (self.interval[1] is None or self.interval[1] > self.limit)


@dataclass
class Judgement:
    representation: str
    failing: Figure   # share of stored functions that fail the check, of those that take a theta
    hard: Figure      # stored blend RMSE over the best known, median over hard functions of the sample
    equal: object     # EqualError, or None
    speedup: Figure   # its ratio: time of the fastest direct fit to exactly the mean blend RMSE that is fitted, over that of the policy
    functions: int = FEWEST_FUNCTIONS  # that take a theta and were judged
    scenes: int = FEWEST_SCENES        # that these are of

    @property
    def figures(self):
        return self.failing, self.hard, self.speedup

    @property
    def is_of_too_few(self):
        return self.functions < FEWEST_FUNCTIONS or self.scenes < FEWEST_SCENES

    def state(self, figure):
        """Of one of the three, for its colour: good, mixed (undecided) or bad."""
        if figure.value is None or figure.is_open or self.is_of_too_few:
            return "mixed"
        return "good" if figure.passes else "bad"

    @property
    def verdict(self):
        if self.is_of_too_few:
            return UNDECIDED
        if any(figure.value is not None and not figure.passes and not figure.is_open for figure in self.figures):
            return FAILS
        return UNDECIDED if any(figure.value is None or figure.is_open for figure in self.figures) else SHIPS


@dataclass
class Speed:
    """How much longer the fastest direct fit takes to the mean blend RMSE of one word, over the functions that take a theta."""
    time_us: float
    failing: tuple         # share of the word's functions that fail the check: value, low, high (95 %)
    baseline: object          # which fit; None: there is no ratio, and the reason says why
    baseline_us: object
    baseline_failing: object  # as failing, of that fit; None likewise
    ratio: object
    low: object            # 95 %
    high: object           # None: no bound
    longest_us: object     # of the longest fit, where none reaches the error
    reason: object


@dataclass
class EqualError:
    """What a generator is worth in time: what is fitted, against the fastest direct fit to the same mean blend RMSE."""
    fitted_us: float
    direct_us: object      # None: not known
    label: object          # of that fit; None: no budget reaches the error, and direct_us is the longest's
    ratio: object
    interval: object       # (low, high), 95 %; high None: no bound
    reason: object         # why there is no ratio of exactly equal errors
    failing: float         # share of the fitted functions that fail the check
    direct_failing: object  # and of the direct fit's; None: not known


def is_direct(family):
    return family.removesuffix("_gated") in DIRECT


def optional(node, read):
    return None if node.value is None else read(node)


def read_share(node):
    return tuple(node[key].number(high=1.0) for key in ("value", "low", "high"))


def read_speed(node):
    """One entry of speed_at_equal_error (docs/reference/formats.md)."""
    number = lambda n: n.number()
    ratio = [optional(node["ratio"], lambda n: optional(n[key], number)) for key in ("value", "low", "high")]
    if ratio[0] is None and node["reason"].value is None:
        node["ratio"].refuse("a ratio, or a reason why there is none", "neither")
    return Speed(node["time_us"].number(), read_share(node["share_failing_check"]), optional(node["baseline"], lambda n: n.text()), optional(node["baseline_us_at_equal_error"], number),
                 optional(node["baseline_share_failing_check"], read_share), *ratio, optional(node["longest_us"], number), optional(node["reason"], lambda n: n.text()))


def at_equal_error(speed):
    """None without a speed."""
    if speed is None:
        return None
    failing = speed.failing[0]
    if speed.ratio is not None:
        return EqualError(speed.time_us, speed.baseline_us, speed.baseline, speed.ratio, (speed.low, speed.high), None, failing, speed.baseline_failing and speed.baseline_failing[0])
    if speed.longest_us is not None:  # it takes at least so long
        return EqualError(speed.time_us, speed.longest_us, None, speed.longest_us / speed.time_us, None, speed.reason, failing, None)
    return EqualError(speed.time_us, None, None, None, None, speed.reason, failing, None)


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
    return Figure(value, value is not None and value <= limit, interval, limit)


def judge_one(name, node, speed, limits, scenes=FEWEST_SCENES):
    """node: of the summary's representation; speed: of what is fitted, or None; scenes: how many are held out."""
    equal = at_equal_error(speed)
    return Judgement(name, at_most(share_of(node["stored"]["theta"], "share_failing_check"), limits.share_failing),
                     at_most(estimate(node["sample"]["ratios"]["stored"]["to_best_known"]["median_hard"]), limits.error_hard), equal,
                     Figure(equal and equal.ratio, bool(equal and equal.ratio and equal.ratio >= limits.speedup), equal and equal.interval, limits.speedup),
                     node["stored"]["theta"]["functions"].count(), scenes)


def judge(inputs, limits, frontier=None):
    """One judgement a generator, in the summary's order."""
    speeds = frontier.speeds if frontier else {}
    return [judge_one(name, inputs.summary["representations"][name], speeds.get(name, {}).get("fitted"), limits, inputs.summary["functions"]["held_out_scenes"].count()) for name in inputs.representations]


def failed(cases):
    return [case for case in cases if not case.holds]


def leader(inputs, judgements):
    """The generator that the page looks at first: the first of the summary that may ship, or the first where none may. A run names
    its representations in the order in which they matter to it."""
    return next((j.representation for j in judgements if j.verdict == SHIPS), inputs.representations[0])

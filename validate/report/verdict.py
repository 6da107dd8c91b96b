"""Whether a generator may ship: three figures against three limits, and no failure of the stability suite left unexplained.

The limits are defaults of report.py's flags, and stand on the page beside what was measured.
"""
from dataclasses import dataclass

SHIPS, FAILS, UNDECIDED = "may ship", "may not ship", "undecided"


@dataclass(frozen=True)
class Limits:
    share_refined: float = 0.10
    error_hard: float = 3.0
    speedup: float = 30.0


@dataclass
class Figure:
    """One of the three, of one generator."""
    value: object  # None: it could not be measured
    passes: bool


@dataclass
class Judgement:
    representation: str
    refined: Figure   # share of functions that fail the bake's check and are fitted on
    hard: Figure      # error over that of direct optimisation, median over hard functions
    speedup: Figure   # time of direct optimisation over that of generator, check and refinement

    @property
    def figures(self):
        return self.refined, self.hard, self.speedup

    @property
    def verdict(self):
        if any(figure.value is None for figure in self.figures):
            return UNDECIDED
        return SHIPS if all(figure.passes for figure in self.figures) else FAILS


def times_us(summary, representation):
    """Mean time a function of (generator, check and refinement; direct optimisation). Direct ran on some of the functions only,
    evenly spread over the others."""
    node = summary["representations"][representation]
    return node["refined"]["us_per_function"].number(), node["direct"]["us_per_function"].number()


def judge(inputs, limits):
    """One judgement a generator, in the summary's order."""
    judgements = []
    for name in inputs.representations:
        node = inputs.summary["representations"][name]
        share = node["share_refined"].number()
        refined_us, direct_us = times_us(inputs.summary, name)
        faster = direct_us / refined_us if refined_us > 0 else None
        # 0: no hard function among those that direct optimisation ran on
        ratio = node["generator_to_direct"]["median_hard"].number() or None
        judgements.append(Judgement(name, Figure(share, share <= limits.share_refined),
                                    Figure(ratio, ratio is not None and ratio <= limits.error_hard),
                                    Figure(faster, faster is not None and faster >= limits.speedup)))
    return judgements


def not_run(cases):
    return [case for case in cases if not case.ran]


def unexplained(cases):
    return [case for case in cases if case.ran and not case.passes and not case.note.strip()]


def leader(inputs, judgements):
    """The generator that the page looks at first: of those that may ship (of all, where none may) the one whose refined functions
    have the lowest mean error."""
    some = [j.representation for j in judgements if j.verdict == SHIPS] or inputs.representations
    return min(some, key=lambda name: inputs.summary["representations"][name]["refined"]["rmse"]["mean"].number())

"""The files of the proof beside nlg-validate's summary: the error-time frontier, the stability suite, what bakes leave out.

docs/reference/formats.md says what stands in them. Read and checked as everything else (inputs.py); nothing here draws or decides.
"""
from dataclasses import dataclass

from inputs import InputError, read_json

GROUPS = ("functions", "optimisers", "pca", "generator", "scenes", "training")
SAVINGS_KEYS = ("savings", "needs")  # of nlg-bake's report: today's name and the one before
ERRORS = ("median", "p5", "p95")
HARD_KEYS = ("rmse_mean", "rmse_median", "rmse_p5", "rmse_p95", "rmse_worst")
POINT_KEYS = ("us_median", "us_p25", "us_p75", "rmse_mean", "rmse_median", "rmse_p5", "rmse_p95", "rmse_worst", "leak_p99")


@dataclass
class Spread:
    """One method on some functions: time and error, the median and what lies around it."""
    us: float
    median: float
    p5: float
    p95: float


@dataclass
class Point:
    """One method at one budget."""
    representation: str
    family: str
    budget: object        # a number, or None where the family has none
    label: str
    figures: dict         # POINT_KEYS → number
    on_front: bool
    by_scene: dict        # scene → Spread
    hard: object          # figures of the hard functions: HARD_KEYS → number; None where there is none
    on_hard_front: bool

    @property
    def whole(self):
        f = self.figures
        return Spread(f["us_median"], f["rmse_median"], f["rmse_p5"], f["rmse_p95"])

    @property
    def whole_hard(self):
        """The hard functions' errors, at the time of all: a bake does not know beforehand what is hard."""
        return Spread(self.figures["us_median"], *(self.hard[f"rmse_{q}"] for q in ERRORS)) if self.hard else None


@dataclass
class Frontier:
    path: str
    held_out: str         # SHA-256 of the shards that it was measured on
    function_count: int
    hard_count: int
    scenes: list
    points: list
    front_sentence: str
    hard_front_sentence: str
    tent: float           # median RMSE of the bare tent, which takes no time
    tent_hard: object     # … over the hard functions; None where there is none
    tent_by_scene: dict   # scene → the same
    hierarchy: list       # one dict a step: texts and numbers
    walks: list           # the same


@dataclass
class Case:
    """One case of the stability suite. A case that does not hold but has a note is explained, not green; one that was not run holds
    nothing and fails nothing, and its note says why. One that holds may still yield a θ that fails the bake's check."""
    group: str
    name: str
    must_hold: str
    measured: str
    holds: bool
    note: str
    ran: bool = True
    fails_check: bool = False


@dataclass
class Saving:
    """One thing that a bake leaves out because the scene does not need it, or could."""
    what: str
    left_out: object       # true, false: not yet; None: there is none of it in this bake
    count: int
    of: int
    seconds_saved: object  # null: not measured
    bytes_saved: object
    same_result: object    # null: not known
    note: str


def check_schema(node):
    if node["schema_version"].count() != 1:
        node["schema_version"].refuse("1", node["schema_version"].value)


def truth(node):
    if not isinstance(node.value, bool):
        node.refuse("true or false", repr(node.value)[:40])
    return node.value


def optional(node, read):
    return None if node.value is None else read(node)


def row(node):
    """A flat object of texts, numbers and truths, in the file's order; nulls stay."""
    result = {}
    for key, value in node.entries():
        if not isinstance(value.value, (str, int, float, type(None))):
            value.refuse("a text, a number, true, false or null", type(value.value).__name__)
        result[key] = value.value
    return result


def check_quantiles(node):
    p5, median, p95 = (node[f"rmse_{q}"].number() for q in ("p5", "median", "p95"))
    if not p5 <= median <= p95:
        node.refuse("rmse_p5 <= rmse_median <= rmse_p95", f"{p5:g}, {median:g}, {p95:g}")


def refuse_other_weights(path, summary, representations):
    """A proof of other weights than those that the summary judges proves nothing of them.

    path              of the proof, whose provenance names the SHA-256 of its weights
    representations   those of the proof; what the summary does not judge is left alone
    """
    hashes = read_json(path)["provenance"]["inputs"]
    known = {node.text() for _, node in hashes.entries()}
    for name, node in summary["representations"].entries():
        wanted = node["weights_sha256"].text()
        if name in representations and wanted not in known:
            hashes.refuse(f"the weights of {name} in {summary.path}, {wanted}", "others")


def read_spread(node):
    check_quantiles(node)
    return Spread(node["us_median"].number(), *(node[f"rmse_{q}"].number() for q in ERRORS))


def read_hard(node):
    check_quantiles(node)
    return {key: node[key].number() for key in HARD_KEYS}


def read_point(node):
    budget = optional(node["budget"], lambda n: n.number())
    by_scene = {scene: read_spread(some) for scene, some in node["by_scene"].entries()}
    point = Point(node["representation"].text(), node["family"].text(), budget, node["label"].text(),
                  {key: node[key].number() for key in POINT_KEYS}, truth(node["on_front"]), by_scene,
                  optional(node["hard"], read_hard), bool(optional(node["hard"], lambda hard: truth(hard["on_front"]))))
    check_quantiles(node)
    if point.whole.us <= 0:
        node["us_median"].refuse("a time above 0", point.whole.us)
    return point


def read_frontier(path):
    file = read_json(path)
    check_schema(file)
    scenes = [node.text() for node in file["scenes"].items()]
    points = [read_point(node) for node in file["points"].items()]
    for index, point in enumerate(points):
        for scene in point.by_scene:
            if scene not in scenes:
                raise InputError(path, f"points[{index}].by_scene", "scenes of the list 'scenes'", f"'{scene}'")
    hard_count = file["hard_functions"].count()
    for index, point in enumerate(points):
        if (point.hard is None) != (hard_count == 0):
            file["points"].refuse("figures of hard functions in all points, or no hard function", f"points[{index}]")
    tent = file["bare_tent"]
    lists = [[row(node) for node in file[key].items()] for key in ("hierarchy", "walks")]
    return Frontier(path, file["provenance"]["inputs"]["held_out"].text(), file["functions"].count(), hard_count, scenes, points, file["front_sentence"].text(), file["hard_front_sentence"].text(),
                    tent["rmse_median"].number(), optional(tent["hard"], lambda n: n["rmse_median"].number()),
                    {scene: node["rmse_median"].number() for scene, node in tent["by_scene"].entries()}, *lists)


def check_same_scenes(frontier, summary):
    """A page shows errors and their times side by side: both of the same held-out scenes."""
    expected = summary["provenance"]["inputs"]["held_out"].text()
    if frontier.held_out != expected:
        raise InputError(frontier.path, "provenance.inputs.held_out", f"the held-out scenes of {summary.path}, {expected}", frontier.held_out)


def read_stability(path):
    file = read_json(path)
    check_schema(file)
    cases = []
    for node in file["cases"].items():
        if node["group"].text() not in GROUPS:
            node["group"].refuse(" or ".join(GROUPS), f"'{node['group'].value}'")
        holds = node["holds" if "holds" in node.value else "passes"]  # "passes": files from before "holds" and "fails_check"
        fails_check = "fails_check" in node.value and truth(node["fails_check"])
        cases.append(Case(*(node[key].text() for key in ("group", "name", "must_hold", "measured")), truth(holds),
                          node["note"].text(), truth(node["ran"]), fails_check))
        if cases[-1].holds and not cases[-1].ran:
            holds.refuse("false of a case that was not run", "true")
    if not cases:
        file["cases"].refuse("at least one case", "none")
    return cases


def read_savings(path):
    """(scene, its rows) of one bake's report."""
    file = read_json(path)
    rows = []
    for node in file[next((key for key in SAVINGS_KEYS if key in (file.value or ())), SAVINGS_KEYS[0])].items():
        saved = [optional(node[key], lambda n: n.number(low=-1e18)) for key in ("seconds_saved", "bytes_saved")]
        rows.append(Saving(node["what"].text(), optional(node["left_out"], truth), node["count"].count(), node["of"].count(), *saved,
                           optional(node["same_result"], truth), node["note"].text()))
        if rows[-1].count > rows[-1].of:
            node["count"].refuse(f"at most 'of', {rows[-1].of}", rows[-1].count)
    return file["scene"].text(), rows

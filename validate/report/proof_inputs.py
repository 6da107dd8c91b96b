"""The files of the proof beside nlg-validate's summary: the error-time frontier, the stability suite, what bakes leave out.

docs/reference/formats.md says what stands in them. Read and checked as everything else (inputs.py); nothing here draws or decides.
"""
import json
import re
from dataclasses import dataclass

from inputs import SCHEMA_VERSION
from tool.errors import InputError
from tool.input_file import read_json
from verdict import optional, read_speed

GROUPS = ("functions", "codes", "generator")
STABILITY_VERSION = 1
POPULATIONS = ("theta", "hard")  # of a frontier, the main one first
POINT_KEYS = ("us_median", "us_p25", "us_p75", "blend_rmse_median", "blend_rmse_mean", "blend_rmse_p5", "blend_rmse_p95", "rmse_mean", "leak_p99", "share_failing_check", "share_fitted")
SPREAD_KEYS = ("us_median", "blend_rmse_mean", "blend_rmse_p5", "blend_rmse_p95", "rmse_mean")


@dataclass
class Spread:
    """One way on some functions: its time, its mean blend RMSE, and between which percentiles its blend RMSEs lie."""
    us: float
    mean: float
    p5: float
    p95: float
    rmse: float           # the mean of the RMSE


@dataclass
class Point:
    """One way at one budget."""
    representation: str
    family: str
    budget: object        # a number, or None where the family has none
    label: str
    words: list           # of network, corrected, fitted, stored: what theta is after this
    figures: dict         # population → POINT_KEYS → number; None where the population has no function
    fronts: dict          # population → whether the point is on its front
    by_scene: dict        # scene → Spread, of functions that take a theta

    def over(self, population):
        f = self.figures[population]
        return Spread(*(f[key] for key in SPREAD_KEYS)) if f else None


@dataclass
class Frontier:
    path: str
    held_out: str         # SHA-256 of the shards that it was measured on
    functions: dict       # population → how many
    scenes: list
    points: list
    sentences: dict       # population → its front in words
    tent: dict            # population → mean blend RMSE of the bare tent, which takes no time; None without functions
    tent_by_scene: dict   # scene → the same
    speeds: dict          # representation → word → verdict.Speed


@dataclass
class Case:
    """One case of the stability suite. One that holds may still yield a θ that fails the bake's check."""
    group: str
    name: str
    must_hold: str
    measured: str
    holds: bool
    fails_check: bool = False


@dataclass
class Saving:
    """One thing that a bake left out because the scene does not need it."""
    what: str
    count: int
    of: int
    seconds_saved: object  # None: the bake does not know
    bytes_saved: object
    note: str


def check_schema(node, version):
    if node["schema_version"].count() != version:
        node["schema_version"].refuse(str(version), node["schema_version"].value)


def entries_or_none(node):
    """Of an object that may be empty, or null."""
    return node.entries() if node.value not in ({}, None) else []


def check_quantiles(node):
    p5, median, p95 = (node[f"blend_rmse_{q}"].number() for q in ("p5", "median", "p95"))
    if not p5 <= median <= p95:
        node.refuse("blend_rmse_p5 <= blend_rmse_median <= blend_rmse_p95", f"{p5:g}, {median:g}, {p95:g}")


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
    return Spread(*(node[key].number() for key in SPREAD_KEYS))


def read_figures(node):
    check_quantiles(node)
    if node["us_median"].number() <= 0:
        node["us_median"].refuse("a time above 0", node["us_median"].value)
    return {key: node[key].number() for key in POINT_KEYS}


def read_point(node):
    figures = {population: optional(node["figures"][population], read_figures) for population in POPULATIONS}
    fronts = {population: figures[population] is not None and node["figures"][population]["on_front"].truth() for population in POPULATIONS}
    return Point(node["representation"].text(), node["family"].text(), optional(node["budget"], lambda n: n.number()), node["label"].text(),
                 [word.text() for word in node["words"].items()], figures, fronts, {scene: read_spread(some) for scene, some in entries_or_none(node["by_scene"])})


def read_frontier(path):
    file = read_json(path)
    check_schema(file, SCHEMA_VERSION)
    scenes = [node.text() for node in file["scenes"].items()]
    functions = {population: file["functions"][population].count() for population in POPULATIONS}
    points = [read_point(node) for node in file["points"].items()]
    for index, point in enumerate(points):
        for scene in point.by_scene:
            if scene not in scenes:
                raise InputError(path, f"points[{index}].by_scene", "scenes of the list 'scenes'", f"'{scene}'")
        for population in POPULATIONS:
            if (point.figures[population] is None) != (functions[population] == 0):
                file["points"].refuse(f"figures of '{population}' where it has functions, and only there", f"points[{index}]")
    tent = file["bare_tent"]
    speeds = {name: {word: read_speed(speed) for word, speed in entries_or_none(words)} for name, words in entries_or_none(file["speed_at_equal_error"])}
    return Frontier(path, file["provenance"]["inputs"]["held_out"].text(), functions, scenes, points, {population: file["front_sentences"][population].text() for population in POPULATIONS},
                    {population: optional(tent["figures"][population], lambda n: n["blend_rmse_mean"].number()) for population in POPULATIONS},
                    {scene: node["blend_rmse_mean"].number() for scene, node in entries_or_none(tent["by_scene"])}, speeds)


def check_same_scenes(frontier, summary):
    """A page shows errors and their times side by side: both of the same held-out scenes."""
    expected = summary["provenance"]["inputs"]["held_out"].text()
    if frontier.held_out != expected:
        raise InputError(frontier.path, "provenance.inputs.held_out", f"the held-out scenes of {summary.path}, {expected}", frontier.held_out)


def read_stability(path):
    file = read_json(path)
    check_schema(file, STABILITY_VERSION)
    cases = []
    for node in file["cases"].items():
        if node["group"].text() not in GROUPS:
            node["group"].refuse(" or ".join(GROUPS), f"'{node['group'].value}'")
        cases.append(Case(*(node[key].text() for key in ("group", "name", "must_hold", "measured")), node["holds"].truth(), node["fails_check"].truth()))
    if not cases:
        file["cases"].refuse("at least one case", "none")
    return cases


@dataclass
class Bake:
    """A whole bake: its seconds by the clock, and the error of light that half of its sample points stay below (None: it made no light)."""
    scene: str
    seconds: float
    light_error: object


def read_bake(path):
    file = read_json(path)
    seconds, light = file["wall_seconds"], file["light"]
    return Bake(file["scene"].text(), seconds["load"].number() + seconds["all"].number(), None if light.value is None else light["median_error"].number())


def read_savings(path):
    """(scene, its rows) of one bake's report."""
    file = read_json(path)
    rows = []
    for node in file["savings"].items():
        saved = [node[key].number(low=-1e18) if key in node else None for key in ("seconds_saved", "bytes_saved")]
        rows.append(Saving(node["what"].text(), node["count"].count(), node["of"].count(), *saved, node["note"].text()))
        if rows[-1].count > rows[-1].of:
            node["count"].refuse(f"at most 'of', {rows[-1].of}", rows[-1].count)
    return file["scene"].text(), rows


def setting_words(text):
    """"train.steps: 3000, full 8000" of the workflow as words: "train, steps: 3,000 instead of 8,000"."""
    found = re.fullmatch(r"(\w+)\.(\w+): (.+), full (.+)", text)
    if not found:
        return text
    section, key, value, full = found.groups()

    def plain(some):
        try:
            some = json.loads(some)
        except ValueError:
            return some
        if isinstance(some, list):
            return ", ".join(map(str, some)) or "none"
        return f"{some:,}" if isinstance(some, int) and not isinstance(some, bool) else "the default" if some is None else str(some)
    return f"{section}, {key.replace('_', ' ')}: {plain(value)} instead of {plain(full)}"

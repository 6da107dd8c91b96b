"""light.json of nlg-validate light: read, checked, and summed up over scenes (docs/reference/formats.md). Nothing here draws.

RMSE, jumps and errors are over truth's root mean square, light in the dark over the level's mean; sizes are bytes, times seconds.
"""
import math
import os
from dataclasses import dataclass, field

import numpy as np

from tool.errors import InputError
from tool.input_file import read_json

SCHEMA_VERSION = 1
GROUPS = ("air", "surface", "turned")
GROUP_NAMES = {"air": "in air", "surface": "5–50 cm before surfaces", "turned": "the same, any normal"}
LIGHTS = ("point", "own", "solved")
LEAST_DARK = 30  # places: a scene with fewer says nothing of light in the dark
RESAMPLES, SEED = 4000, 1
NOT_STORED = "target functions"  # whose bytes nobody would keep
THINNED = ", thinned "  # between the name of a grid and what it was thinned to
TEST_BOXES = ("cornell", "two_rooms")
DAYLIGHT = "daylight"
SCENE_KINDS = {"levels": "levels that hold their own light", "furnished": "furnished and thin-walled scenes", "daylight": "rooms beside daylight", "boxes": "test boxes"}


@dataclass
class Worst:
    """A place where a method is far from truth: irradiance of both, error over truth's root mean square in air, and where its picture lies."""
    scene: str
    group: str
    position_m: list
    normal: list
    truth: list
    answer: list
    error: float
    picture: str = ""  # the path of a PNG; empty: none was drawn


@dataclass
class Point:
    """A method in one scene at one spacing."""
    scene: str
    kind: str      # of SCENE_KINDS
    spacing_m: float
    method: tuple  # weights, light
    rmse: dict     # by group
    smape: float
    dark: float
    edge: float
    jump_mean: float
    jump_largest: float
    unlit: float
    outside: float
    bytes: int
    probes: int
    per_probe: float
    seconds: float  # of the bake: weights and light
    dark_places: int = LEAST_DARK
    by_room: dict = field(default_factory=dict)  # by group, the mean over rooms
    by_distance: list = field(default_factory=list)  # (from_m, to_m, RMSE) before surfaces
    worst: list = field(default_factory=list)


def scene_kind(name, holds_light):
    if name.startswith(DAYLIGHT):
        return "daylight"
    return "boxes" if name.startswith(TEST_BOXES) else "levels" if holds_light else "furnished"


def read_vector(node):
    return [float(value) for value in node.numbers(3)]


def read_worst(node, scene):
    picture = os.path.join(os.path.dirname(node.path), node["picture"].text()) if "picture" in node else ""
    return Worst(scene, node["group"].text(), *(read_vector(node[key]) for key in ("position_m", "normal", "truth", "answer")), node["error"].number(), picture)


def read_method(node, scene, kind, spacing_m):
    air, jumps, times, size = node["air"], node["jumps"], node["times"], node["bytes"]
    distances = [(some["from_m"].number(), some["to_m"].number(), some["rmse"].number()) for some in node["surface"]["by_distance"].items()]
    worst = [read_worst(some, scene) for some in node["worst"].items()]
    return Point(scene, kind, spacing_m, (node["weights"].text(), node["light"].text()), {group: node[group]["rmse"].number() for group in GROUPS},
                 air["smape"].number(0.0, 1.0), *(node[key]["excess"].number(low=-math.inf) for key in ("dark", "edge")), jumps["mean"].number(),
                 jumps["largest"].number(), air["unlit"].number(0.0, 1.0), air["outside"].number(0.0, 1.0), size["total"].count(), node["probes"].count(),
                 size["per_probe"].number(), times["weights_s"].number() + times["light_s"].number(),
                 node["dark"]["places"].count(), {group: node[group]["balanced"]["rmse"].number() for group in GROUPS}, distances, worst)


def read_points(path):
    result = read_json(path)
    if result["schema_version"].number() != SCHEMA_VERSION:
        result["schema_version"].refuse(str(SCHEMA_VERSION), str(result["schema_version"].value))
    scene, holds_light = result["scene"].text(), result["truth"]["all_bounces_in_one_ray"]
    kind = scene_kind(scene, holds_light.truth())
    points = []
    for spacing in result["spacings"].items():
        for method in spacing["methods"].items():
            if method["light"].text() not in LIGHTS:
                method["light"].refuse(" or ".join(LIGHTS), f"'{method['light'].value}'")
            points.append(read_method(method, scene, kind, spacing["spacing_m"].number()))
    if not points:
        result["spacings"].refuse("at least one method", "none")
    return points


def read_all(paths):
    """The points of several scenes, each of which is named by one file alone."""
    points, seen = [], {}
    for path in paths:
        of_path = read_points(path)
        for scene in {point.scene for point in of_path}:
            if scene in seen:
                raise InputError(path, "scene", "one file per scene", f"'{scene}', which {seen[scene]} holds too")
            seen[scene] = path
        points += of_path
    return points


def interval(values, reduce):
    """The 95 % interval of a figure over scenes, by bootstrap; None with fewer than three scenes. reduce takes an axis, as NumPy's own do."""
    if len(values) < 3:
        return None
    values = np.asarray(values)
    drawn = np.random.default_rng(SEED).integers(0, len(values), (RESAMPLES, len(values)))
    low, high = np.percentile(reduce(values[drawn], axis=1), (2.5, 97.5))
    return [float(low), float(high)]


def figure(values, reduce=np.mean):
    return {"mean": float(reduce(np.asarray(values))), "interval": interval(values, reduce)}


def geometric_mean(values, axis=None):
    return np.exp(np.mean(np.log(values), axis=axis))


def ratios_to(points, references, group, error=lambda point, group: point.rmse[group]):
    """RMSE over the reference's, scene by scene, where both have one; references: scene → point."""
    found = [(error(point, group), error(references[point.scene], group)) for point in points if point.scene in references]
    return [ours / theirs for ours, theirs in found if ours > 0.0 and theirs > 0.0]


def in_the_dark(points):
    """Light in the dark, of those that have enough dark places; of all where none has."""
    return [point.dark for point in points if point.dark_places >= LEAST_DARK] or [point.dark for point in points]


def of_method(points, method):
    return [point for point in points if point.method == method]


def methods_of(points):
    """In the order in which they were measured."""
    return list(dict.fromkeys(point.method for point in points))


def spacings_of(points):
    return sorted({point.spacing_m for point in points})


"""The files that the report is drawn from: read, checked, and refused in one line that names file, place, expected and got.

docs/reference/formats.md says what stands in them. Nothing here draws or decides.
"""
import math
import os
from dataclasses import dataclass

import numpy as np

from tool.errors import InputError
from tool.input_file import Node, parse_number, read_columns, read_json

# the four words of every table: what a function is, stage by stage, on its way into the grid; in this order everywhere
WORDS = ("network", "corrected", "fitted", "stored")
# what stands beside them, on the functions of the sample only; best known: the lowest error that any long fit found
FITS = ("direct", "best_known")
POPULATIONS = ("theta", "hard", "all")  # the main one first: functions that take a theta
SCHEMA_VERSION = 2
PRECISIONS = ("float32", "float16", "int8")  # that θ may be stored in
QUANTILES = ("median", "mean", "p95", "p99", "worst")
INTERVALS = ("median", "mean", "p95")   # the quantiles that have one
ERRORS = ("blend_rmse", "rmse")  # over support points; the first is the root of the loss, by which things are judged
RATIOS = ("median", "median_hard")  # of blend RMSEs over the best known, function by function
SLICE_NAMES = ("p5", "median", "p95", "worst")


# ---- what the files hold -----------------------------------------------------------------------------------------------


@dataclass
class Samples:
    """One word's errors, one entry a function; rmse_occluded is NaN where the probe sees all valid points."""
    function: np.ndarray
    scene: np.ndarray
    takes_theta: np.ndarray
    hard: np.ndarray
    blend_rmse: np.ndarray
    rmse: np.ndarray
    rmse_test_points: np.ndarray
    rmse_occluded: np.ndarray
    leak_mean: np.ndarray
    leak_p99: np.ndarray
    fails_check: np.ndarray
    fitted: np.ndarray
    elapsed_us: np.ndarray

    def __len__(self):
        return len(self.function)

    def only(self, mask):
        return Samples(*(getattr(self, name)[mask] for name in self.__dataclass_fields__))

    def of(self, population):
        return self if population == "all" else self.only(self.takes_theta if population == "theta" else self.hard)


@dataclass
class Log:
    step: np.ndarray
    training_loss: np.ndarray
    held_out_network: np.ndarray  # blend RMSE before corrections
    held_out: np.ndarray          # after them


@dataclass
class Slice:
    representation: str
    which: str
    function: int
    scene: str
    blend_rmse: float
    rmse: float
    axis: int
    target: np.ndarray        # size x size, phi at the support point nearest to each pixel
    stored: np.ndarray        # size x size
    difference: np.ndarray    # size x size, at the support point nearest to each pixel
    valid: np.ndarray         # size x size, bool
    seen: np.ndarray          # size x size, bool: in plain sight of the probe


@dataclass
class Inputs:
    summary: Node
    representations: list     # names in the order of the summary
    samples: dict             # (representation, word or fit) → Samples; the bare tent is ("tent", "tent")
    slices: list
    logs: dict                # representation → Log
    paths: dict               # role → path

    def over(self, representation, word, population="theta"):
        """The errors of one word over a population of all held-out functions."""
        return self.samples[("tent", "tent") if word == "tent" else (representation, word)].of(population)

    def sampled(self, representation, word, population="theta"):
        """The same over the functions of the sample, those that long fits ran on."""
        some = self.over(representation, word, population)
        return some.only(np.isin(some.function, self.samples[representation, "best_known"].function))


FUNCTION_COLUMNS = ("representation", "word", "function", "scene", "take_theta", "hard", "blend_rmse", "rmse", "rmse_test_points",
                    "rmse_occluded", "leak_mean", "leak_p99", "fails_check", "fitted", "elapsed_us")


def read_functions(path, representations):
    groups = {}
    for line, row in read_columns(path, FUNCTION_COLUMNS):
        number = lambda column, empty=None: parse_number(path, line, column, row[FUNCTION_COLUMNS.index(column)], empty)
        groups.setdefault((row[0], row[1]), []).append(
            (int(number("function")), row[3], number("take_theta") == 1, number("hard") == 1, number("blend_rmse"), number("rmse"),
             number("rmse_test_points", math.nan), number("rmse_occluded", math.nan), number("leak_mean"), number("leak_p99"), number("fails_check") == 1, number("fitted") == 1, number("elapsed_us")))
    expected = [("tent", "tent")] + [(r, w) for r in representations for w in WORDS + FITS]
    for key in expected:
        if key not in groups:
            raise InputError(path, "columns representation, word", f"rows of '{key[0]}', '{key[1]}'", "none")
    for key in groups:
        if key not in expected:
            raise InputError(path, "columns representation, word", "those of the summary", f"'{key[0]}', '{key[1]}'")
    return {key: Samples(*(np.array(column) for column in zip(*rows))) for key, rows in groups.items()}


LOG_COLUMNS = ("step", "learning_rate", "training_loss", "held_out_network_blend_rmse", "held_out_blend_rmse", "bare_tent_blend_rmse", "rollbacks")


def read_log(path):
    rows = [[parse_number(path, line, c, text) for c, text in zip(LOG_COLUMNS, row)] for line, row in read_columns(path, LOG_COLUMNS)]
    columns = dict(zip(LOG_COLUMNS, np.array(rows).T))
    return Log(columns["step"], columns["training_loss"], columns["held_out_network_blend_rmse"], columns["held_out_blend_rmse"])


def read_logs(paths, representations):
    """A log belongs to the representation that its file is named after."""
    logs = {}
    for path in paths:
        name = os.path.splitext(os.path.basename(path))[0]
        if name not in representations:
            raise InputError(path, "file name", " or ".join(f"{r}.csv" for r in representations), os.path.basename(path))
        logs[name] = read_log(path)
    for name in representations:
        if name not in logs:
            raise InputError("--logs", "list of files", f"{name}.csv", "none of that name")
    return logs


def read_slices(path, representations):
    slices = []
    for node in read_json(path).items():
        size = int(node["size"].number(1, 4096))
        picture = lambda key, low, high: np.array(node[key].numbers(size * size, low, high), dtype=float).reshape(size, size)
        axis = node["axis"].count()
        if axis > 2:
            node["axis"].refuse("0, 1 or 2", axis)
        slices.append(Slice(node["representation"].text(), node["which"].text(), node["function"].count(), node["scene"].text(),
                            node["blend_rmse"].number(), node["rmse"].number(), axis, picture("target_permille", 0, 1000) / 1000,
                            picture("stored_permille", -2000, 2000) / 1000,
                            picture("difference_permille", -2000, 2000) / 1000, picture("valid", 0, 1) > 0, picture("seen", 0, 1) > 0))
    found = {(s.representation, s.which) for s in slices}
    for name in representations:
        for which in SLICE_NAMES:
            if (name, which) not in found:
                raise InputError(path, "list of slices", f"'{which}' of '{name}'", "none")
    return [s for s in slices if s.representation in representations]


def interval_of(node):
    """(low, high) of a list of two numbers."""
    low, high = node.numbers(2)
    if low > high:
        node.refuse("[low, high]", f"[{low:g}, {high:g}]")
    return low, high


def check_quantiles(node):
    """What stands in a list of no function is not read."""
    if node["functions"].count() == 0:
        return
    [node[q].number() for q in QUANTILES]
    [interval_of(node["interval"][q]) for q in INTERVALS]


def check_estimate(node, high):
    [node[key].number(high=high) for key in ("value", "low", "high")]


def check_figures(node):
    if node["functions"].count() == 0:
        return
    [check_quantiles(node[key]) for key in (*ERRORS, "rmse_test_points", "rmse_occluded")]
    [node["leak"][key].number() for key in ("mean", "p99")]
    [check_estimate(node[key], 1.0) for key in ("share_failing_check", "share_fitted")]
    node["us_per_function"].number()


def check_populations(node):
    [check_figures(node[population]) for population in POPULATIONS]


def check_sample(sample):
    sample["functions"].number(1), sample["hard"].count()
    [check_populations(sample[word]) for word in WORDS + FITS]
    for word in WORDS:
        for key in RATIOS:
            ratio = sample["ratios"][word]["to_best_known"][key]
            if ratio["value"].value:  # 0 or null: no function stands behind it
                check_estimate(ratio, math.inf)


def check_stage(stage):
    [stage[key].text() for key in ("title", "takes")]
    if stage["word"].text() not in WORDS:
        stage["word"].refuse(" or ".join(WORDS), f"'{stage['word'].value}'")
    if stage["budget"].value is not None:
        stage["budget"].text()


def check_representation(node):
    [node[key].count() for key in ("parameters", "weights_bytes")]
    [node["theta_bytes"][precision].count() for precision in PRECISIONS]
    node["weights_sha256"].text(), node["evaluate_us"].number()
    [check_stage(stage) for stage in node["stages"].items()]
    [check_populations(node[word]) for word in WORDS]
    check_sample(node["sample"])


def check_summary(summary):
    """Every figure that the report quotes is there and is a number, so that nothing is missed half-way."""
    if summary["schema_version"].count() != SCHEMA_VERSION:
        summary["schema_version"].refuse(str(SCHEMA_VERSION), summary["schema_version"].value)
    for key in ("distinct", "free_space", "duplicates", "in_solid", "empty", "visited_probes", "grid_probes", "held_out",
                "held_out_scenes", "take_theta", "hard", "held_out_in_training", "held_out_in_training_mirrored"):
        summary["functions"][key].count()
    for key in ("rmse", "blend", "leak", "dark_weight", "blend_floor", "hard_tent_rmse", "bare_tent_rmse"):
        summary["tau"][key].number()
    if summary["theta_precision"].text() not in PRECISIONS:
        summary["theta_precision"].refuse(" or ".join(PRECISIONS), f"'{summary['theta_precision'].value}'")
    check_populations(summary["tent"])
    [check_representation(node) for _, node in summary["representations"].entries()]
    origin = summary["provenance"]
    origin["tool"].text(), origin["revision"].text(), [node.text() for _, node in origin["inputs"].entries()]
    origin["options"].entries()


def read_summary(path):
    summary = read_json(path)
    check_summary(summary)
    return summary


def check_counts(functions_path, samples, summary):
    """As many rows of each representation and word as the summary counts functions."""
    for (name, word), some in samples.items():
        node = summary["tent"] if name == "tent" else summary["representations"][name]
        node = node if name == "tent" else node["sample"][word] if word in FITS else node[word]
        for population in POPULATIONS:
            expected = node[population]["functions"].count()
            if len(some.of(population)) != expected:
                raise InputError(functions_path, f"rows of '{name}', '{word}', population '{population}'", f"{expected} as in the summary", str(len(some.of(population))))


def read_inputs(summary_path, functions_path, slices_path, log_paths):
    summary = read_summary(summary_path)
    representations = [name for name, _ in summary["representations"].entries()]
    logs = read_logs(log_paths, representations)
    samples = read_functions(functions_path, representations)
    check_counts(functions_path, samples, summary)
    paths = {"summary": summary_path, "functions": functions_path, "slices": slices_path}
    paths.update({f"log {os.path.basename(p)}": p for p in log_paths})
    return Inputs(summary, representations, samples, read_slices(slices_path, representations), logs, paths)

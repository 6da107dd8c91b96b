"""The files that the report is drawn from: read, checked, and refused in one line that names file, place, expected and got.

docs/reference/formats.md says what stands in them. Nothing here draws or decides.
"""
import csv
import hashlib
import json
import math
import os
import sys
from dataclasses import dataclass
from pathlib import Path

import numpy as np

sys.path.append(str(Path(__file__).resolve().parents[2] / "tool"))
from regular_file import regular


# the four words of every table: what a function is, stage by stage, on its way into the grid; in this order everywhere
WORDS = ("network", "corrected", "fitted", "stored")
# what stands beside them, on the functions of the sample only; best known: the lowest error that any long fit found
FITS = ("adam_theta0", "lm_theta0", "adam_random", "direct", "best_known")
POPULATIONS = ("theta", "hard", "all")  # the main one first: functions that take a theta
SCHEMA_VERSION = 2
QUANTILES = ("median", "mean", "p95", "p99", "worst")
INTERVALS = ("median", "mean", "p95")   # the quantiles that have one
RATIOS = ("median", "median_hard", "median_test_points", "median_occluded_hard")
REFERENCES = ("to_best_known", "to_direct", "without_duplicates")
SLICE_NAMES = ("best", "median", "p95", "worst")
MAX_FILE_BYTES = 1 << 30


class InputError(Exception):
    """A file that cannot be used: the Python side of nlg::InputError (tool/error.h)."""

    def __init__(self, path, place, expected, got):
        super().__init__(f"{path}: {place}: expected {expected}, got {got}")


def read_bytes(path):
    try:
        with open(path, "rb", opener=regular) as file:
            data = file.read(MAX_FILE_BYTES + 1)
    except OSError as error:
        raise InputError(path, "file", "a readable file", error.strerror) from None
    if len(data) > MAX_FILE_BYTES:
        raise InputError(path, "file", "at most 1 GiB", "more")
    return data


def read_text(path):
    try:
        return read_bytes(path).decode("utf-8")
    except UnicodeDecodeError as error:
        raise InputError(path, f"byte {error.start}", "UTF-8", "other bytes") from None


def sha256(path):
    return hashlib.sha256(read_bytes(path)).hexdigest()


class Node:
    """A value inside a JSON file that remembers where it stands."""

    def __init__(self, path, place, value):
        self.path, self.place, self.value = path, place, value

    def refuse(self, expected, got):
        raise InputError(self.path, self.place or "top level", expected, got)

    def __getitem__(self, key):
        if not isinstance(self.value, dict):
            self.refuse("an object", type(self.value).__name__)
        if key not in self.value:
            self.refuse(f"a key '{key}'", "none")
        return Node(self.path, f"{self.place}.{key}" if self.place else key, self.value[key])

    def entries(self):
        if not isinstance(self.value, dict) or not self.value:
            self.refuse("an object with keys", "another value or none")
        return [(key, self[key]) for key in self.value]

    def items(self):
        if not isinstance(self.value, list):
            self.refuse("a list", type(self.value).__name__)
        return [Node(self.path, f"{self.place}[{i}]", value) for i, value in enumerate(self.value)]

    def text(self):
        if not isinstance(self.value, str):
            self.refuse("a text", repr(self.value)[:40])
        return self.value

    def number(self, low=0.0, high=math.inf):
        value = self.value
        if isinstance(value, bool) or not isinstance(value, (int, float)) or not low <= value <= high:
            wanted = f"a number from {low:g} to {high:g}" if high < math.inf else f"a number of at least {low:g}"
            self.refuse(wanted, repr(value)[:40])
        return float(value)

    def count(self):
        value = self.number()
        if value != int(value):
            self.refuse("a whole number", repr(self.value)[:40])
        return int(value)

    def numbers(self, length=None, low=-math.inf, high=math.inf):
        try:
            array = np.array(self.value, dtype=float)
        except (TypeError, ValueError):
            self.refuse("a list of numbers", "other values in it")
        if array.ndim != 1 or (length is not None and len(array) != length):
            self.refuse(f"a list of {length} numbers" if length else "a list of numbers", f"shape {array.shape}")
        if not np.all((array >= low) & (array <= high)):
            self.refuse(f"numbers from {low:g} to {high:g}", "others in it")
        return array


def read_json(path):
    def refuse_constant(name):
        raise InputError(path, "JSON", "finite numbers", name)

    try:
        return Node(path, "", json.loads(read_text(path), parse_constant=refuse_constant))
    except json.JSONDecodeError as error:
        raise InputError(path, f"line {error.lineno}, column {error.colno}", "whole JSON", error.msg) from None
    except RecursionError:
        raise InputError(path, "JSON", "an object", "brackets nested too deeply") from None


def read_columns(path, columns):
    """Rows of a CSV file with exactly these columns, as texts; every row with its line number."""
    rows = csv.reader(read_text(path).splitlines())
    header = next(rows, [])
    if header != list(columns):
        raise InputError(path, "line 1", ",".join(columns), ",".join(header)[:120] or "nothing")
    result = []
    for row in rows:
        if len(row) != len(columns):
            raise InputError(path, f"line {rows.line_num}", f"{len(columns)} values", str(len(row)))
        result.append((rows.line_num, row))
    if not result:
        raise InputError(path, "line 2", "at least one row", "none")
    return result


def parse_number(path, line, column, text, empty=None):
    if text == "" and empty is not None:
        return empty
    try:
        value = float(text)
    except ValueError:
        value = math.nan
    if not math.isfinite(value):
        raise InputError(path, f"line {line}, column {column}", "a finite number", f"'{text[:40]}'")
    return value


# ---- what the files hold -----------------------------------------------------------------------------------------------


@dataclass
class Samples:
    """One word's errors, one entry a function; rmse_occluded is NaN where the probe sees all valid points."""
    function: np.ndarray
    scene: np.ndarray
    takes_theta: np.ndarray
    hard: np.ndarray
    rmse: np.ndarray
    rmse_test_points: np.ndarray
    rmse_occluded: np.ndarray
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
    held_out_network: np.ndarray  # before corrections
    held_out_rmse: np.ndarray       # after them


@dataclass
class Slice:
    representation: str
    which: str
    function: int
    scene: str
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
    basis: Node
    logs: dict                # representation → Log
    paths: dict               # role → path

    def over(self, representation, word, population="theta"):
        """The errors of one word over a population of all held-out functions."""
        return self.samples[("tent", "tent") if word == "tent" else (representation, word)].of(population)

    def sampled(self, representation, word, population="theta"):
        """The same over the functions of the sample, those that long fits ran on."""
        some = self.over(representation, word, population)
        return some.only(np.isin(some.function, self.samples[representation, "best_known"].function))


FUNCTION_COLUMNS = ("representation", "word", "function", "scene", "take_theta", "hard", "rmse", "rmse_test_points", "rmse_occluded",
                    "leak_mean", "leak_p99", "fails_check", "fitted", "elapsed_us")


def read_functions(path, representations):
    groups = {}
    for line, row in read_columns(path, FUNCTION_COLUMNS):
        number = lambda column, empty=None: parse_number(path, line, column, row[FUNCTION_COLUMNS.index(column)], empty)
        groups.setdefault((row[0], row[1]), []).append(
            (int(number("function")), row[3], number("take_theta") == 1, number("hard") == 1, number("rmse"), number("rmse_test_points", math.nan),
             number("rmse_occluded", math.nan), number("leak_p99"), number("fails_check") == 1, number("fitted") == 1, number("elapsed_us")))
    expected = [("tent", "tent")] + [(r, w) for r in representations for w in WORDS + FITS]
    for key in expected:
        if key not in groups:
            raise InputError(path, "columns representation, word", f"rows of '{key[0]}', '{key[1]}'", "none")
    for key in groups:
        if key not in expected:
            raise InputError(path, "columns representation, word", "those of the summary", f"'{key[0]}', '{key[1]}'")
    return {key: Samples(*(np.array(column) for column in zip(*rows))) for key, rows in groups.items()}


LOG_COLUMNS = ("step", "learning_rate", "training_loss", "held_out_network", "held_out_rmse", "rollbacks")


def read_log(path):
    rows = [[parse_number(path, line, c, text) for c, text in zip(LOG_COLUMNS, row)] for line, row in read_columns(path, LOG_COLUMNS)]
    columns = dict(zip(LOG_COLUMNS, np.array(rows).T))
    return Log(columns["step"], columns["training_loss"], columns["held_out_network"], columns["held_out_rmse"])


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
        picture = lambda key, low, high: node[key].numbers(size * size, low, high).reshape(size, size)
        axis = node["axis"].count()
        if axis > 2:
            node["axis"].refuse("0, 1 or 2", axis)
        slices.append(Slice(node["representation"].text(), node["which"].text(), node["function"].count(), node["scene"].text(),
                            node["rmse"].number(), axis, picture("target_permille", 0, 1000) / 1000,
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


def check_quantiles(node, has_intervals=True):
    """What stands in a list of no function is not read."""
    if node["functions"].count() == 0:
        return
    [node[q].number() for q in QUANTILES]
    if has_intervals:
        [interval_of(node["interval"][q]) for q in INTERVALS]


def check_estimate(node, high):
    [node[key].number(high=high) for key in ("value", "low", "high")]


def check_figures(node):
    if node["functions"].count() == 0:
        return
    [check_quantiles(node[key]) for key in ("rmse", "rmse_test_points", "rmse_occluded")]
    [node["leak"][key].number() for key in ("mean", "p99")]
    [check_estimate(node[key], 1.0) for key in ("share_failing_check", "share_fitted")]
    node["us_per_function"].number(), node["us_per_function_median"].number()


def check_populations(node):
    [check_figures(node[population]) for population in POPULATIONS]


def check_sample(sample):
    sample["functions"].number(1), sample["hard"].count()
    [check_populations(sample[word]) for word in WORDS + FITS]
    for word in WORDS:
        for reference in REFERENCES:
            for key in RATIOS:
                ratio = sample["ratios"][word][reference][key]
                if ratio["value"].value:  # 0 or null: no function stands behind it
                    check_estimate(ratio, math.inf)


def check_stage(stage):
    [stage[key].text() for key in ("name", "population", "text")]
    if stage["word"].text() not in WORDS:
        stage["word"].refuse(" or ".join(WORDS), f"'{stage['word'].value}'")
    if stage["above_rmse"].value is not None:
        stage["above_rmse"].number()
    if not isinstance(stage["budget"].value, (int, float, str, type(None))):
        stage["budget"].refuse("a number, a text or null", type(stage["budget"].value).__name__)


def check_representation(node):
    [node[key].count() for key in ("parameters", "bytes", "weights_bytes", "correction_steps")]
    node["weights_sha256"].text(), node["evaluate_us"].number()
    [check_stage(stage) for stage in node["stages"].items()]
    [check_populations(node[word]) for word in WORDS]
    check_sample(node["sample"])
    for _, scene in node["by_scene"].entries():
        [check_quantiles(scene[word], has_intervals=False) for word in ("stored", "network")]


def check_summary(summary):
    """Every figure that the report quotes is there and is a number, so that nothing is missed half-way."""
    if summary["schema_version"].count() != SCHEMA_VERSION:
        summary["schema_version"].refuse(str(SCHEMA_VERSION), summary["schema_version"].value)
    for key in ("distinct", "free_space", "duplicates", "in_solid", "empty", "visited_probes", "grid_probes", "held_out",
                "held_out_scenes", "take_theta", "hard", "held_out_in_training", "held_out_in_training_mirrored"):
        summary["functions"][key].count()
    for key in ("rmse", "leak", "leak_share", "hard_tent_rmse", "bare_tent_rmse"):
        summary["tau"][key].number()
    check_populations(summary["tent"])
    [check_representation(node) for _, node in summary["representations"].entries()]
    origin = summary["provenance"]
    origin["tool"].text(), origin["revision"].text(), [node.text() for _, node in origin["inputs"].entries()]
    origin["options"].entries()


def read_summary(path):
    summary = read_json(path)
    check_summary(summary)
    return summary


def check_basis(basis):
    basis["functions"].count(), basis["components"].count()
    basis["spectrum"].numbers(low=0.0)
    for name, kept in basis["held_out_variance_kept"].entries():
        if not name.isdigit():
            kept.refuse("a count of components as its name", f"'{name[:40]}'")
        kept.number(high=1.0 + 1e-9)


def read_inputs(summary_path, functions_path, slices_path, basis_path, log_paths):
    summary = read_summary(summary_path)
    representations = [name for name, _ in summary["representations"].entries()]
    basis = read_json(basis_path)
    check_basis(basis)
    logs = read_logs(log_paths, representations)
    samples = read_functions(functions_path, representations)
    for (name, word), some in samples.items():
        node = summary["tent"] if name == "tent" else summary["representations"][name]
        node = node if name == "tent" else node["sample"][word] if word in FITS else node[word]
        for population in POPULATIONS:
            expected = node[population]["functions"].count()
            if len(some.of(population)) != expected:
                raise InputError(functions_path, f"rows of '{name}', '{word}', population '{population}'", f"{expected} as in the summary", str(len(some.of(population))))
    paths = {"summary": summary_path, "functions": functions_path, "slices": slices_path, "basis": basis_path}
    paths.update({f"log {os.path.basename(p)}": p for p in log_paths})
    return Inputs(summary, representations, samples, read_slices(slices_path, representations), basis, logs, paths)

"""Numbers of docs/results/ in running text. Read by results.py.

A text quotes a number by a pair of comments, which Markdown does not show; results.py writes what stands between them:

    <!--=tent_mlp.stored.theta.rmse.mean-->.0024<!---->

The key is a way through docs/results/openarena.json, or through docs/results/NAME.json after "NAME@". It begins at the file's root, at its evaluation
or at the evaluation's representations, whichever has it. Two keys with " / " between them give the ratio. After a colon stands how the value is
written, where its name does not say: .1 to .6 digits, %, int, us, text; with ":interval" the value with its 95 % interval.
"""
import re
import sys
from pathlib import Path

sys.path.insert(0, str(Path(__file__).resolve().parents[1]))  # tool/, which all scripts share
from tool.input_file import read_json

MAIN = "openarena"
PENDING = "pending"
NOTHING = "–"  # measured, and there is no such number
MISSING = object()
MARKER = re.compile(r"(?<!`)<!--=([^\n]*?)-->([^\n]*?)<!---->")


class UnknownKey(KeyError):
    """A text quotes what no results file holds."""


def number(value, digits=4):
    """.0123, as everywhere in the documentation."""
    text = f"{value:,.{digits}f}"
    return re.sub(r"^(-?)0\.", r"\1.", text) if digits else text


def percent(share):
    return f"{100 * share:.2g} %" if share < 0.995 else f"{100 * share:.0f} %"


def microseconds(value):
    return f"{value:,.0f}" if value >= 10 else f"{value:.1f}"


def load_results(folder):
    """NAME → its results."""
    return {path.stem: read_json(path).value for path in sorted(folder.glob("*.json"))}


def descend(node, steps):
    """The value at the end of a way of keys, or MISSING."""
    for step in steps:
        if isinstance(node, list) and step.isdigit() and int(step) < len(node):
            node = node[int(step)]
        elif isinstance(node, dict) and step in node:
            node = node[step]
        else:
            return MISSING
    return node


def find(all_results, key):
    """The value that a key leads to (that of a dict is its "value"), and its interval; UnknownKey where it leads nowhere.

    PENDING before anything was measured, NOTHING where the results say null.
    """
    name, _, way = key.rpartition("@")
    results = all_results.get(name or MAIN)
    if results is None:
        raise UnknownKey(key)
    steps = way.split(".")
    for start in ([], ["evaluation"], ["evaluation", "representations"]):
        node = descend(results, start + steps)
        if isinstance(node, dict) and "value" in node:
            return node["value"], [node["low"], node["high"]]
        if node is not MISSING and not isinstance(node, (dict, list)):
            interval = descend(results, [*start, *steps[:-1], "interval", steps[-1]])
            return NOTHING if node is None else node, None if interval is MISSING else interval
    if results.get("pending"):
        return PENDING, None
    raise UnknownKey(key)


def default_style(key, value):
    """How a value is written, by what its key calls it."""
    names = key.split(".")
    if isinstance(value, str):
        return "text"
    if any("share" in name for name in names):
        return "%"
    if any(name == "us" or name.startswith("us_") or name.endswith("_us") for name in names):
        return "us"
    if "ratios" in names or "ratio" in names:
        return ".2"
    if isinstance(value, int):
        return "int"
    if any("rmse" in name or name == "leak" for name in names):
        return ".4"
    return ".3"


def written(value, style):
    if style == "text":
        return str(value)
    if style == "%":
        return percent(value)
    if style == "us":
        return microseconds(value)
    if style == "int":
        return f"{value:,.0f}"
    if re.fullmatch(r"\.[0-6]", style):
        return number(value, int(style[1:]))
    raise UnknownKey(f"the style {style!r}")


def quote(all_results, spec):
    """The text that belongs between the comments of a marker."""
    keys, _, style = spec.strip().partition(":")
    found = [find(all_results, key.strip()) for key in keys.split(" / ")]
    values = [value for value, _ in found]
    for word in (PENDING, NOTHING):
        if word in values:
            return word
    if len(values) == 2:
        return written(values[0] / values[1], style or ".2")
    value, interval = found[0]
    with_interval = style == "interval"
    style = default_style(keys, value) if style in ("", "interval") else style
    text = written(value, style)
    if with_interval:
        if interval is None:
            raise UnknownKey(f"{keys}: its interval")
        low, high = (bound if bound is None else written(bound, style) for bound in interval)
        text += f" ({low} or more)" if high is None else f" ({low} to {high})"
    return text


def fill(text, all_results, problems, place):
    """The text with every quoted number as the results have it; adds a line to problems for each that is another, and each key that is none."""
    def replace(match):
        line = text.count("\n", 0, match.start()) + 1
        try:
            expected = quote(all_results, match[1])
        except UnknownKey as error:
            problems.append((f"{place}:{line}: {match[1]}: expected a key of docs/results, got {error.args[0]}", True))
            return match[0]
        if expected != match[2]:
            problems.append((f"{place}:{line}: {match[1]}: expected {expected}, got {match[2]}", False))
        return f"<!--={match[1]}-->{expected}<!---->"
    return MARKER.sub(replace, text)

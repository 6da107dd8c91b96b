"""Numbers of docs/results/ in running text. Read by results.py.

docs/figures/quotes.json says which phrase of which page holds which numbers:

    {"README.md": {"fits {} of all functions": ["tent_mlp.stored.all.share_fitted:%"]}}

Each {} is a number: the key leads to it, and the style behind the colon says how it is written (.0 to .6 digits, %, int, us). A key is a way through
docs/results/openarena.json, or through docs/results/NAME.json after "NAME@". It begins at the file's root, at its evaluation or at the evaluation's
representations, whichever has it. Two keys with " / " between them give the ratio.
"""
import re
import sys
from pathlib import Path

sys.path.insert(0, str(Path(__file__).resolve().parents[2]))  # tool/, which all scripts share
from tool.input_file import read_json

MAIN = "openarena"
WRITTEN = r"(-?[\d.,]*\d(?: %)?)"  # what stands in a {}, right or wrong


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


def made_by(results, revisions):
    """Command, revision and date of a results file, for the head of its page; results of before 30 November 2026 have no date."""
    of_revision = f" at revision {', '.join(f'`{revision}`' for revision in revisions)}" if revisions else ""
    return f"Made by `{results['command']}`{of_revision}" + (f" on {results['date']}" if "date" in results else "")


def load_results(folder):
    """NAME → its results."""
    return {path.stem: read_json(path).value for path in sorted(folder.glob("*.json"))}


def descend(node, steps):
    """The value at the end of a way of keys, or None."""
    for step in steps:
        node = node.get(step) if isinstance(node, dict) else None
    return node


def find(all_results, key):
    """The number that a key leads to (that of a dict is its "value"); UnknownKey where it leads to none."""
    name, _, way = key.rpartition("@")
    results = all_results.get(name or MAIN, {})
    for start in ([], ["evaluation"], ["evaluation", "representations"]):
        node = descend(results, start + way.split("."))
        node = node.get("value") if isinstance(node, dict) else node
        if isinstance(node, (int, float)):
            return node
    raise UnknownKey(key)


def quote(all_results, spec):
    """The text of a number: KEY:STYLE, or KEY / KEY:STYLE."""
    keys, _, style = spec.rpartition(":")
    values = [find(all_results, key) for key in keys.split(" / ")]
    value = values[0] / values[1] if len(values) == 2 else values[0]
    styles = {"%": percent, "us": microseconds, "int": lambda number_of: f"{number_of:,.0f}"}
    if style in styles:
        return styles[style](value)
    if re.fullmatch(r"\.[0-6]", style):
        return number(value, int(style[1:]))
    raise UnknownKey(f"{spec}: the style {style!r}")


def fill(text, phrases, all_results, problems, place):
    """The text with every quoted number as the results have it; adds a line to problems for each phrase that says something else or is not there.

    phrases   phrase → its numbers, as quotes.json has them of this page
    problems  lines, each with whether it is the key that is wrong
    """
    for phrase, specs in phrases.items():
        parts = phrase.split("{}")
        try:
            numbers = [quote(all_results, spec) for spec in specs]
        except UnknownKey as error:
            problems.append((f"{place}: {phrase!r}: expected a key of docs/results, got {error.args[0]}", True))
            continue
        expected = "".join(part + found for part, found in zip(parts, [*numbers, ""]))
        matches = list(re.finditer(WRITTEN.join(map(re.escape, parts)), text))
        if len(matches) != 1 or len(parts) != len(numbers) + 1:
            problems.append((f"{place}: expected {phrase!r} once, with {len(numbers)} numbers, got it {len(matches)} times", True))
        elif matches[0][0] != expected:
            problems.append((f"{place}: expected {expected!r}, got {matches[0][0]!r}", False))
            text = text[:matches[0].start()] + expected + text[matches[0].end():]
    return text

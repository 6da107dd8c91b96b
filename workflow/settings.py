#!/usr/bin/env python3
"""The settings of a configuration, a row each. From the rows configurations are judged, and docs/reference/settings.md is written.

    settings.py BIN [--check]

The rows of the workflow's own settings stand below. Those of the tools are asked of the tools in BIN (nlg-TOOL --list-options) and kept
in settings.json: a configuration is judged before anything is built. Without --check both files are written. With it nothing is: it fails
where one of them is out of date, where a tool's --help has more than a dozen options, and where pipeline.yaml or one of configs/ holds what
no tool knows.
"""
import json
import re
import subprocess
import sys
from difflib import get_close_matches
from pathlib import Path

sys.path.insert(0, str(Path(__file__).resolve().parents[1]))  # tool/, which all scripts share
from tool.atomic_file import write_files
from tool.errors import CHECK_FAILED, UsageError, run
from plain_yaml import ConfigurationError, read, require

ROOT = Path(__file__).resolve().parents[1]
TABLE, PAGE = ROOT / "workflow/settings.json", ROOT / "docs/reference/settings.md"
TOOLS = ["nlg-datagen", "nlg-pca", "nlg-train", "nlg-export", "nlg-bake", "nlg-validate", "nlg-validate frontier", "nlg-validate light"]
# tools without settings of their own, whose --help is counted too
OTHER_TOOLS = ["nlg-cache", "nlg-view", "nlg-render", "nlg-render irradiance", "nlg-datagen plan", "nlg-datagen geometry",
               "nlg-validate views", "nlg-validate stability", "nlg-export shader", "nlg-export engine", "nlg-export onnx"]
MOST_IN_HELP = 12

FAMILIES = ["house", "maze", "colonnade", "stairs", "clutter", "outdoor", "cave", "kitchen", "gallery", "meeting"]
REPRESENTATIONS = ["mlp", "tent_mlp", "tent_mlp44", "tent_mlp4", "pf3", "pf5", "pf7", "pf9", "code16", "code32", "code48", "code64", "code128"]
MAX_SHARDS = 1000000


def own(section, name, kind, help_text, **more):
    """A row of the workflow's own. Without a default it must be there; a default of None says itself in the help what it is."""
    return {"section": section, "name": name, "type": kind, **more, "help": help_text}


OWN = [
    own("", "name", "text", "name of the run, whose results are written to `out/NAME`. `\"\"`: the name of `scenes.folder`", default=""),
    own("", "effort", "text", "with `full` the section `full` overrides the others", one_of=["short", "full"], default="short"),
    own("", "full", "map", "options of other sections, for `effort: full`. The report of a short run says what it leaves out", default={}),
    own("", "representations", "any", "representations that get a generator ([names](formats.md#all-files)): a list, or a map from each to its own options of the section `train`"),
    own("", "init", "text", "folder of weights, `REPRESENTATION.safetensors`, from which training starts. Their basis and shape override the options of `train`", default=""),
    own("", "data", "text", "name of another run whose data set, basis and function cache are used, and made if they are missing; what lies there is never replaced. `scenes`, `split`, `datagen` and `basis` must be equal in both. With `init` the run has its own basis and cache", default=""),
    own("scenes", "families", "texts", "families of procedural scenes. A scene is named `FAMILY_SEED`", one_of=FAMILIES),
    own("scenes", "per_family", "integer", "number of scenes of each family, with seeds from 0 to `per_family` − 1", min=0, max=MAX_SHARDS),
    own("scenes", "folder", "text", "folder of [scenes](../guide/scenes.md): its `.glb`, `.gltf` and `.obj` files and the maps of its `.pk3` archives. `./pipeline.sh FOLDER` sets it", default=""),
    own("scenes", "jitters", "integer", "number of variants of each training scene. The first is the scene as it is; interiors have only that one", min=1, max=MAX_SHARDS),
    own("scenes", "archives", "any", "[levels](../guide/levels.md) in the archives of Quake III-family games, a list. Keys of an entry: `folder` of the `.pk3` files, prefixed with `NLG_ARCHIVE_ROOT` if it is absolute; `maps`, patterns of map names in lower case; optional `without`, patterns of maps to leave out, and `install`, the command that an error names if the archives are missing", default=[]),
    own("scenes", "furniture", "any", "[furnished interiors](../guide/interiors.md), named `PLAN_SEED_STEM`, a list. Keys of an entry: `archives`, `.sh3f` files, prefixed as above; `plans` out of `flat`, `townhouse`, `office`, `villa`; `seeds`, their number; optional `first_seed` (0), and `install` as above", default=[]),
    own("scenes", "collected", "texts", "folders of shards that [`nlg-bake --collect`](../guide/training.md#hard-functions) wrote, which are trained on, too; those of held-out and evaluation scenes are left out", default=[]),
    own("scenes", "by_scene", "map", "map from patterns of scene names to options of nlg-datagen for these scenes. Later patterns override earlier ones, and all override the section `datagen`", default={}),
    own("split", "held_out", "texts", "patterns of names of scenes that are never trained on, for validation during training and for the report", default=[]),
    own("split", "held_out_share", "number", "share of the scenes of `scenes.folder` (without it: of all scenes), at least one, that is held out at random, unless `held_out` names one of them", min=0.0, max=0.9, default=0.0),
    own("split", "seed", "integer", "seed of that choice", min=0, default=1),
    own("split", "evaluation", "texts", "patterns of names of further held-out scenes, on which the published figures of functions are measured ([the split](../guide/levels.md#the-split))", default=[]),
    own("report", "stability", "text", "stability cases to run. `short`: smaller ones, in seconds", one_of=["short", "full"], default="full"),
    own("report", "savings", "texts", "patterns of held-out and evaluation scenes that are baked with the run's weights, to measure what the bake leaves out. `[]`: none. Default: the first scene of each split", default=None),
    own("validate_light", "scenes", "texts", "scenes, as for nlg-bake, whose light is measured with each generator and the section `bake`", default=[]),
    own("validate_light", "spacings", "numbers", "finest probe spacings, metres", min=0.01, max=1000.0, default=[1.0]),
]
TOOL_ROWS = json.loads(TABLE.read_text()) if TABLE.is_file() else []


def rows_of(section):
    """The workflow's own rows and those of the tool that has the section; None: none."""
    return [row for row in OWN + TOOL_ROWS if row["section"] == section]


def kind_of(row):
    """The tools' rows say it by their defaults."""
    return row.get("type") or {bool: "boolean", int: "integer", float: "number", str: "text", list: "list"}[type(row["default"])]


def expectation(row):
    """What a value must be, in the words of a refusal and of the page."""
    low, high = (f"{limit:.10g}" if isinstance(limit, float) else limit for limit in (row.get("min"), row.get("max")))
    out_of = ", ".join(row.get("one_of", []))
    limits = "" if low is None and high is None else f" from {low}" if high is None else f" to {high}" if low is None else f" from {low} to {high}"
    return {"integer": "an integer" + limits, "number": "a number" + limits, "numbers": "a list of numbers" + limits,
            "boolean": "true or false", "text": f"one of {out_of}" if out_of else "a text", "texts": f"a list out of {out_of}" if out_of else "a list of texts",
            "list": "a list", "map": "a map", "any": "as described"}[kind_of(row)]


def is_number(value, row, kinds=(int, float)):
    return type(value) in kinds and row.get("min", value) <= value <= row.get("max", value)


def number_of(value, kind):
    """YAML 1.1 takes 1e-4 for a text; the tools, for a number."""
    try:
        return kind(value) if isinstance(value, str) else value
    except ValueError:
        return value


def holds(value, row):
    kind, out_of = kind_of(row), row.get("one_of")
    if kind == "integer":
        return is_number(number_of(value, int), row, [int])
    if kind == "number":
        return is_number(number_of(value, float), row)
    if kind == "numbers":
        return isinstance(value, list) and bool(value) and all(is_number(item, row) for item in value)
    if kind == "boolean":
        return isinstance(value, bool)
    if kind == "text":
        return isinstance(value, str) and (not out_of or value in out_of)
    if kind == "texts":
        return isinstance(value, list) and all(isinstance(item, str) and (not out_of or item in out_of) for item in value)
    if kind == "list":
        return isinstance(value, list) and all(isinstance(item, (str, int, float)) for item in value)
    return kind == "any" or isinstance(value, dict)


def judged(place, section, found, beside=(), is_part=False):
    """The section's settings: what was found, and the defaults of the workflow's own settings.

    beside    other keys that may stand there
    is_part   nothing must be there, and no default is added: settings that go over a section
    throws    ConfigurationError at a key that nothing reads, one that is missing, and a value that cannot be
    """
    rows = {row["name"]: row for row in rows_of(section)}
    keys = f"keys {sorted({*rows, *beside})}"
    require(place, found, isinstance(found, dict), "a map of settings")
    for key, value in found.items():
        if key in rows:
            require(f"{place}: {key}", value, holds(value, rows[key]), expectation(rows[key]))
        elif key not in beside:
            near = get_close_matches(str(key), [*rows, *beside], 1)
            raise ConfigurationError(f"{place}: expected {keys}, got unknown key {key!r}" + (f" (did you mean {near[0]!r}?)" if near else ""))
    if is_part:
        return found
    for name, row in rows.items():
        if "tool" not in row and name not in found and "default" not in row:
            raise ConfigurationError(f"{place}: expected {keys}, got missing key {name!r}")
    return {**{name: row["default"] for name, row in rows.items() if "tool" not in row and "default" in row}, **found}


def default(section, name):
    """What a tool takes where a configuration does not say."""
    return next(row["default"] for row in rows_of(section) if row["name"] == name)


def asked(folder):
    """The rows of all tools, by the tools themselves; those that only another section's tool passes on belong to that one."""
    rows = []
    for command in TOOLS:
        name, *arguments = command.split()
        answer = json.loads(subprocess.run([folder / name, *arguments, "--list-options"], capture_output=True, text=True, check=True).stdout)
        passed = [row for row in answer if row["section"] == "validate_light"]
        rows += [{**row, "tool": command} for row in passed or answer]
    return rows


def default_text(row):
    value = row.get("default")
    return "" if value is None else f" (`{json.dumps(value, ensure_ascii=False)}`)"


def help_of(row):
    """The help, and the values that a text or a list may hold."""
    return ("" if "default" in row else "required; ") + row["help"] + (f". Values: {', '.join(row['one_of'])}" if row.get("one_of") and "tool" not in row else "")  # a tool's own text names them


def list_of(rows):
    return [f"- `{row['name']}`{default_text(row)}: {help_of(row)}" for row in rows] + [""]


def page_of(tool_rows):
    lines = ["# Settings", "",
             "A configuration such as `pipeline.yaml` is a map of the sections below. A tool reads its own section of the file that `--config` names. Each setting is also a flag, which overrides the file: `spacing_m` is `--spacing-m`. `nlg-TOOL --help-all` also prints ranges. Parentheses hold defaults. Unknown settings and values out of range are refused, by the tools with file and line.",
             "", "`workflow/settings.py build/release/bin` writes this page, and the test `docs_settings` compares it.", ""]
    known = {}  # a setting as a section has it → that section
    rows = OWN + tool_rows
    for section in dict.fromkeys(row["section"] for row in rows):
        of_section = [row for row in rows if row["section"] == section]
        tools = list(dict.fromkeys(row["tool"] for row in of_section if "tool" in row))
        lines += [f"## {section}" if section else "## At the top", ""] + ([f"Read by {' and '.join(tools)}.", ""] if tools else [])
        groups = dict.fromkeys(row.get("group", "") for row in of_section)
        for group in groups:
            new, same = [], {}
            for row in of_section:
                if row.get("group", "") == group:
                    shown = (row["name"], default_text(row), help_of(row))
                    new += [row] if shown not in known else []
                    same.setdefault(known.get(shown), []).append(row["name"])
                    known.setdefault(shown, section)
            same.pop(None, None)
            title = [f"**{group}**"] if len(groups) > 1 and group else []
            others = "; ".join(f"as in [{other}](#{other}): " + (f"all {len(names)}" if not new and len(names) > 5 else ", ".join(f"`{name}`" for name in names)) for other, names in same.items())
            lines += [": ".join(title + [others]) + "." if others else title[0], ""] if title or others else []
            lines += list_of(new) if new else []
    return "\n".join(lines)


def long_helps(folder):
    for command in TOOLS + OTHER_TOOLS:
        name, *arguments = command.split()
        text = subprocess.run([folder / name, *arguments, "--help"], capture_output=True, text=True, check=True).stdout
        count = len(re.findall(r"^  -", text, flags=re.MULTILINE))
        if count > MOST_IN_HELP:
            yield f"{command} --help: expected at most {MOST_IN_HELP} options, got {count}"


def old_configurations(rows):
    """What configurations of ours hold and no tool knows any more. Only where their scenes are could they be judged whole."""
    TOOL_ROWS[:] = rows
    sections = {row["section"] for row in OWN + rows} - {""}
    for path in [ROOT / "pipeline.yaml", *sorted((ROOT / "configs").glob("*.yaml"))]:
        config = read(path)
        parts = [(name, config[name]) for name in sorted(sections & set(config))] + list(config.get("full", {}).items())
        parts += [("train", own) for own in config["representations"].values()] if isinstance(config["representations"], dict) else []
        for name, part in parts:
            try:
                judged(name, name, part, is_part=True)
            except ConfigurationError as error:
                yield f"{path.relative_to(ROOT)}: {error}"


def main():
    arguments = [argument for argument in sys.argv[1:] if argument != "--check"]
    if len(arguments) != 1:
        raise UsageError("settings.py", "BIN [--check]", f"{len(sys.argv) - 1} arguments")
    rows = asked(Path(arguments[0]))
    texts = {TABLE: "[\n" + ",\n".join(json.dumps(row, ensure_ascii=False) for row in rows) + "\n]\n", PAGE: page_of(rows)}
    if "--check" not in sys.argv:
        write_files({path: text.encode() for path, text in texts.items()})
        return None
    problems = [f"{path.relative_to(ROOT)}: not what the tools say; workflow/settings.py {arguments[0]} writes it"
                for path, text in texts.items() if not path.is_file() or path.read_text() != text]
    problems += [*long_helps(Path(arguments[0])), *old_configurations(rows)]
    print("\n".join(problems) or f"{len(rows)} settings are what the tools say")
    return CHECK_FAILED if problems else None


if __name__ == "__main__":
    sys.exit(run("settings.py", main))

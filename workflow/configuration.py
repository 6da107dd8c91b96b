"""What a run's configuration says, judged in one place before anything is built, made or moved.

    configuration.py CONFIG [--levels FOLDER] [--set SECTION.KEY=VALUE]... [--write | --sweep]

Prints the run's folder, the tools that it needs, the file that holds the configuration (CONFIG, or configuration.yaml of the run's folder where
FOLDER or values go over it), and the folder of its data. --write writes that file. --sweep prints, where a setting has a list of values in place of
one, a line for each run: its folder, and what --set makes it of, apart by tabs. A configuration that cannot be used ends with one line on stderr and exit code 2. The Snakefile, pipeline.sh
and check_artefacts.py take names, scenes and paths from here and from nowhere else; what each setting may be stands in settings.py.
"""
import argparse
import copy
import itertools
import json
import math
import os
import random
import re
import shlex
import sys
from fnmatch import fnmatch
from pathlib import Path

sys.path.insert(0, str(Path(__file__).resolve().parents[1]))  # tool/, which all scripts share
from tool.atomic_file import write_files
from tool.errors import UsageError, run
from tool.input_file import read_header, training_scenes

from entries import files_in, under_root
from furniture import find_interiors
from levels import find_levels, is_texts, level_name
from plain_yaml import ConfigurationError, parsed, read, require, require_plain, text_of
from settings import MAX_SHARDS, OWN, REPRESENTATIONS, ROOT, TOOL_ROWS, default, judged, kind_of, number_of, rows_of

sys.path.append(os.path.join(ROOT, "validate", "report"))  # by whose rule a run is judged
import verdict

SECTIONS = sorted({row["section"] for row in OWN + TOOL_ROWS} - {""})
PART_SECTIONS = sorted({*SECTIONS} - {"split"})  # which `full` may go over
MAX_LIGHT_SPACINGS = 16
LEVEL_ENDINGS = (".glb", ".gltf", ".obj")
STABILITY_DEPTHS = {"short": "--short", "full": ""}
DATA_SECTIONS = ("scenes", "split", "datagen", "basis")
MAX_SWEPT = 64
SPLITS = ["training", "held_out", "evaluation"]
# what nlg-datagen and nlg-bake call by the same name; all else says how a shard is sampled, which a bake does not do
BAKE_TOO = {row["name"] for row in rows_of("datagen")} & {row["name"] for row in rows_of("bake")} - {"seed", "threads"}


def matching(scenes, patterns):
    # a name may hold what patterns are made of
    return [scene for scene in scenes if any(scene == pattern or fnmatch(scene, pattern) for pattern in patterns)]


def flags(options):
    """Options of a configuration as flags of a tool."""
    texts = {key: ",".join(map(str, value)) if isinstance(value, list) else value if isinstance(value, str) else json.dumps(value)
             for key, value in options.items()}
    return shlex.join(f"--{key.replace('_', '-')}={text}" for key, text in sorted(texts.items()))


def archives_in(folder):
    """The entry of scenes.archives of a folder's own archives, in a list; nothing where there are none."""
    return [{"folder": os.path.abspath(folder), "maps": ["*"]}] if folder and files_in(folder, ".pk3")[0] else []


def find_scenes(options, environment):
    """Name of every scene → (what nlg-datagen is asked for, the files that it reads)."""
    scenes = {f"{family}_{seed}": (f"{family}:{seed}", []) for family in options["families"] for seed in range(options["per_family"])}
    folder = options["folder"]
    if folder:
        files, empty = files_in(folder, *LEVEL_ENDINGS)
        require("scenes: folder", f"{len(empty)} empty files" if empty else "none", files or archives_in(folder), f".glb, .gltf, .obj or .pk3 files in {folder}")
        for path in files:
            require(path, path.name, not set(path.stem) & set("{}") and path.name.isprintable(), "a name of one line without braces")
            name = level_name(path.stem, path.suffix)
            if name in scenes:
                raise ConfigurationError(f"{path}: another scene has this name: {scenes[name][0]}")
            scenes[name] = (str(path), [str(path)])
    root = environment.get("NLG_ARCHIVE_ROOT", "")
    for found in (find_levels(options["archives"], root), find_levels(archives_in(folder)), find_interiors(options["furniture"], root, MAX_SHARDS)):
        for name, scene in found.items():
            if name in scenes:
                raise ConfigurationError(f"{scene[0]}: another scene has this name: {scenes[name][0]}")
            scenes[name] = scene
    require("scenes", "none", scenes, "families, a folder, archives or furniture")
    return scenes


def listed(names, most=20, first=()):
    names = [*sorted(first), *sorted({*names} - {*first})]
    return ", ".join(names[:most]) + (f" and {len(names) - most} others" if len(names) > most else "")


class Run:
    """A configuration that was judged, and what follows from it: scenes, splits, and the paths of all shards."""

    def __init__(self, config, environment):
        require_plain("configuration", config)
        config = judged("top level", "", config, beside=SECTIONS)
        folder = (config.get("scenes") or {}).get("folder") or ""
        if not config["name"] and not folder:
            raise ConfigurationError("expected the key 'name', or scenes.folder, whose name is taken, got neither")
        self.name = config["name"] or re.sub(r"[^\w.-]+", "_", Path(os.path.abspath(folder)).name)
        for key, name in (("name", self.name), ("data", config["data"] or self.name)):
            require(key, name, len(name) <= 100 and re.fullmatch(r"[\w.-]*\w[\w.-]*", name), "a folder's name")
        results = environment.get("NLG_OUT") or "out"
        require("NLG_OUT", results, results.isprintable() and not set(results) & set("{}"), "a folder's name of one line without braces")
        self.folder, self.data_folder = (os.path.join(results, name) for name in (self.name, config["data"] or self.name))
        # a basis that weights bring is not that of the run which shares its data
        self.basis_folder = self.folder if config["init"] else self.data_folder
        self._take_effort(config)
        self._take_representations(config["representations"])
        self._take_init(config["init"])
        self._take_training()
        self._take_scenes(self.sections["scenes"], environment)
        self._take_references(environment)
        self._take_split(config.get("split") or {})
        self._take_collected(self.sections["scenes"]["collected"])
        self._take_report(self.sections["report"])
        self._take_light(self.sections["validate_light"])

    def _take_effort(self, config):
        """Sections with what `full` holds over them, where the effort is full."""
        self.effort = config["effort"]
        full = config["full"]
        judged("full", None, full, beside=PART_SECTIONS)
        self.sections, self.full = {}, {}
        for name in PART_SECTIONS:
            section, more = config.get(name) or {}, full.get(name) or {}
            require(name, section, isinstance(section, dict), "a map of settings")
            self.full[name] = judged(f"full: {name}", name, more, is_part=True)
            self.sections[name] = judged(name, name, {**section, **more} if self.effort == "full" else section)
        self.left_out = [] if self.effort == "full" else [f"{name}.{key}: {json.dumps((config.get(name) or {}).get(key))}, full {json.dumps(value)}"
                                                          for name, options in sorted(self.full.items()) for key, value in options.items()]

    def _take_representations(self, found):
        if is_texts(found):
            found = {name: {} for name in found}
        require("representations", found, isinstance(found, dict) and found and set(found) <= set(REPRESENTATIONS),
                "a list out of " + ", ".join(REPRESENTATIONS) + ", or each of them with options of the train section")
        self.representations = {name: judged(f"representations: {name}", "train", options, is_part=True) for name, options in found.items()}

    def _take_init(self, folder):
        """The weights that trainings begin with, by representation."""
        self.init = {name: os.path.join(os.path.abspath(folder), f"{name}.safetensors") for name in self.representations} if folder else {}
        for path in self.init.values():
            require("init", path, os.path.isfile(path), "weights of every representation")
        self.init_scenes = {}
        for name, path in self.init.items():
            texts, _ = read_header(path)
            # nlg-train says so too, when data and basis are made
            require("init", path, texts.get("representation") == name, f"weights of {name}")
            self.init_scenes[path] = training_scenes(texts) or set()

    def _take_references(self, environment):
        """Weights that those of the run are compared with, by what they are: where there are own levels the supplied ones of the same representations
        (or the bakes' first, where there are none of these), and those that trainings begin with."""
        folder = environment.get("NLG_WEIGHTS") or os.path.join(ROOT, "weights")
        supplied = [path for name in self.representations if os.path.isfile(path := os.path.join(folder, f"{name}.safetensors"))]
        supplied = supplied or [path for name in default("bake", "representation") if os.path.isfile(path := os.path.join(folder, f"{name}.safetensors"))]
        references = {"supplied": supplied if self.own_levels else [], "init": list(self.init.values())}
        if list(map(os.path.realpath, references["init"])) == list(map(os.path.realpath, references["supplied"])):
            references["init"] = []  # once
        self.references = {name: paths for name, paths in references.items() if paths}

    def _take_training(self):
        """Processes and threads of each training, which the workflow starts."""
        self.training_cores = {}
        for name, own in self.representations.items():
            options = {key: int({**self.sections["train"], **own}.get(key, default("train", key))) for key in ("processes", "threads", "batch", "dictionary_resolution")}
            # nlg-train says so too, when data and basis are made
            require("train: processes", options["processes"], options["processes"] <= options["batch"], f"at most batch, {options['batch']}")
            require("train: dictionary_resolution", options["dictionary_resolution"], options["dictionary_resolution"] % 2 == 1, "3, 5, 7 or 9")
            self.training_cores[name] = options["processes"], options["threads"]

    def _take_scenes(self, options, environment):
        shards = len(options["families"]) * options["per_family"] * options["jitters"]
        require("scenes", f"{shards}", shards <= MAX_SHARDS, f"at most {MAX_SHARDS} shards")
        self.jitters = options["jitters"]
        self.scenes = find_scenes(options, environment)
        root = environment.get("NLG_ARCHIVE_ROOT", "")
        folders = [folder for folder in (options["folder"], *(under_root(root, entry["folder"]) for entry in options["archives"])) if folder]
        self.empty = [str(path) for folder in folders for path in files_in(folder, *LEVEL_ENDINGS, ".pk3")[1]]
        folder = os.path.join(os.path.abspath(options["folder"]), "") if options["folder"] else None
        self.own_levels = [scene for scene, (_, files) in self.scenes.items() if folder and any(os.path.abspath(file).startswith(folder) for file in files)]
        # another seed is another interior; jitter would take furniture apart, which is of many connected components
        self.unjittered = find_interiors(options["furniture"], root, MAX_SHARDS)
        self.by_scene = options["by_scene"]
        for pattern, values in self.by_scene.items():
            place = f"scenes: by_scene: {pattern}"
            require(place, pattern, matching(self.scenes, [pattern]), "a pattern of some scene")
            judged(place, "datagen", values, is_part=True)

    def _take_split(self, split):
        split = judged("split", "split", split)
        for key in ("held_out", "evaluation"):
            for pattern in split[key]:
                # a scene that a wrong name leaves out would be trained on
                require(f"split: {key}", pattern, matching(self.scenes, [pattern]), "a pattern of some scene out of " + listed(self.scenes, first=self.own_levels))
        self.held_out, self.evaluation = (matching(self.scenes, split[key]) for key in ("held_out", "evaluation"))
        if split["held_out_share"] > 0:
            self._draw_held_out(split["held_out_share"], split["seed"])
        kept = {*self.held_out, *self.evaluation}
        self.training = [scene for scene in self.scenes if scene not in kept]
        require("split", f"{len(self.held_out)} of {len(self.scenes)}", self.held_out and self.training,
                "some of the scenes held out, but not all; held_out names them, held_out_share draws them")
        for path, seen in self.init_scenes.items():
            for scene in sorted(kept & seen):
                raise ConfigurationError(f"split: {scene} is not to be trained on, and init's {path} was; hold out others")
        for scene in sorted({*self.held_out} & {*self.evaluation}):
            raise ConfigurationError(f"split: {scene} is in held_out and in evaluation; a scene can be in one of them")

    def _take_collected(self, folders):
        """Shards of nlg-bake --collect, SCENE.collected.h5, which are trained on beside those that the run makes; not those of other splits."""
        found = []
        for folder in folders:
            shards = [os.path.abspath(path) for path in files_in(folder, ".h5")[0]]
            require("scenes: collected", "none", shards, f"shards of nlg-bake --collect, .h5 files, in {folder}")
            found += shards
        for path in found:
            require("scenes: collected", path, path.isprintable() and not set(path) & set("{}"), "names of one line without braces")
        self.not_collected = [path for path in found if os.path.basename(path).rsplit(".", 2)[0] in {*self.held_out, *self.evaluation}]
        self.collected = [path for path in found if path not in self.not_collected]

    def _draw_held_out(self, share, seed):
        """Holds out a share of the scenes of the folder, or of all scenes where there is none; whole scenes, the same ones for the same names and
        seed. No lot is drawn where held_out names one of them."""
        candidates = self.own_levels or list(self.scenes)
        if {*self.held_out} & {*candidates}:
            return
        lot = sorted(scene for scene in candidates if scene not in self.evaluation)
        require("split: held_out_share", f"{len(lot)}", len(lot) >= 2, "at least two levels, one to train on and one to hold out")
        drawn = {*random.Random(seed).sample(lot, max(round(share * len(lot)), 1))}
        self.held_out = [scene for scene in self.scenes if scene in drawn or scene in self.held_out]

    def _take_report(self, report):
        judged_scenes = self.held_out + self.evaluation
        if report["savings"] is None:
            report = {**report, "savings": [*self.held_out[:1], *self.evaluation[:1]]}
        for pattern in report["savings"]:
            require("report: savings", pattern, matching(judged_scenes, [pattern]), "a pattern of some scene that is held out or for the evaluation")
        self.report = report
        self.savings = matching(judged_scenes, report["savings"])
        # the first held-out one is baked with other weights too, and without a generator
        self.baked = matching(self.held_out, report["savings"])[:1]
        self.bakes = [*self.references, "without"] if self.baked else []

    def _take_light(self, light):
        """Scenes whose light is measured, by file name, and the flags of nlg-validate light."""
        self.light_scenes = {}
        for scene in light["scenes"]:
            name = re.sub(r"[^\w.-]+", "_", Path(scene).stem if scene.lower().endswith((".glb", ".gltf", ".obj", ".bsp")) else scene)
            require("validate_light: scenes", scene, re.search(r"[^\W_]", name) and name not in self.light_scenes, "scenes with different names")
            self.light_scenes[name] = scene
        require("validate_light: spacings", light["spacings"], len(light["spacings"]) <= MAX_LIGHT_SPACINGS, f"at most {MAX_LIGHT_SPACINGS} distances")
        self.light_spacings = [str(value) for value in light["spacings"]]
        self.light = {key: value for key, value in light.items() if key not in ("scenes", "spacings")}
        # the file that each is read from; none where it is a built-in one
        self.light_files = {name: [os.path.abspath(scene)] if os.path.isfile(scene) else [] for name, scene in self.light_scenes.items()}

    def shards(self, split):
        """Paths of the shards of a split, in the order in which the tools are given them."""
        jitters = self.jitters if split == "training" else 1
        return [f"{self.data_folder}/dataset/{split}/{scene}.{jitter}.h5" for scene in getattr(self, split)
                for jitter in range(1 if scene in self.unjittered else jitters)]

    def artefacts(self):
        """Files that the run makes and keeps, in the order in which it makes them; shards aside, and what is in picture_folders."""
        judged = ["validation", *(["evaluation"] if self.evaluation else [])]
        names = []
        for name in self.representations:
            names += [f"training/{name}.ckpt", f"training/{name}.csv", f"training/{name}.json", f"training/{name}/curve.png",
                      f"weights/{name}.safetensors", f"weights/{name}.json"]
        names += [f"{split}/{file}" for split in judged for file in ("summary.json", "functions.csv", "slices.json", "frontier.json")]
        names += [f"{reference}/{file}" for reference in self.references for file in ("summary.json", "functions.csv", "slices.json")]
        names += ["stability.json"]
        names += [f"savings/{scene}.json" for scene in self.savings] + [f"bakes/{name}.json" for name in self.bakes]
        names += [f"light/{scene}.json" for scene in self.light_scenes]
        names += [f"{split}{file}" for split in ("", *(f"{name}/" for name in judged[1:])) for file in ("report.html", "slices.png", "verdict.txt")]
        return [f"{self.data_folder}/dataset.json", *(f"{self.basis_folder}/{name}" for name in ("basis.h5", "basis.json")), *(f"{self.folder}/{name}" for name in names)]

    def picture_folders(self):
        """Folders that a rule makes with whatever is in them → the file that it makes last."""
        return {f"{self.folder}/light/{scene}_places": f"{self.folder}/light/{scene}.json" for scene in self.light_scenes}

    def tools(self):
        """What the run starts; the others need not be built."""
        names = ["datagen", "pca", "cache", "train", "export", "validate"]
        return [f"nlg-{name}" for name in names + ["bake"] * bool(self.report["savings"])]

    def asked(self, name, own=None, without=("threads", "processes")):
        """A tool's options as text, those that nobody names among them: a change of it re-makes what the tool makes.

        own       what a scene or a representation has for itself
        without   options that change no result
        """
        rows = {row["name"]: row for row in rows_of(name)}
        values = {**{key: row.get("default") for key, row in rows.items()}, **self.sections[name], **(own or {})}
        return json.dumps({key: number_of(value, float) if kind_of(rows[key]) in ("integer", "number") else value
                           for key, value in values.items() if key not in without}, sort_keys=True)

    def flags_over(self, name, own=None):
        """Flags over a tool's section of the file: what the effort sets, and over it what a scene or a representation has for itself."""
        return flags({**(self.full[name] if self.effort == "full" else {}), **(own or {})})

    def scene_options(self, scene):
        """The options of every pattern that matches, later ones over earlier ones."""
        options = {}
        for pattern, values in self.by_scene.items():
            if fnmatch(scene, pattern):
                options.update(values)
        return options

    def bake_options(self, scene):
        return {key: value for key, value in self.scene_options(scene).items() if key in BAKE_TOO}


def judge(config, path, environment=os.environ):
    """The run that a configuration describes.

    config        what the file holds; path: the file, for the message
    environment   NLG_OUT and NLG_ARCHIVE_ROOT stand in for `out` and the root of archives' folders
    throws        ConfigurationError
    """
    try:
        return Run(config, environment)
    except (ValueError, OSError) as error:
        raise ConfigurationError(f"{path}: {error}") from None


def few_scenes(run):
    """A line where the verdict is known before the run."""
    count = len(run.held_out)
    if count >= verdict.FEWEST_SCENES:
        return []
    return [f"{count} held-out {'scene' if count == 1 else 'scenes'}: the verdict will be {verdict.UNDECIDED}; name {verdict.FEWEST_SCENES} or more by split.held_out"]


def other_policies(run):
    """Lines about the fits of validations that are not those of the bake: the report's verdict is of the former."""
    lines, sections = [], ("bake", "validate", "frontier")
    keys = [{row["name"] for row in rows_of(name) if row.get("group", "").startswith("Policy")} for name in sections]
    for key in sorted(set.intersection(*keys)):
        values = {name: run.sections[name].get(key, default(name, key)) for name in sections}
        if len(set(values.values())) > 1:
            lines.append(f"{key} is {', '.join(f'{value} in {name}' for name, value in values.items())}: the report's verdict is of validate and frontier")
    return lines


def load(path):
    return judge(read(path), path)


def of_snakemake(config, path):
    """The run of a file that Snakemake was given, by --configfile or --config file=FILE; its folders as absolute paths.

    config   what Snakemake took for the configuration: anything in it that the file does not hold would not reach the tools, which read the file
    """
    content = read(path)
    for key in sorted(set(config) - {"file"}, key=str):
        if not isinstance(content, dict) or key not in content or content[key] != config[key]:
            raise ConfigurationError(f"--config: only file=FILE can be combined with --configfile, got {key!r}")
    return judge(content, path, {**os.environ, "NLG_OUT": os.path.abspath(os.environ.get("NLG_OUT") or "out")})


def changed(content, levels, values):
    """A configuration's content with a folder of levels, and with values for some of its keys.

    values   texts such as "train.steps=8000", each value as YAML writes it
    """
    content = copy.deepcopy(content)
    require_plain("configuration", content)
    require("configuration", content, isinstance(content, dict), "a map of settings")
    pairs = [("scenes.folder", os.path.abspath(levels))] if levels else []
    for text in values:
        key, equals, value = text.partition("=")
        require("--set", text, equals and all(key.split(".")), "KEY=VALUE or SECTION.KEY=VALUE")
        pairs.append((key, parsed(f"--set {key}", value)))
    for key, value in pairs:
        place = content
        *sections, name = key.split(".")
        for section in sections:
            if place.get(section) is None:
                place[section] = {}
            place = place[section]
            require(f"--set {key}: {section}", place, isinstance(place, dict), "a section")
        place[name] = value
    for key, _ in pairs:
        refuse_overruled(content, key)
    return content


def refuse_overruled(content, key):
    """A key that something else in the file goes over would be set in vain."""
    section, _, name = key.partition(".")
    own = content.get("representations")
    over = [f"representations.{of}.{name}" for of, options in (own.items() if section == "train" and isinstance(own, dict) else ())
            if isinstance(options, dict) and name in options]
    full = content.get("full")
    if content.get("effort") == "full" and isinstance(full, dict) and name in (full.get(section) or {}):
        over.append(f"full.{key}")
    for other in over:
        raise ConfigurationError(f"--set {key} has no effect, because {other} overrides it; set that instead")


def add_arguments(parser):
    """What pipeline.sh is told: the file, and what goes over it."""
    parser.add_argument("config", nargs="?")
    parser.add_argument("--levels")
    parser.add_argument("--set", action="append", default=[])


def content_of(arguments):
    """What a run is made by: the file's content, with what goes over it."""
    if arguments.config is None:
        raise UsageError("configuration.py", "CONFIG", "no argument")
    content = read(arguments.config)
    return changed(content, arguments.levels, arguments.set) if arguments.levels or arguments.set else content


def judge_arguments(arguments, content):
    """The run; what is wrong is told of the --set without which it is right, or of the first that is wrong alone, else of the file."""
    def judged_with(values, place):
        return judge(changed(read(arguments.config), arguments.levels, values), place)

    def holds(values):
        try:
            return bool(judged_with(values, arguments.config))
        except ConfigurationError:
            return False

    try:
        return judge(content, arguments.config)
    except ConfigurationError:
        for text in arguments.set:
            if holds([other for other in arguments.set if other != text]):
                return judge(content, f"--set {text}")
        if holds([]):
            for text in arguments.set:
                judged_with([text], f"--set {text}")
        raise


def swept(content):
    """Keys that hold a list where one value is meant → these values. A text such as 4000,8000 in place of a number is a list, too. What makes
    the data has one value: runs are compared on the same functions."""
    own = content.get("representations")
    places = [(name, name, content.get(name)) for name in PART_SECTIONS if name not in DATA_SECTIONS]
    places += [(f"representations.{name}", "train", options) for name, options in (own.items() if isinstance(own, dict) else ())]
    found = {}
    for place, section, options in places:
        kinds = {row["name"]: kind_of(row) for row in rows_of(section)}
        for key, value in (options.items() if isinstance(options, dict) else ()):
            if isinstance(value, str) and "," in value and kinds.get(key) in ("integer", "number", "boolean"):
                value = parsed(f"{place}.{key}", f"[{value}]")
            if isinstance(value, list) and value and kinds.get(key) in ("integer", "number", "boolean", "text"):
                found[f"{place}.{key}"] = value
    return found


def sweep(content, path):
    """The runs that lists of values stand for, each as (its folder, its settings); all share data and basis."""
    found = swept(content) if isinstance(content, dict) else {}
    count = math.prod(len(values) for values in found.values())
    require(f"{path}: {', '.join(found)}", f"{count}", count <= MAX_SWEPT, f"values for at most {MAX_SWEPT} runs")
    for values in itertools.product(*found.values()) if found else ():
        settings = [f"{key}={json.dumps(value)}" for key, value in zip(found, values)]
        base = judge(changed(content, None, settings), path).name
        name = re.sub(r"[^\w.-]+", "-", "-".join([base, *(f"{key.split('.')[-1]}-{value}" for key, value in zip(found, values))]))
        settings += [f"name={name}", f"data={content.get('data') or base}"]
        yield judge(changed(content, None, settings), path).folder, settings


def refuse_others_results(run, content):
    """Two folders of levels may have the same name: the results of one are not replaced by those of the other. Nor are another run's data by
    data that are made otherwise."""
    for folder in dict.fromkeys((run.folder, run.data_folder)):
        path = os.path.join(folder, "configuration.yaml")
        if not os.path.isdir(os.path.join(folder, "dataset")):
            continue
        before = read(path) if os.path.isfile(path) else {}
        # none: the scenes are procedural, or of a configuration's own archives
        levels = [(config.get("scenes") or {}).get("folder") or "" for config in (before, content)]
        require(folder, f"results of {levels[0] or 'other levels'}", levels[0] == levels[1], "results of the same levels; --set name=NAME keeps both")
        for name in DATA_SECTIONS if before and folder != run.folder else ():
            require(f"data: {folder}: {name}", before.get(name), before.get(name) == content.get(name), f"what this run has: {content.get(name)}")


def main():
    parser = argparse.ArgumentParser(prog="pipeline.sh")
    add_arguments(parser)
    parser.add_argument("--write", action="store_true")
    parser.add_argument("--sweep", action="store_true")
    arguments = parser.parse_args()
    content = content_of(arguments)
    if arguments.sweep:
        for folder, settings in sweep(content, arguments.config):
            print(folder, *(f"--set={setting}" for setting in settings), sep="\t")
        return
    run_of_file = judge_arguments(arguments, content)
    for left_out, why in (run_of_file.empty, "empty"), (run_of_file.not_collected, "of levels that are not to be trained on"):
        if left_out and not arguments.write:
            print(f"pipeline.sh: left out, because they are {why}: {listed(left_out)}", file=sys.stderr)
    if not arguments.write:
        for line in few_scenes(run_of_file) + other_policies(run_of_file):
            print(f"pipeline.sh: {line}", file=sys.stderr)
    is_changed = bool(arguments.levels or arguments.set)
    record = os.path.join(run_of_file.folder, "configuration.yaml")
    path = record if is_changed else arguments.config
    if is_changed:
        refuse_others_results(run_of_file, content)
    if arguments.write:
        of_data = os.path.join(run_of_file.data_folder, "configuration.yaml")
        write_files({file: text_of(content).encode() for file in (record, of_data) if file == record or not os.path.exists(of_data)})
    print(run_of_file.folder)
    print(*run_of_file.tools())
    print(path)
    print(run_of_file.data_folder)


if __name__ == "__main__":
    sys.exit(run("pipeline.sh", main))

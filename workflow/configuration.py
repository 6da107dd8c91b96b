"""What a run's configuration says, judged in one place before anything is built, made or moved.

    configuration.py CONFIG

Prints the run's folder. A configuration that cannot be used ends with one line on stderr and exit code 2. The Snakefile, pipeline.sh
and check_artefacts.py take names, scenes and paths from here and from nowhere else; the tools judge the values in their own sections.
"""
import json
import math
import os
import re
import shlex
import sys
from fnmatch import fnmatch
from pathlib import Path

import yaml

sys.path.insert(0, str(Path(__file__).resolve().parents[1]))  # tool/, which all scripts share
from tool.errors import USAGE_ERROR, InputError, ToolError, UsageError, run
from tool.input_file import read_bytes

from furniture import find_interiors
from levels import find_levels, is_texts


TOOL_SECTIONS = {"datagen", "basis", "train", "export", "bake", "validate", "frontier", "solve"}
OWN_SECTIONS = {"name", "scenes", "split", "representations"}
OPTIONAL_SECTIONS = {"report", "validate_light", "effort", "full"} | TOOL_SECTIONS
FAMILIES = ["house", "maze", "colonnade", "stairs", "clutter", "outdoor", "cave"]
REPRESENTATIONS = ["mlp", "tent_mlp", "tent_mlp88", "tent_mlp44", "tent_mlp4", "pf3", "pf5", "pf7", "pf9"]
SMALL_SCENES = ["two_rooms", "doorway", "column", "clutter", "corridor", "table"]  # of nlg-solve
STABILITY_DEPTHS = {"short": "--short", "full": "", "long": "--long"}
# what nlg-validate light measures, and how much of it: default, least and most of each number
LIGHT_COUNTS = {"air_places": (1000, 8, 10000000), "surface_places": (1000, 8, 10000000), "walks": (64, 1, 100000), "truth_rays": (256, 8, 1 << 24), "probe_rays": (256, 8, 1 << 24), "picture_rays": (64, 8, 1 << 20)}
MAX_LIGHT_SPACINGS = 16
SPLITS = ["training", "held_out", "evaluation"]
OWN_PARTS = {"scenes", "report", "validate_light"}  # sections that the workflow itself reads
# what nlg-datagen and nlg-bake call by the same name; all else says how a shard is sampled, which a bake does not do
BAKE_TOO = {"unit", "extent_m", "density_growth", "diffusion_passes", "diffusion_sigma", "diffusion_falloff", "duplicate_rms", "duplicate_validity_points"}
MAX_SHARDS = 1000000
MAX_PROCESSES = 4096  # of nlg-train
MAX_DEPTH = 16
MAX_BYTES = 1 << 20  # of a configuration, as for the tools


class ConfigurationError(ToolError, ValueError):
    """A configuration that cannot be used."""
    exit_code = USAGE_ERROR


def require(place, value, holds, expected):
    if not holds:
        shown = ascii(value) if isinstance(value, str) and not value.isprintable() else repr(value)
        raise ConfigurationError(f"{place}: expected {expected}, got {shown if len(shown) < 200 else shown[:200] + '…'}")


def require_keys(place, found, expected, optional=frozenset()):
    """Refuses a key that nothing reads, or one that is missing; the tools do the same for their own sections."""
    keys = f"keys {sorted(expected | optional)}"
    require(place, found, isinstance(found, dict), keys)
    for key in sorted((set(found) - optional) ^ expected):
        problem = "unknown key" if key in found else "missing key"
        raise ConfigurationError(f"{place}: expected {keys}, got {problem} {key!r}")


def require_plain(place, value, depth=0):
    """Values that every reader of the file can hold: texts of one line, numbers of 64 bits, lists and maps of them, not too deep."""
    require(place, "more", depth < MAX_DEPTH, f"at most {MAX_DEPTH} levels of lists and maps")
    if isinstance(value, dict):
        for key, item in value.items():
            require(place, key, isinstance(key, str), "keys that are texts")
            require_plain(place, key, depth + 1)
            require_plain(f"{place}: {key}" if depth else key, item, depth + 1)
    elif isinstance(value, list):
        for item in value:
            require_plain(place, item, depth + 1)
    elif isinstance(value, str):
        require(place, value, value.isprintable(), "a text of one line")
    elif isinstance(value, int):
        # before it is shown: Python refuses to print an integer of thousands of digits
        require(place, f"one of {value.bit_length()} bits", -2**63 <= value < 2**64, "a number of 64 bits")
    elif isinstance(value, float):
        require(place, value, math.isfinite(value), "a finite number")
    else:
        require(place, value, value is None, "a text, a number, a list or a map")


class Loader(yaml.SafeLoader):
    """YAML's safe loader, which would take the last of two equal keys, and lists of lists of aliases that no machine can hold."""

    def compose_node(self, parent, index):
        if self.check_event(yaml.events.AliasEvent):
            raise yaml.constructor.ConstructorError(None, None, "expected every value written out, got an alias", self.peek_event().start_mark)
        return super().compose_node(parent, index)

    def construct_mapping(self, node, deep=False):
        seen = set()
        for key, _ in node.value:
            if isinstance(key, yaml.ScalarNode):
                if key.value in seen:
                    raise yaml.constructor.ConstructorError(None, None, f"expected each key once, got {key.value!r} again", key.start_mark)
                seen.add(key.value)
        return super().construct_mapping(node, deep)

    def construct_object(self, node, deep=False):
        """With the place of what YAML can write and Python cannot hold: the 45th of May, a number of thousands of digits."""
        try:
            return super().construct_object(node, deep)
        except (ValueError, OverflowError) as error:
            raise yaml.constructor.ConstructorError(None, None, str(error), node.start_mark) from None


def position(text, index):
    """LINE:COLUMN of a character, or of a byte, counted from 1."""
    before = text[:index]
    newline = b"\n" if isinstance(text, bytes) else "\n"
    return f"{before.count(newline) + 1}:{index - (before.rfind(newline) + 1) + 1}"


def read(path):
    """The file's content.

    throws   ConfigurationError when it cannot be read, or is no YAML
    """
    try:
        data = read_bytes(path)
        require(path, f"{len(data)}", len(data) <= MAX_BYTES, f"at most {MAX_BYTES} bytes")
        text = data.decode("utf-8")
        return yaml.load(text, Loader)
    except yaml.MarkedYAMLError as error:
        mark = error.problem_mark or error.context_mark
        raise ConfigurationError(f"{path}:{mark.line + 1}:{mark.column + 1}: {error.problem or error.context}") from None
    except yaml.reader.ReaderError as error:
        raise ConfigurationError(f"{path}:{position(text, error.position)}: expected text, got the character {error.character:#x}") from None
    except UnicodeDecodeError as error:
        raise ConfigurationError(f"{path}:{position(data, error.start)}: expected UTF-8, got other bytes") from None
    except RecursionError:
        raise ConfigurationError(f"{path}: expected at most {MAX_DEPTH} levels of lists and maps, got more") from None
    except InputError as error:
        raise ConfigurationError(str(error)) from None


def matching(scenes, patterns):
    return [scene for scene in scenes if any(fnmatch(scene, pattern) for pattern in patterns)]


def flags(options):
    """Options of a configuration as flags of a tool."""
    texts = {key: ",".join(map(str, value)) if isinstance(value, list) else value if isinstance(value, str) else json.dumps(value)
             for key, value in options.items()}
    return shlex.join(f"--{key.replace('_', '-')}={text}" for key, text in sorted(texts.items()))


def is_option(key):
    return re.fullmatch(r"[a-z][a-z0-9_]*", key)


def find_scenes(options, environment):
    """Name of every scene → (what nlg-datagen is asked for, the files that it reads)."""
    scenes = {f"{family}_{seed}": (f"{family}:{seed}", []) for family in options["families"] for seed in range(options["per_family"])}
    folder = environment.get("NLG_LEVELS") or options["folder"]
    if folder:
        files = sorted(p for p in Path(folder).glob("*") if p.suffix.lower() in (".glb", ".gltf", ".obj"))
        require("scenes: folder", "none", files, f".glb, .gltf or .obj files in {folder}")
        for path in files:
            require(path, path.name, not set(path.stem) & set("{}") and path.name.isprintable(), "a name of one line without braces")
            if path.stem in scenes:
                raise ConfigurationError(f"{path}: expected a name of its own, got one that {scenes[path.stem][0]} has too")
            # a text file's buffers or materials lie beside it
            pattern = {".gltf": "*.bin", ".obj": "*.mtl"}.get(path.suffix.lower())
            beside = sorted(str(p) for p in path.parent.glob(pattern)) if pattern else []
            scenes[path.stem] = (str(path), [str(path), *beside])
    root = environment.get("NLG_ARCHIVE_ROOT", "")
    for found in (find_levels(options.get("archives", []), root), find_interiors(options.get("furniture", []), root, MAX_SHARDS)):
        for name, scene in found.items():
            if name in scenes:
                raise ConfigurationError(f"{scene[0]}: expected a name of its own, got one that {scenes[name][0]} has too")
            scenes[name] = scene
    require("scenes", "none", scenes, "families, a folder, archives or furniture")
    return scenes


class Run:
    """A configuration that was judged, and what follows from it: scenes, splits, and the paths of all shards."""

    def __init__(self, config, environment):
        require_plain("configuration", config)
        require_keys("top level", config, OWN_SECTIONS, OPTIONAL_SECTIONS)
        self.name = config["name"]
        require("name", self.name, isinstance(self.name, str) and len(self.name) <= 100 and re.fullmatch(r"[\w.-]*\w[\w.-]*", self.name),
                "a folder's name")
        results = environment.get("NLG_OUT") or "out"
        require("NLG_OUT", results, results.isprintable() and not set(results) & set("{}"), "a folder's name of one line without braces")
        self.folder = os.path.join(results, self.name)
        self._take_effort(config)
        self._take_representations(config["representations"])
        self._take_training()
        self._take_scenes(self.sections["scenes"], environment)
        self._take_split(config["split"])
        self._take_report(self.sections["report"])
        self._take_light(self.sections["validate_light"])

    def _take_effort(self, config):
        """Sections with what `full` holds over them, where the effort is full."""
        self.effort, full = config.get("effort", "short"), config.get("full") or {}
        require("effort", self.effort, self.effort in ("short", "full"), "short or full")
        require_keys("full", full, set(), OWN_PARTS | TOOL_SECTIONS)
        self.sections, self.full = {}, {}
        for name in OWN_PARTS | TOOL_SECTIONS:
            section, more = config.get(name) or {}, full.get(name) or {}
            for place, options in ((name, section), (f"full: {name}", more)):
                require(place, options, isinstance(options, dict), "a map of options")
            for key in more:
                require(f"full: {name}", key, is_option(key), "options of that section")
            self.full[name] = more
            self.sections[name] = {**section, **more} if self.effort == "full" else section
        self.left_out = [] if self.effort == "full" else [f"{name}.{key}: {json.dumps((config.get(name) or {}).get(key))}, full {json.dumps(value)}"
                                                          for name, options in sorted(self.full.items()) for key, value in options.items()]

    def _take_representations(self, found):
        if is_texts(found):
            found = {name: {} for name in found}
        require("representations", found, isinstance(found, dict) and found and set(found) <= set(REPRESENTATIONS),
                "a list out of " + ", ".join(REPRESENTATIONS) + ", or each of them with options of the train section")
        for name, options in found.items():
            require(f"representations: {name}", options,
                    isinstance(options, dict) and all(is_option(key) and isinstance(value, (bool, int, float, str)) for key, value in options.items()),
                    "options of the train section")
        self.representations = found

    def _take_training(self):
        """Processes and threads of each training, which the workflow starts; the tool judges all else of its section."""
        self.training_cores = {}
        for name, own in self.representations.items():
            options = {"processes": 1, "threads": 1, **self.sections["train"], **own}
            for key, largest in (("processes", MAX_PROCESSES), ("threads", 1024)):
                require(f"train: {key}", options[key], type(options[key]) is int and 1 <= options[key] <= largest, f"an integer from 1 to {largest}")
            self.training_cores[name] = options["processes"], options["threads"]

    def _take_scenes(self, options, environment):
        require_keys("scenes", options, {"families", "per_family", "folder", "jitters"}, {"archives", "furniture", "by_scene"})
        require("scenes: families", options["families"], is_texts(options["families"]) and set(options["families"]) <= set(FAMILIES),
                "a list out of " + ", ".join(FAMILIES))
        require("scenes: folder", options["folder"], isinstance(options["folder"], str), "a folder or an empty text")
        for key, smallest in (("per_family", 0), ("jitters", 1)):
            require(f"scenes: {key}", options[key], type(options[key]) is int and smallest <= options[key] <= MAX_SHARDS,
                    f"an integer from {smallest} to {MAX_SHARDS}")
        shards = len(options["families"]) * options["per_family"] * options["jitters"]
        require("scenes", f"{shards}", shards <= MAX_SHARDS, f"at most {MAX_SHARDS} shards")
        self.jitters = options["jitters"]
        self.scenes = find_scenes(options, environment)
        # another seed is another interior; jitter would take furniture apart, which is of many connected components
        self.unjittered = find_interiors(options.get("furniture", []), environment.get("NLG_ARCHIVE_ROOT", ""), MAX_SHARDS)
        self.by_scene = options.get("by_scene", {})
        require("scenes: by_scene", self.by_scene, isinstance(self.by_scene, dict), "patterns of scenes, each with options")
        for pattern, values in self.by_scene.items():
            place = f"scenes: by_scene: {pattern}"
            require(place, pattern, matching(self.scenes, [pattern]), "a pattern of some scene")
            require(place, values, isinstance(values, dict) and values, "options of nlg-datagen")
            for key, value in values.items():
                require(place, key, is_option(key) and key not in {"scene", "jitter", "held_out", "out", "config"}, "an option of the datagen section")
                is_list = isinstance(value, list) and all(isinstance(item, (int, float)) for item in value)
                require(f"{place}: {key}", value, is_list or isinstance(value, (int, float, str)), "a number, a text or a list of numbers")

    def _take_split(self, split):
        require_keys("split", split, {"held_out"}, {"evaluation"})
        for key in ("held_out", "evaluation"):
            require(f"split: {key}", split.get(key, []), is_texts(split.get(key, [])), "a list of names or patterns")
        self.held_out, self.evaluation = (matching(self.scenes, split.get(key, [])) for key in ("held_out", "evaluation"))
        kept = {*self.held_out, *self.evaluation}
        self.training = [scene for scene in self.scenes if scene not in kept]
        require("split: held_out", f"{len(self.held_out)} of {len(self.scenes)}", self.held_out and self.training, "some of the scenes, but not all")
        for pattern in split.get("evaluation", []):
            # a scene that a wrong name leaves out would be trained on
            require("split: evaluation", pattern, matching(self.scenes, [pattern]), "a pattern of some scene")
        for scene in sorted({*self.held_out} & {*self.evaluation}):
            raise ConfigurationError(f"split: expected scenes that are held out or for the evaluation, got {scene} in both")

    def _take_report(self, found):
        judged = self.held_out + self.evaluation
        report = {"savings": [*self.held_out[:1], *self.evaluation[:1]], "small_scenes": SMALL_SCENES, "stability": "full"}
        require_keys("report", found, set(), set(report))
        report.update(found)
        require("report: savings", report["savings"], is_texts(report["savings"]), "a list of names or patterns")
        for pattern in report["savings"]:
            require("report: savings", pattern, matching(judged, [pattern]), "a pattern of some scene that is held out or for the evaluation")
        require("report: small_scenes", report["small_scenes"], is_texts(report["small_scenes"]) and set(report["small_scenes"]) <= set(SMALL_SCENES),
                "a list out of " + ", ".join(SMALL_SCENES))
        require("report: stability", report["stability"], isinstance(report["stability"], str) and report["stability"] in STABILITY_DEPTHS,
                "one of " + ", ".join(STABILITY_DEPTHS))
        self.report = report

    def _take_light(self, found):
        """Scenes whose light is measured, by file name, and the flags of nlg-validate light."""
        light = {"scenes": [], "spacings": [1.0], "look_up_seconds": 0, **{key: default for key, (default, _, _) in LIGHT_COUNTS.items()}}
        require_keys("validate_light", found, set(), set(light))
        light.update(found)
        scenes, spacings, seconds = light.pop("scenes"), light["spacings"], light["look_up_seconds"]
        require("validate_light: scenes", scenes, is_texts(scenes), "a list of scenes, as nlg-bake takes them")
        self.light_scenes = {}
        for scene in scenes:
            name = re.sub(r"[^\w.-]+", "_", Path(scene).stem if scene.lower().endswith((".glb", ".gltf", ".obj", ".bsp")) else scene)
            require("validate_light: scenes", scene, re.search(r"[^\W_]", name) and name not in self.light_scenes, "scenes with names of their own")
            self.light_scenes[name] = scene
        is_number = lambda value: type(value) in (int, float)
        require("validate_light: spacings", spacings, isinstance(spacings, list) and 0 < len(spacings) <= MAX_LIGHT_SPACINGS and all(is_number(value) and 0.01 <= value <= 1000 for value in spacings),
                f"1 to {MAX_LIGHT_SPACINGS} distances from 0.01 to 1000 metres")
        require("validate_light: look_up_seconds", seconds, is_number(seconds) and 0 <= seconds <= 600, "a number from 0 to 600")
        for key, (_, smallest, largest) in LIGHT_COUNTS.items():
            require(f"validate_light: {key}", light[key], type(light[key]) is int and smallest <= light[key] <= largest, f"an integer from {smallest} to {largest}")
        self.light_spacings = [str(value) for value in light.pop("spacings")]
        self.light = light

    def light_files(self, name):
        """The file that a scene of light is read from; none where it is a built-in one."""
        scene = self.light_scenes[name]
        return [scene] if os.path.isfile(scene) else []

    def shards(self, split):
        """Paths of the shards of a split, in the order in which the tools are given them."""
        jitters = self.jitters if split == "training" else 1
        return [f"{self.folder}/dataset/{split}/{scene}.{jitter}.h5" for scene in getattr(self, split)
                for jitter in range(1 if scene in self.unjittered else jitters)]

    def artefacts(self):
        """Files that the run makes and keeps, in the order in which it makes them; shards aside, and what is in picture_folders."""
        judged = ["validation", *(["evaluation"] if self.evaluation else [])]
        names = ["basis.h5", "basis.json"]
        for name in self.representations:
            names += [f"training/{name}.ckpt", f"training/{name}.csv", f"training/{name}.json", f"training/{name}/curve.png",
                      f"weights/{name}.safetensors", f"weights/{name}.json"]
        names += [f"{split}/{file}" for split in judged for file in ("summary.json", "functions.csv", "slices.json")]
        names += [f"hierarchy/{scene}.hierarchy.json" for scene in self.report["small_scenes"]]
        names += [f"{split}/frontier.{ending}" for split in judged for ending in ("json", "csv")]
        names += [*([] if self.report["stability"] == "short" else ["training_cases.json"]), "stability.json"]
        names += [f"savings/{scene}.json" for scene in matching(self.held_out + self.evaluation, self.report["savings"])]
        names += [f"light/{scene}.json" for scene in self.light_scenes]
        names += [f"{split}{file}" for split in ("", *(f"{name}/" for name in judged[1:])) for file in ("report.html", "slices.png")]
        return [f"{self.folder}/{name}" for name in names]

    def picture_folders(self):
        """Folders that a rule makes with whatever is in them."""
        return [f"{self.folder}/light/{scene}_places" for scene in self.light_scenes]

    def section(self, name):
        """A tool's options as text: a change of them re-runs the rule."""
        return json.dumps(self.sections[name], sort_keys=True)

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
    environment   NLG_OUT, NLG_LEVELS and NLG_ARCHIVE_ROOT stand in for `out`, scenes.folder and the root of archives' folders
    throws        ConfigurationError
    """
    try:
        return Run(config, environment)
    except (ValueError, OSError) as error:
        raise ConfigurationError(f"{path}: {error}") from None


def load(path):
    return judge(read(path), path)


def of_snakemake(config, path):
    """The run of a file that Snakemake was given, by --configfile or --config file=FILE.

    config   what Snakemake took for the configuration: anything in it that the file does not hold would not reach the tools, which read the file
    """
    content = read(path)
    for key in sorted(set(config) - {"file"}, key=str):
        if not isinstance(content, dict) or key not in content or content[key] != config[key]:
            raise ConfigurationError(f"--config: expected file=FILE and nothing else beside one --configfile, got {key!r}")
    return judge(content, path)


def main():
    if len(sys.argv) != 2:
        raise UsageError("configuration.py", "CONFIG", f"{len(sys.argv) - 1} arguments")
    print(load(sys.argv[1]).folder)


if __name__ == "__main__":
    sys.exit(run("pipeline.sh", main))

"""What a run measured, reduced to what the documentation quotes or tables: docs/results/NAME.json. Read by results.py.

Taken are, where the run's folder has them:
    evaluation/summary.json    nlg-validate, schema_version 2
    evaluation/frontier.json   nlg-validate frontier, schema_version 2
    stability.json             nlg-validate stability
    bakes/SCENE.json           nlg-bake (--json)
    benchmarks/*.json          bench_* --benchmark_out=FILE --benchmark_out_format=json
"""
import datetime
import json
import math
import re
import sys
from pathlib import Path

sys.path.insert(0, str(Path(__file__).resolve().parents[2]))  # tool/, which all scripts share
from tool.errors import InputError
from tool.input_file import as_documented, read_header, training_scenes
from tool.input_file import read_json as read_node

STAGES = ("network", "corrected", "fitted", "stored")
POPULATIONS = ("all", "theta", "hard")
FITS = ("direct", "best_known")
ERRORS = ("blend_rmse", "rmse")
SCHEMA_VERSION = 2  # of summary.json and frontier.json
RESULTS_VERSION = 2  # of docs/results/NAME.json
STATISTICS = ("median", "mean", "p95")
WEIGHTS = Path(__file__).resolve().parents[2] / "weights"
OURS = "tent_mlp4"  # what nlg-bake takes without being told
DIGITS = 4  # significant: as many as any text shows


def fail(place, expected, got):
    path, _, inside = str(place).partition(": ")
    raise InputError(path, inside or "file", expected, got)


def read_json(path):
    return read_node(path).value


def rounded(value, place=""):
    """The same value with numbers of at most DIGITS significant digits; refuses NaN and infinity."""
    if isinstance(value, dict):
        return {key: rounded(item, f"{place}.{key}") for key, item in value.items()}
    if isinstance(value, list):
        return [rounded(item, place) for item in value]
    if isinstance(value, float):
        if not math.isfinite(value):
            fail(place, "a finite number", value)
        return int(value) if value.is_integer() and abs(value) < 1e15 else float(f"{value:.{DIGITS}g}")
    return value


def take(source, keys, place):
    """The named keys, all of which must be there."""
    missing = [key for key in keys if key not in source]
    if missing:
        fail(place, f"the keys {', '.join(keys)}", f"none of the name {missing[0]}")
    return {key: source[key] for key in keys}


def slug(name):
    """A key that can stand in a way of keys: "generator/float32:96" is generator_float32_96."""
    return re.sub(r"\W+", "_", name).strip("_")


def trained_on(name):
    """The scenes that the supplied weights of a representation have seen, under the names that files of results have."""
    path = WEIGHTS / f"{name}.safetensors"
    seen = training_scenes(read_header(path)[0])
    if seen is None:
        fail(path, "the scenes that it was trained on", "none")
    return {slug(scene) for scene in seen}


def revision(document, place):
    return take(document, ["provenance"], place)["provenance"].get("revision", "unknown")


def figures(source, place):
    """One population's figures; of the blend RMSE with intervals."""
    out = {"functions": source["functions"], **{key: take(take(source, ERRORS, place)[key], STATISTICS, f"{place}.{key}") for key in ERRORS}}
    out["blend_rmse"]["interval"] = take(source["blend_rmse"]["interval"], ["mean", "p95"], f"{place}.blend_rmse.interval")
    out["rmse_occluded"] = take(source["rmse_occluded"], ["mean"], f"{place}.rmse_occluded")
    return {**out, **take(source, ["share_failing_check", "share_fitted", "us_per_function"], place)}


def by_population(source, place):
    return {key: figures(take(source, POPULATIONS, place)[key], f"{place}.{key}") for key in POPULATIONS}


def sample(source, place):
    """What direct fits were made of: too few functions for percentiles of their own to stand beside those of all."""
    def short(population, where):
        return {"blend_rmse": take(population["blend_rmse"], ["mean"], where), **take(population, ["us_per_function"], where)}
    words = [word for word in (*STAGES, *FITS) if word in source]
    ratios = {word: {"to_best_known": take(entry["to_best_known"], ["median", "median_hard"], f"{place}.ratios.{word}")} for word, entry in take(source, ["functions", "hard", "ratios"], place)["ratios"].items()}
    return {**take(source, ["functions", "hard"], place), "ratios": ratios, **{word: {"theta": short(source[word]["theta"], f"{place}.{word}.theta")} for word in words}}


def representation(source, place):
    out = take(source, ["parameters", "theta_bytes", "weights_bytes", "weights_sha256", "stages"], place)
    out.update({key: source[key] for key in ("evaluate_us", "stored_bytes_mean") if key in source})
    out.update({word: by_population(source[word], f"{place}.{word}") for word in STAGES})
    if "sample" in source:
        out["sample"] = sample(source["sample"], f"{place}.sample")
    return out


def read_measured(path):
    """summary.json or frontier.json."""
    document = read_json(path)
    if document.get("schema_version") != SCHEMA_VERSION:
        fail(path, f"schema_version {SCHEMA_VERSION}", document.get("schema_version"))
    return document


def summary(path):
    document = read_measured(path)
    out = {"revision": revision(document, path), "held_out_sha256": document["provenance"].get("inputs", {}).get("held_out", ""),
           **take(document, ["tau", "theta_precision", "functions"], path), "tent": by_population(document["tent"], f"{path}: tent")}
    out["representations"] = {name: representation(entry, f"{path}: {name}") for name, entry in document["representations"].items()}
    return out


def point_key(point, others):
    """"corrected", "lm_from_theta0_16", "stages_exact_last_layer": the name of a point among those of its representation."""
    key = point["family"] if point["budget"] is None else slug(f"{point['family']}_{point['budget']}")
    return key if key not in others and point["family"] != "stages" else slug(f"{point['family']}_{point['label']}")


def frontier(path):
    """Points of the front of functions that take a theta, by representation and family."""
    document = read_measured(path)
    keys = ["functions", "front_sentences", "speed_at_equal_error"]
    out = {"revision": revision(document, path), "held_out_sha256": document["provenance"].get("inputs", {}).get("held_out", ""),
           **take(document, keys, path), "points": {}}
    for point in document["points"]:
        if not point["figures"]["theta"]["on_front"]:
            continue
        kept = {key: value for key, value in point.items() if key not in {"representation", "by_scene"}}
        others = out["points"].setdefault(point["representation"], {})
        others[point_key(point, others)] = kept
    return out


def stability(path):
    """Cases; what was promised and measured of those alone that do not hold."""
    document = read_json(path)
    texts = lambda case: ["must_hold", "measured"] if not case["holds"] else []
    return {"revision": revision(document, path), "cases": [take(case, ["group", "name", "holds", *texts(case)], path) for case in document["cases"]]}


BAKE_COUNTS = ("threads", "probes", "free_space", "in_solid", "empty", "bare_tents", "duplicates", "functions", "took_fit", "still_failing", "bytes",
               "bytes_per_probe")
BAKE_STAGES = {"network": ["network", "check"], "corrected": ["last_layer"], "fitted": ["lm", "lm_theta0", "adam"],
               "refinement": ["refinement", "larger"]}


def bake(path):
    """One bake: counts, thread seconds by stage, errors by stage."""
    document = read_json(path)
    seconds = take(document, ["thread_seconds"], path)["thread_seconds"]
    out = {**take(document, ["scene", *BAKE_COUNTS, "share_fitted"], path), "wall_s": document["wall_seconds"]["all"],
           "light_s": sum(take(document, ["light"], path)["light"]["wall_seconds"].values()) if document.get("light") else 0.0,
           "thread_s": take(seconds, ["visibility", "functions", "duplicates"], path)}
    out["thread_s"].update({word: sum(seconds["stages"].get(stage, 0.0) for stage in stages) for word, stages in BAKE_STAGES.items()})
    return {**out, "rmse": {word: take(document["rmse"][word], ["mean", "p95", "worst"], path) for word in STAGES}}


TIME_UNITS_US = {"ns": 1e-3, "us": 1, "ms": 1e3, "s": 1e6}
NO_COUNTERS = {"name", "family_index", "per_family_instance_index", "run_name", "run_type", "repetitions", "repetition_index", "threads", "iterations",
               "real_time", "cpu_time", "time_unit", "aggregate_name", "aggregate_unit"}


def benchmarks(paths):
    """Every case's time and counters; of repetitions the median."""
    out = {}
    for path in paths:
        out.update(held_to(cases_of, path))
    return out


def cases_of(path):
    """Those of one file of Google Benchmark."""
    out = {}
    cases = read_json(path)["benchmarks"]
    medians = [case for case in cases if case.get("aggregate_name") == "median"]
    for case in medians or [case for case in cases if case.get("run_type") != "aggregate"]:
        if case.get("error_occurred"):
            continue
        unit = TIME_UNITS_US[case["time_unit"]]
        name = case.get("run_name", case["name"])
        out[slug(name)] = {"case": name, "us": case["cpu_time"] * unit, "wall_us": case["real_time"] * unit,
                           **{key: value for key, value in case.items() if key not in NO_COUNTERS and isinstance(value, (int, float))}}
    return out


def weights_named(section, path):
    """Representation or number → SHA-256, as a result's file names the weights that it is of."""
    document = read_json(path)
    if section == "bakes":
        return {name: entry["sha256"] for name, entry in document.get("weights", {}).items()}
    return {name: sha256 for name, sha256 in document.get("provenance", {}).get("inputs", {}).items() if name.startswith("weights")}


def check_weights(results, files):
    """Every section's figures are of the weights of the evaluation.

    files   section → its files, which name their weights beside the figures
    """
    hashes = {name: entry["weights_sha256"] for name, entry in results.get("evaluation", {}).get("representations", {}).items()}
    for section, paths in files.items():
        for path in paths:
            for name, sha256 in held_to(lambda file: weights_named(section, file), path).items():
                if hashes and sha256 not in hashes.values():
                    fail(f"{path}: {name}", "figures of weights " + " or ".join(sorted(hashes.values())), sha256)
    return hashes


def held_to(read, path):
    """read(path), which takes the file's values as they come."""
    with as_documented(path):
        return read(path)


def today():
    return datetime.date.today().isoformat()


def collect(run, configuration):
    """The results of one run's folder."""
    out = {"schema_version": RESULTS_VERSION, "run": run.name, "configuration": configuration, "command": f"./pipeline.sh {configuration}"}
    out["date"] = today()
    if (run / "machine.txt").exists():
        out["machine"] = (run / "machine.txt").read_text().strip()
    readers = {"evaluation": ("evaluation/summary.json", summary), "frontier": ("evaluation/frontier.json", frontier), "stability": ("stability.json", stability)}
    files = {}  # of sections that name their weights beside the figures
    for section, (file, read) in readers.items():
        if (run / file).exists():
            out[section] = held_to(read, run / file)
            if read is not summary:
                files[section] = [run / file]
    if found := sorted((run / "bakes").glob("*.json")):
        out["bakes"] = {file.stem: held_to(bake, file) for file in found}
        files["bakes"] = found
    if found := sorted((run / "benchmarks").glob("*.json")):
        out["benchmarks"] = benchmarks(found)
    if not set(out) & {"evaluation", "frontier", "stability", "bakes", "benchmarks"}:
        fail(run, "the folder of a run that measured something", "none of its files")
    if "frontier" in out and "evaluation" in out and out["frontier"]["held_out_sha256"] != out["evaluation"]["held_out_sha256"]:
        fail(run / "evaluation/frontier.json", "the shards of summary.json", "other shards")
    out["weights"] = check_weights(out, files)
    return rounded(out, str(run))


def dump(value, indent=""):
    """JSON with a line for every leaf of the tree that fits on one: differences between two revisions are readable."""
    text = json.dumps(value, ensure_ascii=False)
    if not isinstance(value, (dict, list)) or len(indent) + len(text) <= 150:
        return text
    deeper = indent + " "
    if isinstance(value, list):
        return "[\n" + ",\n".join(deeper + dump(item, deeper) for item in value) + f"\n{indent}]"
    return "{\n" + ",\n".join(f"{deeper}{json.dumps(key, ensure_ascii=False)}: {dump(item, deeper)}" for key, item in value.items()) + f"\n{indent}}}"

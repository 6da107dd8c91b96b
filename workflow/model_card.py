"""Model cards of the weights that ship: weights/README.md.

    workflow/model_card.py RUN CONFIG REPRESENTATION ...

writes down in docs/results/weights.json how the weights of a run came about that now lie in weights/: scenes, time, rounding. Called by
workflow/ship_weights.sh. The cards themselves are written by workflow/results.py, from that file, from the headers of the weights, and from the figures
that all of the documentation quotes (docs/results/openarena.json).

RUN     the run's result folder (out/NAME): dataset/, training/, weights/
CONFIG  the configuration that the run was made by
"""
import argparse
import json
import re
import struct
import sys
from pathlib import Path

from results_collect import STAGES, dump, fail, read_json
from results_page import POPULATION_NAMES, POPULATION_ORDER, ratio, share, table
from results_quotes import MAIN, microseconds, number, percent
from tool.atomic_file import write_atomically
from tool.errors import run as run_script
from tool.input_file import as_documented, read_bytes
from tool.input_file import sha256 as hash_of

ROOT = Path(__file__).resolve().parents[1]
WEIGHTS = ROOT / "weights"
FACTS = ROOT / "docs" / "results" / "weights.json"

INTRODUCTION = """# Weights that ship

*Written by `workflow/results.py write`; change nothing here by hand.*

These are trained generators, one for each representation. `nlg-bake` takes them when no weights are named; `--representation` says which ([bake](../docs/guide/bake.md)). The test suite loads every file and holds all of them together to 32 MB.
Each comes from a run of the pipeline, and

```sh
./pipeline.sh CONFIG                                              # out/NAME
workflow/ship_weights.sh out/NAME CONFIG REPRESENTATION ...
```

puts it here with its card.

All errors are RMSE over all valid support points, of functions of scenes that the generators were not trained on. They stand under four words. *Network* is one pass of the generator's network and nothing else. *Corrected* adds what needs no iterative fit: the exact last layer, and learned steps and mirror images where the policy has any. *Fitted* adds every step of Adam or Levenberg–Marquardt that the bake takes. *Stored* is what the grid holds in the end, bare tents and rounding included.
*Share fitted* is the share of functions that took any such step, whether or not its result was kept. *Best known* is the least error that any long fit has found for the same functions. Parentheses hold 95 % intervals. The whole tables, and how all of it was measured, are on the [results page](../docs/reference/results.md).
"""


def read_header(path):
    """The texts of a weights file, and its tensors' dtypes and shapes."""
    with as_documented(path):
        data = read_bytes(path)
        header = json.loads(data[8 : 8 + struct.unpack_from("<Q", data)[0]])
        metadata = header.pop("__metadata__")
        return metadata, {name: tensor for name, tensor in header.items() if not name.startswith("padding.")}


def training_scenes(run):
    """"72 scenes, 5 variants each: …", by the shards that the run left."""
    shards = sorted(path.name for path in (run / "dataset" / "training").glob("*.h5"))
    if not shards:
        fail(run / "dataset" / "training", "the training shards", "none")
    scenes = sorted({shard.rsplit(".", 2)[0] for shard in shards})
    families = {}
    for scene in scenes:
        match = re.fullmatch(r"(house|maze|colonnade|stairs|clutter|outdoor|cave|flat|townhouse|office|villa)_(\d+)(_.*)?", scene)
        families.setdefault(match[1] if match else "", []).append(scene)
    levels = families.pop("", [])
    parts = [f"{len(members)} of the procedural family {family}" for family, members in sorted(families.items())]
    parts += [", ".join(levels)] if levels else []
    return f"{len(scenes)} scenes, {len(shards)} shards: " + "; ".join(parts)


def training_facts(run, config, name):
    """What the weights file itself does not say of how it came about."""
    shipped, made = WEIGHTS / f"{name}.safetensors", run / "weights" / f"{name}.safetensors"
    if hash_of(shipped) != hash_of(made):
        fail(shipped, f"the run's {made}", "another file")
    exported, training = read_json(run / "weights" / f"{name}.json"), read_json(run / "training" / f"{name}.json")
    return {"sha256": hash_of(shipped), "configuration": config, "scenes": training_scenes(run), "minutes": round(training["elapsed_s"] / 60),
            "samples_per_s": round(training["samples_per_s"]), "steps": training["steps"], "parity_theta": exported["parity_theta"],
            "parity_functions": exported["parity_functions"], "held_out_rmse": exported["held_out_rmse"],
            "rounding_rmse": exported["held_out_rmse"] - exported["held_out_rmse_float32"]}


def facts_table(name, facts, entry):
    path = WEIGHTS / f"{name}.safetensors"
    metadata, tensors = read_header(path)
    sha256, parameters = hash_of(path), tensors["theta0"]["shape"][0]
    if facts["sha256"] != sha256:
        fail(f"{FACTS}: {name}", f"facts of weights {sha256}", facts["sha256"])
    if entry and entry["weights_sha256"] != sha256:
        fail(f"docs/results/{MAIN}.json: {name}", f"figures of weights {sha256}", entry["weights_sha256"])
    halves = any(tensor["dtype"] == "F16" for tensor in tensors.values())
    rows = [
        ("file", f"`{path.name}`, {path.stat().st_size:,} bytes, " + ("matrices in float16" if halves else "float32")),
        ("SHA-256", f"`{sha256}`"),
        ("a function", f"{parameters} numbers" + (": " + ", ".join(f"{size:,} bytes in {precision}" for precision, size in entry["theta_bytes"].items()) if entry else "")),
        ("trained on", f"{int(metadata['training_functions']):,} distinct functions; {facts['scenes']}"),
        ("training set", f"`{metadata['training_set_sha256']}`"),
        ("configuration", f"`{facts['configuration']}`"),
        ("options", ", ".join(f"{key} {value}" for key, value in json.loads(metadata["training_options"]).items())),
        ("time", f"{facts['minutes']} minutes, {facts['samples_per_s']:,} samples/s, {facts['steps']:,} steps"),
        ("revision", f"`{json.loads(metadata['provenance'])['revision']}`"),
        ("parity", f"θ of libtorch and of the evaluator differ by at most {facts['parity_theta']:.1e} over {facts['parity_functions']:,} functions"),
        ("rounding", f"float16 changes the mean RMSE over those functions by {facts['rounding_rmse']:+.1e}"),
    ]
    if entry and "evaluate_us" in entry:
        rows.append(("evaluation", f"{microseconds(entry['evaluate_us'])} µs for one θ at 8,192 points"))
    return table(["", ""], rows)


def quantile_cells(q):
    return [f"{q['functions']:,}", *(number(q[key]) for key in ("median", "mean", "p95", "p99", "worst"))]


def split_text(title, split, name):
    """Errors of one set of scenes: by population and stage, then by scene."""
    entry, counts = split["representations"][name], split["functions"]
    rows = []
    for population in POPULATION_ORDER:
        for word in STAGES:
            found = entry[word][population]
            rows.append([POPULATION_NAMES[population] if word == STAGES[0] else "", word, *quantile_cells(found["rmse"]),
                         number(found["rmse_test_points"]["mean"]), number(found["rmse_occluded"]["mean"]),
                         percent(found["share_failing_check"]["value"]), percent(found["share_fitted"]["value"]), microseconds(found["us_per_function"])])
    head = ["", "word", "functions", "median", "mean", "p95", "p99", "worst", "test points, mean", "occluded, mean", "fails the check", "fitted", "µs"]
    text = f"\n{title}: {counts['held_out']:,} functions of {counts['held_out_scenes']} scenes.\n" + table(head, rows)
    if "sample" in entry:
        ratios = entry["sample"]["ratios"]
        parts = [f"{word} {ratio(ratios[word]['to_best_known']['median'])}, hard {ratio(ratios[word]['to_best_known']['median_hard'])}" for word in STAGES]
        text += f"\nError over the best known, median over a sample of {entry['sample']['functions']:,} functions: " + "; ".join(parts) + ".\n"
    rows = [[scene, *quantile_cells(words["stored"]), number(words["network"]["mean"]), number(words["network"]["p95"])]
            for scene, words in entry["by_scene"].items()]
    head = ["scene", "functions that take a θ", "stored: median", "mean", "p95", "p99", "worst", "network: mean", "p95"]
    return text + table(head, rows)


def overview(names, evaluation):
    """One row a representation, the smallest first."""
    rows = []
    for name in names:
        entry = evaluation["representations"][name]
        theta, hard = ({word: entry[word][population] for word in STAGES} for population in ("theta", "hard"))
        cells = [f"[{name}](#{name})", entry["parameters"], entry["theta_bytes"]["int8"], f"{entry['weights_bytes'] / 1000:,.0f} kB",
                 *(number(theta[word]["rmse"]["mean"]) for word in STAGES), number(theta["stored"]["rmse"]["p95"]), number(hard["stored"]["rmse"]["median"]),
                 percent(theta["network"]["share_failing_check"]["value"]), share(theta["fitted"]["share_fitted"]),
                 share(entry["fitted"]["all"]["share_fitted"])]
        if "sample" in entry:
            to_best = entry["sample"]["ratios"]["stored"]["to_best_known"]
            cells += [ratio(to_best["median"]), ratio(to_best["median_hard"])]
        rows.append((entry["parameters"], cells))
    head = ["", "numbers", "bytes, int8", "file", "network: mean", "corrected: mean", "fitted: mean", "stored: mean", "stored: p95", "hard, stored: median",
            "network fails the check", "share fitted", "of all functions", "stored over best known, median", "hard"]
    rows = [cells + [""] * (len(head) - len(cells)) for _, cells in sorted(rows, key=lambda row: row[0])]
    counts = evaluation["functions"]
    text = f"\nEvaluation: the {counts['take_theta']:,} functions that take a θ, of {counts['held_out_scenes']} scenes, none of them trained on. What is stored has θ in {evaluation['theta_precision']}.\n"
    return text + table(head, rows)


def page(all_results):
    """weights/README.md: a table over all, then a card each."""
    facts, results = all_results["weights"], all_results[MAIN]
    names = sorted(path.stem for path in WEIGHTS.glob("*.safetensors"))
    splits = {title: results[key] for key, title in (("evaluation", "Evaluation"), ("validation", "Validation")) if "representations" in results.get(key, {})}
    text = INTRODUCTION
    measured = [name for name in names if name in splits.get("Evaluation", {"representations": {}})["representations"]]
    text += overview(measured, splits["Evaluation"]) if measured else "\nThe figures are measured again with the present policy and are pending.\n"
    for name in names:
        if name not in facts:
            fail(FACTS, f"how {name}.safetensors came about", "nothing: ship it by workflow/ship_weights.sh")
        entries = [split["representations"][name] for split in splits.values() if name in split["representations"]]
        text += f"\n## {name}\n" + facts_table(name, facts[name], entries[0] if entries else None)
        text += "".join(split_text(title, split, name) for title, split in splits.items() if name in split["representations"])
    return text


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("run", type=Path)
    parser.add_argument("config")
    parser.add_argument("representations", nargs="+")
    arguments = parser.parse_args()
    facts = read_json(FACTS) if FACTS.exists() else {}
    for name in arguments.representations:
        with as_documented(arguments.run):
            facts[name] = training_facts(arguments.run, arguments.config, name)
    write_atomically(FACTS, (dump(dict(sorted(facts.items()))) + "\n").encode())


if __name__ == "__main__":
    sys.exit(run_script("model_card", main))

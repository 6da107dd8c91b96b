"""Model cards of the weights that ship: weights/README.md.

    workflow/model_card.py RUN CONFIG REPRESENTATION ...
    workflow/model_card.py --may-ship RUN CONFIG REPRESENTATION ...

The first writes down in docs/results/weights.json how the weights of a run came about that now lie in weights/: scenes, time, rounding. Called by
workflow/ship_weights.sh. The cards themselves are written by workflow/results.py, from that file, from the headers of the weights, and from the figures
that all of the documentation quotes (docs/results/openarena.json).

The second says what stands against shipping them, before anything is copied: weights of a revision with changes that nobody can look up, and
stored errors that are beyond the intervals of what lies in weights/ now. Exit code 6 where something does.

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
from results_page import judgements, ratio, share, table
from results_quotes import MAIN, microseconds, number, percent
from tool.atomic_file import write_atomically
from tool.errors import CHECK_FAILED
from tool.errors import run as run_script
from tool.input_file import as_documented, read_bytes
from tool.input_file import sha256 as hash_of

ROOT = Path(__file__).resolve().parents[1]
WEIGHTS = ROOT / "weights"
FACTS = ROOT / "docs" / "results" / "weights.json"

FRONT_MATTER = """---
license: mit
tags: [light-probes, light-grid, hypernetwork, global-illumination, game-development]
metrics: [rmse]
---
"""  # what model hubs read

INTRODUCTION = FRONT_MATTER + """# Weights that ship

*`workflow/results.py write` writes this page; change nothing here by hand.*

These are trained generators, one a representation: a way to store a weighting function as a few numbers, θ. `nlg-bake` takes `tent_mlp4` when no weights are named; `--representation` names another ([bake](../docs/guide/bake.md)). All files together take at most 32 MB, which a test holds them to.

| representation | what stands for a function |
|---|---|
| `mlp` | the network of the talk: 3 → 8 → 8 → 1 units, LeakyReLU |
| `tent_mlp` | the same network, times the tent, the pyramid around the probe |
| `tent_mlp44` | the tent times the sigmoid of a network of 3 → 4 → 4 → 1 units |
| `tent_mlp4` | the tent times the sigmoid of a network of 3 → 4 → 1 units |
| `pf3` … `pf9` | a product field: two grids of 3³ … 9³ nodes, interpolated; one is clamped, the other goes through a sigmoid, and they are multiplied |
| `code16` … `code128` | the tent times the sigmoid of a sum of so many logits: all functions share them, and θ says how much of each. A function stores as many as it needs |

Each comes from a run of the pipeline. `ship_weights.sh` puts it here with its card:

```sh
./pipeline.sh CONFIG                                              # out/NAME
workflow/ship_weights.sh out/NAME CONFIG REPRESENTATION ...
```
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
        match = re.fullmatch(r"(house|maze|colonnade|stairs|clutter|outdoor|cave|kitchen|gallery|meeting|flat|townhouse|office|villa)_(\d+)(_.*)?", scene)
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
            "parity_functions": exported["parity_functions"], "held_out_blend_rmse": exported["held_out_blend_rmse"],
            "rounding_blend_rmse": exported["held_out_blend_rmse"] - exported["held_out_blend_rmse_float32"]}


def known_facts(name, facts, entry):
    """One row of the table of files; refuses facts and figures of other weights than those that ship."""
    path = WEIGHTS / f"{name}.safetensors"
    metadata, tensors = read_header(path)
    sha256 = hash_of(path)
    if facts["sha256"] != sha256:
        fail(f"{FACTS}: {name}", f"facts of weights {sha256}", facts["sha256"])
    if entry and entry["weights_sha256"] != sha256:
        fail(f"docs/results/{MAIN}.json: {name}", f"figures of weights {sha256}", entry["weights_sha256"])
    return {"name": name, "sha256": sha256, "bytes": path.stat().st_size, "numbers": tensors["theta0"]["shape"][0], "dtype": "float16" if any(tensor["dtype"] == "F16" for tensor in tensors.values()) else "float32",
            "functions": int(metadata["training_functions"]), "training_set": metadata["training_set_sha256"], "options": json.loads(metadata["training_options"]),
            "revision": json.loads(metadata["provenance"])["revision"], **facts}


def sizes_section(cards, entries):
    rows = []
    for card in cards:
        entry = entries.get(card["name"])
        sizes = [f"{size:,}" for size in entry["theta_bytes"].values()] if entry else ["", "", ""]
        if entry and "stored_bytes_mean" in entry and card["name"].startswith("code"):
            sizes[-1] = f"{entry['stored_bytes_mean']:.0f} on average"
        rows.append([f"`{card['name']}`", f"{card['numbers']:,}", *sizes, microseconds(entry["evaluate_us"]) if entry and "evaluate_us" in entry else "", f"{card['bytes'] / 1000:,.0f} kB", card["dtype"]])
    return ("\n## Sizes\nBytes are those of one θ. int8 keeps the last layers of networks, and whole product fields, in float16; a code takes as many numbers as its function needs.\n"
            + table(["", "numbers", "bytes in float32", "in float16", "in int8", "µs for one θ at 8,192 points", "file", "matrices in"], rows))


def errors_section(names, results):
    """One row a representation."""
    evaluation, verdicts, rows = results["evaluation"], judgements(results), []
    for name in names:
        entry = evaluation["representations"][name]
        theta, hard = ({word: entry[word][population] for word in STAGES} for population in ("theta", "hard"))
        to_best = entry["sample"]["ratios"]["stored"]["to_best_known"] if "sample" in entry else None
        rows.append([f"`{name}`", *(number(theta[word]["blend_rmse"]["mean"]) for word in STAGES), number(theta["stored"]["blend_rmse"]["p95"]), number(hard["stored"]["blend_rmse"]["mean"]), number(theta["stored"]["rmse"]["mean"]),
                     percent(theta["stored"]["share_failing_check"]["value"]), share(theta["fitted"]["share_fitted"]), microseconds(theta["stored"]["us_per_function"]), ratio(to_best["median"]) if to_best else "", verdicts[name].verdict if name in verdicts else ""])
    counts = evaluation["functions"]
    head = ["", *(f"{word}, mean" for word in STAGES), "stored, p95", "stored, hard: mean", "stored, mean RMSE", "fails the check", "share fitted", "µs a function", "stored over best known, median", "[by our rule](../docs/guide/training.md#may-it-ship)"]
    return (f"\n## Errors\nOf the {counts['take_theta']:,} functions that take a θ in {counts['held_out_scenes']} levels and villas that no generator was trained on. Errors are blend RMSEs where nothing else is said. Revision `{evaluation['revision']}`. "
            "The [results page](../docs/reference/results.md#words) says what the words mean, and has more.\n" + table(head, rows))


def training_section(cards):
    """What the cards have in common once, and a table of what differs."""
    # "308 scenes, 820 shards" differ where the scenes themselves, which fill lines, do not
    cards = [{**card, **dict(zip(("shards", "scenes"), card["scenes"].split(": ", 1)))} for card in cards]
    shared = lambda key: len({json.dumps(card[key]) for card in cards}) == 1
    keys = list(dict.fromkeys(key for card in cards for key in card["options"]))
    # options come and go: those of a card that has one are compared
    values = {key: [card["options"][key] for card in cards if key in card["options"]] for key in keys}
    common = [key for key in keys if len({json.dumps(value) for value in values[key]}) == 1 and len(values[key]) > 1]
    titles = {"configuration": "Configuration", "functions": "Distinct functions", "training_set": "Training set", "shards": "Data", "scenes": "Scenes"}
    shown = lambda value: f"{value:,}" if isinstance(value, int) else str(value)
    text = "\n## How they were trained\n" + "".join(f"- {title}: {shown(cards[0][key])}\n" for key, title in titles.items() if shared(key))
    text += "- Options of all that have them: " + ", ".join(f"{key} {values[key][0]}" for key in common) + "\n"
    rest = [key for key in titles if not shared(key)]
    rows = [[f"`{card['name']}`", *(shown(card[key]) for key in rest), *(card["options"].get(key, "") for key in keys if key not in common), card["minutes"], f"{card['samples_per_s']:,}", f"`{card['revision']}`",
             f"{card['parity_theta']:.1e}", f"{card['rounding_blend_rmse']:+.1e}" if "rounding_blend_rmse" in card else f"{card['rounding_rmse']:+.1e} RMSE"] for card in cards]
    text += table(["", *(key.replace("_", " ") for key in rest), *(key for key in keys if key not in common), "minutes", "samples/s", "revision", "parity", "rounding"], rows)
    return text + (f"\n*Parity*: the largest difference between θ of libtorch and of the evaluator, over {cards[0]['parity_functions']:,} functions. "
                   "*Rounding*: what float16 changes of the mean blend RMSE over them, or, where it says so, of the mean RMSE.\n")


def page(all_results):
    """weights/README.md: what differs between the generators, as tables."""
    facts, evaluation = all_results["weights"], all_results[MAIN].get("evaluation", {})
    entries = evaluation.get("representations", {})
    cards = []
    for name in sorted(path.stem for path in WEIGHTS.glob("*.safetensors")):
        if name not in facts:
            fail(FACTS, f"how {name}.safetensors came about", "nothing: ship it by workflow/ship_weights.sh")
        cards.append(known_facts(name, facts[name], entries.get(name)))
    cards.sort(key=lambda card: (card["numbers"], card["name"]))
    text = INTRODUCTION + sizes_section(cards, entries)
    if measured := [card["name"] for card in cards if card["name"] in entries]:
        text += errors_section(measured, all_results[MAIN])
    return text + training_section(cards) + "\n## Files\n" + table(["", "SHA-256"], [[f"`{card['name']}.safetensors`", f"`{card['sha256']}`"] for card in cards])


def objections(run, names):
    """What stands against shipping a run's weights, a line each."""
    measured = read_json(run / "evaluation/summary.json")["representations"]
    shipped = read_json(ROOT / f"docs/results/{MAIN}.json").get("evaluation", {}).get("representations", {})
    for name in names:
        revision = json.loads(read_header(run / "weights" / f"{name}.safetensors")[0]["provenance"])["revision"]
        if revision.endswith("-dirty"):
            yield f"{name}: of revision {revision}, which nobody can look up: train from a clean checkout"
        if name not in measured:
            yield f"{name}: not measured by this run"
        elif name in shipped and "blend_rmse" in shipped[name]["stored"]["theta"]:
            now, before = (source[name]["stored"]["theta"]["blend_rmse"] for source in (measured, shipped))
            if now["interval"]["mean"][0] > before["interval"]["mean"][1]:
                yield f"{name}: stored mean blend RMSE {now['mean']:.4f}, of the weights that ship {before['mean']:.4f}, beyond both intervals"


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("run", type=Path)
    parser.add_argument("config")
    parser.add_argument("representations", nargs="+")
    parser.add_argument("--may-ship", action="store_true")
    arguments = parser.parse_args()
    if arguments.may_ship:
        with as_documented(arguments.run):
            found = list(objections(arguments.run, arguments.representations))
        for line in found:
            print(f"ship_weights: {line}", file=sys.stderr)
        return CHECK_FAILED if found else 0
    facts = read_json(FACTS) if FACTS.exists() else {}
    for name in arguments.representations:
        with as_documented(arguments.run):
            facts[name] = training_facts(arguments.run, arguments.config, name)
    write_atomically(FACTS, (dump(dict(sorted(facts.items()))) + "\n").encode())


if __name__ == "__main__":
    sys.exit(run_script("model_card", main))

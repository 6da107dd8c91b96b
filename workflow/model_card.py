"""Model cards of the weights that ship: weights/README.md, from the folder of the run that made them.

    workflow/model_card.py RUN CONFIG WEIGHTS REPRESENTATION ...

RUN      a run's result folder (out/NAME): weights/, training/, validation/, and test/ where the configuration has a test
CONFIG   the configuration that the run was made by
WEIGHTS  the folder that holds the shipped files; its README.md gets a card for every REPRESENTATION, others keep theirs
"""
import argparse
import hashlib
import json
import re
import struct
import sys
from pathlib import Path

INTRODUCTION = """# Weights that ship

Trained generators, one a representation: what `nlg-bake` takes when no weights are named (`--representation` says which, [docs/guide/bake.md](../docs/guide/bake.md)). Every file is checked by the test suite: it loads, and all together they take at most 12 MB.

They are made by a run of the pipeline and put here, with these cards, by

```sh
./pipeline.sh CONFIG                                              # out/NAME
workflow/ship_weights.sh out/NAME CONFIG REPRESENTATION ...
```

Errors are RMSE over all valid support points, of what the generator yields, nothing refined, on scenes that were not trained on; *hard* functions are those whose bare tent is off by .01 or more; *over τ* is the share that needs refinement: a bake refines it. The generator is its network and what
corrects θ after it (an exact last layer, learned correction steps): all that comes before Adam or Levenberg–Marquardt; *network alone* is without these. *Over direct*: median of the error over that of direct optimisation of the same functions: over all, over hard ones, over hard ones at points that the probe does not see.

"""
OVERVIEW_HEAD = """| | numbers | bytes, float16 | file | correction steps | mean | p95 | hard, median | over τ | over direct: all | hard | hard, shadow | network alone: mean | over τ | over direct, hard | on |
|---|---|---|---|---|---|---|---|---|---|---|---|---|---|---|---|
"""


def fail(place, expected, got):
    sys.exit(f"model_card: {place}: expected {expected}, got {got}")


def read_json(path):
    try:
        return json.loads(path.read_text())
    except (OSError, ValueError) as error:
        fail(path, "a file of the run", error)


def read_metadata(path):
    """The header of a weights file: its texts, and the dtypes of its tensors."""
    with open(path, "rb") as stream:
        header = json.loads(stream.read(struct.unpack("<Q", stream.read(8))[0]))
    metadata = header.pop("__metadata__")
    dtypes = {name: tensor["dtype"] for name, tensor in header.items() if not name.startswith("padding.")}
    return metadata, dtypes


def number(value, digits=4):
    """.0123, as everywhere in the documentation."""
    return f"{value:.{digits}f}".lstrip("0") or "0"


def percent(share):
    return f"{100 * share:.2g} %" if share < 0.995 else f"{100 * share:.0f} %"


def quantile_cells(q):
    return f"{q['functions']:,} | " + " | ".join(number(q[key]) for key in ("median", "mean", "p95", "p99", "worst"))


def ratios(to_direct):
    """How far above direct optimisation, in words; a ratio that no function stands behind is left out."""
    parts = [("median", "in the median"), ("median_hard", "over hard functions"), ("median_shadow_hard", "over these at shadow points")]
    return "error over direct " + ", ".join(f"{number(to_direct[key], 2)} {words}" for key, words in parts if to_direct[key] > 0)


def overview_row(run, shipped, name):
    """The representation's row of the table over all: on the test where the run has one, otherwise on its held-out scenes."""
    on = "test" if (run / "test" / "summary.json").exists() else "validation"
    entry = read_json(run / on / "summary.json")["representations"][name]
    generator, alone, ratio, ratio_alone = (entry[key] for key in ("generator", "uncorrected", "generator_to_direct", "uncorrected_to_direct"))
    cells = [f"[{name}](#{name})", f"{entry['parameters']}", f"{entry['bytes'] // 2}", f"{shipped.stat().st_size / 1000:,.0f} kB",
             f"{entry['correction_steps']}", number(generator["rmse"]["mean"]), number(generator["rmse"]["p95"]), number(generator["rmse_hard"]["median"]),
             percent(generator["share_over_tau"]), *(number(ratio[key], 2) for key in ("median", "median_hard", "median_shadow_hard")),
             number(alone["rmse"]["mean"]), percent(alone["share_over_tau"]), number(ratio_alone["median_hard"], 2), on]
    return f"| {' | '.join(cells)} |"


def error_table(title, summary, name):
    """Errors by scene of one set of scenes, all of them and the hard functions first."""
    entry = summary["representations"][name]
    generator, alone = entry["generator"], entry["uncorrected"]
    lines = [f"{title} ({summary['functions']['held_out']:,} functions of {summary['functions']['held_out_scenes']} scenes): "
             f"{percent(generator['share_over_tau'])} over τ; {ratios(entry['generator_to_direct'])}.", "",
             "| scene | functions | median | mean | p95 | p99 | worst |", "|---|---|---|---|---|---|---|",
             f"| **all** | {quantile_cells(generator['rmse'])} |", f"| **hard** | {quantile_cells(generator['rmse_hard'])} |"]
    if alone["rmse"] != generator["rmse"]:
        lines[0] += f" Network alone: {percent(alone['share_over_tau'])} over τ; {ratios(entry['uncorrected_to_direct'])}."
        lines += [f"| **all, network alone** | {quantile_cells(alone['rmse'])} |", f"| **hard, network alone** | {quantile_cells(alone['rmse_hard'])} |"]
    lines += [f"| {scene} | {quantile_cells(q)} |" for scene, q in sorted(entry["by_scene"].items())]
    return "\n".join(lines) + "\n"


def training_scenes(run):
    """"72 scenes, 5 variants each: …", by the shards that the run left."""
    shards = sorted(path.name for path in (run / "dataset" / "training").glob("*.h5"))
    if not shards:
        fail(run / "dataset" / "training", "the training shards", "none")
    scenes = sorted({shard.rsplit(".", 2)[0] for shard in shards})
    families = {}
    for scene in scenes:
        match = re.fullmatch(r"(house|maze|colonnade|stairs|clutter|outdoor|cave)_(\d+)", scene)
        families.setdefault(match[1] if match else "", []).append(scene)
    levels = families.pop("", [])
    parts = [f"{len(members)} of the procedural family {family}" for family, members in sorted(families.items())]
    parts += [", ".join(levels)] if levels else []
    return f"{len(scenes)} scenes, {len(shards)} shards: " + "; ".join(parts)


def card(run, config, shipped, name):
    weights = run / "weights" / f"{name}.safetensors"
    metadata, dtypes = read_metadata(shipped)
    sha256 = hashlib.sha256(shipped.read_bytes()).hexdigest()
    exported, training = read_json(run / "weights" / f"{name}.json"), read_json(run / "training" / f"{name}.json")
    summaries = {"Validation": read_json(run / "validation" / "summary.json")}
    if (run / "test" / "summary.json").exists():
        summaries["Test"] = read_json(run / "test" / "summary.json")
    if hashlib.sha256(weights.read_bytes()).hexdigest() != sha256:
        fail(shipped, f"the run's {weights}", "another file")
    for title, summary in summaries.items():
        measured = summary["representations"].get(name, {}).get("weights_sha256")
        if measured != sha256:
            fail(f"{run}: {title.lower()} of {name}", f"figures of weights {sha256}", measured)
    entry = summaries["Validation"]["representations"][name]
    options = json.loads(metadata["training_options"])
    halves = sorted(tensor for tensor, dtype in dtypes.items() if dtype == "F16")
    loss = exported["held_out_rmse"] - exported["held_out_rmse_float32"]
    rows = [
        ("file", f"`{shipped.name}`, {shipped.stat().st_size:,} bytes, " + ("matrices in float16" if halves else "float32")),
        ("SHA-256", f"`{sha256}`"),
        ("a function", f"{entry['parameters']} numbers: {entry['bytes']} bytes as float32, {entry['bytes'] // 2} as float16"),
        ("trained on", f"{int(metadata['training_functions']):,} distinct functions; {training_scenes(run)}"),
        ("training set", f"`{metadata['training_set_sha256']}`"),
        ("configuration", f"`{config}`"),
        ("options", ", ".join(f"{key} {value}" for key, value in options.items())),
        ("time", f"{training['elapsed_s'] / 60:.0f} minutes, {training['samples_per_s']:,.0f} samples/s, {training['steps']:,} steps"),
        ("revision", f"`{json.loads(metadata['provenance'])['revision']}`"),
        ("parity", f"θ of libtorch and of the evaluator differ by at most {exported['parity_theta']:.1e} over {exported['parity_functions']:,} functions"),
        ("rounding", f"mean RMSE over those {number(exported['held_out_rmse'], 5)}, {loss:+.1e} against float32"),
        ("inference", f"{entry['generator']['us_per_function']:,.0f} µs a function on one thread, {entry['uncorrected']['us_per_function']:,.0f} µs of it the network"
                      + (f"; evaluation at 8,192 points {entry['evaluate_us']:.0f} µs" if "evaluate_us" in entry else "")),
    ]
    lines = ["| | |", "|---|---|", *(f"| {key} | {value} |" for key, value in rows), ""]
    return "\n".join(lines) + "\n" + "\n".join(error_table(title, summary, name) for title, summary in summaries.items())


def read_cards(readme):
    """Representation → text of its card and → its row of the table over all, of a README that stands."""
    if not readme.exists():
        return {}, {}
    head, *parts = re.split(r"^## (\S+)\n\n", readme.read_text(), flags=re.MULTILINE)
    rows = {match[1]: match[0] for match in re.finditer(r"^\| \[(\S+)\]\(#.*$", head, flags=re.MULTILINE)}
    return dict(zip(parts[0::2], parts[1::2])), rows


def by_size(row):
    """Rows in the order of the numbers of a function."""
    return int(row.split("|")[2]), row


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("run", type=Path)
    parser.add_argument("config")
    parser.add_argument("weights", type=Path)
    parser.add_argument("representations", nargs="*")
    arguments = parser.parse_args()
    readme = arguments.weights / "README.md"
    old_cards, old_rows = read_cards(readme)
    cards = {name: text for name, text in old_cards.items() if (arguments.weights / f"{name}.safetensors").exists()}
    rows = {name: row for name, row in old_rows.items() if name in cards}
    for name in arguments.representations:
        shipped = arguments.weights / f"{name}.safetensors"
        cards[name] = card(arguments.run, arguments.config, shipped, name)
        rows[name] = overview_row(arguments.run, shipped, name)
    overview = OVERVIEW_HEAD + "".join(f"{row}\n" for row in sorted(rows.values(), key=by_size)) if rows else ""
    readme.write_text(INTRODUCTION + overview + "".join(f"\n## {name}\n\n{text.strip()}\n" for name, text in sorted(cards.items())))


if __name__ == "__main__":
    main()

"""docs/reference/results.md: what the documentation holds of all results, as tables. Written by results.py from docs/results/, where the rest stands."""
import sys
from pathlib import Path

from results_collect import STAGES
from results_quotes import MAIN, microseconds, number, percent
from tool.input_file import Node

sys.path.append(str(Path(__file__).resolve().parents[1] / "validate" / "report"))  # whose verdict is judged by
import verdict

INTRODUCTION = """# Results

*Written by `workflow/results.py write` from `docs/results/openarena.json`. Change nothing here by hand.*

## Words
A *generator* predicts θ, the parameters of a representation, from a weighting function φ. Four words name the stages of θ, always in this order:

- **network**: one pass of the generator's network.
- **corrected**: the last layer solved exactly, where φ is linear in it (`mlp` and `tent_mlp`). For all others this is the network's θ.
- **fitted**: after every step of Adam or Levenberg–Marquardt that the bake takes.
- **stored**: what the grid holds, rounded, with bare tents.

*Share fitted*: the share of functions that took any such step, whether or not its result was kept.
The *bare tent* is the function of a probe with free space around it; where it is good enough a bake stores no θ. A function is *hard* when its bare tent has an RMSE of .01 or more.
*Direct*: the best of long fits from θ₀ (the same start for all functions) and from random starts. *Best known*: the least blend RMSE of any long fit, those from the generator's θ included.
*Occluded* points are in air, and the probe does not see them.

*Blend RMSE* is the root of the [loss](../theory/math.md#4-the-tiny-networks-their-loss-and-gradient) that every fit minimises, with and without a generator. It weighs points where the probe must not count most, then those that few other probes see. *RMSE* weighs all points alike. Both are over the points of a function that are in air. A function *fails the check* where either is above its threshold. Parentheses hold 95 % intervals, by bootstrap over scenes. Keys: [formats](json.md#summaryjson). Methods: [error against run time](frontier.md), [stability](stability.md).
"""


def table(head, rows):
    lines = [f"| {' | '.join(head)} |", "|" + "---|" * len(head), *(f"| {' | '.join(map(str, row))} |" for row in rows)]
    return "\n" + "\n".join(lines) + "\n"


def spread(low, high, write):
    return f" ({write(low)} or more)" if high is None else f" ({write(low)} to {write(high)})"


def with_interval(q, key):
    return number(q[key]) + spread(*q["interval"][key], number)


def share(entry):
    if entry["low"] == entry["value"] == entry["high"]:
        return percent(entry["value"])
    return percent(entry["value"]) + spread(entry["low"], entry["high"], percent)


def ratio(entry, digits=2):
    return number(entry["value"], digits) + spread(entry["low"], entry["high"], lambda value: number(value, digits))


def short_ratio(entry):
    return number(entry["value"], 2)


def error_cells(theta, hard):
    blend = theta["blend_rmse"]
    return [with_interval(blend, "mean"), number(blend["p95"]), number(hard["blend_rmse"]["mean"]), number(theta["rmse"]["mean"]), number(theta["rmse_occluded"]["mean"]),
            percent(theta["share_failing_check"]["value"]), percent(theta["share_fitted"]["value"])]


ERROR_HEAD = ["", "", "blend RMSE: mean", "p95", "hard: mean", "RMSE: mean", "occluded, mean", "fails the check", "share fitted", "µs a function"]


def in_training(counts):
    """Nothing where validate was given no training shards: then all distinct functions are held out, and nobody compared them."""
    if counts["distinct"] <= counts["held_out"]:
        return ""
    return (f"Training has {counts['held_out_in_training']:,} of all of them too, by the rule for duplicates, and {counts['held_out_in_training_mirrored']:,} when mirror images count. ")


def evaluation_section(split):
    counts = split["functions"]
    text = (f"\n## Evaluation: levels that no generator was trained on\n{counts['held_out']:,} distinct functions of {counts['held_out_scenes']} levels and furnished villas. "
            f"{counts['take_theta']:,} of them take a θ, and the table is of these; {counts['hard']:,} are hard. {in_training(counts)}"
            f"θ is stored in {split['theta_precision']}. Revision `{split['revision']}`.\n\n"
            "*Fitted* stands in the [model cards](../../weights/README.md). One setting was once chosen with the help of these levels (commits a41ee66 to 04510fc), and villas of other seeds were looked at while the weights were made.\n")
    rows = [["bare tent", "", *error_cells(split["tent"]["theta"], split["tent"]["hard"]), "0"]]
    for name, entry in split["representations"].items():
        # fitted differs from stored by rounding alone: the model cards have it
        words = [word for word in ("network", "corrected", "stored") if word != "corrected" or entry[word]["theta"]["rmse"] != entry["network"]["theta"]["rmse"]]
        rows += [[f"`{name}`" if word == STAGES[0] else "", word, *error_cells(entry[word]["theta"], entry[word]["hard"]), microseconds(entry[word]["theta"]["us_per_function"])] for word in words]
    text += table(ERROR_HEAD, rows) + "\n![Slices through weighting functions: target, stored, difference, geometry](../images/slices.png)\n"
    return text + sample_section(split)


def sample_section(split):
    """Against fits of single functions: of a sample, which stands by itself."""
    sampled = {name: entry["sample"] for name, entry in split["representations"].items() if "sample" in entry}
    if not sampled:
        return ""
    first = next(iter(sampled.values()))
    text = (f"\n### Against direct fits\nA sample of {first['functions']:,} functions, {first['hard']:,} of them hard. "
            "Mean blend RMSEs, and medians of the blend RMSE over that of the best known, function by function.\n")
    rows = []
    for name, entry in sampled.items():
        to_best = {word: entry["ratios"][word]["to_best_known"] for word in STAGES}
        mean = lambda word: number(entry[word]["theta"]["blend_rmse"]["mean"])
        rows.append([f"`{name}`", mean("stored"), mean("direct"), mean("best_known"), microseconds(entry["direct"]["theta"]["us_per_function"]),
                     *(short_ratio(to_best[word]["median"]) for word in STAGES[:-1]), short_ratio(to_best["stored"]["median"]), short_ratio(to_best["stored"]["median_hard"])])
    return text + table(["", "stored", "direct", "best known", "direct, µs a function", "over best known: network", "corrected", "fitted", "stored", "stored, hard"], rows)


def validation_section(split):
    counts = split["functions"]
    rows = [[f"`{name}`", *(number(entry[word]["theta"]["blend_rmse"]["mean"]) for word in STAGES), with_interval(entry["stored"]["theta"]["blend_rmse"], "p95"), number(entry["stored"]["hard"]["blend_rmse"]["mean"]),
             number(entry["stored"]["theta"]["rmse"]["mean"]), share(entry["stored"]["theta"]["share_failing_check"]), share(entry["stored"]["theta"]["share_fitted"])] for name, entry in split["representations"].items()]
    text = (f"\n## Validation: held-out scenes of the kinds trained on\n{counts['take_theta']:,} functions that take a θ, of {counts['held_out_scenes']} scenes. Errors are blend RMSEs where nothing else is said. Revision `{split['revision']}`.\n")
    return text + table(["", *(f"{word}, mean" for word in STAGES), "stored, p95", "stored, hard: mean", "stored, mean RMSE", "fails the check", "share fitted"], rows)


def stages_section(split):
    """What each representation goes through, from the policy's own list."""
    lists = {}
    for name, entry in split["representations"].items():
        lists.setdefault("; ".join(stage["text"] for stage in entry["stages"]), []).append(f"`{name}`")
    return "\n## What a bake does with each representation\n" + table(["", "stages, and which functions take them"], [[", ".join(names), stages] for stages, names in lists.items()])


def frontier_section(front):
    counts = front["functions"]
    text = (f"\n## Error against run time\n{counts['theta']:,} functions of the evaluation that take a θ, {counts['hard']:,} of them hard. {front['front_sentences'].get('theta', '')} "
            f"[How it is measured](frontier.md). Revision `{front['revision']}`.\n\n![Error against run time](../images/error_against_time.png)\n")
    rows = []
    members = [(name, point) for name, ways in front["points"].items() for point in ways.values() if point["figures"]["theta"]["on_front"]]
    for name, point in sorted(members, key=lambda member: member[1]["figures"]["theta"]["us_median"]):
        theta, hard = point["figures"]["theta"], point["figures"]["hard"]
        label = f"bake, after: {point['label']}" if point["family"] == "stages" else point["label"]
        rows.append([f"`{name}`", label, microseconds(theta["us_median"]), number(theta["blend_rmse_mean"]), number(hard["blend_rmse_mean"]) if hard else "", percent(theta["share_failing_check"])])
    text += table(["", "", "µs a function, median", "blend RMSE: mean", "hard: mean", "fails the check"], rows)
    return text + speed_section(front)


def times_as_long(speed):
    """The ratio of a speed, or what is known of it."""
    if speed["ratio"]:
        return ratio(speed["ratio"])
    return f"more than {number(speed['longest_us'] / speed['time_us'], 1)}" if speed["longest_us"] else ""


def speed_section(front):
    """Like with like: both sides minimise the one loss, and what fails stands beside both."""
    text = ("\n### Speed at equal error\nThe time of the fastest fit without a generator to the mean blend RMSE that the network alone has, and that the bake has *fitted*, over the time of these. Below 1 the fit is "
            "faster. The share that fails the check stands beside both: at equal means tails may differ.\n")
    rows = []
    for name, words in front["speed_at_equal_error"].items():
        for word in ("network", "fitted"):
            speed = words[word]
            rows.append([f"`{name}`" if word == "network" else "", word, microseconds(speed["time_us"]), number(speed["blend_rmse_mean"]), percent(speed["share_failing_check"]["value"]), speed["baseline"] or speed["reason"],
                         percent(speed["baseline_share_failing_check"]["value"]) if speed["baseline"] else "", times_as_long(speed)])
    return text + table(["", "", "µs, mean", "mean blend RMSE", "fails the check", "fastest fit without it", "fails the check", "times as long"], rows)


def judgements(results):
    """Representation → its verdict, by the limits that the report judges by; of those that were measured."""
    split, speeds = results.get("evaluation", {}), results.get("frontier", {}).get("speed_at_equal_error", {})
    node = lambda way, value: Node(f"docs/results/{MAIN}.json", way, value)
    found = {}
    for name, entry in split.get("representations", {}).items():
        if "sample" not in entry:
            continue
        speed = speeds.get(name, {}).get("fitted")
        found[name] = verdict.judge_one(name, node(f"evaluation.representations.{name}", entry), speed and verdict.read_speed(node(f"frontier.speed_at_equal_error.{name}.fitted", speed)), verdict.Limits())
    return found


def verdict_section(results):
    found = judgements(results)
    if not found:
        return ""
    text = ("\n## Which of these may ship\nBy the rule of every run's report, on the evaluation ([training](../guide/training.md#may-it-ship)).\n")
    shown = lambda figure, write: "" if figure.value is None else write(figure.value) + (spread(*figure.interval, write) if figure.interval and figure.interval[0] != figure.interval[1] else "")
    rows = [[f"`{name}`", shown(j.failing, percent), shown(j.hard, lambda v: number(v, 2)), ("more than " if j.equal and j.equal.ratio and not j.equal.label else "") + shown(j.speedup, lambda v: number(v, 2)), j.verdict]
            for name, j in found.items()]
    return text + table(["", "stored, fails the check", "stored over best known, hard", "times as fast as a fit without it", ""], rows)


def stability_section(stability):
    cases = stability["cases"]
    groups = {}
    for case in cases:
        groups.setdefault(case["group"], []).append(case)
    rows = [[group, len(found), sum(case["ran"] for case in found), sum(case["ran"] and case["holds"] for case in found)] for group, found in groups.items()]
    text = f"\n## Stability\nStiff and extreme cases ([how](stability.md)). Revision `{stability['revision']}`.\n"
    text += table(["", "cases", "run", "hold"], rows)
    failed = [f"{case['name']}: {case['must_hold']}. {case['measured']}" for case in cases if case["ran"] and not case["holds"]]
    return text + "".join(f"\n- Does not hold: {line}" for line in failed) + ("\n" if failed else "")


# the talk's bakes, on 64 cores: probes, seconds of visibility, of functions, of lighting, distinct functions, seconds of network and check, share fitted, MB, bytes a probe
TALK_BAKES = {"A": (138645, 22, 7, 62, 49211, 1.8, 6.5, 31.2, 236), "B": (193162, 46, 10, 84, 98721, 3.8, 4.1, 57.0, 309),
              "C": (386922, 93, 20, 152, 223992, 8.5, 4.9, 125, 339), "D": (33815, 7, 2, 17, 19071, 0.5, 13.4, 10.6, 329),
              "E": (301138, 86, 16, 114, 143868, 5.3, 5.6, 84.5, 294)}
BAKE_HEAD = ["level", "probes", "visibility, s", "functions, s", "light, s", "bare tents", "functions that take a θ", "network and check, s", "exact last layer, s", "fits, s", "share fitted, of all",
             "of those with a θ", "stored, mean", "MB", "bytes a probe", "whole bake, s"]


def bake_row(name, entry):
    seconds = entry["thread_s"]
    return [name, f"{entry['probes']:,}", *(f"{seconds[key]:.1f}" for key in ("visibility", "functions")), f"{entry['light_s']:.1f}", f"{entry['bare_tents']:,}", f"{entry['functions']:,}",
            *(f"{seconds[key]:.2f}" for key in ("network", "corrected")), f"{seconds['fitted'] + seconds['refinement']:.2f}", percent(entry["share_fitted"]["all"]),
            percent(entry["share_fitted"]["theta"]), number(entry["rmse"]["stored"]["mean"]), f"{entry['bytes'] / 1e6:.1f}", f"{entry['bytes_per_probe']:.0f}", f"{entry['wall_s']:.1f}"]


def sum_of_bakes(bakes):
    """All levels as one."""
    entries = list(bakes.values())
    total = lambda key: sum(entry[key] for entry in entries)
    functions, probes = max(1, total("functions")), max(1, total("probes"))
    return {**{key: total(key) for key in ("probes", "bare_tents", "functions", "bytes", "wall_s", "light_s")},
            "thread_s": {key: sum(entry["thread_s"][key] for entry in entries) for key in entries[0]["thread_s"]},
            "share_fitted": {"all": total("took_fit") / max(1, total("functions") + total("bare_tents")), "theta": total("took_fit") / functions},
            "rmse": {"stored": {"mean": sum(entry["rmse"]["stored"]["mean"] * entry["functions"] for entry in entries) / functions}},
            "bytes_per_probe": total("bytes") / probes}


def bakes_section(bakes):
    rows = [[f"talk {name}, *64 cores*", f"{probes:,}", seen, made, lit, "", f"{functions:,}", checked, "", "", f"{fitted} %", "", "", size, bytes_a_probe, ""]
            for name, (probes, seen, made, lit, functions, checked, fitted, size, bytes_a_probe) in TALK_BAKES.items()]
    rows += [bake_row(name, entry) for name, entry in bakes.items()]
    rows.append(bake_row("**all**", sum_of_bakes(bakes)))
    threads = sorted({entry["threads"] for entry in bakes.values()})
    text = (f"\n## Whole bakes\nOurs on {', '.join(map(str, threads))} thread{'s' if threads != [1] else ''}; seconds of stages are thread seconds, those of light and of the whole bake by the "
            "clock. The talk's are by the clock on 64 cores, over all its functions, and all bytes include light. What a bake left out because its scene does not need it, every bake says itself "
            "([bake](../guide/bake.md#what-a-scene-does-not-need)).\n")
    return text + table(BAKE_HEAD, rows)


def savings_section(savings):
    """A line a kind of what was left out, a column a scene."""
    kinds = {key: line["what"] for entry in savings.values() for key, line in entry["lines"].items()}

    def cell(line):
        if line is None:
            return ""
        known = [f"{line['count']:,} of {line['of']:,}"]
        known += [f"{line['seconds_saved']:,.1f} s"] if "seconds_saved" in line else []
        known += [f"{line['bytes_saved'] / 1000:,.0f} kB"] if line.get("bytes_saved") else []
        return "; ".join(known)

    rows = [[what, *(cell(entry["lines"].get(key)) for entry in savings.values())] for key, what in kinds.items()]
    text = "\n## What bakes left out\nHow many of how many, and the bytes that this saves; processor seconds where the machine was quiet ([bake](../guide/bake.md#what-a-scene-does-not-need)).\n"
    return text + table(["", *savings], rows)


# of all cases: the generator beside the machine's peak and libtorch; look-ups stand on the page of light
SHOWN_BENCHMARKS = ("machine/", "peer/generator/", "generator/float32/batch/")


def benchmarks_section(benchmarks):
    shown = lambda value: f"{value:,.0f}" if abs(value) >= 1000 else f"{value:.4g}"
    rows = [[f"`{entry['case']}`", microseconds(entry["us"]),
             "; ".join(f"{key.replace('_', ' ')} {shown(value)}" for key, value in entry.items() if key not in {"case", "us", "wall_us"})]
            for entry in benchmarks.values() if entry["case"].startswith(SHOWN_BENCHMARKS)]
    return "\n## Benchmarks\nOne core; the machine's peak was measured in the same run.\n" + table(["case", "µs", "counters"], rows)


def page(all_results):
    """The whole page, of the main results; what was not measured has no section."""
    results = all_results[MAIN]
    text = INTRODUCTION + f"\nMade by `{results['command']}` and `workflow/results.py collect out/{results['run']}`; the SHA-256 of the weights stand in their [cards](../../weights/README.md). {results.get('note', '')}\n"
    sections = {"evaluation": evaluation_section, "validation": validation_section, "frontier": frontier_section, "bakes": bakes_section, "savings": savings_section,
                "stability": stability_section, "benchmarks": benchmarks_section}
    for key, write in sections.items():
        text += write(results[key]) if key in results else ""
        text += verdict_section(results) if key == "frontier" else ""
    return text + (stages_section(results["evaluation"]) if "evaluation" in results else "")

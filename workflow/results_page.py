"""docs/reference/results.md: all results, as tables. Written by results.py from docs/results/."""
from results_collect import FITS, STAGES
from results_quotes import MAIN, microseconds, number, percent

POPULATION_NAMES = {"theta": "functions that take a θ", "hard": "hard functions", "all": "all distinct functions"}
POPULATION_ORDER = ("theta", "hard", "all")
FIT_NAMES = {"direct": "direct", "adam_theta0": "Adam from θ₀", "lm_theta0": "Levenberg–Marquardt from θ₀", "adam_random": "Adam from a random start",
             "best_known": "best known"}
SPLIT_TITLES = {"evaluation": "Evaluation: scenes that no generator was trained on", "validation": "Validation: held-out scenes of the kinds trained on"}

INTRODUCTION = """# Results

*Written by `workflow/results.py write` from `docs/results/`; other texts quote from there. Change nothing here by hand.*

Errors are RMSE over all valid support points, of functions of scenes that no generator was trained on. They are given under four words, always in this order:

- **network**: one pass of the generator's network, and nothing else.
- **corrected**: with the exact last layer, and with learned steps and mirror images where the policy has any (the stages of each representation are listed below). No iterative fit.
- **fitted**: with every step of Adam or Levenberg–Marquardt that the bake takes before it writes the grid.
- **stored**: what the grid holds in the end, bare tents and the rounding of θ included (the evaluation says to what).

**Share fitted** is the share of functions that took any step of Adam or Levenberg–Marquardt, whether or not its result was kept. Among all distinct functions it is what stands beside the 4 to 13 % of the talk.
Populations: *functions that take a θ* are the main one. *All distinct functions* also has those for which the bare tent is enough; they count as the bare tent under every word, in the time of one check, as a bake has them. *Hard functions* are those whose bare tent has an RMSE of .01 or more.
*Test points* are points that no fit has seen. *Occluded* points are valid points that the probe does not see. Numbers in parentheses are 95 % intervals, by bootstrap over scenes. How it is all measured: [formats](formats.md#summaryjson), [error against run time](frontier.md), [stability](stability.md).
"""
PENDING_NOTE = "\n*These figures are measured again with the present policy; what is not there yet reads \"pending\" elsewhere.*\n"


def table(head, rows):
    lines = [f"| {' | '.join(head)} |", "|" + "---|" * len(head), *(f"| {' | '.join(map(str, row))} |" for row in rows)]
    return "\n" + "\n".join(lines) + "\n"


def spread(interval, write):
    return f" ({write(interval[0])} to {write(interval[1])})"


def with_interval(q, key):
    return number(q[key]) + spread(q["interval"][key], number)


def share(entry):
    if entry["low"] == entry["value"] == entry["high"]:
        return percent(entry["value"])
    return percent(entry["value"]) + spread([entry["low"], entry["high"]], percent)


def ratio(entry):
    return number(entry["value"], 2) + spread([entry["low"], entry["high"]], lambda value: number(value, 2))


def figure_cells(entry):
    rmse = entry["rmse"]
    return [f"{rmse['functions']:,}", number(rmse["median"]), with_interval(rmse, "mean"), with_interval(rmse, "p95"), number(rmse["p99"]),
            number(rmse["worst"]), number(entry["rmse_test_points"]["mean"]), number(entry["rmse_occluded"]["mean"]),
            f"{number(entry['leak']['mean'], 5)}, {number(entry['leak']['p99'], 3)}", share(entry["share_failing_check"])]


FIGURE_HEAD = ["", "word", "functions", "median", "mean", "p95", "p99", "worst", "test points, mean", "occluded, mean", "leak: mean, p99",
               "fails the check", "fitted", "µs a function"]


def stage_rows(name, entry, population):
    return [[f"`{name}`" if word == STAGES[0] else "", word, *figure_cells(entry[word][population]), share(entry[word][population]["share_fitted"]),
             microseconds(entry[word][population]["us_per_function"])] for word in STAGES]


def figures_section(split):
    text = ""
    for population in POPULATION_ORDER:
        rows = [["no network", "bare tent", *figure_cells(split["tent"][population]), "0 %", "0"]]
        for name, entry in split["representations"].items():
            rows += stage_rows(name, entry, population)
        text += f"\n### {POPULATION_NAMES[population].capitalize()}\n" + table(FIGURE_HEAD, rows)
    return text


def stages_section(split):
    """What each representation goes through, from the policy's own list."""
    rows = [[f"`{name}`" if i == 0 else "", stage["word"], stage["text"]] for name, entry in split["representations"].items()
            for i, stage in enumerate(entry["stages"])]
    return "\n## What a bake does with each representation\n" + table(["", "word", "stage, and which functions take it"], rows)


def size_section(split):
    precisions = next(iter(split["representations"].values()))["theta_bytes"]
    rows = [[f"`{name}`", entry["parameters"], *(f"{entry['theta_bytes'][precision]:,}" for precision in precisions), f"{entry['weights_bytes'] / 1000:,.0f} kB", entry["correction_steps"],
             microseconds(entry["evaluate_us"]) if "evaluate_us" in entry else ""] for name, entry in split["representations"].items()]
    head = ["", "numbers a function", *(f"bytes, {precision}" for precision in precisions), "weights file", "learned steps", "µs for one θ at 8,192 points"]
    return "\n## Sizes\n" + table(head, rows) + "\nint8 keeps the last layers of networks, and whole product fields, in float16.\n"


RATIO_HEAD = ["", "word", "median", "hard, median", "at test points, median", "hard, at occluded points, median", "without duplicates: median", "hard, median"]
RATIO_KEYS = ["median", "median_hard", "median_test_points", "median_occluded_hard"]


def ratio_rows(name, ratios, reference):
    rows = []
    for word in STAGES:
        entry = ratios[word]
        cells = [ratio(entry[reference][key]) for key in RATIO_KEYS]
        # those without duplicates are to the best known alone
        cells += [ratio(entry["without_duplicates"][key]) for key in RATIO_KEYS[:2]] if reference == "to_best_known" else ["", ""]
        rows.append([f"`{name}`" if word == STAGES[0] else "", word, *cells])
    return rows


def sample_section(split):
    """Against fits of single functions: of a sample, which stands by itself."""
    sampled = {name: entry["sample"] for name, entry in split["representations"].items() if "sample" in entry}
    if not sampled:
        return ""
    first = next(iter(sampled.values()))
    rows = []
    for name, entry in sampled.items():
        for word in (*STAGES, *(fit for fit in FITS if fit in entry)):
            theta, hard = entry[word]["theta"], entry[word]["hard"]
            rows.append([f"`{name}`" if word == STAGES[0] else "", FIT_NAMES.get(word, word), *(number(theta["rmse"][key]) for key in ("median", "mean")),
                         *(number(hard["rmse"][key]) for key in ("median", "mean")), microseconds(theta["us_per_function"])])
    text = (f"\n### Against direct fits\nA sample of {first['functions']:,} functions, {first['hard']:,} of them hard. *Direct* is the best of long fits from θ₀ and "
            "from random starts; *best known* the least error that any long fit has found, from the generator's θ too. Sample and whole set have different "
            "percentiles: compare within this table alone.\n")
    text += table(["", "", "median", "mean", "hard: median", "hard: mean", "µs a function"], rows)
    found = [[f"`{name}`", ", ".join(f"{fit.replace('_', ' ')} {count:,}" for fit, count in entry["best_known_from"].items())]
             for name, entry in sampled.items() if "best_known_from" in entry]
    if found:
        text += "\nWhich fit found the best known, and of how many functions:\n" + table(["", ""], found)
    for reference, title in (("to_best_known", "best known"), ("to_direct", "direct")):
        rows = [row for name, entry in sampled.items() for row in ratio_rows(name, entry["ratios"], reference)]
        text += f"\nError over that of *{title}*, function by function:\n" + table(RATIO_HEAD, rows)
    return text


def convergence_section(split):
    """Whether direct fits have converged: their error over restarts and over steps."""
    curves = {name: entry["convergence"] for name, entry in split["representations"].items() if "convergence" in entry}
    if not any(curve["functions"] for curve in curves.values()):
        return ""
    text = "\n### Whether direct fits have converged\nMean RMSE of the best of all fits of the same hard functions, with more random starts and with fewer and more steps of Adam.\n"
    rows = []
    for name, curve in curves.items():
        points = [(point, f"{point['restarts']} random starts") for point in curve["by_restarts"]]
        points += [(point, f"{point['adam_steps']:,} steps of Adam") for point in curve["by_adam_steps"]]
        rows.append([f"`{name}`", f"{curve['functions']:,}", "; ".join(f"{words}: {number(point['rmse_mean'], 5)}" for point, words in points)])
    return text + table(["", "hard functions", "mean RMSE"], rows)


def split_section(key, split):
    counts = split["functions"]
    text = f"\n## {SPLIT_TITLES[key]}\n\n" if key in SPLIT_TITLES else f"\n## {key}\n\n"
    text += (f"{counts['held_out']:,} distinct functions of {counts['held_out_scenes']} scenes; {counts['take_theta']:,} of them take a θ, {counts['hard']:,} are hard. "
             f"Training has {counts['held_out_in_training']:,} of them too, by the rule for duplicates, and {counts['held_out_in_training_mirrored']:,} when mirror "
             f"images count. What is stored has θ in {split['theta_precision']}. Revision `{split['revision']}`.\n")
    if key == "evaluation":
        text += ("\nOne setting was once chosen with the help of these levels (commits a41ee66 to 04510fc), and villas of other seeds were looked at while "
                 "the weights were made. None of them was trained on, but they are no test that nobody has looked at.\n")
    return text + figures_section(split) + sample_section(split) + convergence_section(split)


FRONT_POPULATIONS = ("theta", "hard")
FRONT_HEAD = ["", "", "word", "µs a function", "share fitted", "mean", "median", "p95", "hard: mean", "hard: median", "hard: p95", "on a front"]
FRONT_KEYS = ["rmse_mean", "rmse_median", "rmse_p95"]


def point_row(name, point):
    """Of the functions that take a θ, then of the hard ones among them."""
    theta, hard = (point["figures"][population] for population in FRONT_POPULATIONS)
    label = f"bake, after: {point['label']}" if point["family"] == "stages" else point["label"]
    fronts = [population for population in FRONT_POPULATIONS if point["figures"][population] and point["figures"][population]["on_front"]]
    return [f"`{name}`", label, ", ".join(point["words"]), microseconds(theta["us_median"]), percent(theta["share_fitted"]), *(number(theta[key]) for key in FRONT_KEYS),
            *(number(hard[key]) if hard else "" for key in FRONT_KEYS), ", ".join(fronts)]


def generic_rows(rows):
    """Rows of like keys as a table; numbers as they are, at four digits."""
    head = [key for key in rows[0] if not isinstance(rows[0][key], (dict, list))]
    cell = lambda value: "" if value is None else f"{value:.4g}" if isinstance(value, float) else f"{value:,}" if isinstance(value, int) else f"{value}"
    return table([key.replace("_", " ") for key in head], [[cell(row.get(key)) for key in head] for row in rows])


def speed_cells(speed):
    cells = [microseconds(speed["time_us"]), number(speed["rmse_mean"])]
    if speed["ratio"] is None:
        return [*cells, speed["reason"], "", ""]
    low, high = speed["ratio"]["low"], speed["ratio"]["high"]
    bounds = f" ({number(low, 1)} or more)" if high is None else f" ({number(low, 1)} to {number(high, 1)})"
    return [*cells, speed["rival"], microseconds(speed["rival_us_at_equal_error"]), number(speed["ratio"]["value"], 1) + bounds]


def equal_error_section(front):
    """How much longer the fastest direct fit takes to the same mean error."""
    text = "\n### Speed at equal error\nHow many times as long the fastest direct fit takes to exactly the mean error under each word, with the 95 % interval.\n"
    head = ["", "word", "µs, mean", "RMSE, mean", "fastest direct fit", "µs at that error", "times as long"]
    for key, title in (("speed_at_equal_error", POPULATION_NAMES["theta"]), ("speed_at_equal_error_hard", POPULATION_NAMES["hard"])):
        rows = [[f"`{name}`" if i == 0 else "", word, *speed_cells(speed)] for name, words in front[key].items() for i, (word, speed) in enumerate(words.items())]
        text += f"\n{title.capitalize()}:\n" + table(head, rows) if rows else ""
    return text


def frontier_section(front):
    counts = front["functions"]
    text = (f"\n{counts['theta']:,} functions of the evaluation that take a θ, {counts['hard']:,} of them hard. Times and the first three errors are over all of these, "
            f"the last three errors over the hard ones. Revision `{front['revision']}`.\n")
    text += "".join(f"\n{front['front_sentences'][population]}\n" for population in FRONT_POPULATIONS if front["front_sentences"].get(population))
    text += "\n![Error against run time](../images/error_against_time.png)\n"
    rows = [(point["figures"]["theta"]["us_median"], point_row(name, point)) for name, points in front["points"].items() for point in points.values()]
    text += "\nWhat nothing beats, from the fastest on:\n" + table(FRONT_HEAD, [row for _, row in sorted(rows, key=lambda row: row[0]) if row[-1]])
    text += equal_error_section(front)
    text += "\n### Every point\n" + table(FRONT_HEAD, [row for _, row in rows])
    if front["hierarchy"]:
        text += "\n### The hierarchy of truths\n" + generic_rows(front["hierarchy"])
    if front["walks"]:
        text += "\n### Walks\n" + generic_rows(front["walks"])
    return text


def stability_section(stability):
    cases = stability["cases"]
    ran, held = [case for case in cases if case["ran"]], [case for case in cases if case["ran"] and case["holds"]]
    rows = [[case["group"], case["name"], case["must_hold"], case["measured"] + (f" ({case['note']})" if case["note"] else ""),
             ("yes, and fails the check" if case["holds"] and case["fails_check"] else "yes" if case["holds"] else "**no**") if case["ran"] else "not run"]
            for case in cases]
    text = f"\n{len(cases)} cases; {len(ran)} were run, and {len(held)} of these hold. Revision `{stability['revision']}`.\n"
    return text + table(["group", "case", "what must hold", "measured", "holds"], rows)


def savings_section(savings):
    text = ""
    words = {True: "yes", False: "not yet", None: "–"}
    cell = lambda value: "" if value is None else f"{value:,.1f}" if isinstance(value, float) else f"{value:,}"
    for scene, entry in savings.items():
        rows = [[line["what"], words[line["left_out"]], f"{line['count']:,} of {line['of']:,}", cell(line["seconds_saved"]), cell(line["seconds_noise"]),
                 cell(line["bytes_saved"]), {True: "yes", False: "no", None: ""}[line["same_result"]]] for line in entry["lines"].values()]
        text += f"\n### {scene}\n" + table(["what", "left out", "how many", "CPU s saved", "± s", "bytes saved", "same look-ups"], rows)
    return text


# the talk's bakes, on 64 cores: probes, seconds of visibility, of functions, of lighting, distinct functions, seconds of network and check, share fitted, MB, bytes a probe
TALK_BAKES = {"A": (138645, 22, 7, 62, 49211, 1.8, 6.5, 31.2, 236), "B": (193162, 46, 10, 84, 98721, 3.8, 4.1, 57.0, 309),
              "C": (386922, 93, 20, 152, 223992, 8.5, 4.9, 125, 339), "D": (33815, 7, 2, 17, 19071, 0.5, 13.4, 10.6, 329),
              "E": (301138, 86, 16, 114, 143868, 5.3, 5.6, 84.5, 294)}
BAKE_HEAD = ["level", "probes", "visibility, s", "functions, s", "lighting, s", "bare tents", "functions that take a θ", "network and check, s", "corrections, s", "short fits, s",
             "refinement, s", "fitted, of all", "of those with a θ", "stored, mean RMSE", "still failing", "MB", "bytes a probe", "whole bake, s"]


def bake_row(name, entry):
    seconds = entry["thread_s"]
    return [name, f"{entry['probes']:,}", *(f"{seconds[key]:.1f}" for key in ("visibility", "functions")), f"{entry['light_s']:.1f}", f"{entry['bare_tents']:,}", f"{entry['functions']:,}",
            *(f"{seconds[key]:.2f}" for key in ("network", "corrected", "fitted", "refinement")), percent(entry["share_fitted"]["all"]),
            percent(entry["share_fitted"]["theta"]), number(entry["rmse"]["stored"]["mean"]), f"{entry['still_failing']:,}", f"{entry['bytes'] / 1e6:.1f}",
            f"{entry['bytes_per_probe']:.0f}", f"{entry['wall_s']:.1f}"]


def sum_of_bakes(bakes):
    """All levels as one."""
    entries = list(bakes.values())
    total = lambda key: sum(entry[key] for entry in entries)
    functions, probes = max(1, total("functions")), max(1, total("probes"))
    return {**{key: total(key) for key in ("probes", "bare_tents", "functions", "still_failing", "bytes", "wall_s", "light_s")},
            "thread_s": {key: sum(entry["thread_s"][key] for entry in entries) for key in entries[0]["thread_s"]},
            "share_fitted": {"all": total("took_fit") / max(1, total("functions") + total("bare_tents")), "theta": total("took_fit") / functions},
            "rmse": {"stored": {"mean": sum(entry["rmse"]["stored"]["mean"] * entry["functions"] for entry in entries) / functions}},
            "bytes_per_probe": total("bytes") / probes}


def bakes_section(bakes):
    rows = [[f"talk {name}, *64 cores*", f"{probes:,}", seen, made, lit, "", f"{functions:,}", checked, "", "", "", f"{fitted} %", "", "", "", size, bytes_a_probe, ""]
            for name, (probes, seen, made, lit, functions, checked, fitted, size, bytes_a_probe) in TALK_BAKES.items()]
    rows += [bake_row(name, entry) for name, entry in bakes.items()]
    rows.append(bake_row("**all**", sum_of_bakes(bakes)))
    threads = sorted({entry["threads"] for entry in bakes.values()})
    text = (f"\nOurs on {', '.join(map(str, threads))} thread{'s' if threads != [1] else ''}; seconds of stages are thread seconds, those of lighting and of the whole bake by the "
            "clock. The talk's are by the clock on 64 cores, over all its functions, and all bytes include light.\n")
    return text + table(BAKE_HEAD, rows)


LOOK_UP_HEAD = ["", "unlit", "RMSE of a share", "wrong light: mean", "p99", "from the seen tents", "leak: mean", "p99"]


def look_up_rows(entry, write):
    """Of target φ, of the bare tents, and of every representation."""
    named = {"target φ": entry["target"], "bare tents": entry["tent"], **{f"`{name}`": found for name, found in entry["representations"].items()}}
    return [[name, *write(found)] for name, found in named.items()]


def distance_words(entry):
    """Heads of the classes of distance: "below 5 cm", "5 to 20 cm", …"""
    words = []
    for place in entry["places"]["by_distance"]:
        low, high = place["from_m"], place["to_m"]
        words.append(f"above {100 * low:g} cm" if high is None else f"below {100 * high:g} cm" if not low else f"{100 * low:g} to {100 * high:g} cm")
    return words


def look_up_section(look_up):
    text = ("\nAt random places in air the weights of the probes around are divided by their sum, as a look-up blends them, and compared with those of target φ at the "
            "same places. *Unlit* is the share of places that get no weight. *Wrong light* is half the sum of the differences of the shares: the share of the "
            "light that comes from wrong probes. *Leak* is the share that comes from probes that do not see the place. *From the seen tents* is the wrong light "
            "against the tents of those probes that do.\n")
    for scene, entry in look_up.items():
        cells = lambda found: [percent(found["unlit"]), number(found["rmse"]), number(found["wrong"]["mean"]), number(found["wrong"]["p99"]), number(found["wrong_to_seen"]),
                               number(found["leak"]["mean"]), number(found["leak"]["p99"])]
        places = entry["places"]
        text += (f"\n### {scene}\nProbes {entry['spacing_m']:g} m apart; revision `{entry['revision']}`. Even target φ leaves {percent(places['unlit_by_target'])} of the "
                 f"places unlit, and {percent(places['seen_by_no_probe'])} are seen by no probe around.\n")
        text += table(LOOK_UP_HEAD, look_up_rows(entry, lambda found: cells(found["all"])))
        heads = distance_words(entry)
        text += "\nBy distance to the nearest surface, mean of the wrong light and of the leak:\n"
        text += table(["", *heads], look_up_rows(entry, lambda found: [f"{number(by['wrong']['mean'])}, {number(by['leak']['mean'])}" for by in found["by_distance"]]))
        jumps = [[name, *(number(found["jumps"][key], 6) for key in ("mean", "p99", "largest")), *(number(found["border"][key]) if "border" in found else ""
                                                                                                   for key in ("mean", "p99", "largest"))]
                 for name, found in [("bare tents", entry["tent"]), *((f"`{name}`", found) for name, found in entry["representations"].items())]]
        text += "\nJumps of the shares through faces of cells, and what functions say at the border of their supports, where the look-up's bound makes it 0:\n"
        text += table(["", "jump: mean", "p99", "largest", "border: mean", "p99", "largest"], jumps)
    return text


def benchmarks_section(benchmarks):
    shown = lambda value: f"{value:,.0f}" if abs(value) >= 1000 else f"{value:.4g}"
    rows = [[f"`{entry['case']}`", microseconds(entry["us"]),
             "; ".join(f"{key.replace('_', ' ')} {shown(value)}" for key, value in entry.items() if key not in {"case", "us", "wall_us"})]
            for entry in benchmarks.values()]
    return table(["case", "µs", "counters"], rows)


def provenance(results):
    weights = "".join(f"\n- `{name}`: `{sha256}`" for name, sha256 in results.get("weights", {}).items())
    text = f"\nMade by `{results['command']}` and `workflow/results.py collect out/{results['run']}`."
    return text + (f" SHA-256 of the weights:\n{weights}\n" if weights else "\n")


def page(all_results):
    """The whole page, of the main results."""
    results = all_results[MAIN]
    text = INTRODUCTION + provenance(results) + (PENDING_NOTE if results.get("pending") else "")
    if "representations" in results.get("evaluation", {}):
        text += size_section(results["evaluation"]) + stages_section(results["evaluation"])
    for key in ("evaluation", "validation"):
        if "representations" in results.get(key, {}):
            text += split_section(key, results[key])
    sections = {"frontier": ("Error against run time", frontier_section), "look_up": ("What a look-up blends", look_up_section),
                "stability": ("Stability", stability_section), "savings": ("What a bake leaves out", savings_section),
                "bakes": ("Whole bakes", bakes_section), "benchmarks": ("Benchmarks", benchmarks_section)}
    for key, (title, write) in sections.items():
        text += f"\n## {title}\n" + (write(results[key]) if key in results else "\nNot measured at this revision.\n")
    return text

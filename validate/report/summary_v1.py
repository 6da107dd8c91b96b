"""For as long as nlg-validate writes schema_version 1: its two files in the shape of schema_version 2, so that the pipeline keeps drawing.

To be removed with the first nlg-validate that writes version 2. What version 1 did not know is not made up: it has no populations (all
functions count as taking a theta) and no intervals, and what it calls refined is the last that it knows of a function; the page says so.
"""
import csv
import os

import numpy as np

WORDS = {"uncorrected": ("network",), "generator": ("corrected",), "refined": ("fitted", "stored"), "adam_theta0": ("adam_theta0",), "lm_theta0": ("lm_theta0",),
         "adam_random": ("adam_random",), "direct": ("direct", "best_known"), "tent": ("tent",)}
NOTE = "measured by an nlg-validate of before schema_version 2: all functions count as taking a θ, there are no intervals, stored is fitted, best known is direct, and of fits only the refinement counts"


def rows(path, tau_rmse=.02, tau_leak=.1):
    """(line, row) in the columns of version 2; None where the file is not of version 1."""
    try:
        with open(path, newline="", encoding="utf-8") as file:
            old = list(csv.DictReader(file))
    except (OSError, UnicodeDecodeError):
        return None
    if not old or "method" not in old[0]:
        return None
    result, fails = [], lambda r: float(r["rmse"]) > tau_rmse or float(r["leak_p99"]) > tau_leak
    failed = {(r["representation"], r["function"]) for r in old if r["method"] == "generator" and fails(r)}
    for line, r in enumerate(old, 2):
        for word in WORDS.get(r["method"], ()):
            fitted = (r["representation"], r["function"]) in failed if r["method"] == "refined" else r["method"] not in ("uncorrected", "generator", "tent")
            result.append((line, [r["representation"], word, r["function"], r["scene"], "1", r["hard"], r["rmse"], r["rmse_unseen_points"], r["rmse_shadow"], r["leak_mean"], r["leak_p99"],
                                  str(int(fails(r))), str(int(fitted)), r["elapsed_us"]]))
    return result


def quantiles(values):
    values = np.array([float(v) for v in values if v != ""])
    if not len(values):
        return {"functions": 0}
    some = dict(zip(("median", "mean", "p95", "p99", "worst"), map(float, (np.median(values), values.mean(), *np.quantile(values, (.95, .99)), values.max()))))
    return some | {"functions": len(values), "interval": {q: [some[q]] * 2 for q in ("median", "mean", "p95")}}


def share(column):
    value = sum(v == "1" for v in column) / len(column)
    return dict.fromkeys(("value", "low", "high"), value)


def figures(some, leak):
    if not some:
        return {"functions": 0}
    columns = list(zip(*some))
    time = quantiles(columns[13])
    return {"functions": len(some), "rmse": quantiles(columns[6]), "rmse_test_points": quantiles(columns[7]), "rmse_occluded": quantiles(columns[8]), "leak": leak,
            "share_failing_check": share(columns[11]), "share_fitted": share(columns[12]), "us_per_function": time["mean"], "us_per_function_median": time["median"]}


def populations(some, leak):
    return {"all": figures(some, leak), "theta": figures(some, leak), "hard": figures([r for r in some if r[5] == "1"], leak)}


def ratios(some, reference):
    value = lambda column, only_hard: float(np.median([float(r[column]) / float(reference[r[2]][column]) for r in some
                                                       if r[column] and float(reference[r[2]][column] or 0) and (r[5] == "1" or not only_hard)] or [0]))
    return {key: dict.fromkeys(("value", "low", "high"), value(*of)) for key, of in
            {"median": (6, False), "median_hard": (6, True), "median_test_points": (7, False), "median_occluded_hard": (8, True)}.items()}


def upgraded(node):
    old = node.value
    if not isinstance(old, dict) or old.get("schema_version") != 1:
        return node
    some = rows(os.path.join(os.path.dirname(node.path), "functions.csv"), old["tau"]["rmse"], old["tau"]["leak_p99"])
    if some is None:
        return node
    table = {}
    for _, row in some:
        table.setdefault((row[0], row[1]), []).append(row)
    counts = old["functions"]
    new = {"schema_version": 2, "provenance": {**old["provenance"], "effort": NOTE}, "tau": {**old["tau"], "leak": old["tau"]["leak_p99"], "leak_share": .01, "bare_tent_rmse": 0.0},
           "functions": {**counts, "take_theta": counts["held_out"], "held_out_in_training_mirrored": counts["held_out_in_training"]},
           "tent": populations(table["tent", "tent"], old["tent"]["leak"]), "representations": {}}
    for name, r in old["representations"].items():
        known = {row[2]: row for row in table[name, "direct"]}
        sampled = lambda word: [row for row in table[name, word] if row[2] in known]
        leak = {word: r[method]["leak"] for method, words in WORDS.items() if method != "tent" for word in words}
        sample = {word: populations(sampled(word), of) for word, of in leak.items()}
        sample |= {"functions": len(known), "hard": sum(row[5] == "1" for row in known.values()),
                   "ratios": {word: dict.fromkeys(("to_best_known", "to_direct", "without_duplicates"), ratios(sampled(word), known)) for word in ("network", "corrected", "fitted", "stored")}}
        new["representations"][name] = {"evaluate_us": 0, **{key: r[key] for key in ("parameters", "bytes", "weights_bytes", "weights_sha256", "correction_steps", "evaluate_us") if key in r},
                                        "stages": [], **{word: populations(table[name, word], leak[word]) for word in ("network", "corrected", "fitted", "stored")}, "sample": sample,
                                        "by_scene": {scene: {"stored": q, "network": q} for scene, q in r["by_scene"].items()}}
    return type(node)(node.path, node.place, new)


def upgraded_frontier(node):
    """The same for frontier.json of version 1, which did not time exactly equal errors."""
    old = node.value
    if not isinstance(old, dict) or old.get("schema_version") != 1 or "hard_functions" not in old:
        return node
    keys = ("us_median", "us_p25", "us_p75", "leak_p99")
    points = []
    for p in old["points"]:
        all_of = {**{k: v for k, v in p.items() if k in keys or k.startswith("rmse_") or k == "on_front"}, "share_fitted": 0.0}
        hard = {**all_of, **p["hard"]} if p["hard"] else None
        word = {"generator": ["network"], "corrected": ["corrected"]}.get(p["family"], [])
        points.append({"representation": p["representation"], "family": p["family"].replace("_from_generator", "_from_corrected"), "budget": p["budget"], "label": p["label"], "words": word,
                       "figures": {"all": all_of, "theta": all_of, "hard": hard}, "by_scene": p["by_scene"]})
    tent = old["bare_tent"]
    count, errors = old["functions"], {k: v for k, v in tent.items() if k.startswith("rmse_")}
    return type(node)(node.path, node.place, {**old, "schema_version": 2, "functions": {"all": count, "theta": count, "hard": old["hard_functions"]}, "points": points,
                                              "bare_tent": {"figures": {"all": errors, "theta": errors, "hard": tent["hard"]}, "by_scene": tent["by_scene"]},
                                              "front_sentences": {"all": old["front_sentence"], "theta": old["front_sentence"], "hard": old["hard_front_sentence"]},
                                              "speed_at_equal_error": {}, "speed_at_equal_error_hard": {}})

"""Inputs of the report that nobody measured: every file that it reads, small, of every kind of row, the same bytes each time."""
import csv
import json
import os
import random
import struct
import zlib

SCENES = ("am_galmevish2", "a_scene_whose_name_is_longer_than_any_column_should_have_to_be", "kaos <b>& \"sons\"</b>, $x$")
REPRESENTATIONS = {"tent_mlp": 113, "mlp": 113, "pf5": 250}
WORDS = ("network", "corrected", "fitted", "stored")
FITS = ("direct", "best_known")
SAMPLED = 3  # every third function, where it takes a θ
FUNCTIONS = 60
ERROR = {"tent": 1.0, "network": 0.5, "corrected": 0.3, "fitted": 0.15, "stored": 0.151, "direct": 0.15, "best_known": 0.14}
TIME_US = {"network": 20, "corrected": 300, "fitted": 500, "stored": 500, "direct": 180000, "best_known": 240000}
TAU = {"rmse": 0.02, "blend": 0.06, "leak": 0.1, "dark_weight": 64, "blend_floor": 0.2, "hard_tent_rmse": 0.01, "bare_tent_rmse": 0.005}
BLEND = 2.5  # every blend RMSE over its RMSE: what takes one for the other shows
# name, title, word, budget, which functions take it
STAGES = [("network", "network", "network", None, "all functions"),
          ("last_layer", "exact last layer", "corrected", None, "functions that the network left above a blend RMSE of 0.001 or failing the check"),
          ("lm", "Levenberg-Marquardt", "fitted", "4 iterations at most", "those of them whose blend RMSE is still above 0.005"),
          ("refinement", "refinement", "fitted", "3 rounds at most", "functions that fail the check"),
          ("rounding", "rounding", "stored", None, "all functions")]
AFTER = (["network"], ["corrected"], ["fitted"], ["stored"], [])  # what θ is called after a stage

def quantiles(values):
    values = sorted(values)
    at = lambda share: values[round(share * (len(values) - 1))] if values else 0
    some = {"median": at(.5), "mean": sum(values) / max(1, len(values)), "p95": at(.95), "p99": at(.99), "worst": at(1), "functions": len(values)}
    return some | {"interval": {q: [some[q] * .9, some[q] * 1.1] for q in ("median", "mean", "p95")}}


def samples(seed):
    """(representation, word) → [(function, scene, takes a θ, hard, rmse, leak_p99, fails the check, fitted, elapsed_us)]"""
    chance = random.Random(seed)
    tent = [10 ** chance.uniform(-3, -0.9) for _ in range(FUNCTIONS)]
    table = {}
    for representation, word in [("tent", "tent")] + [(r, w) for r in REPRESENTATIONS for w in WORDS + FITS]:
        worse = 1.6 if representation == "mlp" else 1.0
        rows = []
        for i in range(0, FUNCTIONS, SAMPLED if word in FITS else 1):
            takes, rmse, leak = tent[i] >= TAU["bare_tent_rmse"], tent[i] * ERROR[word] * (worse if word != "tent" else 1) * chance.uniform(.8, 1.25), tent[i] * chance.uniform(.2, 1.1)
            if not takes and word in FITS:
                continue
            if not takes and word in WORDS:
                rmse = tent[i]  # the bare tent at every stage
            rows.append((i, SCENES[i * len(SCENES) // FUNCTIONS], takes, tent[i] >= TAU["hard_tent_rmse"], rmse, leak, rmse > TAU["rmse"] or BLEND * rmse > TAU["blend"],
                         word in FITS or (takes and word in ("fitted", "stored") and tent[i] > .05), TIME_US.get(word, 0) * chance.uniform(.9, 1.1) * takes))
        table[representation, word] = rows
    return table


def share(part, whole):
    value = part / max(1, whole)
    return {"value": value, "low": max(0, value - .02), "high": min(1, value + .02)}


def figures(rows):
    rmse = quantiles([r[4] for r in rows])
    return {"functions": len(rows), "blend_rmse": quantiles([BLEND * r[4] for r in rows]), "rmse": rmse, "rmse_test_points": quantiles([1.1 * r[4] for r in rows]), "rmse_occluded": quantiles([1.3 * r[4] for r in rows if r[3]]),
            "leak": {"mean": .003, "p99": .05}, "share_failing_check": share(sum(r[6] for r in rows), len(rows)), "share_fitted": share(sum(r[7] for r in rows), len(rows)),
            "us_per_function": quantiles([r[8] for r in rows])["mean"]}


def populations(rows):
    return {"all": figures(rows), "theta": figures([r for r in rows if r[2]]), "hard": figures([r for r in rows if r[3]])}


HELD_OUT = "00" * 32  # SHA-256 of the shards


def ratio(rows, reference):
    value = quantiles([r[4] / reference[r[0]] for r in rows if r[0] in reference])["median"]
    return {"value": value, "low": .9 * value, "high": 1.1 * value}


def sample(table, name):
    known = {r[0] for r in table[name, "best_known"]}
    of = lambda word: [r for r in table[name, word] if r[0] in known]
    best = {r[0]: r[4] for r in table[name, "best_known"]}
    ratios = {word: {"to_best_known": {"median": ratio([r for r in of(word) if r[2]], best), "median_hard": ratio([r for r in of(word) if r[3]], best)}} for word in WORDS}
    return {"functions": len(known), "hard": sum(r[3] for r in of("network")), **{word: populations(of(word)) for word in WORDS + FITS}, "ratios": ratios}


def summary(table, held_out=HELD_OUT):
    representations = {}
    for name, parameters in REPRESENTATIONS.items():
        stages = [{"name": stage, "title": title, "word": word, "budget": budget, "takes": takes, "text": f"{title}: {takes}"} for stage, title, word, budget, takes in STAGES]
        node = {"parameters": parameters, "theta_bytes": {"float32": 4 * parameters, "float16": 2 * parameters, "int8": parameters + 9}, "weights_bytes": 2000000, "weights_sha256": "0" * 64, "evaluate_us": 10.0, "stages": stages}
        node |= {word: populations(table[name, word]) for word in WORDS} | {"sample": sample(table, name)}
        representations[name] = node
    options = {"direct_adam_steps": 32000, "direct_lm_iterations": 40, "direct_restarts": 2}
    tent = table["tent", "tent"]
    counts = {"distinct": 200, "free_space": 900, "duplicates": 80, "in_solid": 300, "empty": 1, "outside": 19, "visited_probes": 1500, "grid_probes": 9000,
              "held_out": FUNCTIONS, "held_out_scenes": len(SCENES), "take_theta": sum(r[2] for r in tent), "hard": sum(r[3] for r in tent), "held_out_in_training": 2,
              "held_out_in_training_mirrored": 3}
    return {"schema_version": 2, "provenance": {"tool": "nlg-validate", "revision": "made-up", "options": options, "inputs": {"held_out": held_out}},
            "tau": TAU, "theta_precision": "int8", "functions": counts, "tent": populations(tent), "representations": representations}


def slices():
    size, result = 12, []
    for name in REPRESENTATIONS:
        for which in ("p5", "median", "p95", "worst"):
            ramp = [1000 * i // (size * size) for i in range(size * size)]
            result.append({"representation": name, "which": which, "function": 7, "scene": SCENES[1], "blend_rmse": .075, "rmse": .03, "axis": 1, "size": size,
                           "valid": [int(i % size > 2) for i in range(size * size)], "seen": [int(i % size > 6) for i in range(size * size)], "target_permille": ramp, "stored_permille": ramp[::-1],
                           "difference_permille": [b - a for a, b in zip(ramp, ramp[::-1])]})
    return result


def frontier():
    chance, points = random.Random(2), []
    families = [("lm_from_corrected", [1, 2, 4, 8, 16, 32, 64]), ("adam_from_corrected", [16, 50, 200, 1000]),
                ("lm_from_theta0", [4, 16, 64]), ("lm_from_theta0_gated", [4, 16, 64]), ("adam_from_random", [200, 1000, 8000])]

    def add(representation, family, budget, label, us, rmse, words=(), fitted=0.0):
        statistics = {"mean": 1.5, "median": 1, "p5": .25, "p95": 5, "worst": 15}
        errors = lambda c: {**{f"blend_rmse_{key}": BLEND * share * rmse * c for key, share in statistics.items()}, "rmse_mean": 1.5 * rmse * c}
        figures = lambda c: {"us_median": us, "us_p25": us * .95, "us_p75": us * 1.1, **errors(c), "leak_p99": .05, "share_failing_check": .01 * c, "share_fitted": fitted, "on_front": False}
        points.append({"representation": representation, "family": family, "budget": budget, "label": label, "words": list(words),
                       "figures": {"theta": figures(1), "hard": figures(3)},
                       "by_scene": {scene: {"us_median": us, "us_p25": us, "us_p75": us, **errors(1 + i / 2)} for i, scene in enumerate(SCENES)}})

    for r, representation in enumerate(REPRESENTATIONS):
        for i, stage in enumerate(STAGES):
            add(representation, "stages", None, stage[1], 20 * 1.9 ** i * (1 + r / 2), .004 * (1 + r / 3) * .8 ** i, AFTER[i], .3 * (i > 1))
        for f, (family, budgets) in enumerate(families):
            for budget in budgets:
                us = (250, 300, 250, 150, 300)[f] * (1 + r / 2) * (1 + budget)
                rmse = .004 * (1 + r / 3) * us ** -.12 * (3 if "theta0" in family or "random" in family else 1) * chance.uniform(.9, 1.1)
                add(representation, family, budget, f"{budget} of {family.replace('_', ' ')}", us, rmse, fitted=float("_from_" in family))
    for population in ("theta", "hard"):
        best = float("inf")
        for point in sorted(points, key=lambda p: (p["figures"][population]["us_median"], p["figures"][population]["blend_rmse_mean"])):
            if point["figures"][population]["blend_rmse_mean"] < best:
                point["figures"][population]["on_front"], best = True, point["figures"][population]["blend_rmse_mean"]
    speed = {"time_us": 500.0, "blend_rmse_mean": .005, "share_failing_check": share(1, 100), "baseline": "LM from theta0, gated", "baseline_us_at_equal_error": 3000.0,
             "baseline_share_failing_check": share(3, 100), "ratio": {"value": 6.0, "low": 4.5, "high": 8.1}, "longest_us": None, "reason": None}
    speeds = {representation: {word: speed for word in WORDS} for representation in REPRESENTATIONS}
    speeds["mlp"]["fitted"] = {**speed, "ratio": {"value": 4.0, "low": 3.0, "high": None}}
    tent = lambda c: {"blend_rmse_mean": BLEND * .03 * c}
    return {"schema_version": 2, "provenance": {"inputs": {"held_out": HELD_OUT, "weights.0": "0" * 64}},
            "functions": {"theta": 60, "hard": 9}, "scenes": list(SCENES), "points": points,
            "bare_tent": {"figures": {"theta": tent(1), "hard": tent(2)}, "by_scene": {scene: tent(1) for scene in SCENES}},
            "front_sentences": {"theta": "On the front: tent_mlp, stage after stage.", "hard": "On the front over hard functions: the same."},
            "speed_at_equal_error": speeds}


def stability():
    case = lambda group, name, holds: {"group": group, "name": name, "must_hold": "No NaN comes out, and nothing is worse than its start.",
                                       "measured": "largest error 1.2e-6 of 400 starts", "figures": {"largest_error": 1.2e-6}, "holds": holds, "fails_check": False}
    groups = ("functions", "codes", "generator")
    cases = [case(group, f"{group} case {i}", True) for group in groups for i in range(3)]
    cases += [case("functions", "triangles <slivers> of 1e6:1", False)]
    cases += [{**case("functions", "half space", True), "fails_check": True, "measured": "RMSE .03 where the best known has .028"}]
    return {"schema_version": 1, "provenance": {"inputs": {"weights_0": "0" * 64}}, "cases": cases}


def bake(scene, seconds=12.0, error=0.025):
    saving = lambda what, **more: {"what": what, "count": 60, "of": 90, **more, "note": "a note"}
    return {"scene": scene, "wall_seconds": {"load": 1.0, "all": seconds - 1}, "light": {"median_error": error}, "savings": [saving("probes in free space", seconds_saved=1.25, bytes_saved=123456), saving("links that no triangle is near"),
                                        saving("probes in solid", count=0, seconds_saved=0.0, bytes_saved=0),
                                        saving("duplicates", seconds_saved=-0.5, bytes_saved=12)]}


def png(width, height, grey):
    """A picture of one grey."""
    def chunk(name, data):
        return struct.pack(">I", len(data)) + name + data + struct.pack(">I", zlib.crc32(name + data))

    rows = (b"\0" + bytes([grey]) * width) * height
    return b"\x89PNG\r\n\x1a\n" + chunk(b"IHDR", struct.pack(">IIBBBBB", width, height, 8, 0, 0, 0, 0)) + chunk(b"IDAT", zlib.compress(rows)) + chunk(b"IEND", b"")


def light(scene, harder):
    """Three methods at two spacings; solved light is best before surfaces. The two harder scenes have pictures of our worst places."""
    def method(weights, light, rmse, per_probe, probes):
        some = {"rmse": rmse, "smape": .1, "unlit": .001, "outside": 0.0, "balanced": {"rooms": 4, "rmse": 2 * rmse}}
        surface = {**some, "by_distance": [{"from_m": low, "to_m": high, "rmse": rmse * (1 + low)} for low, high in ((.02, .05), (.05, .1), (.1, .2), (.2, .5))]}
        worst = [{"group": ("air", "surface", "turned")[i % 3], "position_m": [i, 1.5, -2], "normal": [0, 0, 1], "truth": [.5, .4, .3], "answer": [.9, .4, .3], "error": rmse * (10 - i)} for i in range(10)]
        return {"weights": weights, "light": light, "air": some, "surface": surface, "turned": {**some, "rmse": 1.2 * rmse}, "dark": {"places": 99, "excess": rmse / 10 - .01}, "edge": {"excess": rmse}, "jumps": {"mean": .003, "largest": .1},
                "bytes": {"total": per_probe * probes, "per_probe": float(per_probe)}, "probes": probes, "worst": worst, "times": {"weights_s": .4 * (weights == "tent_mlp"), "light_s": .02}}

    methods = lambda far, probes: [method("valid trilinear", "point", .2 * harder * far, 33, probes), method("DDGI as shipped", "own", .18 * harder * far, 1288, probes),
                                   method("target functions", "solved", .098 * harder * far, 8192, probes), method("tent_mlp", "solved", .1 * harder * far, 59, probes)]
    fine, coarse = methods(1, 800), methods(1.6, 120)
    for rank, place in enumerate(fine[3]["worst"] if harder > 1 else ()):
        place["picture"] = f"pictures/{harder}_{rank}.png"
    return {"schema_version": 1, "scene": scene, "truth": {"all_bounces_in_one_ray": True}, "floor": method("harmonics at the point", "point", .05 * harder, 33, 800),
            "spacings": [{"spacing_m": 1.0, "methods": fine}, {"spacing_m": 2.0, "methods": coarse}]}


def write_csv(path, header, rows):
    with open(path, "w", newline="") as file:
        csv.writer(file, lineterminator="\n").writerows([header, *rows])


def write_json(path, content):
    with open(path, "w") as file:
        json.dump(content, file)
    return path


COLUMNS = "representation,word,function,scene,take_theta,hard,blend_rmse,rmse,rmse_test_points,rmse_occluded,leak_mean,leak_p99,fails_check,fitted,elapsed_us"


def write_functions(path, table):
    rows = [(r, w, i, scene, int(takes), int(hard), f"{BLEND * rmse:.6g}", f"{rmse:.6g}", f"{1.1 * rmse:.6g}", f"{1.3 * rmse:.6g}" if hard else "", f"{leak / 9:.6g}", f"{leak:.6g}", int(fails), int(fitted),
             f"{us:.6g}") for (r, w), some in table.items() for i, scene, takes, hard, rmse, leak, fails, fitted, us in some]
    write_csv(path, COLUMNS.split(","), rows)


def write_all(folder):
    """Writes every input; returns the arguments of report.py that read what it must have, and those of the proof."""
    path = lambda name: os.path.join(folder, name)
    table = samples(2)
    write_json(path("summary.json"), summary(table))
    write_functions(path("functions.csv"), table)
    write_json(path("slices.json"), slices())
    for name in REPRESENTATIONS:
        write_csv(path(f"{name}.csv"), "step,learning_rate,training_loss,held_out_network_blend_rmse,held_out_blend_rmse,bare_tent_blend_rmse,rollbacks".split(","),
                  [(i, .001, .02 / i, .03 / i, .01 / i, .02, 0) for i in range(1, 6)])
    write_json(path("frontier.json"), frontier())
    write_json(path("stability.json"), stability())
    for index, scene in enumerate(SCENES[:2]):
        write_json(path(f"bake{index}.json"), bake(scene))
    for index, scene in enumerate(SCENES):
        write_json(path(f"light{index}.json"), light(scene, 1 + index))
    counts = {"probes": 900, "functions": 200, "free_space": 400, "in_solid": 250, "duplicates": 45, "empty": 5, "outside": 0, "bare_tents": 90, "hard": 50, "of_solid": 8,
              "tent_blend_rmse": [{"at_most": 0.01, "functions": 150}, {"at_most": None, "functions": 50}]}
    write_json(path("dataset.json"), {"shards": 3, "scenes": [{"split": split, "scene": scene, **counts} for split, scene in (("held_out", "a"), ("training", "b"), ("training", "c"))]})
    os.makedirs(path("run"), exist_ok=True)
    split = {"scenes": 1, "shards": 1, "probes": 1000.0, "functions": 250.0, "core_s": 9.0, "bytes": 1e6}
    write_json(path("run/plan.json"), {"schema_version": 1, "configuration": "c", "cores": 2, "clock_s": 30.0, "splits": {"training": split, "held_out": split},
                                       "stages": [{"name": name, "rule": "r", "jobs": 1, "core_s": 40.0, "cores": 2} for name in ("train mlp", "report")]})
    write_json(path("run/times.json"), {"plan": "c", "stages": {"train mlp": {"jobs": 1, "seconds": 30.0}}})
    os.makedirs(path("pictures"), exist_ok=True)
    for harder in (2, 3):
        for rank in range(10):
            with open(path(f"pictures/{harder}_{rank}.png"), "wb") as file:
                file.write(png(72, 24, 20 * harder + rank))
    needed = ["--summary", path("summary.json"), "--functions", path("functions.csv"), "--slices", path("slices.json"),
              "--logs", *(path(f"{name}.csv") for name in REPRESENTATIONS)]
    left_out = ["train.steps: 3000, full 8000", 'report.savings: ["doorway", "table"], full ["two_rooms", "doorway", "table"]']
    return needed, ["--data", path("dataset.json"), "--run", path("run"), "--left-out", *left_out, "--frontier", path("frontier.json"), "--stability", path("stability.json"), "--savings", path("bake0.json"), path("bake1.json"),
                                               "--light", *(path(f"light{index}.json") for index in range(len(SCENES)))]

#!/usr/bin/python3
"""nlg-validate frontier on next to nothing: every key of the contract and no other, and figures that agree.

    frontier_test.py BIN_FOLDER MAKE_WEIGHTS
"""
import json
import math
import os
import sys

sys.dont_write_bytecode = True
sys.path.append(os.path.join(os.path.dirname(os.path.abspath(__file__)), ".."))
from tools import Tools, run_checks

TOOLS = Tools(sys.argv[1])
expect = TOOLS.check
MAKE_WEIGHTS = os.path.abspath(sys.argv[2])
TINY = ["--functions", "7", "--repeats", "2", "--corrected-lm-steps", "1,2", "--corrected-adam-steps", "2", "--direct-lm-steps", "2,3", "--direct-adam-steps", "64"]
GOOD = ["--weights", "tent_mlp.safetensors", "pf3.safetensors", "pf5.safetensors", "code16.safetensors", "--held-out", "one.h5", "two.h5", *TINY]
NAMES = ["tent_mlp", "pf3", "pf5", "code16"]
POPULATIONS = ["theta", "hard"]
WORDS = ["network", "corrected", "fitted", "stored"]
ERRORS = [*(f"blend_rmse_{key}" for key in ("mean", "median", "p5", "p95", "worst")), "rmse_mean"]
TIMES = ["us_median", "us_p25", "us_p75"]
# of each list and object of frontier.json: all its keys
KEYS = {part: set(keys) for part, keys in {
    "": "schema_version provenance functions scenes representations points bare_tent front_sentences speed_at_equal_error".split(),
    "functions": "theta hard".split(),
    "representations": "stages".split(),
    "points": "representation family budget label words figures by_scene".split(),
    "figures": [*TIMES, *ERRORS, "leak_p99", "share_failing_check", "share_fitted", "on_front"],
    "by_scene": [*TIMES, *ERRORS],
    "bare_tent": "figures by_scene".split(),
    "speed": "time_us blend_rmse_mean share_failing_check baseline baseline_us_at_equal_error baseline_share_failing_check ratio longest_us reason".split(),
}.items()}


def check_numbers(figures, keys, name):
    numbers = [figures[key] for key in keys if key != "on_front"]
    expect(all(math.isfinite(number) and number >= 0 for number in numbers), f"{name}: {numbers}")
    expect(0 < figures["us_p25"] <= figures["us_median"] <= figures["us_p75"], f"{name}: times {figures}")
    expect(figures["blend_rmse_p5"] <= figures["blend_rmse_median"] <= figures["blend_rmse_p95"] <= figures["blend_rmse_worst"], f"{name}: errors {figures}")
    expect(figures["blend_rmse_mean"] >= figures["rmse_mean"], f"{name}: no point weighs less than 1, but {figures}")
    expect(figures.get("share_failing_check", 0) <= 1, f"{name}: {figures}")


def check_point(point, keys, result):
    name = f"{point['representation']}: {point['label']}"
    expect(set(point) == keys["points"], f"{name}: keys {set(point) ^ keys['points']}")
    expect(list(point["figures"]) == POPULATIONS, f"{name}: populations {list(point['figures'])}")
    for population, figures in point["figures"].items():
        expect(set(figures) == keys["figures"], f"{name}: keys {set(figures) ^ keys['figures']}")
        check_numbers(figures, keys["figures"], f"{name}, {population}")
    theta, hard = (point["figures"][population] for population in POPULATIONS)
    expect(hard["blend_rmse_worst"] <= theta["blend_rmse_worst"], f"{name}: a hard function is worse than the worst")
    for scene, figures in point["by_scene"].items():
        expect(scene in result["scenes"] and set(figures) == keys["by_scene"], f"{name}: {scene} {set(figures) ^ keys['by_scene']}")
        check_numbers(figures, keys["by_scene"], f"{name}, {scene}")


def check_speeds(result, keys):
    """Of every representation all four words, each with the figures of its point, and a ratio or a reason."""
    key, population = "speed_at_equal_error", "theta"
    expect(set(result[key]) == set(NAMES), f"{key}: {set(result[key])}")
    for name, words in result[key].items():
        expect(list(words) == WORDS, f"{key}, {name}: {list(words)}")
        for word, speed in words.items():
            expect(set(speed) == keys["speed"], f"{key}, {name}, {word}: keys {set(speed) ^ keys['speed']}")
            point = next(p for p in result["points"] if p["representation"] == name and word in p["words"])
            expect(math.isclose(speed["blend_rmse_mean"], point["figures"][population]["blend_rmse_mean"], rel_tol=1e-9), f"{key}, {name}, {word}: {speed}")
            expect(math.isclose(speed["share_failing_check"]["value"], point["figures"][population]["share_failing_check"], abs_tol=1e-9), f"{key}, {name}, {word}: {speed}")
            expect((speed["ratio"] is None) == (speed["baseline"] is None) == (speed["reason"] is not None), f"{key}, {name}, {word}: {speed}")


def check_result(tools):
    tools.must(["nlg-validate", "frontier", *GOOD, "--out", "out"])
    result = json.load(open("out/frontier.json"))
    keys = KEYS
    points = result["points"]
    expect(set(result) == keys[""], f"keys of the file: {set(result) ^ keys['']}")
    counts = result["functions"]
    expect(set(counts) == keys["functions"], f"keys of functions: {counts}")
    expect(0 < counts["hard"] <= counts["theta"] <= 7, f"functions: {counts}")
    expect(result["scenes"] == ["house_1", "house_2"], f"scenes: {result['scenes']}")
    for name, entry in result["representations"].items():
        titles = [point["label"] for point in points if (point["representation"], point["family"]) == (name, "stages")]
        expect(set(entry) == keys["representations"] and len(entry["stages"]) == len(titles) - 1, f"{name}: {entry} and {titles}")
    for point in points:
        check_point(point, keys, result)
    tent = result["bare_tent"]
    expect(set(tent) == keys["bare_tent"] and list(tent["figures"]) == POPULATIONS, f"bare tent: {tent}")
    check_speeds(result, keys)


def make_inputs(tools):
    for name, scene in [("one", "house:1"), ("two", "house:2")]:
        tools.must(f"nlg-datagen --scene {scene} --max-functions 8 --test-points 64 --held-out --out {name}.h5")
    for name in NAMES:
        tools.must([MAKE_WEIGHTS, f"{name}.safetensors", name])


if __name__ == "__main__":
    sys.exit(run_checks(TOOLS, (make_inputs, check_result)))

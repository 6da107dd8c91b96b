#!/usr/bin/python3
"""nlg-validate frontier on next to nothing: every documented key and no other, figures that agree, and what it refuses.

    frontier_test.py BIN_FOLDER MAKE_WEIGHTS MAKE_NARROW_SHARD
"""
import csv
import json
import math
import os
import re
import subprocess
import sys
import tempfile

USAGE_ERROR, INPUT_ERROR, OUTPUT_ERROR = 2, 3, 5  # tool/error.h

BIN, MAKE_WEIGHTS, MAKE_NARROW_SHARD = (os.path.abspath(path) for path in sys.argv[1:4])
TIMEOUT_FACTOR = float(os.environ.get("NLG_TEST_TIMEOUT_FACTOR", "1"))  # of sanitizers, which slow everything down
SOURCES = os.path.dirname(os.path.dirname(os.path.dirname(os.path.abspath(__file__))))
TINY = ["--functions", "7", "--repeats", "2", "--lm-steps", "1,2", "--adam-steps", "2", "--direct-lm-steps", "2", "--direct-adam-steps", "64",
        "--coefficients", "5,25"]
GOOD = ["--weights", "tent_mlp.safetensors", "pf3.safetensors", "pf5.safetensors", "--held-out", "one.h5", "two.h5", *TINY]
failures = []


def expect(holds, what):
    if not holds:
        failures.append(what)


def run(tool, *arguments):
    return subprocess.run([os.path.join(BIN, tool), *arguments], capture_output=True, text=True, timeout=120 * TIMEOUT_FACTOR)


def must(*command):
    result = subprocess.run(command, capture_output=True, text=True, timeout=120 * TIMEOUT_FACTOR)
    if result.returncode != 0:
        sys.exit(f"{' '.join(command)}: exit code {result.returncode}\n{result.stderr}")
    return result.stdout


def documented_keys():
    """Of each list and object of frontier.json, the keys in the table of docs/reference/formats.md."""
    text = open(os.path.join(SOURCES, "docs/reference/formats.md")).read()
    section = re.search(r"\n## frontier\.json.*?(?=\n## )", text, re.S).group(0)
    keys = {"": set(), "points": set(), "hard": set(), "bare_tent": set(), "by_scene": set(), "hierarchy": set(), "walks": set()}
    for cell in re.findall(r"^\| (`.*?) \|", section, re.M):
        for name in re.findall(r"`([^`]+)`", cell):
            part, _, key = name.rpartition(".")
            keys[part].add(key)
    return keys


def check_front(members, errors, tent, sentence):
    """The sentence names every member; there are some when anything is better than the bare tent."""
    expect(bool(members) == (min(errors) < tent), f"{len(members)} members, errors from {min(errors)}, the tent's {tent}")
    expect(all(f"{p['representation']}: {p['label']} (" in sentence for p in members), sentence)
    expect(members or sentence.startswith("Nothing has a smaller median error"), sentence)


def check_result():
    must(os.path.join(BIN, "nlg-validate"), "frontier", *GOOD, "--hierarchy", "room.hierarchy.json", "hall.hierarchy.json", "--out", "out")
    result = json.load(open("out/frontier.json"))
    keys = documented_keys()
    points = result["points"]
    expect(set(result) == keys[""], f"keys of the file: {set(result) ^ keys['']}")
    for point in points:
        name = f"{point['representation']}: {point['label']}"
        expect(set(point) == keys["points"], f"{name}: keys {set(point) ^ keys['points']}")
        expect(set(point["hard"]) == keys["hard"], f"{name}: keys of hard {point['hard']}")
        expect(point["hard"]["rmse_worst"] <= point["rmse_worst"], f"{name}: a hard function is worse than the worst")
        expect(set(point["by_scene"]) == set(result["scenes"]), f"{name}: scenes {set(point['by_scene'])}")
        for figures in [point, *point["by_scene"].values()]:
            expect(figures is point or set(figures) == keys["by_scene"], f"{name}: keys of a scene {set(figures) ^ keys['by_scene']}")
            numbers = [figures[key] for key in keys["by_scene"]]
            expect(all(math.isfinite(number) and number >= 0 for number in numbers), f"{name}: {numbers}")
            expect(0 < figures["us_p25"] <= figures["us_median"] <= figures["us_p75"], f"{name}: times {figures}")
            expect(figures["rmse_p5"] <= figures["rmse_median"] <= figures["rmse_p95"] <= figures["rmse_worst"], f"{name}: errors {figures}")
    expect(0 < result["hard_functions"] <= 7, f"{result['hard_functions']} hard functions")
    expect(result["functions"] == 7 and result["scenes"] == ["house_1", "house_2"], f"{result['functions']} of {result['scenes']}")
    count = {"generator": 1, "corrected": 5, "lm_from_generator": 2, "adam_from_generator": 1, "lm_from_theta0": 1, "adam_from_theta0": 1,
             "lm_from_random": 1, "adam_from_random": 1, "coefficients": 2, "precision": 2, "theta_precision": 2, "threads": 2}
    for family, wanted in count.items():
        for name in ["tent_mlp", "pf3", "pf5"]:
            found = [p["budget"] for p in points if (p["representation"], p["family"]) == (name, family)]
            expect(len(found) == wanted, f"{name}, {family}: budgets {found}")
    choices = [point["representation"] for point in points if point["family"] == "choice"]
    expect(choices == ["pf3+pf5"], f"choices: {choices}")
    tent = result["bare_tent"]
    expect(set(tent) == keys["bare_tent"] and set(tent["by_scene"]) == set(result["scenes"]), f"bare tent: {tent}")
    check_front([p for p in points if p["on_front"]], [p["rmse_median"] for p in points], tent["rmse_median"], result["front_sentence"])
    hard_members = [point for point in points if point["hard"]["on_front"]]
    check_front(hard_members, [p["hard"]["rmse_median"] for p in points], tent["hard"]["rmse_median"], result["hard_front_sentence"])
    expect(" over hard functions" in result["hard_front_sentence"], result["hard_front_sentence"])
    expect(not any(p["on_front"] or p["hard"]["on_front"] for p in points if p["family"] == "threads"), "a point of several threads is on a front")
    expect(result["hierarchy"] == [{"step": "solved", "representation": None, "scenes": 2, "rmse_mean": 2, "function_rmse": None}],
           f"hierarchy: {result['hierarchy']}")
    expect(result["walks"] == [{"functions": "solved", "representation": None, "scenes": 2, "light_jump_worst": 3}], f"walks: {result['walks']}")
    rows = list(csv.DictReader(open("out/frontier.csv")))
    expect([row["label"] for row in rows] == [point["label"] for point in points], "frontier.csv has other rows than frontier.json")
    for row, point in zip(rows, points):
        expect(math.isclose(float(row["hard_rmse_p95"]), point["hard"]["rmse_p95"], rel_tol=1e-5), f"{row['label']}: {row}")
        for key in ["us_median", "rmse_median", "leak_p99"]:
            expect(math.isclose(float(row[key]), point[key], rel_tol=1e-5), f"{row['label']}: {key} is {row[key]} and {point[key]}")


def refuses(code, names, *arguments):
    result = run("nlg-validate", "frontier", *arguments)
    lines = result.stderr.splitlines()
    expect(result.returncode == code, f"{arguments}: exit code {result.returncode}, expected {code}: {result.stderr}")
    expect(len(lines) == 1 and lines[0].startswith("nlg-validate frontier: error: "), f"{arguments}: {lines}")
    for name in names:
        expect(name in result.stderr, f"{arguments}: stderr does not name '{name}': {result.stderr}")
    expect(not os.path.exists("bad"), f"{arguments}: left an output behind")


def check_bad_input():
    open("broken.safetensors", "w").write("x")
    open("other.json", "w").write("{}")

    def replaced(old, new):
        return [new if argument == old else argument for argument in GOOD] + ["--out", "bad"]

    refuses(USAGE_ERROR, ["--weights"], "--held-out", "one.h5", "--out", "bad")
    refuses(USAGE_ERROR, ["--held-out"], "--weights", "tent_mlp.safetensors", "--out", "bad")
    refuses(USAGE_ERROR, ["--coefficients", "25", "26"], *replaced("5,25", "5,26"))
    refuses(USAGE_ERROR, ["--coefficients"], *replaced("5,25", "5,4"))
    refuses(USAGE_ERROR, ["--lm-steps", "'0'"], *replaced("1,2", "0,2"))
    refuses(USAGE_ERROR, ["--functions"], *replaced("7", "0"))
    refuses(INPUT_ERROR, ["missing.safetensors"], *replaced("pf3.safetensors", "missing.safetensors"))
    refuses(INPUT_ERROR, ["broken.safetensors"], *replaced("pf3.safetensors", "broken.safetensors"))
    refuses(INPUT_ERROR, ["missing.h5"], *replaced("two.h5", "missing.h5"))
    refuses(INPUT_ERROR, ["training.h5", "--held-out"], "--weights", "pf3.safetensors", "--held-out", "training.h5", *TINY, "--out", "bad")
    refuses(INPUT_ERROR, ["narrow.h5"], *replaced("two.h5", "narrow.h5"))
    refuses(INPUT_ERROR, ["other.json"], *GOOD, "--hierarchy", "other.json", "--out", "bad")
    refuses(INPUT_ERROR, ["missing.json"], *GOOD, "--hierarchy", "missing.json", "--out", "bad")
    refuses(OUTPUT_ERROR, ["other.json/"], *GOOD, "--out", "other.json")


def main():
    with tempfile.TemporaryDirectory() as folder:
        os.chdir(folder)
        for name, seed, flags in [("one", 1, ["--held-out"]), ("two", 2, ["--held-out"]), ("training", 3, [])]:
            must(os.path.join(BIN, "nlg-datagen"), "--scene", f"house:{seed}", "--max-functions", "8", "--test-points", "64", *flags,
                 "--out", f"{name}.h5")
        for name in ["tent_mlp", "pf3", "pf5"]:
            must(MAKE_WEIGHTS, f"{name}.safetensors", name)
        must(MAKE_NARROW_SHARD, "narrow.h5")
        for scene, rmse in [("room", 1), ("hall", 3)]:
            step = {"scene": scene, "step": "solved", "representation": None, "rmse_mean": rmse, "function_rmse": None}
            walk = {"scene": scene, "functions": "solved", "representation": None, "light_jump_worst": rmse}
            json.dump({"schema_version": 1, "hierarchy": [step], "walks": [walk]}, open(f"{scene}.hierarchy.json", "w"))
        check_result()
        check_bad_input()
        os.chdir("/")
    for failure in failures:
        print("FAILED:", failure)
    return 1 if failures else 0


if __name__ == "__main__":
    sys.exit(main())

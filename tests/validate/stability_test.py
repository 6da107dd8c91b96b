#!/usr/bin/python3
"""nlg-validate stability in its short form: every case holds, and the table keeps its contract (docs/reference/formats.md).

    stability_test.py BIN_FOLDER WEIGHTS_FOLDER
"""
import json
import math
import os
import sys

sys.dont_write_bytecode = True
sys.path.append(os.path.join(os.path.dirname(os.path.abspath(__file__)), ".."))
from tools import INPUT_ERROR, SECONDS, USAGE_ERROR, Tools, run_checks

TOOLS, WEIGHTS = Tools(sys.argv[1]), os.path.abspath(sys.argv[2])
check = TOOLS.check
GROUPS = ["functions", "codes", "generator"]


def stability(*arguments):
    return TOOLS.run(["nlg-validate", "stability", *arguments], timeout=10 * SECONDS)


def table(path):
    with open(path) as file:
        return json.load(file)


def check_short_form(_):
    weights = [os.path.join(WEIGHTS, f"{name}.safetensors") for name in ["tent_mlp4", "pf5", "code64"]]
    result = stability("--short", "--weights", *weights, "--out", "stability.json")
    check(result.returncode == 0, f"the short form ended with {result.returncode}: {result.stderr}")
    whole = table("stability.json")
    check(whole["schema_version"] == 1 and whole["provenance"]["tool"] == "nlg-validate stability", "schema or provenance")
    cases = whole["cases"]
    check(list(dict.fromkeys(case["group"] for case in cases)) == GROUPS, "groups are missing or out of order")
    check(len({(case["group"], case["name"]) for case in cases}) == len(cases), "two cases of one name")
    for case in cases:
        name = f"{case['group']}: {case['name']}"
        check(case["holds"], f"{name}: {case['measured']}")
        check(case["figures"] and all(math.isfinite(value) for value in case["figures"].values()), f"{name}: figures {case['figures']}")
    # what no representation of this size can hold holds its bound and has the other colour; what it can hold has not
    fails_check = {case["name"]: case["fails_check"] for case in cases if case["group"] == "functions"}
    check(fails_check["checkerboard"], "a checkerboard passes the bake's check")
    check(not fails_check["free space"] and not fails_check["wall along an axis"], "a tent, or a wall, fails the bake's check")


def check_refusals(tools):
    for code, arguments in [(USAGE_ERROR, "--only codes"), (USAGE_ERROR, f"--weights {WEIGHTS}/pf3.safetensors --only nothing"),
                            (USAGE_ERROR, f"--weights {WEIGHTS}/pf3.safetensors --only codes"), (INPUT_ERROR, "--weights nowhere")]:
        tools.refuses(code, [], f"nlg-validate stability {arguments} --out x.json")


if __name__ == "__main__":
    sys.exit(run_checks(TOOLS, (check_short_form, check_refusals)))

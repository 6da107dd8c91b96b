#!/usr/bin/python3
"""nlg-validate light on a corner of a house: its result keeps the contract of docs/reference/formats.md.

    light_test.py BIN_FOLDER WEIGHTS_FOLDER
"""
import copy
import json
import os
import subprocess
import sys
import tempfile
import unittest

sys.dont_write_bytecode = True
sys.path.append(os.path.join(os.path.dirname(os.path.abspath(__file__)), ".."))
from tools import INPUT_ERROR, USAGE_ERROR

BIN, WEIGHTS = os.path.abspath(sys.argv[1]), os.path.abspath(sys.argv[2])
HOUSE = ["house:1", "--light-error", "0.001", "--extent-m", "0,0,0,5,5,3", "--air-samples", "100", "--surface-samples", "80", "--walks", "3", "--truth-rays", "64", "--probe-rays", "64"]


def light(*arguments):
    return subprocess.run([os.path.join(BIN, "nlg-validate"), "light", *arguments], capture_output=True, text=True)


def weights(*lists):
    return ["--weights", *(",".join(os.path.join(WEIGHTS, name + ".safetensors") for name in names.split()) for names in lists)]


def without_times(result):
    for spacing in result["spacings"]:
        for method in spacing["methods"]:
            method.pop("times")
    result["floor"].pop("times")
    return result


class Light(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.folder = tempfile.TemporaryDirectory()
        cls.out = os.path.join(cls.folder.name, "house.json")
        run = light(*HOUSE, *weights("tent_mlp4", "pf3 pf5"), "--spacings", "1.5", "3", "--threads", "1", "--out", cls.out)
        assert run.returncode == 0, run.stderr
        with open(cls.out) as file:
            cls.result = json.load(file)

    @classmethod
    def tearDownClass(cls):
        cls.folder.cleanup()

    def methods(self):
        return [method for spacing in self.result["spacings"] for method in spacing["methods"]]

    def test_grids_are_the_same_without_baselines_and_beside_thinned_ones(self):
        out = os.path.join(self.folder.name, "thinned.json")
        run = light(*HOUSE, *weights("tent_mlp4", "pf3 pf5"), "--spacings", "1.5", "--grid-spacings", "3", "--thin-errors", ".02", ".2", "--out", out)
        self.assertEqual(run.returncode, 0, run.stderr)
        with open(out) as file:
            result = json.load(file)
        self.assertEqual(result["provenance"]["options"]["thin_errors"], [.02, .2])
        fine, coarse = without_times(result)["spacings"]
        both, alone = without_times(copy.deepcopy(self.result))["spacings"]
        is_thinned = lambda method: ", thinned" in method["weights"]
        self.assertEqual([method for method in fine["methods"] if not is_thinned(method)], both["methods"])
        grids = ("tent_mlp4", "pf3 or pf5")
        self.assertEqual([method for method in coarse["methods"] if not is_thinned(method)], [method for method in alone["methods"] if method["weights"] in grids])
        for methods in (fine["methods"], coarse["methods"]):
            size = {(method["weights"], method["light"]): method["bytes"]["total"] for method in methods}
            self.assertEqual([name for name in size if ", thinned" in name[0]], [(f"{name}, thinned {error}", "solved") for name in grids for error in (.02, .2)])
            for name in grids:
                self.assertLess(size[f"{name}, thinned 0.2", "solved"], size[f"{name}, thinned 0.02", "solved"])
                self.assertLess(size[f"{name}, thinned 0.02", "solved"], size[name, "solved"])

    def test_figures_are_shares_and_bytes_add_up(self):
        for method in self.methods():
            for group in ("air", "surface", "turned"):
                self.assertEqual(method[group]["balanced"]["rooms"] > 0, method[group]["balanced"]["rmse"] > 0.0)
                for figures in [method[group], *method[group].get("by_distance", [])]:
                    self.assertGreaterEqual(figures["rmse"], 0.0)
                self.assertGreaterEqual(method[group]["energy"], 0.0)
                for key in ("smape", "unlit", "outside"):
                    self.assertTrue(0.0 <= method[group][key] <= 1.0 + 1e-9, f"{method['weights']}: {method[group]}")
            size = method["bytes"]
            self.assertEqual(size["light"] + size["weights"] + size["tree"], size["total"])
            self.assertEqual(len(method["worst"]), 10)
            errors = [worst["error"] for worst in method["worst"]]
            self.assertEqual(errors, sorted(errors, reverse=True))

    def test_has_holes_and_leaks_of_every_grid(self):
        for spacing in self.result["spacings"]:
            self.assertEqual([found["weights"] for found in spacing["blends"]], ["tent_mlp4", "pf3 or pf5"])
            for found in spacing["blends"]:
                self.assertEqual([(some["from_m"], some["to_m"]) for some in found["surface"]], [(0, .02), (.02, .08), (.08, .2)])
                for some in (found["air"], *found["surface"]):
                    self.assertGreater(some["points"], 100)
                    self.assertTrue(all(0 <= some[key] <= 1 for key in ("holes", "leaks")), some)
                    self.assertTrue(0 < some["total_variation"] < 1, some)
            first, second = spacing["blends"]
            self.assertEqual([some["points"] for some in first["surface"]], [some["points"] for some in second["surface"]])

    def test_threads_change_nothing_but_times(self):
        again = os.path.join(self.folder.name, "again.json")
        run = light(*HOUSE, *weights("tent_mlp4", "pf3 pf5"), "--spacings", "1.5", "3", "--threads", "3", "--out", again)
        self.assertEqual(run.returncode, 0, run.stderr)
        with open(self.out) as one, open(again) as other:
            self.assertEqual(without_times(json.load(one)), without_times(json.load(other)))

    def test_what_learns_says_what_it_cost_and_threads_change_nothing_of_it(self):
        results = []
        for threads in ("1", "2"):
            out = os.path.join(self.folder.name, f"learned_{threads}.json")
            run = light(*HOUSE, "--spacings", "3", "1.5", "--grids-only", "--neural", "--neural-samples", "2", "--neural-steps", "5", "--threads", threads, "--out", out)
            self.assertEqual(run.returncode, 0, run.stderr)
            with open(out) as file:
                results.append(json.load(file))
        coarse, fine = results[0]["spacings"]
        self.assertEqual([method["weights"] for method in coarse["methods"]], ["target functions"] * 2, "learned at the finest spacing alone")
        learned = {method["weights"]: method for method in fine["methods"] if "learned" in method}
        names = [*(f"neural volume, 2^{size}" for size in (10, 12, 13, 14, 15, 17)), *(f"network grid, {width}" for width in (8, 16, 32))]
        self.assertEqual([name for name in learned if not name.startswith("SH octree")], names)
        self.assertGreater(len(learned), len(names), "no octree")
        for name, method in learned.items():
            size, cost = method["bytes"], method["learned"]
            self.assertEqual(size["light"] + size["weights"] + size["tree"], size["total"], name)
            self.assertGreater(cost["multiply_adds"], 0, name)
            if name in names:
                self.assertEqual(2 * cost["parameters"], size["light"] + size["weights"], name)
                self.assertEqual(cost["steps"], 5, name)
                self.assertGreater(method["times"]["training_s"], 0.0, name)
            else:
                self.assertLessEqual(size["total"], 1.5 * 1024 * int(name.split()[2]), name)
        self.assertEqual(*(without_times(result)["spacings"] for result in results))

    def test_draws_the_worst_places_of_the_grid_at_the_finest_spacing(self):
        result = os.path.join(self.folder.name, "drawn.json")
        run = light(*HOUSE, *weights("pf3 pf5"), "--spacings", "3", "1.5", "--pictures", os.path.join(self.folder.name, "places", "drawn"), "--picture-rays", "8", "--out", result)
        self.assertEqual(run.returncode, 0, run.stderr)
        with open(result) as file:
            spacings = json.load(file)["spacings"]
        named = {(spacing["spacing_m"], method["weights"], method["light"]): [worst["picture"] for worst in method["worst"] if "picture" in worst]
                 for spacing in spacings for method in spacing["methods"]}
        pictures = named.pop((1.5, "pf3 or pf5", "solved"))
        self.assertEqual(pictures, [f"places/drawn/house_1_pf3-or-pf5_{rank:02}.png" for rank in range(1, 11)])
        self.assertFalse(any(named.values()), "pictures of other methods or spacings")

    def test_refuses_what_cannot_be_measured(self):
        self.assertEqual(light(*HOUSE).returncode, USAGE_ERROR)
        self.assertEqual(light(*HOUSE, "--spacings", "0", "--out", self.out).returncode, USAGE_ERROR)
        self.assertEqual(light(*HOUSE, *weights("pf3 pf3"), "--out", self.out).returncode, USAGE_ERROR)
        self.assertEqual(light(*HOUSE, *weights("none"), "--out", self.out).returncode, INPUT_ERROR)


if __name__ == "__main__":
    unittest.main(argv=sys.argv[:1])

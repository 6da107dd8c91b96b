#!/usr/bin/python3
"""nlg-validate light on a corner of a house: its result keeps the contract of docs/reference/formats.md.

    light_test.py BIN_FOLDER WEIGHTS_FOLDER
"""
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
SETS, GRIDS = ("tent_mlp4", "pf3 pf5"), ("tent_mlp4", "pf3 or pf5")
LEARNED = ["--neural", "--neural-samples", "2", "--neural-steps", "5"]


def light(*arguments):
    return subprocess.run([os.path.join(BIN, "nlg-validate"), "light", *arguments], capture_output=True, text=True)


def weights(*lists):
    return ["--weights", *(",".join(os.path.join(WEIGHTS, name + ".safetensors") for name in names.split()) for names in lists)]


def measured(*arguments, out):
    """What it writes, without its times."""
    run = light(*HOUSE, *arguments, "--out", out)
    assert run.returncode == 0, run.stderr
    with open(out) as file:
        result = json.load(file)
    training_s = [method["times"].pop("training_s") for spacing in result["spacings"] for method in spacing["methods"] if "training_s" in method["times"]]
    assert all(seconds > 0 for seconds in training_s), training_s
    for part in [result["floor"], *(method for spacing in result["spacings"] for method in spacing["methods"])]:
        del part["times"]
    return result


def named(methods):
    return [(method["weights"], method["light"]) for method in methods]


class Light(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.folder = tempfile.TemporaryDirectory()
        cls.out = os.path.join(cls.folder.name, "house.json")
        cls.result = measured(*weights(*SETS), "--spacings", "3", "1.5", *LEARNED, "--threads", "1", out=cls.out)

    @classmethod
    def tearDownClass(cls):
        cls.folder.cleanup()

    def methods(self):
        return [method for spacing in self.result["spacings"] for method in spacing["methods"]]

    def test_threads_pictures_thinned_grids_and_spacings_without_baselines_change_no_figure(self):
        more = ["--grid-spacings", "3", "--thin-errors", ".02", ".2", "--pictures", os.path.join(self.folder.name, "places", "drawn"), "--picture-rays", "8", "--threads", "3"]
        result = measured(*weights(*SETS), "--spacings", "1.5", *LEARNED, *more, out=os.path.join(self.folder.name, "thinned.json"))
        self.assertEqual(result["provenance"]["options"]["thin_errors"], [.02, .2])
        # the worst places of both grids, at the finest spacing alone
        pictures = {(spacing["spacing_m"], *name): [worst.pop("picture") for worst in method["worst"] if "picture" in worst]
                    for spacing in result["spacings"] for name, method in zip(named(spacing["methods"]), spacing["methods"])}
        drawn = {name: paths for name, paths in pictures.items() if paths}
        self.assertEqual(drawn, {(1.5, name, "solved"): [f"places/drawn/house_1_{name.replace(' ', '-')}_{rank:02}.png" for rank in range(1, 11)] for name in GRIDS})
        self.assertTrue(all(os.path.getsize(os.path.join(self.folder.name, path)) > 0 for paths in drawn.values() for path in paths))
        (fine, coarse), (coarse_before, fine_before) = result["spacings"], self.result["spacings"]
        for spacing, before, kept in ((fine, fine_before, None), (coarse, coarse_before, GRIDS)):
            thinned = [method for method in spacing["methods"] if ", thinned" in method["weights"]]
            size = {(method["weights"], method["light"]): method["bytes"]["total"] for method in spacing["methods"]}
            self.assertEqual(named(thinned), [(f"{name}, thinned {error}", "solved") for name in GRIDS for error in (.02, .2)])
            for name in GRIDS:
                self.assertLess(size[f"{name}, thinned 0.2", "solved"], size[f"{name}, thinned 0.02", "solved"])
                self.assertLess(size[f"{name}, thinned 0.02", "solved"], size[name, "solved"])
            wanted = [method for method in before["methods"] if kept is None or method["weights"] in kept]
            self.assertEqual({**spacing, "methods": [method for method in spacing["methods"] if method not in thinned]}, {**before, "methods": wanted})
        for part in ("truth", "floor"):
            self.assertEqual(result[part], self.result[part])

    def test_grids_only_leaves_out_the_baselines(self):
        result = measured("--spacings", "3", "--grids-only", out=os.path.join(self.folder.name, "grids.json"))
        methods = result["spacings"][0]["methods"]
        self.assertEqual([method["weights"] for method in methods], ["target functions"] * 2)

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
            self.assertEqual([found["weights"] for found in spacing["blends"]], list(GRIDS))
            for found in spacing["blends"]:
                self.assertEqual([(some["from_m"], some["to_m"]) for some in found["surface"]], [(0, .02), (.02, .08), (.08, .2)])
                for some in (found["air"], *found["surface"]):
                    self.assertGreater(some["points"], 100)
                    self.assertTrue(all(0 <= some[key] <= 1 for key in ("holes", "leaks")), some)
                    self.assertTrue(0 < some["total_variation"] < 1, some)
            first, second = spacing["blends"]
            self.assertEqual([some["points"] for some in first["surface"]], [some["points"] for some in second["surface"]])

    def test_what_learns_says_what_it_cost_at_the_finest_spacing_alone(self):
        coarse, fine = self.result["spacings"]
        self.assertFalse([method for method in coarse["methods"] if "learned" in method])
        learned = {method["weights"]: method for method in fine["methods"] if "learned" in method}
        names = [*(f"neural volume, 2^{size}" for size in (10, 12, 13, 14, 15, 17)), *(f"network grid, {width}" for width in (8, 16, 32))]
        self.assertEqual([name for name in learned if not name.startswith("SH octree")], names)
        self.assertGreater(len(learned), len(names), "no octree")
        for name, method in learned.items():
            size, cost = method["bytes"], method["learned"]
            self.assertGreater(cost["multiply_adds"], 0, name)
            if name in names:
                self.assertEqual(2 * cost["parameters"], size["light"] + size["weights"], name)
                self.assertEqual(cost["steps"], 5, name)
            else:
                self.assertLessEqual(size["total"], 1.5 * 1024 * int(name.split()[2]), name)

    def test_refuses_what_cannot_be_measured(self):
        self.assertEqual(light(*HOUSE).returncode, USAGE_ERROR)
        self.assertEqual(light(*HOUSE, "--spacings", "0", "--out", self.out).returncode, USAGE_ERROR)
        self.assertEqual(light(*HOUSE, *weights("pf3 pf3"), "--out", self.out).returncode, USAGE_ERROR)
        self.assertEqual(light(*HOUSE, *weights("none"), "--out", self.out).returncode, INPUT_ERROR)


if __name__ == "__main__":
    unittest.main(argv=sys.argv[:1])

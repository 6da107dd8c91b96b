#!/usr/bin/python3
"""nlg-validate views on a corner of a house: its result keeps the contract of docs/reference/formats.md.

    views_test.py BIN_FOLDER WEIGHTS_FOLDER
"""
import json
import os
import subprocess
import sys
import tempfile
import unittest

import matplotlib.image

sys.dont_write_bytecode = True
sys.path.append(os.path.join(os.path.dirname(os.path.abspath(__file__)), ".."))
from tools import INPUT_ERROR, OUTPUT_ERROR, USAGE_ERROR, read

BIN, WEIGHTS = os.path.abspath(sys.argv[1]), os.path.abspath(sys.argv[2])
WIDTH, HEIGHT = 48, 27
HOUSE = ["house:1", "--extent-m", "0,0,0,5,5,3", "--weights", os.path.join(WEIGHTS, "tent_mlp4.safetensors"), "--most-views", "2",
         "--width", str(WIDTH), "--height", str(HEIGHT), "--truth-rays", "16", "--probe-rays", "64", "--target-functions"]
SHARES = ("brighter", "darker")


def views(*arguments):
    return subprocess.run([os.path.join(BIN, "nlg-validate"), "views", *arguments], capture_output=True, text=True)


class Views(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.folder = tempfile.TemporaryDirectory()
        cls.out = cls.path("house.json")
        cls.run_ = views(*HOUSE, "--spacing-m", "2", "--threads", "1", "--pictures", cls.path("pictures"), "--truth", cls.path("truth"), "--out", cls.out)
        assert cls.run_.returncode == 0, cls.run_.stderr
        with open(cls.out) as file:
            cls.result = json.load(file)

    @classmethod
    def tearDownClass(cls):
        cls.folder.cleanup()

    @classmethod
    def path(cls, name):
        return os.path.join(cls.folder.name, name)

    def test_has_figures_of_every_class_that_is_seen(self):
        for method in self.result["methods"]:
            self.assertIn("edge", method)
            for of_class in method.keys() - {"weights", "light"}:
                figures = method[of_class]
                self.assertGreater(figures["receivers"], 0)
                for share in [*(figures["off_2"][way] for way in SHARES), figures["below_eighth"], figures["ringing"]]:
                    self.assertTrue(0 <= share <= 1, figures)
                self.assertLessEqual(figures["below_eighth"], figures["off_2"]["darker"])
                self.assertGreaterEqual(figures["energy"], 0)
            parts = [view_method["all"] for view in self.result["views"] for view_method in view["methods"] if view_method["weights"] == method["weights"]]
            self.assertAlmostEqual(method["all"]["hyab"], sum(part["hyab"] for part in parts) / len(parts), places=9)

    def test_draws_truth_and_methods_of_every_view(self):
        for view in self.result["views"]:
            image = matplotlib.image.imread(self.path(view["picture"]))
            # truth, exact visibility, the grid, target functions, DDGI at four times their size
            self.assertGreaterEqual(image.shape[1], 5 * 4 * WIDTH)
        sheet = matplotlib.image.imread(self.path(self.result["sheet"]))
        self.assertGreaterEqual(sheet.shape[0], len(self.result["views"]) * HEIGHT)

    def test_gives_the_same_bytes_on_any_number_of_threads_from_truth_that_was_kept(self):
        again = self.path("again.json")
        run = views(*HOUSE, "--spacing-m", "2", "--threads", "3", "--pictures", self.path("pictures"), "--truth", self.path("truth"), "--out", again)
        self.assertEqual(run.returncode, 0, run.stderr)
        with open(self.out) as a, open(again) as b:
            self.assertEqual(a.read(), b.read())
        self.assertNotIn("traced anew", run.stderr)

    def test_looks_from_the_same_places_at_the_same_truth_at_any_spacing(self):
        coarse = self.path("coarse.json")
        run = views(*HOUSE, "--spacing-m", "3", "--grids-only", "--threads", "3", "--truth", self.path("another"), "--out", coarse)
        self.assertEqual(run.returncode, 0, run.stderr)
        kept = {name: read(self.path(os.path.join("truth", name))) for name in os.listdir(self.path("truth"))}
        self.assertEqual(kept, {name: read(self.path(os.path.join("another", name))) for name in os.listdir(self.path("another"))})
        with open(coarse) as file:
            result = json.load(file)
        self.assertEqual([view["eye_m"] for view in result["views"]], [view["eye_m"] for view in self.result["views"]])
        self.assertEqual([method["weights"] for method in result["methods"]], ["tent_mlp4", "target functions", "exact visibility"])
        self.assertNotIn("sheet", result)

    def test_looks_from_the_scenes_own_cameras_and_at_grids_of_files(self):
        out, grid = self.path("rooms.json"), self.path("before.safetensors")
        bake = subprocess.run([os.path.join(BIN, "nlg-bake"), "two_rooms:1", "--weights", os.path.join(WEIGHTS, "tent_mlp4.safetensors"), "--spacing-m", "2", "--out", grid], capture_output=True, text=True)
        self.assertEqual(bake.returncode, 0, bake.stderr)
        size = ["--width", str(WIDTH), "--height", str(HEIGHT), "--truth-rays", "16", "--spacing-m", "2"]
        run = views("two_rooms:1", "--cameras", "--grid", grid, "--grids-only", *size, "--out", out)
        self.assertEqual(run.returncode, 0, run.stderr)
        with open(out) as file:
            result = json.load(file)
        self.assertEqual([[round(x, 4) for x in view["eye_m"]] for view in result["views"]], [[-0.4, 1.6, -1.7], [3.75, 1.6, -1.7]])
        self.assertEqual([method["weights"] for method in result["methods"]], ["before", "exact visibility"])
        self.assertEqual(views("house:1", "--cameras", *size, "--out", out).returncode, INPUT_ERROR)

    def test_pictures_that_others_drew_stay(self):
        folder = self.path("others")
        os.mkdir(folder)
        for name in os.listdir(self.path("pictures")):
            with open(os.path.join(folder, name), "w") as file:
                file.write("mine")
        run = views(*HOUSE, "--spacing-m", "2", "--pictures", folder, "--truth", self.path("truth"), "--out", self.path("others.json"))
        self.assertEqual(run.returncode, USAGE_ERROR, run.stderr)
        for name in os.listdir(folder):
            with open(os.path.join(folder, name)) as file:
                self.assertEqual(file.read(), "mine")

    def test_refuses_what_cannot_be_measured(self):
        self.assertEqual(views(*HOUSE).returncode, USAGE_ERROR)
        self.assertEqual(views(*HOUSE, "--light", "none", "--out", self.path("dark.json")).returncode, USAGE_ERROR)
        self.assertEqual(views("none.glb", "--out", self.path("none.json")).returncode, INPUT_ERROR)
        self.assertEqual(views(*HOUSE, "--pictures", self.out, "--out", self.path("none.json")).returncode, OUTPUT_ERROR)
        self.assertFalse(os.path.exists(self.path("none.json")))


if __name__ == "__main__":
    unittest.main(argv=sys.argv[:1])

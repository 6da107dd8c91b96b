#!/usr/bin/python3
"""nlg-validate look-up on a corner of a house: its result keeps the contract of docs/reference/formats.md.

    look_up_test.py BIN_FOLDER WEIGHTS_FOLDER
"""
import json
import os
import subprocess
import sys
import tempfile
import unittest

BIN, WEIGHTS = os.path.abspath(sys.argv[1]), os.path.abspath(sys.argv[2])
USAGE_ERROR, INPUT_ERROR = 2, 3  # tool/error.h
HOUSE = ["house:1", "--extent-m", "0,0,0,6,6,3", "--spacing-m", "1.5", "--places", "400"]


def look_up(*arguments):
    return subprocess.run([os.path.join(BIN, "nlg-validate"), "look-up", *arguments], capture_output=True, text=True)


def weights(*names):
    return ["--weights", *(os.path.join(WEIGHTS, name + ".safetensors") for name in names)]


class LookUp(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.folder = tempfile.TemporaryDirectory()
        cls.out = os.path.join(cls.folder.name, "house.json")
        run = look_up(*HOUSE, *weights("pf3", "tent_mlp4"), "--specks", "20000", "--threads", "1", "--out", cls.out)
        assert run.returncode == 0, run.stderr
        with open(cls.out) as file:
            cls.result = json.load(file)

    @classmethod
    def tearDownClass(cls):
        cls.folder.cleanup()

    def figures(self):
        blends = {"target": self.result["target"], "tent": self.result["tent"], **self.result["representations"]}
        return [(name, f) for name, blend in blends.items() for f in [blend["all"], *blend["by_distance"]]]

    def test_says_where_it_comes_from(self):
        self.assertEqual(self.result["schema_version"], 1)
        self.assertEqual(self.result["scene"], "house_1")
        self.assertEqual(set(self.result["provenance"]["inputs"]), {"weights of pf3", "weights of tent_mlp4"})
        self.assertEqual(list(self.result["representations"]), ["tent_mlp4", "pf3"], "by rising number of parameters")

    def test_shares_of_the_air_add_up(self):
        places = self.result["places"]
        self.assertAlmostEqual(sum(by["air_share"] for by in places["by_distance"]), 1.0)
        self.assertAlmostEqual(places["in_solid"] + places["disputed"] + places["in_air"], 1.0)
        self.assertEqual(sum(by["places"] for by in places["by_distance"]), self.result["tent"]["all"]["places"])

    def test_specks_are_searched_in_places_enough_and_listed(self):
        for found in self.result["representations"].values():
            specks = found["specks"]
            self.assertGreaterEqual(specks["looked_up"], 19000)  # 20,000 in air, give or take four standard deviations of the air's share
            self.assertEqual(len(specks["first"]), min(10, specks["count"]))
            for speck in specks["first"]:
                self.assertLess(speck["share"], 0.05)

    def test_figures_are_shares(self):
        for name, f in self.figures():
            for value in (f["unlit"], f["rmse"], f["wrong"]["mean"], f["wrong"]["p99"], f["wrong_to_seen"], f["leak"]["mean"], f["leak"]["p99"]):
                self.assertTrue(0.0 <= value <= 1.0 + 8 * 2.0**-24, f"{name}: {f}")

    def test_target_is_nothing_wrong_and_functions_beat_bare_tents(self):
        self.assertEqual(self.result["target"]["all"]["wrong"], {"mean": 0.0, "p99": 0.0})
        for blend in self.result["representations"].values():
            self.assertLess(blend["all"]["wrong"]["mean"], self.result["tent"]["all"]["wrong"]["mean"])

    def test_no_weight_jumps_although_a_field_does_not_end_with_its_support(self):
        self.assertEqual(self.result["representations"]["tent_mlp4"]["border"]["largest"], 0.0)
        self.assertGreater(self.result["representations"]["pf3"]["border"]["largest"], 0.01)
        for blend in self.result["representations"].values():
            self.assertGreater(blend["jumps"]["segments"], 100)
            self.assertLess(blend["jumps"]["p99"], 1e-4)

    def test_threads_change_no_byte(self):
        again = os.path.join(self.folder.name, "again.json")
        run = look_up(*HOUSE, *weights("pf3", "tent_mlp4"), "--specks", "20000", "--threads", "3", "--out", again)
        self.assertEqual(run.returncode, 0, run.stderr)
        with open(self.out, "rb") as one, open(again, "rb") as other:
            self.assertEqual(one.read(), other.read())

    def test_refuses_what_cannot_be_measured(self):
        self.assertEqual(look_up(*HOUSE, "--out", self.out).returncode, USAGE_ERROR)
        self.assertEqual(look_up(*HOUSE, *weights("pf3", "pf3"), "--out", self.out).returncode, USAGE_ERROR)
        self.assertEqual(look_up(*HOUSE, *weights("none"), "--out", self.out).returncode, INPUT_ERROR)


if __name__ == "__main__":
    unittest.main(argv=sys.argv[:1])

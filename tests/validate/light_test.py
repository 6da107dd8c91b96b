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

BIN, WEIGHTS = os.path.abspath(sys.argv[1]), os.path.abspath(sys.argv[2])
USAGE_ERROR, INPUT_ERROR = 2, 3  # tool/error.h
HOUSE = ["house:1", "--extent-m", "0,0,0,5,5,3", "--air-places", "100", "--surface-places", "80", "--walks", "3", "--truth-rays", "64", "--probe-rays", "64"]


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

    def test_says_where_it_comes_from(self):
        self.assertEqual(self.result["schema_version"], 1)
        self.assertEqual(self.result["scene"], "house_1")
        self.assertEqual(set(self.result["provenance"]["inputs"]), {"weights of tent_mlp4", "weights of pf3", "weights of pf5"})
        self.assertEqual([spacing["spacing_m"] for spacing in self.result["spacings"]], [1.5, 3])

    def test_has_every_method_with_light_gathered_and_solved(self):
        for spacing in self.result["spacings"]:
            lights = {}
            for method in spacing["methods"]:
                lights.setdefault(method["weights"], []).append(method["light"])
            for name in ("trilinear", "valid trilinear", "exact visibility", "tetrahedra", "APV", "DDGI's weights", "target functions", "tent_mlp4", "pf3 or pf5"):
                self.assertEqual(lights[name], ["point", "solved"], name)
            for name in ("DDGI float", "DDGI as shipped", "DDGI, exact visibility", "DDGI float, relocated", "DDGI as shipped, relocated"):
                self.assertEqual(lights[name], ["own"], name)

    def test_figures_are_shares_and_bytes_add_up(self):
        for method in self.methods():
            for group in ("air", "surface", "turned"):
                for figures in [method[group], *method[group].get("by_distance", [])]:
                    self.assertGreaterEqual(figures["rmse"], 0.0)
                    for value in (figures["smape"], figures["unlit"], figures["outside"], figures["fallback"]):
                        self.assertTrue(0.0 <= value <= 1.0 + 1e-9, f"{method['weights']}: {figures}")
            size = method["bytes"]
            self.assertEqual(size["light"] + size["weights"] + size["tree"], size["total"])
            self.assertEqual(len(method["worst"]), 10)
            errors = [worst["error"] for worst in method["worst"]]
            self.assertEqual(errors, sorted(errors, reverse=True))

    def test_places_are_the_same_at_every_spacing(self):
        fine, coarse = (spacing["methods"][0] for spacing in self.result["spacings"])
        self.assertEqual(fine["air"]["places"], coarse["air"]["places"])
        self.assertEqual(fine["dark"]["truth"], coarse["dark"]["truth"])
        self.assertEqual(fine["jumps"]["steps"], coarse["jumps"]["steps"])

    def test_threads_change_nothing_but_times(self):
        again = os.path.join(self.folder.name, "again.json")
        run = light(*HOUSE, *weights("tent_mlp4", "pf3 pf5"), "--spacings", "1.5", "3", "--threads", "3", "--out", again)
        self.assertEqual(run.returncode, 0, run.stderr)
        with open(self.out) as one, open(again) as other:
            self.assertEqual(without_times(json.load(one)), without_times(json.load(other)))

    def test_refuses_what_cannot_be_measured(self):
        self.assertEqual(light(*HOUSE).returncode, USAGE_ERROR)
        self.assertEqual(light(*HOUSE, "--spacings", "0", "--out", self.out).returncode, USAGE_ERROR)
        self.assertEqual(light(*HOUSE, *weights("pf3 pf3"), "--out", self.out).returncode, USAGE_ERROR)
        self.assertEqual(light(*HOUSE, *weights("none"), "--out", self.out).returncode, INPUT_ERROR)


if __name__ == "__main__":
    unittest.main(argv=sys.argv[:1])

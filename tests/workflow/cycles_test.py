#!/usr/bin/env python3
"""What holds our path tracer against Cycles: its arithmetic, and which results go together. cycles_test.py (from anywhere)."""
import json
import math
import sys
import tempfile
import unittest
from pathlib import Path

sys.dont_write_bytecode = True
SOURCES = Path(__file__).resolve().parents[2]
sys.path[:0] = [str(SOURCES), str(SOURCES / "docs" / "figures"), str(SOURCES / "docs" / "figures" / "cycles")]
import cycles_page
import ratios
from tool.errors import InputError


class Ratios(unittest.TestCase):
    def test_mean_and_its_error_are_those_of_independent_runs(self):
        # the error is the runs' standard deviation over the root of their number
        cases = [([2.0, 2.0], (2.0, 0.0)), ([1.0, 3.0], (2.0, 1.0)), ([0.0, 0.0, 6.0], (2.0, 2.0))]
        for runs, (mean, error) in cases:
            with self.subTest(runs=runs):
                found = ratios.mean_and_error(runs)
                self.assertAlmostEqual(found[0], mean)
                self.assertAlmostEqual(found[1], error)

    def test_the_ratio_is_of_means_and_its_error_of_both_sides_noise(self):
        # ours, our errors, theirs, their errors → ratio, error, difference, noise
        cases = {
            "the same": ([1, 3], [0, 0], [1, 3], [0, 0], 1, 0, 0, 0),
            "a half more, everywhere": ([3, 4.5], [0, 0], [2, 3], [0, 0], 1.5, 0, 0.5, 0),
            "places differ and means do not": ([2, 0], [0, 0], [1, 1], [0, 0], 1, 0, 1, 0),
            "our noise": ([1, 1], [0.3, 0.4], [1, 1], [0, 0], 1, 0.25, 0, 0.5 / math.sqrt(2)),
            "their noise counts as often as the ratio": ([4, 4], [0, 0], [1, 1], [0.3, 0.4], 4, 1, 3, 0.5 / math.sqrt(2)),
            "black": ([0, 0], [0, 0], [1, 1], [0, 0], 0, 0, 1, 0),
        }
        for name, (ours, our_errors, theirs, their_errors, *expected) in cases.items():
            with self.subTest(name):
                found = ratios.over(ours, our_errors, theirs, their_errors)
                for key, value in zip(("ratio", "error", "difference", "noise"), expected, strict=True):
                    self.assertAlmostEqual(found[key], value, msg=key)

    def test_what_is_black_or_of_another_number_of_places_is_refused(self):
        for name, arguments in {"black": ([1], [0], [0], [0]), "places": ([1, 2], [0, 0], [1], [0])}.items():
            with self.subTest(name), self.assertRaises(ValueError):
                ratios.over(*arguments)

    def test_channels_are_kept_apart(self):
        # two runs of one place, each side
        found = ratios.compare([[[2, 3, 0]], [[2, 3, 1]]], [[[1, 1, 1]], [[1, 5, 1]]])
        self.assertEqual([found[name]["ratio"] for name in ("red", "green", "blue")], [2, 1, 0.5])
        for name, error in {"red": 0, "green": 2 / 3, "blue": 0.5}.items():
            self.assertAlmostEqual(found[name]["error"], error, msg=name)


class Page(unittest.TestCase):
    def setUp(self):
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.folder = Path(folder.name)
        for scene in cycles_page.SCENES:
            self.write(scene, 1.01 if scene != "mask" else 0.2112)

    def write(self, scene, ratio, **more):
        channels = {name: {"ours": 1.0, "theirs": 1.0, "ratio": ratio, "error": 0.0023, "difference": 0.0311, "noise": 0.03} for name in cycles_page.CHANNELS}
        result = {"scene": scene, "revision": "0123abc", "blender": "3.4.1", "places": 600, "runs": 4, "samples": 1024, "rays": 4096, "channels": channels, **more}
        (self.folder / f"{scene}.result.json").write_text(json.dumps(result))

    def test_results_of_two_revisions_or_of_too_few_scenes_are_refused(self):
        self.write("sum", 1.0, revision="other")
        with self.assertRaisesRegex(InputError, "one revision in all results, got 0123abc, other"):
            cycles_page.collect(self.folder)
        (self.folder / "sum.result.json").unlink()
        with self.assertRaisesRegex(InputError, "sum.result.json"):
            cycles_page.collect(self.folder)


if __name__ == "__main__":
    unittest.main()

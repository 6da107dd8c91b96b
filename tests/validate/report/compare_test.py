#!/usr/bin/python3
"""What counts as a change between two runs, and what as noise.

    compare_test.py
"""
import json
import math
import os
import subprocess
import sys
import tempfile
import unittest

sys.dont_write_bytecode = True
import made_up

SCRIPT = os.path.join(os.path.dirname(os.path.abspath(__file__)), "..", "..", "..", "validate", "report", "compare.py")
sys.path.insert(0, os.path.dirname(SCRIPT))
import compare
import numpy as np
from inputs import WORDS
from tool.errors import CHECK_FAILED, InputError
from tool.input_file import Node

made_up.FUNCTIONS = 400  # enough for chances to be told from noise
made_up.REPRESENTATIONS = {"mlp": 113}
made_up.SCENES = tuple(f"level{i}" for i in range(12))
TAU, BLEND = made_up.TAU["rmse"], made_up.BLEND
SCENES = made_up.SCENES


def same(function, rmse):
    return rmse


class Comparisons(unittest.TestCase):
    def setUp(self):
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.folder = folder.name

    def write(self, name, changed=same, held_out=made_up.HELD_OUT):
        """A run whose functions that take a θ have an RMSE from .001 to .021 at every stage, but for what `changed` makes of it."""
        table = made_up.samples(1)
        for word in WORDS:
            chance = np.random.default_rng(7)
            for i, row in enumerate(table["mlp", word]):
                rmse = changed(row[0], 0.001 + 0.02 * chance.uniform()) if row[2] else row[4]
                table["mlp", word][i] = (*row[:4], rmse, row[5], rmse > TAU or BLEND * rmse > made_up.TAU["blend"], *row[7:])
        os.makedirs(os.path.join(self.folder, name), exist_ok=True)
        made_up.write_functions(os.path.join(self.folder, name, "functions.csv"), table)
        return made_up.write_json(os.path.join(self.folder, name, "summary.json"), made_up.summary(table, held_out))

    def run_of(self, *arguments, **keywords):
        return compare.read_run(self.write(*arguments, **keywords))

    def change(self, old, new, figure, scene=""):
        return next(some for some in compare.compare(old, new).changes if (some.figure, some.scene) == (figure, scene))

    def only(self, old, word, function, rmse):
        """The same run with another error of one function at one stage."""
        samples = {key: some.only(np.arange(len(some))) for key, some in old.samples.items()}
        samples["mlp", word].blend_rmse = np.where(samples["mlp", word].function == function, BLEND * rmse, samples["mlp", word].blend_rmse)
        return compare.Run(old.path, old.summary, samples)

    def test_finds_nothing_between_a_run_and_itself(self):
        run = self.run_of("old")
        comparison = compare.compare(run, run)
        self.assertTrue(comparison.changes)
        self.assertEqual({some.trend for some in comparison.changes}, {"same", "shown"})

    def test_sees_a_small_change_of_all_functions(self):
        # 3 %: far below what the spread over functions would hide if they were not paired
        old, worse = self.run_of("old"), self.run_of("new", lambda i, rmse: 1.03 * rmse)
        there = self.change(old, worse, "network, mean blend RMSE")
        self.assertEqual(there.trend, "worse")
        self.assertAlmostEqual(there.new / there.old, 1.03, places=3)
        self.assertEqual(self.change(worse, old, "network, mean blend RMSE").trend, "better")

    def test_calls_noise_the_same(self):
        # either run's errors are off by up to 30 %, so that each function's two could as well stand the other way round
        chance = np.random.default_rng(11)
        noise = lambda i, rmse: rmse * (0.7 + 0.6 * chance.uniform())
        self.assertEqual({some.trend for some in compare.compare(self.run_of("old", noise), self.run_of("new", noise)).changes}, {"same", "shown"})

    def test_takes_one_scene_for_what_it_is(self):
        # 1.3 times the error in one level of twelve: over functions alone the mean would be beyond chance
        a_scene = len(made_up.SCENES)
        old, new = self.run_of("old"), self.run_of("new", lambda i, rmse: 1.3 * rmse if i * a_scene < made_up.FUNCTIONS else rmse)
        self.assertEqual(self.change(old, new, "network, mean blend RMSE").trend, "same")
        self.assertEqual([self.change(old, new, "network, mean blend RMSE", scene).trend for scene in SCENES], ["worse"] + ["same"] * 11)

    def test_counts_functions_that_come_to_fail_the_check(self):
        old, worse = self.run_of("old", lambda i, rmse: rmse / 2), self.run_of("new", lambda i, rmse: 0.03 if i % 10 == 0 else rmse / 2)
        there = self.change(old, worse, "network, share that fails the check")
        self.assertEqual((there.old, there.trend), (0.0, "worse"))
        self.assertIn(" rose above it, 0 fell below", there.note)

    def test_judges_no_times(self):
        old, slow = self.run_of("old"), self.run_of("new")
        slow.summary.value["representations"]["mlp"]["network"]["theta"]["us_per_function"] *= 3
        self.assertEqual(self.change(old, slow, "network, µs a function").trend, "shown")

    def test_refuses_other_functions_and_other_thresholds(self):
        old = self.run_of("old")

        def refuses(word, new):
            with self.assertRaises(InputError) as refused:
                compare.compare(old, new)
            self.assertIn(word, str(refused.exception))
        refuses("held_out", self.run_of("other", held_out="f" * 64))
        for place, value in (("tau", made_up.TAU | {"rmse": 0.03}), ("theta_precision", "float32"), ("representations", {"pf3": old.summary.value["representations"]["mlp"]})):
            refuses(place, compare.Run("new", Node("new", "", old.summary.value | {place: value}), old.samples))
        other = self.only(old, "network", 0, 0.0)
        other.samples["mlp", "network"].scene[3] = "elsewhere"
        refuses("functions.csv", other)

    def test_sees_one_function_that_leaps(self):
        old = self.run_of("old")
        stored = old.samples["mlp", "stored"]
        function = int(stored.function[stored.takes_theta][0])
        tail = self.only(old, "stored", function, 0.9)
        worst = self.change(old, tail, "stored, worst blend RMSE")
        self.assertEqual((worst.trend, worst.new), ("worse", BLEND * 0.9))
        self.assertIn(f"function {function} of", worst.note)
        self.assertEqual([self.change(old, tail, "stored, worst blend RMSE", scene).trend for scene in SCENES], ["worse"] + ["same"] * 11)
        self.assertEqual(self.change(old, tail, "network, worst blend RMSE").trend, "same")
        self.assertEqual(self.change(tail, old, "stored, worst blend RMSE").trend, "better")
        # up to the factor, of tau or of its own error, it is not
        self.assertEqual(self.change(old, self.only(old, "stored", function, 0.0479), "stored, worst blend RMSE").trend, "same")

    def test_says_so_by_its_exit_code(self):
        old, worse = self.write("old"), self.write("new", lambda i, rmse: 2 * rmse)
        run = lambda *arguments: subprocess.run([SCRIPT, *arguments], capture_output=True, text=True)
        self.assertEqual(run(old, old).returncode, 0)
        found = run(old, worse)
        self.assertEqual(found.returncode, CHECK_FAILED)
        self.assertRegex(found.stderr, r"^compare.py: error: the new run is worse than the old one beyond noise in .*; the first: mlp: network, mean blend RMSE\n$")
        changes = json.loads(run(old, worse, "--json").stdout)["changes"]
        self.assertEqual({some["trend"] for some in changes if some["figure"] == "stored, mean blend RMSE"}, {"worse"})


class Chances(unittest.TestCase):
    def test_a_mean_follows_student_with_the_number_of_pairs(self):
        # differences 1 and 3, ten of each: mean 2, variance 20/19, standard error sqrt(1/19)
        there = compare.mean_change(np.full(20, 100.0), np.tile([101.0, 103.0], 10))
        self.assertAlmostEqual(there["standard_error"], math.sqrt(1 / 19), places=12)
        # t = 8.7 of 19 degrees of freedom would be 5e-8
        self.assertEqual(there["chance"], 2.0 ** -19)
        # differences -2 and 3, four of each: mean .5, variance 50/7, t = .52915; by Simpson's rule of 7 degrees: .6131
        self.assertAlmostEqual(compare.mean_change(np.full(8, 10.0), np.tile([8.0, 13.0], 4))["chance"], 0.6131, places=4)

    def test_a_mean_over_scenes_follows_student_with_the_number_of_scenes(self):
        # four scenes of five functions, all of a scene alike: that is four numbers, 1 2 3 6, mean 3, variance 14/3, standard error sqrt(7/6)
        scenes = np.repeat(["a", "b", "c", "d"], 5)
        there = compare.mean_change(np.full(20, 10.0), 10.0 + np.repeat([1.0, 2.0, 3.0, 6.0], 5), scenes)
        self.assertAlmostEqual(there["standard_error"], math.sqrt(7 / 6), places=12)
        # t = 2.7775 of 3 degrees: by tables between .05 and .1 (3.182 and 2.353)
        self.assertAlmostEqual(there["chance"], 0.0691, places=3)
        # of two scenes nothing is known of a third: the functions decide
        self.assertLess(compare.mean_change(np.full(10, 10.0), 10.0 + np.repeat([1.0, 2.0], 5), scenes[:10])["chance"], 0.01)

    def test_a_p99_is_the_sign_test_at_the_percentile_of_both_runs(self):
        # 2000 functions from 0 to 1; 60 of the best become the worst: the highest 1 % of 4000 are 40 of these, and none falls
        old = np.arange(2000) / 2000.0
        new = np.where(np.arange(2000) < 60, 2.0 + np.arange(2000), old)
        for a, b in ((old, new), (new, old)):
            self.assertAlmostEqual(compare.p99_change(a, b)["chance"] / 2.0 ** -39, 1.0, places=9)
        # thirty that change places with the worst thirty: as many up as down
        swapped = old.copy()
        swapped[:30], swapped[-30:] = old[-30:], old[:30]
        self.assertEqual(compare.p99_change(old, swapped)["chance"], 1.0)
        # where the ten that may rise above it can be chance, however high they rise
        few = compare.p99_change(old[:499], old[:499] + 9.0)
        self.assertEqual((few["trend"], few.get("chance"), few["new"] > 9.0), ("shown", None, True))

    def test_many_figures_follow_holm(self):
        # .05 / 4 = .0125, .05 / 3 = .0167, .05 / 2 = .025: the third fails, and with it the fourth, though it is below .05
        self.assertEqual(compare.beyond_chance([0.03, 0.01, 0.04, 0.015], 0.05), [False, True, False, True])
        self.assertEqual(compare.beyond_chance([0.0126] * 4, 0.05), [False] * 4)
        self.assertEqual(compare.beyond_chance([0.0125, 0.016, 0.025, 0.05], 0.05), [True] * 4)
        self.assertEqual(compare.beyond_chance([], 0.05), [])


if __name__ == "__main__":
    unittest.main()

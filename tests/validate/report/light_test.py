#!/usr/bin/python3
"""light.py: what it says of scenes whose figures are known."""
import json
import os
import subprocess
import sys
import tempfile
import unittest

TOOL = os.path.join(os.path.dirname(os.path.abspath(__file__)), "../../../validate/report/light.py")
INPUT_ERROR = 3  # tool/error.h


def method(weights, light, rmse, size):
    figures = {"rmse": rmse, "smape": 0.1, "colour": {"mean": 2.0, "p95": 4.0}, "unlit": 0.0, "outside": 0.0, "balanced": {"rooms": 3, "rmse": 2 * rmse}}
    surface = {**figures, "by_distance": [{"from_m": 0.02, "to_m": 0.05, "rmse": rmse}]}
    worst = {"group": "air", "position_m": [0, 1, 2], "normal": [0, 0, 1], "truth": [1, 1, 1], "answer": [1, 2, 1], "error": 0.6}
    return {"weights": weights, "light": light, "air": figures, "surface": surface, "turned": figures, "dark": {"excess": -0.01}, "beside_light": {"excess": 0.02}, "edge": {"excess": 0.3}, "corner": {"excess": 0.4},
            "jumps": {"mean": 0.01, "largest": 0.1}, "bytes": {"total": size, "per_probe": size / 20}, "probes": 20, "worst": [worst],
            "times": {"weights_s": 1.0, "light_s": 0.5}}


def scene(name, reference, ours):
    return {"schema_version": 1, "scene": name, "truth": {"all_bounces_in_one_ray": False},
            "spacings": [{"spacing_m": spacing_m, "methods": [method("valid trilinear", "point", reference * spacing_m, 1000), method("tent_mlp", "solved", ours * spacing_m, 1200)]}
                         for spacing_m in (1.0, 2.0)]}


class LightSummary(unittest.TestCase):
    def setUp(self):
        self.folder = tempfile.TemporaryDirectory()
        self.addCleanup(self.folder.cleanup)

    def run_tool(self, *scenes):
        paths = []
        for i, made in enumerate(scenes):
            paths.append(os.path.join(self.folder.name, f"{i}.json"))
            with open(paths[-1], "w") as file:
                json.dump(made, file)
        return subprocess.run([sys.executable, TOOL, "--light", *paths, "--out", os.path.join(self.folder.name, "out")], capture_output=True, text=True)

    def summary(self, *scenes):
        run = self.run_tool(*scenes)
        self.assertEqual(run.returncode, 0, run.stderr)
        self.assertGreater(os.path.getsize(os.path.join(self.folder.name, "out", "error_against_bytes.png")), 10000)
        with open(os.path.join(self.folder.name, "out", "summary.json")) as file:
            return json.load(file)

    def test_ratios_are_geometric_means_over_scenes(self):
        summary = self.summary(scene("a", 0.4, 0.2), scene("b", 0.1, 0.1), scene("c", 0.2, 0.05))
        self.assertEqual(summary["scenes"], ["a", "b", "c"])
        self.assertEqual([spacing["spacing_m"] for spacing in summary["spacings"]], [1.0, 2.0])
        reference, ours = summary["spacings"][0]["methods"]
        self.assertAlmostEqual(reference["air"]["ratio"]["mean"], 1.0)
        self.assertAlmostEqual(ours["air"]["mean"], 0.35 / 3)
        self.assertAlmostEqual(ours["air"]["ratio"]["mean"], 0.5)  # of 1/2, 1, 1/4
        low, high = ours["air"]["ratio"]["interval"]
        self.assertTrue(0.25 <= low < 0.5 < high <= 1.0, (low, high))
        self.assertAlmostEqual(ours["dark"]["mean"], -0.01)
        self.assertEqual(ours["bytes"], 3600)
        self.assertAlmostEqual(ours["air"]["median"], 0.1)  # of .2, .1, .05
        self.assertAlmostEqual(ours["seconds"]["mean"], 1.5)
        self.assertNotIn("look_ups_per_s", ours)
        self.assertAlmostEqual(ours["air_by_room"]["mean"], 0.7 / 3)
        for key, mean in (("beside_light", 0.02), ("edge", 0.3), ("corner", 0.4)):
            self.assertAlmostEqual(ours[key]["mean"], mean)

    def test_refuses_what_is_no_result(self):
        self.assertEqual(self.run_tool({**scene("a", 0.4, 0.2), "schema_version": 2}).returncode, INPUT_ERROR)
        self.assertEqual(self.run_tool({"schema_version": 1}).returncode, INPUT_ERROR)
        self.assertIn("'a', which", self.run_tool(scene("a", 0.4, 0.2), scene("a", 0.4, 0.2)).stderr)
        broken = scene("a", 0.4, 0.2)
        broken["spacings"][0]["methods"][0]["air"]["rmse"] = -1
        self.assertEqual(self.run_tool(broken).returncode, INPUT_ERROR)


if __name__ == "__main__":
    unittest.main()

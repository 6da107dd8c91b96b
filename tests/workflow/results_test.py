#!/usr/bin/env python3
"""docs/figures/results.py on a made-up run: what it takes, what it writes, and what it finds wrong. results_test.py (from anywhere)."""
import json
import shutil
import struct
import subprocess
import sys
import tempfile
import unittest
from pathlib import Path

SOURCES = Path(__file__).resolve().parents[2]
SHA256 = "ab" * 32


def interval(value):
    return {"value": value, "low": value * 0.9, "high": value * 1.1}


def quantiles(mean):
    q = {"median": mean / 2, "mean": mean, "p95": 3 * mean, "p99": 5 * mean, "worst": 9 * mean, "functions": 1000}
    return {**q, "interval": {key: [0.9 * q[key], 1.1 * q[key]] for key in ("median", "mean", "p95")}}


def figures(mean):
    return {"functions": 1000, "blend_rmse": quantiles(1.5 * mean), "rmse": quantiles(mean), "rmse_test_points": quantiles(1.2 * mean), "rmse_occluded": quantiles(2 * mean),
            "leak": {"mean": 0.00012, "p99": 0.01}, "share_failing_check": interval(0.0312), "share_fitted": interval(0.25),
            "us_per_function": 612.3}


def populations(mean):
    return {"all": figures(mean / 2), "theta": figures(mean), "hard": figures(3 * mean)}


def representation(weights_sha256):
    words = {word: populations(mean) for word, mean in (("network", 0.0053), ("corrected", 0.0027), ("fitted", 0.00241), ("stored", 0.00239))}
    fits = {word: populations(0.0017) for word in ("direct", "best_known")}
    ratios = {word: {"to_best_known": {"median": interval(1.48), "median_hard": interval(1.48)}} for word in words}
    stages = [{"name": "network", "word": "network", "population": "theta", "above_rmse": None, "budget": None, "text": "one pass"},
              {"name": "adam", "word": "fitted", "population": "theta", "above_rmse": 0.003, "budget": 500, "text": "500 steps of Adam"}]
    return {"parameters": 113, "theta_bytes": {"float32": 452, "float16": 226, "int8": 122}, "weights_bytes": 3032068, "weights_sha256": weights_sha256, "evaluate_us": 9.1,
            "stages": stages, **words, "sample": {"functions": 280, "hard": 70, **words, **fits, "ratios": ratios}}


def summary(weights_sha256=SHA256):
    counts = {"distinct": 9000, "free_space": 1, "duplicates": 2, "in_solid": 3, "empty": 4, "visited_probes": 5, "grid_probes": 6, "held_out": 2000,
              "held_out_scenes": 41, "take_theta": 1000, "hard": 300, "held_out_in_training": 20, "held_out_in_training_mirrored": 30}
    return {"schema_version": 2, "provenance": {"tool": "nlg-validate", "revision": "0123abc", "options": {}, "inputs": {"held_out": "cd" * 32}},
            "tau": {"rmse": 0.02, "blend": 0.03, "leak": 0.1, "dark_weight": 64, "blend_floor": 0.2, "hard_tent_rmse": 0.01, "bare_tent_rmse": 0.002}, "theta_precision": "int8", "functions": counts,
            "tent": populations(0.012), "representations": {"tent_mlp": representation(weights_sha256)}}


def frontier():
    statistics = {"mean": 0.006, "median": 0.002, "p5": 0.001, "p95": 0.018, "worst": 0.04}
    errors = {**{f"blend_rmse_{key}": value for key, value in statistics.items()}, "rmse_mean": 0.003}
    found = {"us_median": 5246, "us_p25": 5000, "us_p75": 5500, **errors, "leak_p99": 0.01, "share_failing_check": 0.05, "share_fitted": 1.0, "on_front": True}
    point = {"representation": "tent_mlp", "family": "lm_from_theta0", "budget": 16, "label": "16 LM from theta0", "words": [],
             "figures": {"theta": found, "hard": {**found, "on_front": False}}, "by_scene": {"kaos2": {}}}
    stage = {**point, "family": "stages", "budget": None, "label": "Adam", "words": ["fitted"]}
    speed = {"time_us": 600.0, "blend_rmse_mean": 0.0048, "share_failing_check": interval(0.01), "baseline": "Adam from theta0", "baseline_us_at_equal_error": 3960.0,
             "baseline_share_failing_check": interval(0.02), "ratio": {"value": 6.6, "low": 5.1, "high": None}, "longest_us": None, "reason": None}
    none = {**speed, "baseline": None, "baseline_us_at_equal_error": None, "baseline_share_failing_check": None, "ratio": None, "longest_us": 9000.0, "reason": "no direct fit reaches the error"}
    return {"schema_version": 2, "provenance": {"revision": "0123abc", "inputs": {"held_out": "cd" * 32}},
            "functions": {"theta": 246, "hard": 50}, "scenes": ["kaos2"],
            "points": [point, stage, {**stage, "label": "refinement"}], "bare_tent": {"figures": {"theta": errors, "hard": errors}, "by_scene": {}},
            "front_sentences": {"theta": "One point.", "hard": ""},
            "speed_at_equal_error": {"tent_mlp": {"network": speed, "corrected": none, "fitted": none}}}


def stability():
    case = {"group": "functions", "name": "free space", "must_hold": "it holds", "measured": "0.0059", "figures": {}, "holds": True, "fails_check": False}
    return {"schema_version": 1, "provenance": {"revision": "0123abc"}, "cases": [case, {**case, "name": "other"}]}


def bake():
    counts = {key: 100 for key in ("probes", "free_space", "in_solid", "empty", "bare_tents", "duplicates", "functions", "took_fit", "still_failing", "bytes")}
    errors = {"mean": 0.0034, "median": 0.002, "p95": 0.01, "p99": 0.02, "worst": 0.03, "leak_mean": 0.0, "failing": 0, "us_per_function": 600.0}
    return {"scene": "kaos2", "threads": 2, **counts, "bytes_per_probe": 26.0, "share_fitted": {"all": 0.1, "theta": 0.4},
            "thread_seconds": {"visibility": 3.6, "functions": 0.9, "duplicates": 0.1, "stages": {"network": 0.05, "check": 0.01, "adam": 2.0}},
            "wall_seconds": {"load": 0.2, "all": 7.6}, "light": {"wall_seconds": {"cache": 0.0, "measure": 2.0, "solve": 0.5}}, "rmse": {word: errors for word in ("network", "corrected", "fitted", "stored")}}


def benchmarks():
    case = {"name": "generator/float32:96_median", "run_name": "generator/float32:96", "run_type": "aggregate", "aggregate_name": "median", "threads": 1,
            "iterations": 7, "real_time": 18.4, "cpu_time": 18.3, "time_unit": "us", "items_per_second": 54400.0}
    return {"context": {}, "benchmarks": [{**case, "name": "generator/float32:96", "run_type": "iteration", "cpu_time": 99.0}, case]}


def light_method(weights, light, rmse, size, **more):
    group = {"rmse": rmse, "smape": 0.1, "unlit": 0.0, "outside": 0.0, "balanced": {"rooms": 3, "rmse": rmse ** 2}}
    surface = {**group, "by_distance": [{"from_m": 0.05, "to_m": 0.1, "rmse": rmse}]}
    return {"weights": weights, "light": light, "air": group, "surface": surface, "turned": group, "dark": {"places": 99, "excess": rmse / 10}, "edge": {"excess": rmse / 2}, "jumps": {"mean": 0.01, "largest": 0.1},
            "bytes": {"total": size, "per_probe": size / 8}, "probes": 8, "times": {"weights_s": 1.0, "light_s": 0.5}, "worst": [], **more}


def light(scene, baseline, ours, direct="all"):
    """Of a level: DDGI's error, and that of ours, whole; a validity mask is half as wrong again as DDGI. Relative errors are the same of all.

    kaos2 has double-sided faces: RTXGI's own rule for their backs is twice as wrong there as the other.
    """
    ddgi = {"DDGI as shipped": 2 * baseline, "DDGI as shipped, backless sheets": baseline} if scene == "kaos2" else {"DDGI as shipped": baseline}
    methods = [light_method("valid trilinear", "point", 1.5 * baseline, 400), light_method("exact visibility", "point", ours, 400), *(light_method(name, "own", error, 10000) for name, error in ddgi.items()),
               light_method("tent_mlp4", "point", 2 * ours, 480), light_method("tent_mlp4", "solved", ours, 480), light_method("target functions", "solved", ours / (1.25 if scene == "aggressor" else 1.125), 99999),
               light_method("tent_mlp4, thinned 0.03", "solved", 2 * ours, 360), light_method("tent_mlp4, thinned 0.2", "solved", 9 * ours, 320)]
    return {"schema_version": 1, "scene": scene, "provenance": {"revision": "0123abc", "options": {"light_direct": direct}}, "floor": light_method("harmonics at the point", "point", 0.01, 1),
            "truth": {"all_bounces_in_one_ray": True, "noise": 0.01, "places": {"air": 300, "surface": 300, "dark": 20}}, "spacings": [{"spacing_m": 1.0, "methods": methods}]}


def seen(scene, ddgi):
    """Pictures of one offset of the lattice: ours differs by 2; ddgi: HyAB by rule."""
    figures = lambda hyab: {"all": {"hyab": hyab, "energy": 1.0, "off_2": {"brighter": .01, "darker": .02}, "below_eighth": .005, "ringing": .01}}
    names = {("tent_mlp4", "solved"): 2.0, **{(name, "own"): hyab for name, hyab in ddgi.items()}}
    return {"scene": scene, "provenance": {"revision": "0123abc"}, "methods": [{"weights": weights, "light": way, **figures(hyab)} for (weights, way), hyab in names.items()]}


def write_weights(path):
    metadata = {"training_set_sha256": SHA256, "training_options": '{"seed": 1, "training_scenes": {"aggressor": "cd"}}', "provenance": '{"revision": "8d19a80"}'}
    header = json.dumps({"__metadata__": metadata, "theta0": {"dtype": "F32", "shape": [113], "data_offsets": [0, 452]}}).encode()
    path.write_bytes(struct.pack("<Q", len(header)) + header + bytes(452))


class Results(unittest.TestCase):
    def setUp(self):
        self.root = Path(tempfile.mkdtemp())
        self.addCleanup(shutil.rmtree, self.root)
        (self.root / "docs" / "figures").mkdir(parents=True)
        for script in SOURCES.glob("docs/figures/*.py"):
            shutil.copy(script, self.root / "docs" / "figures")
        shutil.copytree(SOURCES / "validate" / "report", self.root / "validate" / "report", ignore=shutil.ignore_patterns("__pycache__"))
        shutil.copytree(SOURCES / "tool", self.root / "tool", ignore=shutil.ignore_patterns("__pycache__"))
        for folder in ("docs/results", "docs/reference", "docs/images", "weights"):
            (self.root / folder).mkdir(parents=True)
        for name in ("tent_mlp", "tent_mlp4"):
            write_weights(self.root / "weights" / f"{name}.safetensors")
        sys.path.insert(0, str(SOURCES / "docs" / "figures"))
        import model_card
        self.sha256 = model_card.hash_of(self.root / "weights" / "tent_mlp.safetensors")
        facts = {"sha256": self.sha256, "configuration": "c.yaml", "scenes": "2 scenes", "functions": 352884, "steps": 30000,
                 "parity_theta": 7e-6, "parity_functions": 1024, "held_out_rmse": 0.005, "rounding_rmse": 1e-8}
        self.write("docs/results/weights.json", {"tent_mlp": facts, "tent_mlp4": facts})
        self.write("docs/results/openarena.json", {"schema_version": 1, "run": "openarena", "command": "./pipeline.sh"})
        self.write("docs/figures/quotes.json", {})
        run = "out/openarena/"
        self.write(run + "evaluation/summary.json", summary(self.sha256))
        self.write(run + "evaluation/frontier.json", frontier())
        self.write(run + "stability.json", stability())
        self.write(run + "bakes/kaos2.json", bake())
        self.write(run + "benchmarks/runtime_eval.json", benchmarks())

    def write(self, path, content):
        file = self.root / path
        file.parent.mkdir(parents=True, exist_ok=True)
        file.write_text(content if isinstance(content, str) else json.dumps(content))

    def run_results(self, *arguments):
        command = ["/usr/bin/python3", self.root / "docs" / "figures" / "results.py", *arguments]
        return subprocess.run(command, capture_output=True, text=True, cwd=self.root)

    def collect(self):
        return self.run_results("collect", "out/openarena", "--config", "c.yaml", "--no-pictures")

    def quote(self, specs):
        """README quotes each of these, one a line, all of them wrongly."""
        self.write("README.md", "".join(f"number {i} of {len(specs)} is 999.9\n" for i in range(len(specs))))
        self.write("docs/figures/quotes.json", {"README.md": {f"number {i} of {len(specs)} is {{}}": [spec] for i, spec in enumerate(specs)}})

    def filled(self, *specs):
        """What stands in the README for these after a whole collection."""
        self.quote(specs)
        result = self.collect()
        self.assertEqual(result.returncode, 0, result.stderr)
        return [line.split(" is ")[1] for line in (self.root / "README.md").read_text().splitlines()]

    def test_numbers_are_written_as_their_styles_say(self):
        expected = {
            "tent_mlp.stored.theta.rmse.mean:.4": ".0024",
            "tent_mlp.stored.theta.rmse.mean:.3": ".002",
            "tent_mlp.fitted.all.share_fitted:%": "25 %",
            "tent_mlp.fitted.theta.us_per_function:us": "612",
            "tent_mlp.sample.ratios.stored.to_best_known.median_hard:.2": "1.48",
            "tent_mlp.network.theta.rmse.mean / tent_mlp.stored.theta.rmse.mean:.1": "2.2",
            "functions.take_theta:int": "1,000",
            "frontier.points.tent_mlp.lm_from_theta0_16.figures.theta.us_median:us": "5,246",
            "frontier.points.tent_mlp.stages_Adam.figures.theta.rmse_mean:.4": ".0030",
            "frontier.speed_at_equal_error.tent_mlp.network.ratio:.1": "6.6",
            "benchmarks.generator_float32_96.items_per_second:int": "54,400",
            "bakes.kaos2.thread_s.network:.2": ".06",
            "weights@tent_mlp.steps:int": "30,000",
        }
        self.assertEqual(dict(zip(expected, self.filled(*expected))), expected)

    def test_writing_twice_changes_nothing_and_check_agrees(self):
        self.filled("tent_mlp.stored.theta.rmse.mean:.4")
        self.assertEqual(self.run_results("write").stdout, "")
        self.assertEqual(self.run_results("check").returncode, 0)

    def test_check_names_the_phrase_that_says_something_else(self):
        self.filled("tent_mlp.stored.theta.rmse.mean:.4")
        readme = self.root / "README.md"
        readme.write_text(readme.read_text().replace(".0024", ".0025"))
        result = self.run_results("check")
        self.assertEqual(result.returncode, 6)
        self.assertIn("README.md: expected 'number 0 of 1 is .0024', got 'number 0 of 1 is .0025'", result.stderr)

    def test_check_names_figures_of_another_revision_or_of_none_that_can_be_looked_up(self):
        self.filled("tent_mlp.stored.theta.rmse.mean:.4")
        path = self.root / "docs/results/openarena.json"
        before = json.loads(path.read_text())
        for old, new in (("0123abc", "0123abc-dirty"), ('"revision": "0123abc", "held_out', '"revision": "4567def", "held_out')):
            path.write_text(json.dumps(before).replace(old, new))
            self.run_results("write")
            result = self.run_results("check")
            self.assertEqual(result.returncode, 6)
            self.assertIn(f"expected one revision without changes in openarena, got {'4567def' if '4567def' in new else '0123abc-dirty'}", result.stderr)

    def test_a_release_has_figures_of_its_own_sources(self):
        def git(*arguments):
            named = ("-c", "user.name=a", "-c", "user.email=a@b")
            return subprocess.run(["git", "-C", self.root, *named, *arguments], check=True, capture_output=True, text=True).stdout.strip()

        def commit(path, content):
            self.write(path, content)
            git("add", path)
            git("commit", "-qm", path)
            return git("rev-parse", "HEAD")
        git("init", "-q")
        measured = commit("light/solve.cpp", "int x;")
        self.filled("tent_mlp.stored.theta.rmse.mean:.4")
        other = self.root / "docs" / "results" / "other.json"
        other.write_text(json.dumps({"run": "other", "revision": measured}))
        stale = f"expected other of the present sources, got {measured}, since which 1 files changed: light/solve.cpp"
        for path, is_stale in (("a.md", False), ("tests/a.cpp", False), ("light/solve.cpp", True)):
            commit(path, "int y;")
            said = self.run_results("check", "--release").stderr
            if is_stale:
                # a comment, or where a line ends, changes no figure
                commit(path, "int x;  // the sum\n")
                self.assertNotIn("present sources", self.run_results("check", "--release").stderr)
            self.assertEqual(stale in said, is_stale, f"{path}: {said}")
            self.assertNotIn("present sources", self.run_results("check").stderr)
        other.write_text(json.dumps({"run": "other", "revision": "4567def4567d"}))
        self.assertIn("expected other of a revision of this repository, got 4567def4567d", self.run_results("check", "--release").stderr)
        # what times fits changes no figure of light, and no figure goes through exports
        asked = "import sys; sys.path.insert(0, 'docs/figures'); import results; print(*(results.older_than_sources({name: {'revision': sys.argv[1]}}) != [] for name in ('light', 'openarena', 'reliability')))"
        for path, stale in (("validate/frontier/a.cpp", "False True True"), ("validate/views/a.cpp", "True False True"), ("export/engine/a.cpp", "False False True")):
            before = git("rev-parse", "HEAD")
            commit(path, "int z;")
            said = subprocess.run(["/usr/bin/python3", "-c", asked, before], cwd=self.root, capture_output=True, text=True)
            self.assertEqual(said.stdout.strip(), stale, f"{path}: {said.stderr}")

    def test_all_rows_of_a_table_have_the_cells_of_its_head(self):
        self.assertEqual(self.collect().returncode, 0)
        for page in ("docs/reference/results.md", "weights/README.md"):
            cells = 0
            for line in (self.root / page).read_text().splitlines():
                if not line.startswith("|"):
                    cells = 0
                    continue
                cells = cells or line.count("|")
                self.assertEqual(line.count("|"), cells, f"{page}: {line}")

    def collect_light(self):
        return self.run_results("collect-light", "out/light", "--no-pictures")

    def write_light(self):
        for scene, baseline, ours in (("kaos2", 0.4, 0.1), ("am_thornish", 0.2, 0.1), ("aggressor", 0.1, 0.1)):
            self.write(f"out/light/{scene}.json", light(scene, baseline, ours))

    def test_light_is_collected_quoted_and_tabled(self):
        expected = {
            "light@targets.levels.1m.air:.2": ".50",  # geometric mean of 1/4, 1/2 and 1, over DDGI, the better of the baselines
            "light@targets.by_room.1m.air:.2": ".25",  # squares of those
            "light@methods.levels.1m.DDGI_as_shipped.own.edge:.2": ".12",  # the mean of .4, .2 and .1, halved
            "light@targets.front.share:%": "83 %",  # in aggressor the validity mask has fewer bytes than the whole grid, and less error than the thinned one
            "light@targets.front.missed_in.aggressor.points:int": "3",
            "light@thinning.levels.thinned.tent_mlp4_thinned_0_03.bytes:.2": ".75",
            "light@thinning.levels.thinned.tent_mlp4_thinned_0_03.turned:.2": "2.00",
            "light@thinning.levels.at_equal_error.air.over_whole:.2": "1.00",
            "light@thinning.levels.at_equal_error.smape_in_air.over_whole:.2": ".67",  # any will do
            "light@thinning.levels.at_equal_error.smape_in_air.over_before:.2": "1.03",  # 320 over 8 probes of 39
            "light@methods.levels.1m.tent_mlp4_thinned_0_03.solved.per_probe:int": "45",
            "light@targets.dark.1m.ours:.3": ".010",
            "light@targets.bytes_below_baselines:int": "360",
            "light@methods.levels.1m.tent_mlp4.solved.surface:.3": ".100",
            "light@methods.levels.1m.DDGI_as_shipped.own.per_probe:int": "1,250",
            "light@bakes.kaos2.wall_s:.1": "7.6",
            # over target functions, where the weights have seen the scene, and where not
            "light@over_exact.trained.error:.3": "1.250",
            "light@over_exact.unseen.error:.3": "1.125",
        }
        self.write_light()
        self.write("out/light/bakes/kaos2.json", bake())
        self.quote(expected)
        result = self.collect_light()
        self.assertEqual(result.returncode, 0, result.stderr)
        texts = [line.split(" is ")[1] for line in (self.root / "README.md").read_text().splitlines()]
        self.assertEqual(dict(zip(expected, texts)), expected)
        self.assertIn("`tent_mlp4` was trained on 1 of these 3 scenes: aggressor.", (self.root / "docs/reference/light.md").read_text())
        self.assertEqual(self.run_results("check").returncode, 0)

    def test_pictures_are_means_over_offsets_by_the_better_rule_of_ddgi(self):
        self.write_light()
        own, other = "DDGI as shipped", "DDGI as shipped, backless sheets"
        for name, ddgi in (("kaos2_1", {own: 16.0, other: 9.0}), ("kaos2_2", {own: 2.0, other: 7.0}), ("aggressor_1", {own: 4.0}), ("aggressor_2", {own: 4.0})):
            self.write(f"out/light/views/{name}.json", seen(name.split("_")[0], ddgi))
        # 2 over the mean of 9 and 7, which is less than that of 16 and 2; and over 4
        expected = {"light@views.hyab_over_best_baseline.levels.value:.3": ".354", "light@views.methods.levels.DDGI_as_shipped_own.all.hyab:.1": "6.0", "light@views.offsets:int": "2"}
        self.quote(expected)
        result = self.collect_light()
        self.assertEqual(result.returncode, 0, result.stderr)
        texts = [line.split(" is ")[1] for line in (self.root / "README.md").read_text().splitlines()]
        self.assertEqual(dict(zip(expected, texts)), expected)
        (self.root / "out" / "light" / "views" / "kaos2_2.json").unlink()
        self.assertEqual(self.collect_light().returncode, 3)

    def test_refuses_bakes_of_other_weights_than_the_evaluation(self):
        self.write("out/openarena/bakes/kaos2.json", {**bake(), "weights": {"tent_mlp": {"sha256": SHA256}}})
        result = self.collect()
        self.assertEqual(result.returncode, 3)
        self.assertIn("figures of weights", result.stderr)


if __name__ == "__main__":
    unittest.main()

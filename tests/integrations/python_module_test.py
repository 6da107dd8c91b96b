#!/usr/bin/python3
"""The module nlg for Python: its numbers are those of the interface in C, and bad arguments raise.

    python_module_test.py BUILD TOOLS CMAKE CC

Exit code 77, a skipped test, where numpy is missing.
"""
import _thread
import ctypes
import importlib.util
import os
import signal
import subprocess
import sys
import tempfile
import threading
import unittest
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]
BUILD, TOOLS, CMAKE, CC = sys.argv[1:]
WEIGHTS = ROOT / "weights"
P = 8192


def skip(reason):
    print("skipped:", reason)
    sys.exit(77)


if importlib.util.find_spec("numpy") is None:
    skip("no numpy (Debian: python3-numpy)")
import numpy as np


def output(*command):
    result = subprocess.run(list(map(str, command)), stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True)
    if result.returncode != 0:
        sys.exit(f"{command}: exit code {result.returncode}\n{result.stdout[-4000:]}")
    return result.stdout


def numbers_of_c(folder, weights, grid):
    """What the interface in C says of the functions and positions of numbers.c, by name: an array of the numbers of each line."""
    program, library = folder / "numbers", Path(BUILD, "runtime_eval")
    output(CC, "-std=c11", "-O2", ROOT / "tests/other_machines/numbers.c", "-o", program, f"-I{ROOT}/include", f"-L{library}", f"-L{library}/weights_file", f"-L{library}/regular_file",
           "-lnlg_runtime_eval", "-lnlg_weights_file", "-lnlg_regular_file", "-lhwy", "-lstdc++", "-lm")
    lines = [line.split() for line in output(program, weights, grid).splitlines()]
    return {name: [np.array(words[1:], np.float32) for words in lines if words[0] == name] for name in {words[0] for words in lines}}


def positions_of_c(count=5000):
    """The positions and normals of numbers.c."""
    i = np.arange(count)
    steps = np.array([0.8191725133961645, 0.6710436067037893, 0.5497004779019703])
    normals = np.zeros((count, 3), np.float32)
    normals[i, i % 3] = np.where(i % 2 == 0, 1, -1)
    return np.array([6.0, 3.0, 6.0]) * np.fmod(steps * i[:, None], 1.0), normals


def walls():
    """The functions of numbers.c, 16 x P: the tent on one side of a wall, nothing behind it."""
    x, y, _ = points = nlg.support_points().T
    tent = np.prod(np.float32(1) - np.abs(points), axis=0, dtype=np.float32)
    wall = np.arange(16, dtype=np.float32)[:, None]
    return np.where(x + np.float32(.1) * wall * y < np.float32(.05) * wall, np.floor(255 * tent + .5), 0).astype(np.uint8)


class PythonModule(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        folder = tempfile.TemporaryDirectory()
        cls.addClassCleanup(folder.cleanup)
        cls.folder = Path(folder.name)
        cls.weights = WEIGHTS / "tent_mlp4.safetensors"
        cls.house = cls.folder / "house.safetensors"
        output(f"{TOOLS}/nlg-bake", "house:3", "--weights", cls.weights, "--spacing-m", 1, "--extent-m=0,0,0,6,3,6", "--sky", "1,1,1", "--sun", "40,50,3,2.8,2.5", "--out", cls.house)
        cls.kitchen = cls.folder / "kitchen.safetensors"
        output(f"{TOOLS}/nlg-bake", ROOT / "samples/kitchen.glb", "--weights", cls.weights, "--sky", ".55,.75,1", "--light-groups", "name", "--out", cls.kitchen)
        cls.of_c = numbers_of_c(cls.folder, cls.weights, cls.house)
        cls.generator = nlg.Generator(cls.weights)

    def raises(self, kind, text, call, *arguments):
        with self.assertRaises(kind) as raised:
            call(*arguments)
        self.assertIs(type(raised.exception), kind)
        self.assertIn(text, str(raised.exception))

    # light grids

    def test_light_is_that_of_the_interface_in_c(self):
        positions, normals = positions_of_c()
        rgb, status = nlg.LightGrid(self.house).irradiance(positions, normals)
        np.testing.assert_array_equal(rgb.ravel(), self.of_c["light.many"][0])
        np.testing.assert_array_equal(status, self.of_c["status.many"][0])
        self.assertEqual((rgb.shape, rgb.dtype, status.dtype), ((5000, 3), np.float32, np.uint8))
        self.assertGreater((status == nlg.LIT).sum(), 1000)
        self.assertTrue(rgb[status == nlg.LIT].any())

    def test_probes_are_those_that_the_bake_tool_lists(self):
        grid = nlg.LightGrid(self.house)
        header, *rows = [line.split(",") for line in output(f"{TOOLS}/nlg-bake", "probes", self.house).splitlines()]
        self.assertEqual(header[:4], ["x_m", "y_m", "z_m", "kind"])
        np.testing.assert_allclose(grid.probe_positions, np.array([row[:3] for row in rows], float), rtol=1e-8)
        low, high = grid.bounds
        self.assertTrue((grid.probe_positions >= low - 1e-9).all() and (grid.probe_positions <= high + 1e-9).all())

    def test_groups_mix(self):
        grid = nlg.LightGrid(self.kitchen)
        self.assertEqual(grid.groups, ["sky", "sun", "pendant"])
        positions = grid.probe_positions
        light = lambda: grid.irradiance(positions, np.tile(np.float32([0, -1, 0]), (len(positions), 1)))
        whole, mean, parts = light()[0], grid.mean_radiance, []
        for group in range(3):
            grid.mix(np.eye(3, dtype=np.float32)[group][:, None] * np.ones(3, np.float32))
            parts.append(grid.mean_radiance)
        self.assertTrue(all(part.any() for part in parts))
        np.testing.assert_allclose(sum(parts), mean, rtol=1e-4)
        grid.mix(np.array([[0, 0, 0], [0, 0, 0], [0, 2, 0]], np.float32))
        np.testing.assert_allclose(grid.mean_radiance, [0, 2, 0] * parts[2], rtol=1e-6)
        rgb, status = light()
        self.assertFalse(rgb[:, [0, 2]].any())
        self.assertTrue(rgb[status == nlg.LIT, 1].any())
        grid.mix(np.ones((3, 3), np.float32))
        np.testing.assert_array_equal(light()[0], whole)

    def test_a_grid_without_groups_mixes_nothing(self):
        grid = nlg.LightGrid(self.house)
        self.assertEqual(grid.groups, [])
        grid.mix(np.zeros((0, 3), np.float32))
        self.raises(ValueError, "colours: expected float32 of shape (0, 3), got float32 of shape (1, 3)", grid.mix, np.ones((1, 3), np.float32))

    def test_files_are_paths_or_bytes(self):
        positions, normals = positions_of_c(100)
        for source in (str(self.house), self.house, self.house.read_bytes()):
            np.testing.assert_array_equal(nlg.LightGrid(source).irradiance(positions, normals)[0].ravel(), self.of_c["light.many"][0][:300])

    def test_positions_that_are_none_are_outside(self):
        grid, (positions, normals) = nlg.LightGrid(self.house), positions_of_c(4)
        positions[:3] = [[np.nan] * 3, [np.inf] * 3, [1e300] * 3]
        normals[3] = np.nan
        rgb, status = grid.irradiance(positions, normals)
        self.assertEqual(status.tolist(), [nlg.OUTSIDE] * 3 + [nlg.UNLIT])
        self.assertFalse(rgb.any())

    def test_threads_look_up_while_light_is_mixed(self):
        grid, (positions, normals) = nlg.LightGrid(self.kitchen), positions_of_c()
        ends = [np.zeros((3, 3), np.float32), np.ones((3, 3), np.float32)]
        answers = set()
        for colours in ends:
            grid.mix(colours)
            answers.add(grid.irradiance(positions, normals)[0].tobytes())
        seen = set()
        threads = [threading.Thread(target=lambda: seen.update(grid.irradiance(positions, normals)[0].tobytes() for _ in range(20))) for _ in range(3)]
        for thread in threads:
            thread.start()
        while any(thread.is_alive() for thread in threads):
            for colours in ends:
                grid.mix(colours)
        self.assertEqual(len(answers), 2)
        self.assertLessEqual(seen, answers)
        self.assertTrue(seen)

    # generators

    def test_theta_and_its_values_are_those_of_the_interface_in_c(self):
        theta = self.generator.generate(walls(), np.full((len(walls()), P // 8), 255, np.uint8))
        np.testing.assert_array_equal(theta, self.of_c["theta"])
        np.testing.assert_array_equal(self.generator.evaluate(theta[5], nlg.support_points()), self.of_c["value"][5])
        self.assertEqual((self.generator.representation, self.generator.theta_count), ("tent_mlp4", 21))

    def test_the_policy_makes_theta_that_stands_for_its_function(self):
        phi = np.concatenate([walls()[:4], np.zeros((1, P), np.uint8)])
        valid = np.ones((5, P), bool)
        valid[3, ::3] = False
        phi[4] = np.floor(255 * np.prod(1 - np.abs(nlg.support_points()), axis=1, dtype=np.float32) + .5)
        theta, has_theta, rmse = self.generator.make_theta(phi, np.packbits(valid, axis=1, bitorder="little"))
        # the last is the bare tent
        self.assertEqual(has_theta.tolist(), [True] * 4 + [False])
        self.assertFalse(theta[4].any())
        for i in range(4):
            values = self.generator.evaluate(theta[i], nlg.support_points())
            error = np.sqrt(np.mean((values.astype(float) - phi[i] / 255)[valid[i]] ** 2))
            self.assertAlmostEqual(error, rmse[i], delta=1e-6)
        # whatever stands beside it
        alone, _, _ = self.generator.make_theta(phi[2:3], np.packbits(valid[2:3], axis=1, bitorder="little"))
        np.testing.assert_array_equal(alone[0], theta[2])

    def test_an_interrupt_ends_the_policy(self):
        phi = np.repeat(walls(), 250, axis=0)
        # who runs this in the background may have it ignored
        before = signal.signal(signal.SIGINT, signal.default_int_handler)
        self.addCleanup(signal.signal, signal.SIGINT, before)
        timer = threading.Timer(.05, _thread.interrupt_main)
        timer.start()
        with self.assertRaises(KeyboardInterrupt):
            self.generator.make_theta(phi, np.full((len(phi), P // 8), 255, np.uint8))

    def test_every_representation_evaluates_up_to_its_bounds(self):
        corners = np.array([[-1, -1, -1], [1, 1, 1], [0, 1, -1]], np.float32)
        for path in sorted(WEIGHTS.glob("*.safetensors")):
            generator = nlg.Generator(path)
            for theta in (0, 1e9, -1e9):
                self.assertEqual(generator.evaluate(np.full(generator.theta_count, theta, np.float32), corners).shape, (3,), path)

    # refusals

    def test_wrong_arrays_raise(self):
        grid, (positions, normals) = nlg.LightGrid(self.house), positions_of_c(4)
        for arguments, text in [
                ((positions.astype(np.float32), normals), "positions: expected float64 of shape (n, 3), got float32 of shape (4, 3)"),
                ((positions.astype(">f8"), normals), "got >f8 of shape"), ((positions, normals[:3]), "got float32 of shape (3, 3)"),
                ((positions.tolist(), normals), "positions: expected float64 of shape (n, 3), got no array but list"), ((positions, None), "got no array but NoneType")]:
            self.raises(ValueError, text, grid.irradiance, *arguments)
        kitchen = nlg.LightGrid(self.kitchen)
        before = kitchen.mean_radiance
        self.raises(ValueError, "colours: expected float32 of shape (3, 3)", kitchen.mix, np.ones((2, 3), np.float32))
        self.raises(ValueError, "colours: expected numbers within", kitchen.mix, np.full((3, 3), np.nan, np.float32))
        np.testing.assert_array_equal(kitchen.mean_radiance, before)
        phi, validity, theta = np.zeros((2, P), np.uint8), np.zeros((2, P // 8), np.uint8), np.zeros(21, np.float32)
        self.raises(ValueError, "phi: expected uint8 of shape (n, 8192), got uint8 of shape (2, 1024)", self.generator.generate, validity, validity)
        self.raises(ValueError, "validity: expected uint8 of shape (2, 1024), got bool of shape (2, 8192)", self.generator.make_theta, phi, phi > 0)
        self.raises(ValueError, "theta: expected float32 of shape (21,), got float32 of shape (1, 21)", self.generator.evaluate, theta[None], nlg.support_points())

    def test_missing_and_damaged_files_raise_with_their_reason(self):
        for load, file in ((nlg.LightGrid, self.house), (nlg.Generator, self.weights)):
            self.raises(OSError, "nowhere.safetensors", load, self.folder / "nowhere.safetensors")
            self.raises(OSError, str(self.folder), load, self.folder)
            whole = file.read_bytes()
            for damaged in (b"", whole[:-1], whole[:-9] + bytes([whole[-9] ^ 1]) + whole[-8:]):
                with self.assertRaises(ValueError) as raised:
                    load(damaged)
                self.assertTrue(str(raised.exception))
        self.raises(ValueError, "(tensor_missing)", nlg.LightGrid, self.weights)
        self.raises(ValueError, f"{self.house}: ", nlg.Generator, self.house)

    def test_sample_points_are_those_of_the_page(self):
        section = (ROOT / "docs/reference/training_files.md").read_text().split("## Sample points\n")[1].split("\n## ")[0]
        listed = [int(word) for word in section.rsplit(":", 1)[1].strip(" .\n").split(",")]
        of_c = ctypes.CDLL(f"{BUILD}/python/nlg/libnlg.so").nlg_sample_point
        of_c.restype = ctypes.c_size_t
        self.assertEqual([of_c(ctypes.c_size_t(i)) for i in range(1024)], [1024 * m + s for m in range(8) for s in listed])

    def test_the_guide_runs(self):
        text = (ROOT / "docs/guide/python.md").read_text()
        code = "\n".join(block.split("```")[0] for block in text.split("```python\n")[1:])
        for name, file in (("level.safetensors", self.kitchen), ("weights/tent_mlp4.safetensors", self.weights)):
            self.assertIn(name, code)
            (self.folder / name).parent.mkdir(exist_ok=True)
            (self.folder / name).write_bytes(file.read_bytes())
        names = {}
        os.chdir(self.folder)
        exec(compile(code, "python.md", "exec"), names)
        self.assertEqual(names["rgb"].shape[1], 3)

    def test_installs_beside_other_modules(self):
        output(CMAKE, "--install", f"{BUILD}/integrations/python", "--prefix", self.folder / "prefix")
        folder = self.folder / "prefix/lib/python3/dist-packages"
        result = subprocess.run([sys.executable, "-c", "import nlg; print(nlg.__file__)"], env={"PATH": "/usr/bin:/bin", "PYTHONPATH": str(folder)}, cwd="/", capture_output=True, text=True)
        self.assertTrue(result.stdout.startswith(str(folder)), result.stderr)


if __name__ == "__main__":
    sys.path.insert(0, f"{BUILD}/python")
    import nlg
    unittest.main(argv=sys.argv[:1])

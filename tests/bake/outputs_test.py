#!/usr/bin/python3
"""What nlg-bake and nlg-view may replace: what they wrote themselves, and nothing else; what a bake collects. outputs_test.py FOLDER_OF_TOOLS"""
import json
import os
import subprocess
import sys
import tempfile
import unittest
from pathlib import Path

sys.dont_write_bytecode = True
sys.path.append(str(Path(__file__).resolve().parents[1]))
from tools import SECONDS, USAGE_ERROR

TOOLS = Path(sys.argv.pop(1)).resolve()
QUICK = ["--spacing-m", "2", "--light-samples", "2", "--light-rays", "8", "--lm-iterations", "0", "--adam-steps", "0", "--refine-rounds", "0"]
# what others have, some of it much like ours
OTHERS = {"diary.txt": b"Dear diary, \"kind\":\"nlg-light-grid\"", "wall.png": b"\x89PNG\r\n\x1a\n", "level.gltf": b'{"asset":{"version":"2.0"},"scene":0}', "list.json": b'["b","a"]\n', "pretty.json": b'[\n "a"\n]\n',
          "weights": b'\x60\0\0\0\0\0\0\0{"__metadata__":{"kind":"nlg-weights"}}', "package.json": b'{"scene":"x","name":"y"}\n'}
A_WALL = "v 0 0 0\nv 4 0 0\nv 4 3 0\nv 0 3 0\nvt 0 0\nvt 1 0\nvt 1 1\nvt 0 1\nusemtl m\nf 1/1 2/2 3/3 4/4\n"


class Outputs(unittest.TestCase):
    def setUp(self):
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.folder = Path(folder.name)

    def run_tool(self, *words):
        return subprocess.run([TOOLS / words[0], *words[1:]], cwd=self.folder, capture_output=True, text=True, errors="replace", timeout=4 * SECONDS)

    def bake(self, *words):
        return self.run_tool("nlg-bake", "cornell:0", *QUICK, *words)

    def assert_baked(self, done):
        self.assertEqual(done.returncode, 0, done.stderr)

    def assert_refused(self, done, flag):
        self.assertEqual(done.returncode, USAGE_ERROR, done.stderr)
        self.assertRegex(done.stderr, rf"(?m)^nlg-\w+: error: {flag}: expected a new file, or .* to overwrite, got ")

    def test_a_bake_replaces_its_own(self):
        own = ["--out", "grid", "--json", "report", "--inputs", "inputs"]
        self.assert_baked(self.bake(*own))
        self.assert_baked(self.bake(*own))
        self.assert_baked(self.bake("--relight", "grid", "--out", "relit", *own[2:]))
        for name in ("empty grid", "empty report", "empty inputs"):
            (self.folder / name).touch()
        self.assert_baked(self.bake("--out", "empty grid", "--json", "empty report", "--inputs", "empty inputs"))
        # of a grid whose end is gone it can be said all the same
        whole = (self.folder / "grid").read_bytes()
        (self.folder / "grid").write_bytes(whole[:len(whole) // 2])
        self.assert_baked(self.bake(*own))
        self.assertEqual((self.folder / "grid").read_bytes(), whole)

    def test_a_bake_replaces_nobody_elses(self):
        for name, content in OTHERS.items():
            (self.folder / name).write_bytes(content)
            for flag in ("--out", "--json", "--inputs"):
                others = [] if flag == "--out" else ["--out", "grid"]
                self.assert_refused(self.bake(flag, name, *others), flag)
                self.assertEqual((self.folder / name).read_bytes(), content)
        # nor what it wrote of another kind
        self.assert_baked(self.bake("--out", "grid", "--json", "report", "--inputs", "inputs"))
        for flag, name in (("--out", "report"), ("--out", "inputs"), ("--json", "grid"), ("--json", "inputs"), ("--inputs", "report")):
            before = (self.folder / name).read_bytes()
            self.assert_refused(self.bake(flag, name, *([] if flag == "--out" else ["--out", "other"])), flag)
            self.assertEqual((self.folder / name).read_bytes(), before)
        (self.folder / "cornell_0.safetensors").write_bytes(OTHERS["weights"])
        self.assert_refused(self.bake(), "--out")

    def test_a_shard_of_what_fails(self):
        collect, shard = ["--out", "grid", "--json", "report", "--collect", "hard"], self.folder / "hard/cornell_0.collected.h5"
        for _ in range(2):
            done = self.bake(*collect)
            self.assert_baked(done)
            failing = json.loads((self.folder / "report").read_text())["still_failing"]
            self.assertIn(f"hard/{shard.name}: {failing} of the {failing} functions that fail the check", done.stderr)
        said = self.run_tool("nlg-datagen", "info", "--json", f"hard/{shard.name}")
        self.assert_baked(said)
        self.assertEqual([json.loads(said.stdout)[key] for key in ("scene", "jitter", "functions", "visited_probes")], ["cornell_0", 0, failing, failing])
        self.assertGreater(failing, 0)
        # the scene's file is known by its geometry, as in other shards
        (self.folder / "room.obj").write_text(A_WALL, encoding="utf-8")
        self.assert_baked(self.run_tool("nlg-bake", "room.obj", *QUICK, "--tau-rmse", "1e-6", *collect))
        info = json.loads(self.run_tool("nlg-datagen", "info", "--json", "hard/room.collected.h5").stdout)
        self.assertEqual(info["origin"]["inputs"]["scene"], self.run_tool("nlg-datagen", "info", "--digest", "room.obj").stdout.split()[0])
        # what is no shard stays, and is refused before the bake
        shard.write_bytes(OTHERS["diary.txt"])
        self.assert_refused(self.bake(*collect), "--collect")
        shard.unlink()
        done = self.run_tool("nlg-bake", "cornell:0", *QUICK[:6], "--tau-rmse", "1", "--tau-blend", "1", *collect)
        self.assert_baked(done)
        self.assertIn("no function fails", done.stderr)
        self.assertFalse(shard.exists())
        for other in (["--draft"], ["--check", "grid"], ["--relight", "grid"]):
            done = self.bake("--collect", "hard", *other)
            self.assertEqual(done.returncode, USAGE_ERROR, done.stderr)
            self.assertIn(f"--collect cannot be combined with {other[0]}", done.stderr)

    def test_names_that_are_no_utf_8(self):
        name = "w\udce4nd.png"
        (self.folder / "room.obj").write_text("mtllib room.mtl\n" + A_WALL, encoding="utf-8")
        (self.folder / "room.mtl").write_text(f"newmtl m\nmap_Kd {name}\n", encoding="utf-8", errors="surrogateescape")
        done = self.run_tool("nlg-bake", "room.obj", *QUICK, "--inputs", "inputs", "--json", "report", "--out", "grid")
        self.assert_baked(done)
        inputs = json.loads((self.folder / "inputs").read_text(encoding="utf-8"))
        self.assertIn("\1./w\xe4nd.png", inputs)
        self.assert_baked(self.run_tool("nlg-bake", "room.obj", *QUICK, "--inputs", "inputs", "--json", "report", "--out", "grid"))

    def test_a_view_replaces_its_own_and_nobody_elses(self):
        view = lambda baselines="none": self.run_tool("nlg-view", "cornell:0", "--grid", "grid", "--baselines", baselines, "--truth-views", "0", "--truth-samples", "0", "--out", "page")
        self.assert_baked(self.bake("--out", "grid"))
        page = self.folder / "page"
        page.mkdir()
        (page / "method-acting.js").write_text("on stage", encoding="utf-8")
        self.assert_baked(view("valid-trilinear"))
        self.assertTrue((page / "method-valid-trilinear.js").exists())
        self.assert_baked(view())
        self.assertFalse((page / "method-valid-trilinear.js").exists(), "what a view before left")
        self.assertEqual((page / "method-acting.js").read_text(encoding="utf-8"), "on stage")
        for name in ("index.html", "viewer.js", "scene.js", "method-grid.js"):
            own = (page / name).read_bytes()
            (page / name).write_text("<html>mine</html>", encoding="utf-8")
            before = {path.name: path.read_bytes() for path in page.iterdir()}
            self.assert_refused(view(), "--out")
            self.assertEqual({path.name: path.read_bytes() for path in page.iterdir()}, before)
            (page / name).write_bytes(own)
        (self.folder / "diary.txt").write_bytes(OTHERS["diary.txt"])
        watch = lambda: self.run_tool("nlg-view", "cornell:0", "--watch", "--port", "0", "--grid", "diary.txt", "--out", "page")
        self.assert_refused(watch(), "--grid")
        (self.folder / "diary.txt").unlink()
        (page / "watch").mkdir()
        (page / "watch/settings.yaml").write_text("mine: 1\n", encoding="utf-8")
        self.assert_refused(watch(), "--out")
        self.assertEqual(os.listdir(page / "watch"), ["settings.yaml"])


if __name__ == "__main__":
    unittest.main()

#!/usr/bin/python3
"""nlg: it starts the tools of its folder, and in a checkout builds first what a tool needs. Without a network and without the real tools.

    nlg_test.py
"""
import os
import re
import shutil
import signal
import subprocess
import tempfile
import unittest
from pathlib import Path

SOURCES = Path(__file__).resolve().parents[2]
# "builds" nlg-bake
PROJECT = """cmake_minimum_required(VERSION 3.25)
project(small LANGUAGES NONE)
foreach(name TRAINING TESTS)
  option(NLG_BUILD_${name} "" ON)
endforeach()
add_custom_command(OUTPUT bin/nlg-bake COMMAND cp ${PROJECT_SOURCE_DIR}/bake.sh bin/nlg-bake DEPENDS ${PROJECT_SOURCE_DIR}/bake.sh)
add_custom_target(nlg-bake DEPENDS ${PROJECT_BINARY_DIR}/bin/nlg-bake)
file(MAKE_DIRECTORY ${PROJECT_BINARY_DIR}/bin)
"""


class InFolder(unittest.TestCase):
    def setUp(self):
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.folder = Path(folder.name)
        shutil.copy(SOURCES / "nlg", self.folder)

    def write(self, name, text):
        path = self.folder / name
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_text(text)
        path.chmod(0o755)

    def nlg(self, *arguments, **environment):
        outside = {key: value for key, value in os.environ.items() if key != "NLG_BIN"}
        return subprocess.run([self.folder / "nlg", *arguments], capture_output=True, text=True, cwd="/", env={**outside, **environment})


class Installed(InFolder):
    def setUp(self):
        super().setUp()
        self.write("nlg-bake", '#!/bin/sh\n[ "$1" != --die ] || kill -TERM $$\nprintf "%s|" "$@"\nexit 7\n')

    def test_starts_the_tool_of_its_folder_and_ends_as_it_does(self):
        result = self.nlg("bake", "a b", "--out=c", "")
        self.assertEqual((result.stdout, result.stderr, result.returncode), ("a b|--out=c||", "", 7))
        self.assertEqual(self.nlg("bake", "--die").returncode, -signal.SIGTERM)

    def test_refuses_what_is_no_command_in_one_line(self):
        for name in ("back", "view", "bake.*", "--bake", "../nlg-bake"):
            result = self.nlg(name)
            self.assertEqual((result.returncode, result.stdout), (2, ""))
            self.assertEqual(result.stderr, f"nlg: error: expected one of bake, got '{name}'\n")


class Checkout(InFolder):
    def setUp(self):
        super().setUp()
        for name in ("workflow/setup.sh", "CMakePresets.json"):
            (self.folder / name).parent.mkdir(exist_ok=True)
            shutil.copy(SOURCES / name, self.folder / name)
        self.write("cmake/packages.txt", "# packages\nhas-it\nlacks-it train\n")
        self.write("CMakeLists.txt", PROJECT)
        self.write("bake.sh", '#!/bin/sh\necho "$1 in $PWD"\n')
        self.write("system/dpkg-query", "#!/bin/sh\necho installed has-it\n")
        self.write("system/sudo", '#!/bin/sh\nexec "$@"\n')
        self.write("system/apt-get", '#!/bin/sh\necho "$@" >> "$0.log"\n[ "$1" = update ]\n')

    def nlg(self, *arguments):
        return super().nlg(*arguments, PATH=f"{self.folder}/system:{os.environ['PATH']}")

    def option(self, name):
        cache = (self.folder / "build/release/CMakeCache.txt").read_text()
        return next((line.partition("=")[2] for line in cache.splitlines() if line.startswith(name + ":")), None)

    def test_builds_what_a_bake_needs_and_nothing_else(self):
        result = self.nlg("bake", "level")
        self.assertEqual((result.returncode, result.stdout), (0, "level in /\n"), result.stderr)
        self.assertEqual([self.option("NLG_BUILD_" + name) for name in ("TRAINING", "TESTS")], ["OFF"] * 2)
        self.assertFalse((self.folder / "system/apt-get.log").exists())

    def test_knows_every_tool(self):
        built = {name for file in SOURCES.glob("*/CMakeLists.txt") for name in re.findall(r"nlg_tool\(nlg-([a-z]+)", file.read_text())}
        listed = set(re.findall(r"^  ([a-z]+) ", self.nlg("--help").stdout, flags=re.MULTILINE)) - {"completion", "compare"}  # no tools of their own
        self.assertEqual(listed, built)

    def test_builds_again_what_has_changed_without_a_word(self):
        self.nlg("bake")
        (self.folder / "cmake/packages.txt").unlink()  # nobody asks for packages now
        self.write("bake.sh", "#!/bin/sh\necho anew\n")
        result = self.nlg("bake")
        self.assertEqual((result.stdout, result.stderr, result.returncode), ("anew\n", "", 0))

    def test_keeps_what_the_build_was_configured_for(self):
        subprocess.run(["cmake", "--preset", "release", "-DNLG_BUILD_TRAINING=ON", "-DNLG_BUILD_TESTS=ON"], cwd=self.folder, capture_output=True, check=True)
        self.assertEqual(self.nlg("bake").returncode, 0)
        self.assertEqual([self.option("NLG_BUILD_" + name) for name in ("TRAINING", "TESTS")], ["ON", "ON"])

    def test_asks_for_the_packages_of_the_tool_alone(self):
        result = self.nlg("train")
        self.assertNotEqual(result.returncode, 0)
        self.assertEqual(result.stdout, "")
        self.assertEqual((self.folder / "system/apt-get.log").read_text().splitlines()[-1].split()[-1], "lacks-it")
        self.assertFalse((self.folder / "build/release").exists())
        self.nlg("export", "engine")
        self.assertEqual(len((self.folder / "system/apt-get.log").read_text().splitlines()), 2)


if __name__ == "__main__":
    unittest.main()

#!/usr/bin/python3
"""The packages: what they hold, and that a bake from them is that of the build. And README's commands in a clone.

    package_test.py BUILD CPACK VERSION archive   unpacked into an empty folder, in an environment without anything
    package_test.py BUILD CPACK VERSION training  the same of training: a whole run of next to nothing
    package_test.py BUILD CPACK VERSION debian    both installed on a bare Debian 12 that is made for this: a first bake, a linked program and
                                                  a first own generator, with their times; skipped where none can be made
    package_test.py BUILD CPACK VERSION clone     README's commands, as they stand there, in a clone of HEAD on another such Debian
"""
import os
import re
import shlex
import shutil
import subprocess
import sys
import tempfile
import unittest
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]
BUILD, CPACK, VERSION, KIND = Path(sys.argv[1]), sys.argv[2], sys.argv[3], sys.argv[4]
TOOLS = ["nlg-bake", "nlg-datagen", "nlg-export", "nlg-render", "nlg-view"]
OF_EVERY_DEBIAN = {"libc.so.6", "libm.so.6", "libgcc_s.so.1", "libstdc++.so.6", "libz.so.1", "ld-linux-x86-64.so.2"}
BAKE = ["courtyard.glb", "--sky", ".55,.75,1"]
# a run of next to nothing
SMALL = [f"--set={setting}" for setting in (
    "scenes.families=[clutter]", "scenes.per_family=2", "split.held_out=[clutter_1]", "datagen.max_functions=60", "basis.components=32", "train.steps=10", "representations=[tent_mlp4]",
    "validate.direct_functions=4", "frontier.functions=4", "report.savings=[]", "validate_light.scenes=[]")]


def output(*command, **options):
    result = subprocess.run(list(map(str, command)), stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True, **options)
    if result.returncode != 0:
        raise AssertionError(f"{command}: exit code {result.returncode}\n{result.stdout}")
    return result.stdout


def pack(generator, folder):
    """The package and the sample in a folder; returns the package, and the bytes of what the build bakes of the sample."""
    output(CPACK, "--config", BUILD / "CPackConfig.cmake", "-G", generator, "-B", folder / "packed")
    package, = (folder / "packed").glob("nlg*")
    shutil.copy(ROOT / "samples/courtyard.glb", folder)
    environment = {name: value for name, value in os.environ.items() if name != "NLG_WEIGHTS"}
    output(BUILD / "bin/nlg-bake", *BAKE, "--out", "built.safetensors", cwd=folder, env=environment)
    return package, (folder / "built.safetensors").read_bytes()


class Archive(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        folder = tempfile.TemporaryDirectory()
        cls.addClassCleanup(folder.cleanup)
        cls.folder = Path(folder.name)
        cls.package, cls.built = pack("TZST", cls.folder)
        empty = cls.folder / "an empty folder"
        empty.mkdir()
        output("cmake", "-E", "tar", "xf", cls.package, cwd=empty)
        cls.prefix, = empty.iterdir()

    def nlg(self, *arguments):
        return output(self.prefix / "bin/nlg", *arguments, cwd=self.folder, env={"PATH": "/usr/bin:/bin"})

    def entries(self, tool):
        return output("readelf", "-d", self.prefix / "bin" / tool)

    def test_bakes_what_the_build_bakes(self):
        self.assertIn(f"weights: {self.prefix}/share/neural-light-grid/weights/", self.nlg("bake", *BAKE, "--out", "packed.safetensors"))
        self.assertEqual((self.folder / "packed.safetensors").read_bytes(), self.built)
        self.nlg("export", "shader", "--grid", "packed.safetensors", "--format", "c-header", "--out", "engine")
        self.assertTrue(any((self.folder / "engine").iterdir()))

    def test_holds_the_tools_that_need_no_libtorch(self):
        self.assertIn(f"-{VERSION}-", self.package.name)
        self.assertEqual(sorted(path.name for path in (self.prefix / "bin").iterdir()), ["nlg", *TOOLS])
        self.assertEqual(re.findall(r"^  ([a-z]+) ", self.nlg("--help"), re.MULTILINE), ["bake", "view", "render", "datagen", "export", "completion"])
        for tool in TOOLS:
            self.assertNotIn("torch", self.entries(tool))

    def test_holds_nothing_of_the_machine_that_made_it(self):
        for path in filter(Path.is_file, self.prefix.rglob("*")):
            for place in (ROOT, BUILD):
                self.assertNotIn(str(place).encode(), path.read_bytes(), path)
        for tool in TOOLS:
            self.assertNotRegex(self.entries(tool), r"\((RPATH|RUNPATH)\)")

    def test_holds_the_licences_of_what_is_compiled_in(self):
        doc = self.prefix / "share/doc/nlg"
        self.assertEqual((doc / "copyright").read_text(), (ROOT / "LICENSE").read_text())
        wanted = re.findall(r"^(\S+-dev)$", (ROOT / "cmake/packages.txt").read_text(), re.MULTILINE)
        self.assertIn("libhwy-dev", wanted)
        self.assertEqual({path.name for path in (doc / "licences").iterdir()}, {*wanted, "three.js", "Apache-2.0"})

    def test_holds_the_module_for_python(self):
        made = output("/usr/bin/python3", "-c", "import nlg; print(nlg.__file__)", cwd="/", env={"PYTHONPATH": str(self.prefix / "lib/python3/dist-packages")})
        self.assertTrue(made.startswith(str(self.prefix)), made)

    def test_the_guide_names_the_packages_that_the_tools_need(self):
        libraries = {name for tool in TOOLS for name in re.findall(r"NEEDED.*\[(.*)\]", self.entries(tool))} - OF_EVERY_DEBIAN
        places = dict(re.findall(r"^\t(\S+) \(libc6,.*\) => (\S+)", output("/sbin/ldconfig", "-p"), re.MULTILINE))
        needed = {output("dpkg", "-S", os.path.realpath(places[name])).split(":")[0] for name in libraries}
        line, = re.findall(r"^apt install (lib.*)$", (ROOT / "docs/guide/install.md").read_text(), re.MULTILINE)
        self.assertEqual(sorted(line.split()), sorted(needed))


def training():
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        output(CPACK, "--config", BUILD / "CPackTraining.cmake", "-G", "TZST", "-B", folder / "packed")
        package, = (folder / "packed").glob("nlg-training*")
        output("cmake", "-E", "tar", "xf", package, cwd=folder)
        prefix, = folder.glob("nlg-training-*")
        home = prefix / "lib/nlg-training"
        for path in filter(Path.is_file, prefix.rglob("*")):
            assert str(ROOT).encode() not in path.read_bytes(), path
        output(home / "pipeline.sh", *SMALL, "configs/smoke.yaml", cwd=home, env={"PATH": "/usr/bin:/bin", "NLG_OUT": str(folder / "out")})
        assert (folder / "out/smoke/weights/tent_mlp4.safetensors").stat().st_size > 0 and (folder / "out/smoke/report.html").exists()


def bare_debian(folder, copied, wrong):
    """Runs folder/install.sh beside what is copied on a system from nothing, which goes with the command that makes it; its mounts are in a
    namespace of their own. The file "kept" that the script leaves there is then in the folder."""
    if os.geteuid() != 0 or not shutil.which("mmdebstrap"):
        skip("needs root and mmdebstrap")
    hooks = [f"touch {folder}/made", f"cp -r {' '.join(map(str, copied))} {folder}/install.sh $1/root", 'chroot "$1" bash /root/install.sh', f"cp $1/root/kept {folder}"]
    result = subprocess.run(["mmdebstrap", "--variant=apt", "--format=null", *("--customize-hook=" + hook for hook in hooks), "bookworm", "/dev/null"],
                            stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True)
    if not (folder / "made").exists():
        skip("no bare Debian 12 can be made here: " + result.stdout.strip().splitlines()[-1])
    print(result.stdout)
    assert result.returncode == 0, wrong


TOOK = """set -e
            export DEBIAN_FRONTEND=noninteractive
            cd /root
            SECONDS=0
            took() { echo "took: $SECONDS s to $1"; }
            apt-get update -q
"""


def debian():
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        package, built = pack("DEB", folder)
        output(CPACK, "--config", BUILD / "CPackTraining.cmake", "-G", "DEB", "-B", folder / "training")
        training_package, = (folder / "training").glob("nlg-training*.deb")
        (folder / "install.sh").write_text(TOOK + f"""
            apt-get install -q -y ./{package.name}
            took "the package installed"
            nlg bake {' '.join(BAKE)}
            took "the first bake"
            nlg view {' '.join(BAKE)} --grid courtyard.safetensors --truth-views 1 --truth-width 64 --truth-rays 8 --truth-samples 16
            test -s courtyard/index.html
            took "its page"
            cp courtyard.safetensors kept
            apt-get install -q -y cmake g++ libhwy-dev make
            cmake -S examples -B program && cmake --build program
            program/bake_minimal /usr/share/neural-light-grid/weights/tent_mlp4.safetensors
            program/bake_minimal_c /usr/share/neural-light-grid/weights/tent_mlp4.safetensors
            took "a linked program"
            apt-get purge -q -y nlg
            if find / -xdev -path '*nlg*' -not -path '/root/*' -o -path '*neural-light-grid*' | grep .; then exit 1; fi
            apt-get install -q -y ./{training_package.name}
            cp -r /usr/lib/nlg-training training
            training/pipeline.sh {' '.join(SMALL)} training/configs/smoke.yaml
            test -s training/out/smoke/weights/tent_mlp4.safetensors
            took "a first own generator"
            """)
        bare_debian(folder, [package, training_package, ROOT / "examples", folder / "courtyard.glb"], "the package does not install, bake and go")
        assert (folder / "kept").read_bytes() == built, "another light grid than the build's"


def clone():
    sys.path.insert(0, str(ROOT / "tests/pipeline"))
    from own_levels_test import SMALL as LITTLE, room
    text = (ROOT / "README.md").read_text().split("\n# Reference\n")[0]
    lines = [line.split(" #")[0].strip() for block in re.findall(r"```sh\n(.*?)```", text, flags=re.DOTALL) for line in block.splitlines()]
    names = {"LEVELS": "levels", "LEVEL.glb": "levels/room0.obj"}
    # a run of next to nothing, and a page that is not watched for changes until somebody stops it
    little = " ".join(f"'--set={setting}'" for setting in LITTLE if not setting.startswith(("scenes.", "representations"))) + " '--set=representations={tent_mlp4: {}}'"
    # ./test.sh is what CI runs in a clone
    lines = [re.sub(r"\b(LEVELS|LEVEL\.glb)\b", lambda found: names[found[1]], line) for line in lines if "--watch" not in line and line != "./test.sh"]
    assert sum("pipeline.sh" in line for line in lines) == 3 and sum("nlg" in line for line in lines) >= 4, lines
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        output("git", "clone", "--quiet", "--depth=1", ROOT.as_uri(), folder / "repository")
        (folder / "levels").mkdir()
        for seed in range(6):
            (folder / f"levels/room{seed}.obj").write_text(room(seed))
        shutil.copy(ROOT / "samples/courtyard.glb", folder / "level.glb")
        output(BUILD / "bin/nlg-bake", "level.glb", "--out", "built.safetensors", cwd=folder, env={name: value for name, value in os.environ.items() if name != "NLG_WEIGHTS"})
        commands = "\n".join(re.sub(r"^\./pipeline\.sh", f"./pipeline.sh {little}", line) + f"\ntook {shlex.quote(line)}" for line in lines)
        (folder / "install.sh").write_text(TOOK + f"""
            cd repository
            mv ../levels ../level.glb .
            {commands}
            test -s level/index.html && test -s kitchen/index.html && test -s out/default/report.html && test -s out/levels/report.html && test -s room0.safetensors
            mv level.safetensors ../kept
            """)
        bare_debian(folder, [folder / "repository", folder / "levels", folder / "level.glb"], "README's commands fail in a clone")
        tensors = lambda data: data[8 + int.from_bytes(data[:8], "little"):]  # behind the header, which names the revision
        assert tensors((folder / "kept").read_bytes()) == tensors((folder / "built.safetensors").read_bytes()), "another light grid than the build's"


def skip(reason):
    print("skipped:", reason)
    sys.exit(77)


if __name__ == "__main__":
    if KIND == "debian":
        debian()
    elif KIND == "clone":
        clone()
    elif KIND == "training":
        training()
    else:
        unittest.main(argv=sys.argv[:1])

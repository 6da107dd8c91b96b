"""What tests of the tools share: calls, exit codes, what a refusal looks like, and claims that are counted."""
import os
import shlex
import shutil
import struct
import subprocess
import sys
import tempfile
import zlib

USAGE_ERROR, INPUT_ERROR, NUMERICAL_ERROR, OUTPUT_ERROR, CHECK_FAILED, DAMAGED_FILE = 2, 3, 4, 5, 6, 7  # tool/error.h

SOURCES = os.path.dirname(os.path.dirname(os.path.abspath(__file__)))
SECONDS = 60 * float(os.environ.get("NLG_TEST_TIMEOUT_FACTOR", "1"))  # of one call; sanitizers slow everything down
LONGEST_LINE = 4200  # bytes of an error, whatever a file or a command line holds
NAME_COMMANDS = ("nlg-datagen", "nlg-export", "nlg-validate")  # in their errors: "nlg-datagen info: error: "


def words_of(command):
    return shlex.split(command) if isinstance(command, str) else [str(word) for word in command]


class Tools:
    """The tools of a build, and the claims about them that do not hold."""

    def __init__(self, folder, form="whole"):
        """form   whole, or short: of what `few` is given one item in turn, instead of all"""
        self.folder, self.is_short = os.path.abspath(folder), form == "short"
        self.cases, self.turn, self.failures = 0, 0, []

    def check(self, holds, claim):
        if not holds:
            self.failures.append(claim)

    def few(self, items):
        """All of them, or in the short form one: the next at every call."""
        items = list(items)
        self.turn += 1
        return [items[self.turn % len(items)]] if self.is_short else items

    def run(self, command, **more):
        """A call of a tool, or of any program, that is named by a text or by a list of words."""
        words = words_of(command)
        if words[0].startswith("nlg-"):
            words[0] = os.path.join(self.folder, words[0])
        return subprocess.run(words, **{"capture_output": True, "text": True, "timeout": SECONDS, **more})

    def must(self, command, **more):
        """What the tool prints; it has to succeed."""
        result = self.run(command, **more)
        if result.returncode != 0:
            sys.exit(f"{' '.join(words_of(command))}: exit code {result.returncode}\n{result.stderr}")
        return result.stdout

    def refuses(self, exit_code, names, command, keeps=(), **more):
        """It ends with this code and one line that holds every text of `names` (a text, or a list), and leaves nothing but what it `keeps`."""
        self.cases += 1
        words, before = words_of(command), set(os.listdir("."))
        try:
            result = self.run(words, **more)
        except subprocess.TimeoutExpired as expired:
            self.failures.append(f"{' '.join(words)}: still running after {expired.timeout} s")
            return
        said = f"{' '.join(words)}: exit code {result.returncode}, expected {exit_code}\n    {result.stderr.strip()[-600:]}"
        has_command = words[0] in NAME_COMMANDS and len(words) > 1 and not words[1].startswith("-")
        begins = f"{' '.join(words[:1 + has_command])}: error: " if words[0].startswith("nlg-") else ""
        self.check(result.returncode == exit_code, said)
        self.check(len(result.stderr.splitlines()) == 1 and len(result.stderr) < LONGEST_LINE and result.stderr.startswith(begins), f"expected one line, '{begins}…': {said}")
        for name in [names] if isinstance(names, str) else names:
            self.check(name in result.stderr, f"'{name}' is not named: {said}")
        for path in set(os.listdir(".")) - before - set(keeps):
            self.failures.append(f"left {path} behind: {said}")
            shutil.rmtree(path) if os.path.isdir(path) else os.remove(path)

    def end(self):
        """Says what did not hold; the exit code of a test."""
        for failure in self.failures:
            print("FAILED:", failure)
        print(f"{self.cases} cases, {len(self.failures)} failures")
        return 1 if self.failures else 0


def run_checks(tools, checks, start=None):
    """Each check in turn in one folder for all, which begins as a copy of `start`; the exit code of a test."""
    for variable in ("OPENBLAS_NUM_THREADS", "OMP_NUM_THREADS"):
        os.environ[variable] = "1"
    with tempfile.TemporaryDirectory() as folder:
        if start:
            shutil.copytree(start, folder, dirs_exist_ok=True, symlinks=True)
        os.chdir(folder)
        for check in checks:
            check(tools)
        os.chdir("/")
    return tools.end()


def write(path, content):
    with open(path, "wb" if isinstance(content, bytes) else "w") as file:
        file.write(content)
    return path


def read(path):
    with open(path, "rb") as file:
        return file.read()


def box(low, high, is_room):
    """Twelve triangles of a box, which face inward for a room and outward for what stands in it."""
    corners = [[(low, high)[bits >> axis & 1][axis] for axis in range(3)] for bits in range(8)]
    faces = [(0, 2, 3, 1), (4, 5, 7, 6), (0, 1, 5, 4), (2, 6, 7, 3), (0, 4, 6, 2), (1, 3, 7, 5)]
    return corners, [tuple(reversed(face)) if is_room else face for face in faces]


def room(seed):
    """A room with a wall that leaves a door, as an OBJ file."""
    width, depth = 4 + seed % 3, 5 + seed % 2
    lines, first = [], 1
    for low, high, is_room in [((0, 0, 0), (width, 2.6, depth), True), ((0, 0, 2 + 0.1 * seed), (width - 1.1, 2.6, 2.2 + 0.1 * seed), False)]:
        corners, faces = box(low, high, is_room)
        lines += [f"v {x} {y} {z}" for x, y, z in corners]
        lines += ["f " + " ".join(str(first + i) for i in face) for face in faces]
        first += 8
    return "\n".join(lines) + "\n"


def png(rgba, side=2):
    row = b"\0" + bytes(rgba) * side
    chunk = lambda kind, data: struct.pack(">I", len(data)) + kind + data + struct.pack(">I", zlib.crc32(kind + data))
    return b"\x89PNG\r\n\x1a\n" + chunk(b"IHDR", struct.pack(">IIBBBBB", side, side, 8, 6, 0, 0, 0)) + chunk(b"IDAT", zlib.compress(row * side)) + chunk(b"IEND", b"")

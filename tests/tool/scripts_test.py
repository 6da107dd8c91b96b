#!/usr/bin/python3
"""What the Python scripts share: files that are whole or not there, input that is refused in one line, the ends of a script.

    scripts_test.py
"""
import os
import signal
import socket
import subprocess
import sys
import tempfile
import unittest
from pathlib import Path

sys.dont_write_bytecode = True
SOURCES = Path(__file__).resolve().parents[2]
sys.path.insert(0, str(SOURCES))
from tool.atomic_file import write_atomically
from tool.errors import InputError, OutputError
from tool.input_file import parse_number, read_bytes, read_columns, read_json, read_text


class InFolder(unittest.TestCase):
    def setUp(self):
        self.folder = tempfile.TemporaryDirectory()
        self.addCleanup(self.folder.cleanup)
        self.path = os.path.join(self.folder.name, "data")

    def left(self):
        return sorted(os.listdir(self.folder.name))


class AtomicFile(InFolder):
    def temporary(self, process, host=None):
        return f"{self.path}.tmp.{host or socket.gethostname()}.{process}.0"

    def ended_process(self):
        process = subprocess.Popen(["/bin/true"])
        process.wait()
        return process.pid

    def test_replaces_the_old_file_whole(self):
        write_atomically(self.path, b"a longer old text")
        write_atomically(self.path, b"new")
        self.assertEqual(read_bytes(self.path), b"new")
        self.assertEqual(self.left(), ["data"])

    def test_removes_what_ended_processes_of_this_machine_left_and_nothing_else(self):
        stale, foreign = self.temporary(self.ended_process()), self.temporary(self.ended_process(), "elsewhere")
        alive, of_another_file, odd = self.temporary(os.getpid()), f"{self.path}2.tmp.{socket.gethostname()}.{self.ended_process()}.0", self.temporary("x")
        for path in (stale, foreign, alive, of_another_file, odd):
            Path(path).write_bytes(b"half")
        write_atomically(self.path, b"new")
        self.assertEqual(self.left(), sorted(map(os.path.basename, (self.path, foreign, alive, of_another_file, odd))))

    def test_leaves_no_temporary_for_ever_after_a_kill(self):
        text = "import os, signal; os.fsync = lambda file: os.kill(os.getpid(), signal.SIGKILL); from tool.atomic_file import write_atomically; write_atomically(%r, b'new')" % self.path
        write_atomically(self.path, b"old")
        killed = subprocess.run([sys.executable, "-B", "-c", text], cwd=SOURCES)
        self.assertEqual(killed.returncode, -signal.SIGKILL)
        self.assertEqual(read_bytes(self.path), b"old")
        self.assertEqual(len(self.left()), 2, "the kill came too late: nothing was tested")
        write_atomically(self.path, b"new")
        self.assertEqual(self.left(), ["data"])

    def test_refuses_to_replace_a_link_a_folder_or_a_pipe(self):
        os.mkdir(self.path + "folder")
        os.mkfifo(self.path + "pipe")
        os.symlink("nowhere", self.path + "link")
        for kind in ("folder", "pipe", "link"):
            with self.assertRaisesRegex(OutputError, f"^{self.path}{kind}: cannot be written: it "):
                write_atomically(self.path + kind, b"new")
        self.assertEqual(len(self.left()), 3)

    def test_leaves_nothing_where_the_disk_is_full(self):
        text = ("import resource, signal; signal.signal(signal.SIGXFSZ, signal.SIG_IGN); resource.setrlimit(resource.RLIMIT_FSIZE, (1000, 1000));"
                "from tool.atomic_file import write_atomically; from tool.errors import run; import sys; sys.exit(run('x', lambda: write_atomically(%r, bytes(5000))))" % self.path)
        result = subprocess.run([sys.executable, "-B", "-c", text], cwd=SOURCES, capture_output=True, text=True)
        self.assertEqual((result.returncode, self.left()), (5, []))
        self.assertEqual(result.stderr, f"x: error: {self.path}: cannot be written: File too large\n")


class InputFile(InFolder):
    def write(self, content):
        Path(self.path).write_bytes(content if isinstance(content, bytes) else content.encode())
        return self.path

    def refuses(self, content, read, words):
        with self.assertRaises(InputError, msg=repr(content)[:60]) as caught:
            read(self.write(content))
        line = str(caught.exception)
        self.assertTrue(line.startswith(self.path) and words in line, line[:300])
        line.encode()  # can be printed

    def test_refuses_json_that_no_reader_can_hold(self):
        for content, words in [("", "line 1, column 1"), ('{"a": [1,', "line 1"), (b"\xff\xfe", "UTF-8"), ("[" * 100000, "nested"), ('{"a":' * 50000, "nested"), ("NaN", "NaN"),
                               ("-Infinity", "-Infinity"), ("1e999", "finite"), ("9" * 400, "400 digits"), ("9" * 5000, "5000 digits"), ("18446744073709551616", "64 bits"),
                               ('{"a": ["\\ud800"]}', "a.0: expected whole characters"), ('{"\\udfff": 1}', "whole characters"), ("\ufeff{}", "BOM")]:
            self.refuses(content, read_json, words)
        taken = read_json(self.write('{"a": "\\ud83d\\ude00 \\\\ud800", "b": 18446744073709551615}'))
        self.assertEqual((taken["a"].text(), taken["b"].count()), ("\U0001f600 \\ud800", 2**64))

    def test_refuses_tables_that_are_none(self):
        read = lambda path: [parse_number(path, line, "b", row[1]) for line, row in read_columns(path, ["a", "b"])]
        for content, words in [("", "line 1"), ("a,c\n1,2\n", "line 1"), ("a,b\n", "line 2"), ("a,b\n1\n", "line 2"), ("a,b\n1,2,3\n", "line 2"), ("a,b\n1,nan\n", "line 2, column b"),
                               ("a,b\n1,1e999\n", "line 2, column b"), ("a,b\n1," + "9" * 400 + "\n", "line 2, column b"), ("a,b\n1,2\n1,x\n", "line 3, column b"), ('a,b\n1,"\n', "line 2"),
                               ("a,b\n1," + "9" * 200000 + "\n", "line 2"), (b"a,b\n1,\xff\n", "UTF-8"), (b"a,b\n1,\0\n", "line 2")]:
            self.refuses(content, read, words)
        self.assertEqual(read(self.write('a,b\r\n"x\ny",2\r\n')), [2.0])

    def test_reads_regular_files_alone_and_waits_for_none(self):
        os.mkfifo(self.path)
        for path, words in [(self.path, "got a pipe"), ("/dev/zero", "got a device"), (self.folder.name, "got a directory"), (self.path + "0", "No such file"), ("a\0b", "a file's name")]:
            for read in (read_bytes, read_text, read_json):
                with self.assertRaisesRegex(InputError, words):
                    read(path)


class Ends(unittest.TestCase):
    def end(self, text):
        result = subprocess.run([sys.executable, "-B", "-c", f"import sys; from tool.errors import *; sys.exit(run('x', lambda: {text}))"], cwd=SOURCES, capture_output=True, text=True)
        return result.returncode, result.stderr

    def test_every_error_is_one_line_and_its_code(self):
        throw = "(_ for _ in ()).throw({})"
        for error, code, words in [("InputError('f', 'p', 'a', 'b')", 3, "x: error: f: p: expected a, got b\n"), ("UsageError('f', 'a', 'b')", 2, "f: expected a, got b"),
                                   ("OutputError('f', 'no')", 5, "f: cannot be written: no"), ("InputError('a\\nb\\x1b[31m', 'p', 'a\\ud800', 'b')", 3, "a b [31m"),
                                   ("MemoryError()", 1, "out of memory"), ("KeyError('k')", 1, "a bug of ours")]:
            found, line = self.end(throw.format(error))
            self.assertEqual((found, line.count("\n")), (code, 1), line)
            self.assertIn(words, line)
        self.assertEqual(self.end("None"), (0, ""))
        self.assertEqual(self.end("6"), (6, ""))


if __name__ == "__main__":
    unittest.main()

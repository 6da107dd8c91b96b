"""Tools at work: their processes, one after another, how far they are, and what they said."""

import json
import os
import re
import subprocess
import threading

from .errors import ToolError

PREFIX = re.compile(r"^nlg-\w+: [^:]*: ")  # before notes: the tool and the scene
ERROR = re.compile(r"nlg-\w+(?: [a-z]+)?: error: (?P<sentence>.*)")


class Job:
    def __init__(self, commands, folder):
        """commands   lists of words; the first that fails is the last
        folder     that they run in
        """
        self.stage, self.percent = "", 0.0
        self.notes = []  # what they said to people, a line each
        self.output = ""  # of the last
        self.exit_code = 0
        self.is_cancelled = False
        self._commands, self._folder = commands, folder
        self._process, self._lock = None, threading.Lock()
        self._error = ""
        self._thread = threading.Thread(target=self._run, daemon=True)
        self._thread.start()

    @property
    def is_running(self):
        return self._thread.is_alive()

    def wait(self):
        self._thread.join()

    def cancel(self):
        """Ends what is at work. What it would have written is not there."""
        with self._lock:
            self.is_cancelled = True
            if self._process is not None:
                self._process.terminate()

    def check(self, *expected):
        """throws   ToolError in the tool's own words, where one failed with another exit code than `expected`"""
        if self.exit_code not in (0, *expected):
            raise ToolError(self._error or f"{os.path.basename(self._commands[0][0])} ended with {self.exit_code}")

    def _run(self):
        for command in self._commands:
            try:
                self._run_one(command)
            except OSError as error:
                self.exit_code, self._error = 1, f"{command[0]}: {error.strerror}"
            if self.exit_code != 0 or self.is_cancelled:
                break

    def _run_one(self, command):
        with self._lock:
            if self.is_cancelled:
                return
            self._process = subprocess.Popen(
                command, cwd=self._folder, env={**os.environ, "NLG_PROGRESS": "json"}, stdin=subprocess.DEVNULL,
                stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True, encoding="utf-8", errors="replace",
            )
        # both at once: either may fill its pipe
        printed = []
        reader = threading.Thread(target=lambda: printed.append(self._process.stdout.read()), daemon=True)
        reader.start()
        for line in self._process.stderr:
            self._hear(line.rstrip())
        reader.join()
        self.exit_code = self._process.wait()
        self.output = printed[0]

    def _hear(self, line):
        if line.startswith('{"'):
            said = json.loads(line)
            self.stage, self.percent = said["stage"], 100.0 * said.get("done", 0) / max(1, said.get("of", 1))
        elif match := ERROR.match(line):
            self._error = match["sentence"]
        elif line and not line.startswith("weights: "):
            self.notes.append(PREFIX.sub("", line))

"""What a run has made: size, time and SHA-256 of every file that a rule finished, in RUN/artefacts.json.

A file that is another one although its time is the same was damaged. Shards and function caches are left out: they name their own
digests, which their readers compare, and are most of a run's bytes.
"""
import hashlib
import json
import os
import sys
from pathlib import Path

sys.path.insert(0, str(Path(__file__).resolve().parents[1]))  # tool/, which all scripts share
from tool.atomic_file import write_atomically
from tool.errors import InputError, OutputError
from tool.input_file import as_documented, read_bytes
from tool.regular_file import regular

NAME = "artefacts.json"
SCHEMA_VERSION = 1


def sha256_of(path):
    with open(path, "rb", opener=regular) as file:
        return hashlib.file_digest(file, "sha256").hexdigest()


def names_its_digest(relative_path):
    return relative_path.startswith("dataset" + os.sep) or relative_path.endswith(".cache")


def state_of(path):
    """What is recorded of a file."""
    status = os.stat(path)
    return {"bytes": status.st_size, "mtime_ns": status.st_mtime_ns, "sha256": sha256_of(path)}


def files_of(paths):
    """The paths, and for each that is a folder those of what is in it."""
    for path in paths:
        if os.path.isdir(path) and not os.path.islink(path):
            yield from (os.path.join(folder, name) for folder, _, names in sorted(os.walk(path)) for name in sorted(names))
        else:
            yield path


def digest_of(files):
    return hashlib.sha256(json.dumps(files, sort_keys=True).encode()).hexdigest()


class Artefacts:
    """The record of a run's folder. Paths in it are relative to the folder.

    fault   why an earlier record says nothing; empty where it is whole or there is none
    """

    def __init__(self, folder):
        self.folder, self.path, self.fault = folder, os.path.join(folder, NAME), ""
        self.files = self._read()
        # one that says nothing is written anew, whatever is in it
        self.written = None if self.fault else dict(self.files)

    def _read(self):
        if not os.path.lexists(self.path):
            return {}
        try:
            with as_documented(self.path):
                found = json.loads(read_bytes(self.path))
                if found["schema_version"] == SCHEMA_VERSION and found["sha256"] == digest_of(found["files"]):
                    return found["files"]
                self.fault = f"{self.path}: damaged, or of another schema version than {SCHEMA_VERSION}"
        except InputError as error:
            self.fault = f"{error}: damaged"
        return {}

    def take(self, paths):
        """Records files, and all files in folders, as they are now; what is no regular file of the run's folder is left out."""
        for path in files_of(paths):
            relative = os.path.relpath(path, self.folder)
            if not relative.startswith(os.pardir) and not names_its_digest(relative) and os.path.isfile(path):
                self.files[relative] = state_of(path)

    def write_if_changed(self):
        if self.files == self.written:
            return
        record = {"schema_version": SCHEMA_VERSION, "files": self.files, "sha256": digest_of(self.files)}
        write_atomically(self.path, json.dumps(record, indent=1, sort_keys=True).encode())
        self.written = dict(self.files)


class Recorder:
    """A log handler of snakemake's: records what each job has made as soon as the job is done."""

    def __init__(self, folder):
        self.artefacts, self.outputs = Artefacts(folder), {}

    def __call__(self, event):
        if event["level"] == "job_info":
            self.outputs[event["jobid"]] = event["output"]
        elif event["level"] == "job_finished":
            made = self.outputs.pop(event["jobid"], [])
            try:
                self.artefacts.take(made)
                self.artefacts.write_if_changed()
            except (OSError, OutputError) as error:
                # the files themselves are there: a later run judges them by themselves
                print(f"artefacts: {', '.join(made)}: not recorded: {error}", file=sys.stderr)

"""What a run has made: size, time and SHA-256 of every file that a rule finished, in RUN/artefacts.json.

A file that is another one although its time is the same was damaged. Shards and function caches are left out: they name their own
digests, which their readers compare, and are most of a run's bytes.
"""
import hashlib
import json
import os
import sys

NAME = "artefacts.json"
SCHEMA_VERSION = 1


def sha256_of(path):
    with open(path, "rb") as file:
        return hashlib.file_digest(file, "sha256").hexdigest()


def names_its_digest(relative_path):
    return relative_path.startswith(("dataset" + os.sep, "plan" + os.sep)) or relative_path.endswith(".cache")


def state_of(path):
    """What is recorded of a file."""
    status = os.stat(path)
    return {"bytes": status.st_size, "mtime_ns": status.st_mtime_ns, "sha256": sha256_of(path)}


def digest_of(files):
    return hashlib.sha256(json.dumps(files, sort_keys=True).encode()).hexdigest()


class Artefacts:
    """The record of a run's folder. Paths in it are relative to the folder.

    fault   why an earlier record says nothing; empty where it is whole or there is none
    """

    def __init__(self, folder):
        self.folder, self.path, self.fault = folder, os.path.join(folder, NAME), ""
        self.files = self._read()
        self.written = dict(self.files)

    def _read(self):
        try:
            with open(self.path, encoding="utf-8") as file:
                found = json.load(file)
            if found["schema_version"] != SCHEMA_VERSION:
                self.fault = f"{self.path}: of schema version {found['schema_version']}, expected {SCHEMA_VERSION}"
            elif found["sha256"] != digest_of(found["files"]):
                self.fault = f"{self.path}: damaged: its SHA-256 is that of other entries"
            else:
                return found["files"]
        except FileNotFoundError:
            pass
        except (ValueError, KeyError, TypeError, RecursionError) as error:
            self.fault = f"{self.path}: damaged: {' '.join(str(error).split())}"
        return {}

    def take(self, paths):
        """Records files as they are now; what is no regular file of the folder is left out."""
        for path in paths:
            relative = os.path.relpath(path, self.folder)
            if not relative.startswith(os.pardir) and not names_its_digest(relative) and os.path.isfile(path):
                self.files[relative] = state_of(path)

    def write_if_changed(self):
        if self.files == self.written:
            return
        temporary = f"{self.path}.tmp.{os.getpid()}"
        with open(temporary, "w", encoding="utf-8") as file:
            json.dump({"schema_version": SCHEMA_VERSION, "files": self.files, "sha256": digest_of(self.files)}, file, indent=1, sort_keys=True)
            file.flush()
            os.fsync(file.fileno())
        os.replace(temporary, self.path)
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
            except OSError as error:
                # the files themselves are there: a later run takes them as they are then
                print(f"artefacts: {', '.join(made)}: not recorded: {error}", file=sys.stderr)

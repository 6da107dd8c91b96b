"""Compares what lies in a run's folder with what the run made, and puts aside what is another, so that the workflow makes it again.

    check_artefacts.py CONFIG BIN_FOLDER [--prune]

A file whose bytes are not those of its record (origins.py) was damaged, or is somebody else's: it becomes NAME.damaged, and nothing is deleted.
What has no record is left to the workflow, which makes it again. Shards that lie in the data's folder and are of no run are named, and
with --prune removed, with their records.

Touches only what the configuration names, inside the run's own folders: a path that leads out of them through a link stays as it is. Why
something is made again is said on stderr. Exit codes are those of the tools: 2 on a configuration that cannot be used; 3 when a file cannot
be judged (permission denied, another kind of file), and then nothing was moved.
"""
import argparse
import collections
import os
import subprocess
import sys
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

import configuration
import tool.errors
from origins import digest_of, read_record, record_path, revision_of
from tool.errors import InputError, OutputError, ToolError, one_line


def say(line):
    print(f"check_artefacts: {one_line(line)}", file=sys.stderr)


def is_own(folder, path):
    """Whether a path lies where it says: no link between the results' folder and the file, nor the file itself."""
    root = os.path.dirname(os.path.abspath(folder))
    return os.path.realpath(path) == os.path.join(os.path.realpath(root), os.path.relpath(path, root))


def free_name(path):
    """Where a damaged file goes: earlier ones stay."""
    names = [f"{path}.damaged", *(f"{path}.damaged.{number}" for number in range(2, 1000))]
    return next(name for name in names if not os.path.lexists(name))


def digest(path):
    """… or the error that kept it from being read."""
    try:
        return digest_of(path)
    except OSError as error:
        return InputError(path, "file", "a readable file", error.strerror or error)


def other_files(run):
    """Shards of the data's folder that are none of the run's."""
    own = {os.path.abspath(path) for split in configuration.SPLITS for path in run.shards(split)}
    return sorted(str(path) for path in Path(run.data_folder, "dataset").glob("*/*.h5") if os.path.abspath(path) not in own)


def remove_others(run, prune):
    others = other_files(run)
    if others and not prune:
        say(f"{len(others)} shards in {run.data_folder}/dataset are of no run, and count for nothing; --prune removes them: {configuration.listed(others, 3)}")
    for path in others if prune else ():
        os.remove(path)
        if os.path.lexists(record_path(run.data_folder, path)):
            os.remove(record_path(run.data_folder, path))
        say(f"{path}: removed")


def check(run, tools, prune=False):
    made = dict.fromkeys([*(shard for split in configuration.SPLITS for shard in run.shards(split)), *run.artefacts(), *run.picture_folders()])
    folder_of = lambda path: next(folder for folder in (run.folder, run.data_folder) if os.path.abspath(path).startswith(os.path.join(os.path.abspath(folder), "")))
    there = {}
    for path in filter(os.path.lexists, made):
        if not is_own(folder_of(path), path):
            say(f"{path} is reached through a link: not touched")
            continue
        there[path] = read_record(folder_of(path), path)
    recorded = [path for path, record in there.items() if record]
    if len(recorded) < len(there):
        say(f"nothing says what {len(there) - len(recorded)} files were made of; they are made again")
    with ThreadPoolExecutor(os.cpu_count()) as pool:
        digests = dict(zip(there, pool.map(digest, there)))
    for error in (found for found in digests.values() if isinstance(found, InputError)):
        raise error
    for path in recorded:
        if digests[path] != there[path]["sha256"]:
            aside = free_name(path)
            os.rename(path, aside)
            say(f"{path}: other bytes than the run made; moved to {aside}; it will be made again")
    revision = revision_of(tools)
    for other, count in collections.Counter(there[path]["tools"] for path in recorded if there[path]["tools"] != revision).items():
        say(f"{count} files were made by tools of revision {other}, these are {revision}: they stay; without {run.folder} all is made again")
    remove_others(run, prune)


def main():
    parser = argparse.ArgumentParser(prog="check_artefacts.py")
    parser.add_argument("config")
    parser.add_argument("tools")
    parser.add_argument("--prune", action="store_true")
    arguments = parser.parse_args()
    run = configuration.load(arguments.config)
    try:
        check(run, arguments.tools, arguments.prune)
    except (OSError, subprocess.CalledProcessError) as error:
        raise OutputError(getattr(error, "filename", None) or arguments.tools, getattr(error, "strerror", None) or error) from None
    except RuntimeError as error:  # of threads that the system refuses
        raise ToolError(str(error)) from None


if __name__ == "__main__":
    sys.exit(tool.errors.run("check_artefacts", main))

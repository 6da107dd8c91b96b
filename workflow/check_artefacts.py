"""Verifies what a run has made and puts aside what is proven damaged, so that the workflow makes it again.

    check_artefacts.py CONFIG BIN_FOLDER

Shards prove by their own digests what they are. Every other file is compared with the record of the run (artefacts.py): one that is
another although its time is the same is damaged. One that is newer than its record, or has none, must prove itself as far as its kind
can: bases, checkpoints and weights by their digests, JSON by being JSON, tables, pages and pictures by their ends. Nobody but the run
makes tables, pages and pictures: one that is not as recorded is made again.

Touches only what the configuration names, inside the run's own folder: a path that leads out of it through a link stays as it is, and
so does every other file that lies there. A damaged file becomes NAME.damaged: nothing is deleted. Prints the files to make
again on stdout, one a line; why, on stderr. Exit codes are those of the tools: 2 on a configuration that cannot be used; 3 when a
file cannot be judged (permission denied, another kind of file), and then nothing was moved.
"""
import os
import subprocess
import sys
from concurrent.futures import ThreadPoolExecutor

import configuration
import tool.errors
from artefacts import Artefacts, files_of, state_of
from tool.errors import DAMAGED_FILE, INPUT_ERROR, InputError, OutputError, ToolError, one_line
from tool.input_file import read_bytes, read_json

# which tool knows a file by its ending; shards aside
TOOL_OF = {".h5": "nlg-pca", ".ckpt": "nlg-train", ".safetensors": "nlg-export"}
# how a whole one ends
END_OF = {".csv": b"\n", ".txt": b"\n", ".html": b"</html>", ".png": b"IEND\xaeB`\x82"}


def say(line):
    print(f"check_artefacts: {one_line(line)}", file=sys.stderr)


def is_own(run, path):
    """Whether a path lies where it says: no link between the results' folder and the file, nor the file itself."""
    root = os.path.realpath(os.path.dirname(run.folder))
    return os.path.realpath(path) == os.path.join(root, os.path.relpath(path, os.path.dirname(run.folder)))


def ask(tool, path):
    """Exit code of a tool's `info` and the one line that it ends with."""
    result = subprocess.run([tool, "info", "--quiet", "--", path], capture_output=True, text=True, errors="replace")
    return result.returncode, (result.stderr.strip().splitlines() or [f"{path}: {os.path.basename(tool)} info ended with {result.returncode}"])[-1]


def judge_by_itself(tools, path):
    """What a file that no record vouches for proves of itself: exit code and line as of `info`."""
    ending = os.path.splitext(path)[1]
    if ending in TOOL_OF:
        return ask(os.path.join(tools, TOOL_OF[ending]), path)
    try:
        data = read_bytes(path)
    except InputError as error:
        return INPUT_ERROR, str(error)
    try:
        if ending == ".json":
            read_json(path)
    except InputError as error:
        return DAMAGED_FILE, str(error)
    if not data.endswith(END_OF.get(ending, b"")):
        return DAMAGED_FILE, f"{path}: end: expected that of a whole file, got another"
    return 0, ""


def judge_by_record(tools, path, recorded):
    """A file against what the run recorded when it made it."""
    try:
        found = state_of(path)
    except FileNotFoundError:
        return DAMAGED_FILE, f"{path}: expected what the run made, got nothing"
    except OSError as error:
        return INPUT_ERROR, f"{path}: expected a readable file, got: {error.strerror}"
    if found["sha256"] == recorded["sha256"]:
        return 0, ""
    if found["mtime_ns"] == recorded["mtime_ns"]:
        return DAMAGED_FILE, f"{path}: other bytes than the run made, and its time has not changed"
    if os.path.splitext(path)[1] in END_OF:
        return DAMAGED_FILE, f"{path}: other bytes than the run made"
    return judge_by_itself(tools, path)


def free_name(path):
    """Where a damaged file goes: earlier ones stay."""
    names = [f"{path}.damaged", *(f"{path}.damaged.{number}" for number in range(2, 1000))]
    return next(name for name in names if not os.path.lexists(name))


def check(run, tools):
    """Files to make again, and the exit code."""
    shards = dict.fromkeys(shard for split in configuration.SPLITS for shard in run.shards(split))
    artefacts = Artefacts(run.folder)
    if artefacts.fault:
        say(f"{artefacts.fault}; earlier results are verified by their own digests, and recorded again")
    recorded = {os.path.join(run.folder, relative): state for relative, state in artefacts.files.items()}
    made, folders = run.artefacts(), run.picture_folders()
    # what was put aside stays wanted until it is there: an earlier check may have been of a run that then did not get far enough
    again = [path for path in [*shards, *made, *folders] if not os.path.lexists(path) and os.path.lexists(f"{path}.damaged")]
    # a folder is judged file by file, those of the record among them, and made again as a whole; one whose rule was killed is made again
    # anyway, and is no damage
    folder_of = {path: folder for folder, result in folders.items() if os.path.isdir(folder) and os.path.lexists(result)
                 for path in [*files_of([folder]), *(path for path in recorded if path.startswith(folder + os.sep))]}
    there = []
    for path in [*(path for path in [*shards, *made] if os.path.lexists(path)), *folder_of]:
        if is_own(run, path):
            there.append(path)
        else:
            say(f"{path} is reached through a link: not touched")

    def judge(path):
        if path in shards:
            return ask(os.path.join(tools, "nlg-datagen"), path)
        return judge_by_record(tools, path, recorded[path]) if path in recorded else judge_by_itself(tools, path)

    with ThreadPoolExecutor(os.cpu_count()) as pool:
        verdicts = list(zip(there, pool.map(judge, there)))
    unclear = [(code, line) for _, (code, line) in verdicts if code not in (0, DAMAGED_FILE)]
    for _, line in unclear:
        print(line, file=sys.stderr)
    if unclear:
        codes = {code for code, _ in unclear}
        return [], INPUT_ERROR if INPUT_ERROR in codes else 1
    for path, (code, line) in verdicts:
        whole = folder_of.get(path, path)
        if code == DAMAGED_FILE and whole not in again:
            aside = free_name(whole)
            os.rename(whole, aside)
            say(f"{line}; moved to {aside}; it will be made again")
            again.append(whole)
    # what is sound, whoever put it there, is what the run has from now on
    artefacts.take(path for path, (code, _) in verdicts if code == 0 and path not in shards)
    artefacts.write_if_changed()
    return again, 0


def main():
    run = configuration.load(sys.argv[1])
    try:
        again, code = check(run, sys.argv[2])
    except OSError as error:
        raise OutputError(error.filename or "artefacts", error.strerror or error) from None
    except RuntimeError as error:  # of threads that the system refuses
        raise ToolError(str(error)) from None
    for path in again:
        print(path)
    return code


if __name__ == "__main__":
    sys.exit(tool.errors.run("check_artefacts", main))

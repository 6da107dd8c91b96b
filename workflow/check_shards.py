"""Verifies the shards of a run and puts aside those that are proven damaged, so that the workflow makes them again.

    check_shards.py CONFIG BIN_FOLDER

Touches only what the run's own plan names, inside the run's own folder: a path that leads out of it through a link stays as it is,
and so does every other file that lies there. A damaged shard becomes NAME.damaged: nothing is deleted. Prints the shards to make
again on stdout, one a line; why, on stderr. Exit codes are those of the tools: 2 on a configuration that cannot be used; 3 when a
shard cannot be judged (permission denied, another kind of file), and then nothing was moved.
"""
import os
import subprocess
import sys
from concurrent.futures import ThreadPoolExecutor

import configuration

INPUT_ERROR, OUTPUT_ERROR, DAMAGED_FILE = 3, 5, 7  # tool/error.h


def say(line):
    print(f"check_shards: {line}", file=sys.stderr)


def is_own(run, shard):
    """Whether a planned path lies where it says: no link between the results' folder and the shard, nor the shard itself."""
    root = os.path.realpath(os.path.dirname(run.folder))
    return os.path.realpath(shard) == os.path.join(root, os.path.relpath(shard, os.path.dirname(run.folder)))


def judge(tool, shard):
    """Exit code of `nlg-datagen info` and the one line that it ends with."""
    result = subprocess.run([tool, "info", "--quiet", "--", shard], capture_output=True, text=True, errors="replace")
    return result.returncode, (result.stderr.strip().splitlines() or [f"{shard}: nlg-datagen info ended with {result.returncode}"])[-1]


def free_name(path):
    """Where a damaged file goes: earlier ones stay."""
    names = [f"{path}.damaged", *(f"{path}.damaged.{number}" for number in range(2, 1000))]
    return next(name for name in names if not os.path.lexists(name))


def check(run, tool):
    """Shards to make again, and the exit code."""
    planned = [shard for split in configuration.SPLITS for shard in run.shards(split)]
    # an earlier check that put them aside, of a run that then did not get far enough
    again = [shard for shard in planned if not os.path.lexists(shard) and os.path.lexists(f"{shard}.damaged")]
    there = []
    for shard in (shard for shard in planned if os.path.lexists(shard)):
        if is_own(run, shard):
            there.append(shard)
        else:
            say(f"{shard} leads elsewhere through a link: left as it is")
    with ThreadPoolExecutor(os.cpu_count()) as pool:
        verdicts = list(zip(there, pool.map(lambda shard: judge(tool, shard), there)))
    unclear = [(code, line) for _, (code, line) in verdicts if code not in (0, DAMAGED_FILE)]
    for _, line in unclear:
        print(line, file=sys.stderr)
    if unclear:
        codes = {code for code, _ in unclear}
        return [], INPUT_ERROR if INPUT_ERROR in codes else 1
    for shard, (code, line) in verdicts:
        if code == DAMAGED_FILE:
            aside = free_name(shard)
            os.rename(shard, aside)
            say(f"{line}; put aside as {aside}, it will be made again")
            again.append(shard)
    return again, 0


def main():
    run = configuration.load_or_exit(sys.argv[1], "check_shards")
    try:
        again, code = check(run, os.path.join(sys.argv[2], "nlg-datagen"))
    except OSError as error:
        say(f"error: {error}")
        return OUTPUT_ERROR
    for shard in again:
        print(shard)
    return code


if __name__ == "__main__":
    sys.exit(main())

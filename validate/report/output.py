"""How the report's tools end: outputs whole or not at all, one line on stderr, the exit codes of tool/error.h."""
import os
import sys

import inputs

INPUT_ERROR, OUTPUT_ERROR = 3, 5


def write_atomically(path, data):
    temporary_path = f"{path}.tmp.{os.getpid()}"
    os.makedirs(os.path.dirname(os.path.abspath(path)), exist_ok=True)
    try:
        with open(temporary_path, "wb") as file:
            file.write(data)
            file.flush()
            os.fsync(file.fileno())
        os.replace(temporary_path, path)
    except BaseException:
        if os.path.exists(temporary_path):
            os.remove(temporary_path)
        raise


def run(tool, out, make):
    """The tool's exit code. make(): path → bytes of every file to write, in order."""
    try:
        files = make()
    except inputs.InputError as error:
        print(f"{tool}: error: {' '.join(str(error).split())}", file=sys.stderr)
        return INPUT_ERROR
    try:
        for path, data in files.items():
            write_atomically(path, data)
    except OSError as error:
        print(f"{tool}: error: {out}: cannot be written: {error.strerror}", file=sys.stderr)
        return OUTPUT_ERROR
    return 0

"""How the Python scripts end, as the tools do: one line on stderr, the exit codes of tool/error.h."""
import os
import sys
import traceback

INTERNAL_ERROR, USAGE_ERROR, INPUT_ERROR, OUTPUT_ERROR, CHECK_FAILED, DAMAGED_FILE = 1, 2, 3, 5, 6, 7
STOPPED = 130  # by Ctrl-C, as shells say it


class ToolError(Exception):
    """Its text is the one line that the user sees."""
    exit_code = INTERNAL_ERROR


class UsageError(ToolError):
    """A command line or setting that cannot be used; place: file with line and column, or the flag."""
    exit_code = USAGE_ERROR

    def __init__(self, place, expected, got):
        super().__init__(f"{place}: expected {expected}, got {got}")


class InputError(ToolError):
    """A file that cannot be used; place: where in it."""
    exit_code = INPUT_ERROR

    def __init__(self, path, place, expected, got):
        super().__init__(f"{path}: {place}: expected {expected}, got {got}")


class OutputError(ToolError):
    """A file that could not be written: the one that was asked for, and the system's words."""
    exit_code = OUTPUT_ERROR

    def __init__(self, path, reason):
        super().__init__(f"{path}: cannot be written: {reason}")


def one_line(text):
    """What an input brings must neither break the line nor steer a terminal."""
    return " ".join("".join(c if c.isprintable() else " " for c in str(text)).split())


def say(name, text):
    print(f"{name}: error: {one_line(text)}", file=sys.stderr)


def run(name, work):
    """The script's exit code: what work() returns, 0 for None, or that of the error which it ended with."""
    try:
        code = work()
        # what is printed is the result: losing it on a full disk or a closed pipe must not look like success
        sys.stdout.flush()
        return code or 0
    except ToolError as error:
        say(name, error)
        return error.exit_code
    except OSError as error:
        # what is read and written has a name; Python would flush once more at its end
        if error.filename is None:
            os.dup2(os.open(os.devnull, os.O_WRONLY), 1)
        say(name, OutputError(error.filename or "standard output", error.strerror or error))
        return OUTPUT_ERROR
    except KeyboardInterrupt:
        return STOPPED
    except MemoryError:
        say(name, "out of memory")
        return INTERNAL_ERROR
    except Exception as error:
        place = traceback.extract_tb(error.__traceback__)[-1]
        say(name, f"a bug of ours in {place.filename}, line {place.lineno}: {type(error).__name__}: {error}")
        return INTERNAL_ERROR

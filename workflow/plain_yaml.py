"""A configuration's file: YAML that every reader of it can hold, without what YAML itself would let pass."""
import math
import sys
from pathlib import Path

import yaml

sys.path.insert(0, str(Path(__file__).resolve().parents[1]))  # tool/, which all scripts share
from tool.errors import USAGE_ERROR, InputError, ToolError
from tool.input_file import read_bytes

MAX_DEPTH = 16
MAX_BYTES = 1 << 20  # as for the tools


class ConfigurationError(ToolError, ValueError):
    """A configuration that cannot be used."""
    exit_code = USAGE_ERROR


def require(place, value, holds, expected):
    if not holds:
        shown = ascii(value) if isinstance(value, str) and not value.isprintable() else repr(value)
        raise ConfigurationError(f"{place}: expected {expected}, got {shown if len(shown) < 200 else shown[:200] + '…'}")


def require_plain(place, value, depth=0):
    """Values that every reader of the file can hold: texts of one line, numbers of 64 bits, lists and maps of them, not too deep."""
    require(place, "more", depth < MAX_DEPTH, f"at most {MAX_DEPTH} levels of lists and maps")
    if isinstance(value, dict):
        for key, item in value.items():
            require(place, key, isinstance(key, str), "keys that are texts")
            require_plain(place, key, depth + 1)
            require_plain(f"{place}: {key}" if depth else key, item, depth + 1)
    elif isinstance(value, list):
        for item in value:
            require_plain(place, item, depth + 1)
    elif isinstance(value, str):
        require(place, value, value.isprintable(), "a text of one line")
    elif isinstance(value, int):
        # before it is shown: Python refuses to print an integer of thousands of digits
        require(place, f"one of {value.bit_length()} bits", -2**63 <= value < 2**64, "a number of 64 bits")
    elif isinstance(value, float):
        require(place, value, math.isfinite(value), "a finite number")
    else:
        require(place, value, value is None, "a text, a number, a list or a map")


class Loader(yaml.SafeLoader):
    """YAML's safe loader, which would take the last of two equal keys, and lists of lists of aliases that no machine can hold."""

    def compose_node(self, parent, index):
        if self.check_event(yaml.events.AliasEvent):
            raise yaml.constructor.ConstructorError(None, None, "expected every value written out, got an alias", self.peek_event().start_mark)
        return super().compose_node(parent, index)

    def construct_mapping(self, node, deep=False):
        seen = set()
        for key, _ in node.value:
            if isinstance(key, yaml.ScalarNode):
                if key.value in seen:
                    raise yaml.constructor.ConstructorError(None, None, f"expected each key once, got {key.value!r} again", key.start_mark)
                seen.add(key.value)
        return super().construct_mapping(node, deep)

    def construct_object(self, node, deep=False):
        """With the place of what YAML can write and Python cannot hold: the 45th of May, a number of thousands of digits."""
        try:
            return super().construct_object(node, deep)
        except (ValueError, OverflowError) as error:
            raise yaml.constructor.ConstructorError(None, None, str(error), node.start_mark) from None


def position(text, index):
    """LINE:COLUMN of a character, or of a byte, counted from 1."""
    before = text[:index]
    newline = b"\n" if isinstance(text, bytes) else "\n"
    return f"{before.count(newline) + 1}:{index - (before.rfind(newline) + 1) + 1}"


def parsed(place, text):
    """The value that a text of YAML says."""
    try:
        return yaml.load(text, Loader)
    except (yaml.YAMLError, RecursionError) as error:
        raise ConfigurationError(f"{place}: expected a value as YAML writes it (patterns in quotes), got {text[:200]!r}: {getattr(error, 'problem', error)}") from None


def text_of(content):
    """A file that reads as this content."""
    return yaml.safe_dump(content, allow_unicode=True, sort_keys=False, width=130)


def read(path):
    """The file's content.

    throws   ConfigurationError when it cannot be read, or is no YAML
    """
    try:
        data = read_bytes(path)
        require(path, f"{len(data)}", len(data) <= MAX_BYTES, f"at most {MAX_BYTES} bytes")
        text = data.decode("utf-8")
        return yaml.load(text, Loader)
    except yaml.MarkedYAMLError as error:
        mark = error.problem_mark or error.context_mark
        raise ConfigurationError(f"{path}:{mark.line + 1}:{mark.column + 1}: {error.problem or error.context}") from None
    except yaml.reader.ReaderError as error:
        raise ConfigurationError(f"{path}:{position(text, error.position)}: expected text, got the character {error.character:#x}") from None
    except UnicodeDecodeError as error:
        raise ConfigurationError(f"{path}:{position(data, error.start)}: expected UTF-8, got other bytes") from None
    except RecursionError:
        raise ConfigurationError(f"{path}: expected at most {MAX_DEPTH} levels of lists and maps, got more") from None
    except InputError as error:
        raise ConfigurationError(str(error)) from None

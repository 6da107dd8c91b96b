"""Files that Python scripts read: refused in one line that names file, place, expected and got, whatever lies in them."""
import contextlib
import csv
import hashlib
import io
import json
import math
import os
import re
import struct

from tool.errors import InputError
from tool.regular_file import regular

MAX_FILE_BYTES = 1 << 30
MAX_INTEGER_DIGITS = 20  # of 64 bits, with its sign


def read_bytes(path):
    path = os.fspath(path)
    try:
        with open(path, "rb", opener=regular) as file:
            data = file.read(MAX_FILE_BYTES + 1)
    except OSError as error:
        raise InputError(path, "file", "a regular file", error.strerror or error) from None
    except ValueError as error:  # a name that no file can have
        raise InputError(path, "file", "a file's name", error) from None
    if len(data) > MAX_FILE_BYTES:
        raise InputError(path, "file", "at most 1 GiB", "more")
    return data


def read_text(path):
    try:
        return read_bytes(path).decode("utf-8")
    except UnicodeDecodeError as error:
        raise InputError(path, f"byte {error.start}", "UTF-8", "other bytes") from None


def sha256(path):
    return hashlib.sha256(read_bytes(path)).hexdigest()


def read_header(path):
    """The texts of a weights file, and its tensors' dtypes and shapes."""
    with as_documented(path):
        data = read_bytes(path)
        header = json.loads(data[8 : 8 + struct.unpack_from("<Q", data)[0]])
        metadata = header.pop("__metadata__")
        return metadata, {name: tensor for name, tensor in header.items() if not name.startswith("padding.")}


def training_scenes(texts):
    """The names of the scenes that weights were trained on, by the texts of their file; None where they do not say, as nlg-train takes them, too."""
    try:
        return set(json.loads(texts["training_options"])["training_scenes"])
    except (KeyError, TypeError, ValueError):
        return None


def shown(value):
    """The beginning of a value, for a message; never one that Python refuses to print."""
    return repr(value)[:40]


class Node:
    """A value inside a JSON file that remembers where it stands."""

    def __init__(self, path, place, value):
        self.path, self.place, self.value = path, place, value

    def refuse(self, expected, got):
        raise InputError(self.path, self.place or "top level", expected, got)

    def __contains__(self, key):
        """Whether the object has the key."""
        if not isinstance(self.value, dict):
            self.refuse("an object", type(self.value).__name__)
        return key in self.value

    def __getitem__(self, key):
        if key not in self:
            self.refuse(f"a key '{key}'", "none")
        return Node(self.path, f"{self.place}.{key}" if self.place else key, self.value[key])

    def entries(self):
        if not isinstance(self.value, dict) or not self.value:
            self.refuse("an object with keys", "another value or none")
        return [(key, self[key]) for key in self.value]

    def items(self):
        if not isinstance(self.value, list):
            self.refuse("a list", type(self.value).__name__)
        return [Node(self.path, f"{self.place}[{i}]", value) for i, value in enumerate(self.value)]

    def text(self):
        if not isinstance(self.value, str):
            self.refuse("a text", shown(self.value))
        return self.value

    def truth(self):
        if not isinstance(self.value, bool):
            self.refuse("true or false", shown(self.value))
        return self.value

    def number(self, low=0.0, high=math.inf):
        value = self.value
        if type(value) not in (int, float) or not low <= value <= high:
            wanted = f"a number from {low:g} to {high:g}" if high < math.inf else f"a number of at least {low:g}"
            self.refuse(wanted, shown(value))
        return float(value)

    def count(self):
        value = self.number()
        if value != int(value):
            self.refuse("a whole number", shown(self.value))
        return int(value)

    def numbers(self, length=None, low=-math.inf, high=math.inf):
        """The list's numbers."""
        values = self.value
        if not isinstance(values, list) or not set(map(type, values)) <= {int, float}:
            self.refuse("a list of numbers", "another value" if not isinstance(values, list) else "other values in it")
        if length is not None and len(values) != length:
            self.refuse(f"a list of {length} numbers", f"{len(values)}")
        if values and not (low <= min(values) and max(values) <= high):
            self.refuse(f"numbers from {low:g} to {high:g}", "others in it")
        return values


def place_of_half_characters(value, place=""):
    """Where a text holds half of a pair of surrogates, which JSON can write and no output can hold; None where none does."""
    if isinstance(value, str):
        return None if re.search("[\ud800-\udfff]", value) is None else place or "top level"
    parts = value.items() if isinstance(value, dict) else enumerate(value) if isinstance(value, list) else ()
    for key, item in parts:
        for part in (key, item) if isinstance(key, str) else (item,):
            if found := place_of_half_characters(part, f"{place}.{one_key(key)}" if place else one_key(key)):
                return found
    return None


def one_key(key):
    return ascii(key)[1:-1] if isinstance(key, str) else str(key)


def parse_json(path, text):
    """The value of a JSON text; every number in it is finite and of at most 64 bits, every text can be printed."""
    def refuse(expected, got):
        raise InputError(path, "JSON", expected, got)

    def integer(digits):
        if len(digits) > MAX_INTEGER_DIGITS or not -2**63 <= int(digits) < 2**64:
            refuse("numbers of 64 bits", f"one of {len(digits)} digits")
        return int(digits)

    def real(digits):
        if not math.isfinite(float(digits)):
            refuse("finite numbers", shown(digits))
        return float(digits)

    try:
        value = json.loads(text, parse_int=integer, parse_float=real, parse_constant=lambda name: refuse("finite numbers", name))
        # they can come from escapes alone
        if re.search(r"\\u[dD][89a-fA-F]", text) and (place := place_of_half_characters(value)):
            raise InputError(path, place, "whole characters", "half of a surrogate pair")
        return value
    except json.JSONDecodeError as error:
        raise InputError(path, f"line {error.lineno}, column {error.colno}", "whole JSON", error.msg) from None
    except RecursionError:
        raise InputError(path, "JSON", "an object", "brackets nested too deeply") from None


def read_json(path):
    return Node(os.fspath(path), "", parse_json(path, read_text(path)))


def read_rows(path):
    """The rows of a CSV file, each with its line number; a text may hold line breaks."""
    rows = csv.reader(io.StringIO(read_text(path), newline=""), strict=True)
    try:
        return [(rows.line_num, row) for row in rows]
    except csv.Error as error:
        raise InputError(path, f"line {rows.line_num}", "comma-separated values", error) from None


def read_columns(path, columns):
    """Rows of a CSV file with exactly these columns, as texts; every row with its line number."""
    rows = read_rows(path)
    header = rows[0][1] if rows else []
    if header != list(columns):
        raise InputError(path, "line 1", ",".join(columns), ",".join(header)[:120] or "nothing")
    for line, row in rows[1:]:
        if len(row) != len(columns):
            raise InputError(path, f"line {line}", f"{len(columns)} values", str(len(row)))
    if len(rows) == 1:
        raise InputError(path, "line 2", "at least one row", "none")
    return rows[1:]


def parse_number(path, line, column, text, empty=None):
    if text == "" and empty is not None:
        return empty
    try:
        value = float(text)
    except ValueError:
        value = math.nan
    if not math.isfinite(value):
        raise InputError(path, f"line {line}, column {column}", "a finite number", f"'{text[:40]}'")
    return value


@contextlib.contextmanager
def as_documented(path):
    """For what takes a file's values as they come: a key that is missing, a value of another kind, is the file's fault and ends in one line."""
    try:
        yield
    except (LookupError, TypeError, AttributeError, ValueError, ArithmeticError) as error:
        raise InputError(path, "content", "what docs/reference/formats.md says", f"{type(error).__name__}: {str(error)[:200]}") from None

"""What the lists of a configuration's section `scenes` have in common: archives of levels, libraries of furniture."""
import os
from pathlib import Path


def is_texts(value):
    return isinstance(value, list) and all(isinstance(item, str) for item in value)


def check_keys(place, entry, required, optional):
    """Raises ValueError unless entry is a mapping with all required keys and no others than these two sets name."""
    if not isinstance(entry, dict):
        raise ValueError(f"{place}: expected keys {sorted(required | optional)}, got {entry!r}")
    for key in sorted(set(entry) - required - optional, key=str):
        raise ValueError(f"{place}: expected keys {sorted(required | optional)}, got unknown key {key!r}")
    for key in sorted(required - set(entry)):
        raise ValueError(f"{place}: expected keys {sorted(required)}, got missing key {key!r}")


def check_text(place, entry, key):
    """Raises ValueError when entry has the key with anything but a text."""
    if not isinstance(entry.get(key, ""), str):
        raise ValueError(f"{place}: {key}: expected a text, got {entry[key]!r}")


def checked(name, entries, check):
    """(place, entry) of the list scenes.NAME, each after check(place, entry)."""
    if not isinstance(entries, list):
        raise ValueError(f"scenes: {name}: expected a list, got {entries!r}")
    for number, entry in enumerate(entries):
        place = f"scenes: {name}: {number}"
        check(place, entry)
        yield place, entry


def under_root(root, path):
    """root stands before absolute paths, for packages that were unpacked elsewhere."""
    return root + path if os.path.isabs(path) else path


def install_hint(entry, what):
    return f"; install {what}: {entry['install']}" if entry.get("install") else ""


def files_in(folder, *endings):
    """Files of a folder with these endings: those that hold anything, and the empty ones, which an export that failed leaves."""
    files = sorted(path for path in Path(folder).glob("[!.]*") if path.suffix.lower() in endings and path.is_file())
    return [path for path in files if path.stat().st_size], [path for path in files if not path.stat().st_size]

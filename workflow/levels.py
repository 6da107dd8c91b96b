"""Levels in the archives of Quake III-family games: what a configuration's scenes.archives name."""
import re
import zipfile
from fnmatch import fnmatch
from pathlib import Path

from entries import check_keys, check_text, checked, files_in, install_hint, is_texts, under_root
from settings import FAMILIES

REQUIRED, OPTIONAL = {"folder", "maps"}, {"without", "install"}


def check_entry(place, entry):
    check_keys(place, entry, REQUIRED, OPTIONAL)
    for key in ("maps", "without"):
        if not is_texts(entry.get(key, [])):
            raise ValueError(f"{place}: {key}: expected a list of names or patterns, got {entry[key]!r}")
    for key in ("folder", "install"):
        check_text(place, entry, key)


def maps_of(archive):
    """Names of an archive's maps, in lower case: maps/NAME.bsp, not those of folders below."""
    try:
        with zipfile.ZipFile(archive) as opened:
            names = [name.lower() for name in opened.namelist()]
    except (zipfile.BadZipFile, OSError, NotImplementedError, UnicodeDecodeError) as error:
        raise ValueError(f"{archive}: expected a whole ZIP archive, got: {error}")
    maps = [match[1] for match in (re.fullmatch(r"maps/([^/]+)\.bsp", name) for name in names) if match]
    for name in maps:
        # a map's name becomes a file's
        if not re.fullmatch(r"[\w+-][\w.+-]*", name, re.ASCII):
            raise ValueError(f"{archive}: expected maps named with letters, digits and . _ + -, got {name!r}")
    return maps


def matching(place, patterns, names):
    """The names that a list of patterns matches; a pattern that matches none is a mistake."""
    found = set()
    for pattern in patterns:
        matched = {name for name in names if fnmatch(name, pattern)}
        if not matched:
            raise ValueError(f"{place}: expected patterns of existing maps, got {pattern!r}")
        found |= matched
    return found


def level_name(stem, ending):
    """As loadScene names it: a level that is called as a procedural scene is (house_3) keeps its ending."""
    family, _, seed = stem.rpartition("_")
    return stem + ending.lower() if family in FAMILIES and re.fullmatch(r"[0-9]+", seed) else stem


def find_levels(archives, root=""):
    """Name of every level → (what nlg-datagen is asked for, the files that it reads).

    A level that several archives of a folder hold counts once: a later archive hides an earlier one.
    root: see under_root. Raises ValueError with place, expected, got.
    """
    levels = {}
    for place, entry in checked("archives", archives, check_entry):
        folder = Path(under_root(root, entry["folder"]))
        files = [str(path) for path in files_in(folder, ".pk3")[0]]
        if not files:
            raise ValueError(f"{place}: folder: expected .pk3 files in {folder}, got none{install_hint(entry, 'them')}")
        names = {name for file in files for name in maps_of(file)}
        chosen = matching(f"{place}: maps", entry["maps"], names) - matching(f"{place}: without", entry.get("without", []), names)
        for level in sorted(chosen):
            name = level_name(level, ".bsp")
            if name in levels:
                raise ValueError(f"{place}: two levels are named {name}, in {folder} and in {levels[name][0]}")
            levels[name] = (f"{folder}:{level}", files)
    return levels

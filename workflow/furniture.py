"""Interiors with real furniture: what a configuration's scenes.furniture names."""
import os
import re
from pathlib import Path

PLANS = ["flat", "townhouse", "office", "villa"]  # interiorPlans() of datagen/scene/interiors
REQUIRED, OPTIONAL = {"archives", "plans", "seeds"}, {"first_seed", "install"}
MAX_SEED = 10**9


def is_texts(value):
    return isinstance(value, list) and value and all(isinstance(item, str) for item in value)


def check_entry(place, entry):
    if not isinstance(entry, dict):
        raise ValueError(f"{place}: expected keys {sorted(REQUIRED | OPTIONAL)}, got {entry!r}")
    for key in sorted(set(entry) - REQUIRED - OPTIONAL, key=str):
        raise ValueError(f"{place}: expected keys {sorted(REQUIRED | OPTIONAL)}, got unknown key {key!r}")
    for key in sorted(REQUIRED - set(entry)):
        raise ValueError(f"{place}: expected keys {sorted(REQUIRED)}, got missing key {key!r}")
    if not is_texts(entry["archives"]) or not all(path.lower().endswith(".sh3f") for path in entry["archives"]):
        raise ValueError(f"{place}: archives: expected a list of .sh3f files, got {entry['archives']!r}")
    if not is_texts(entry["plans"]) or not set(entry["plans"]) <= set(PLANS):
        raise ValueError(f"{place}: plans: expected a list out of {', '.join(PLANS)}, got {entry['plans']!r}")
    for key, least in (("seeds", 1), ("first_seed", 0)):
        value = entry.get(key, least)
        if type(value) is not int or not least <= value <= MAX_SEED:
            raise ValueError(f"{place}: {key}: expected an integer from {least} to {MAX_SEED}, got {value!r}")
    if not isinstance(entry.get("install", ""), str):
        raise ValueError(f"{place}: install: expected a text, got {entry['install']!r}")


def stem_of(archive):
    """The archive's part of a scene's name, as makeInterior names it."""
    return re.sub(r"[^a-z0-9_-]", "-", re.sub(r"[A-Z]", lambda match: match[0].lower(), Path(archive).stem))


def find_interiors(entries, root="", most=100000):
    """Name of every interior → (what nlg-datagen is asked for, the file that it reads).

    root stands before absolute paths, for packages that were unpacked elsewhere. Raises ValueError with place, expected, got.
    """
    if not isinstance(entries, list):
        raise ValueError(f"scenes: furniture: expected a list, got {entries!r}")
    scenes = {}
    for number, entry in enumerate(entries):
        place = f"scenes: furniture: {number}"
        check_entry(place, entry)
        first = entry.get("first_seed", 0)
        count = len(entry["archives"]) * len(entry["plans"]) * entry["seeds"]
        if count + len(scenes) > most:
            raise ValueError(f"{place}: expected at most {most} scenes, got {count + len(scenes)}")
        for archive in entry["archives"]:
            path = root + archive if os.path.isabs(archive) else archive
            if not os.path.isfile(path):
                hint = f"; install it: {entry['install']}" if entry.get("install") else ""
                raise ValueError(f"{place}: archives: expected the file {path}, got none{hint}")
            for plan in entry["plans"]:
                for seed in range(first, first + entry["seeds"]):
                    name = f"{plan}_{seed}_{stem_of(archive)}"
                    if name in scenes:
                        raise ValueError(f"{place}: expected scenes with names of their own, got {name} twice")
                    scenes[name] = (f"{path}:{plan}:{seed}", [path])
    return scenes

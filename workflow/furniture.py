"""Interiors with real furniture: what a configuration's scenes.furniture names."""
import os
import re
from pathlib import Path

from entries import check_keys, check_text, checked, install_hint, is_texts, under_root

PLANS = ["flat", "townhouse", "office", "villa"]  # interiorPlans() of scene/interiors
REQUIRED, OPTIONAL = {"archives", "plans", "seeds"}, {"first_seed", "install"}
MAX_SEED = 10**9


def check_entry(place, entry):
    check_keys(place, entry, REQUIRED, OPTIONAL)
    if not entry["archives"] or not is_texts(entry["archives"]) or not all(path.lower().endswith(".sh3f") for path in entry["archives"]):
        raise ValueError(f"{place}: archives: expected a list of .sh3f files, got {entry['archives']!r}")
    if not entry["plans"] or not is_texts(entry["plans"]) or not set(entry["plans"]) <= set(PLANS):
        raise ValueError(f"{place}: plans: expected a list out of {', '.join(PLANS)}, got {entry['plans']!r}")
    for key, least in (("seeds", 1), ("first_seed", 0)):
        value = entry.get(key, least)
        if type(value) is not int or not least <= value <= MAX_SEED:
            raise ValueError(f"{place}: {key}: expected an integer from {least} to {MAX_SEED}, got {value!r}")
    check_text(place, entry, "install")


def stem_of(archive):
    """The archive's part of a scene's name, as makeInterior names it."""
    return re.sub(r"[^a-z0-9_-]", "-", re.sub(r"[A-Z]", lambda match: match[0].lower(), Path(archive).stem))


def find_interiors(entries, root="", most=100000):
    """Name of every interior → (what nlg-datagen is asked for, the file that it reads).

    root: see under_root. Raises ValueError with place, expected, got.
    """
    scenes = {}
    for place, entry in checked("furniture", entries, check_entry):
        first = entry.get("first_seed", 0)
        count = len(entry["archives"]) * len(entry["plans"]) * entry["seeds"]
        if count + len(scenes) > most:
            raise ValueError(f"{place}: expected at most {most} scenes, got {count + len(scenes)}")
        for archive in entry["archives"]:
            path = under_root(root, archive)
            if not os.path.isfile(path):
                raise ValueError(f"{place}: archives: expected the file {path}, got none{install_hint(entry, 'it')}")
            for plan in entry["plans"]:
                for seed in range(first, first + entry["seeds"]):
                    name = f"{plan}_{seed}_{stem_of(archive)}"
                    if name in scenes:
                        raise ValueError(f"{place}: two scenes are named {name}")
                    scenes[name] = (f"{path}:{plan}:{seed}", [path])
    return scenes

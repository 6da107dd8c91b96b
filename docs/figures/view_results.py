"""What a player sees (nlg-validate views), summed up over scenes: the section `views` of docs/results/light.json. Read by light_results.py.

Every scene counts alike, of it every offset of the lattice, and of that every view. Of a class that a scene's views do not have, it has no say.
"""
import numpy as np

from results_collect import fail, held_to, read_json, revision, slug, take

import light_figures as figures

CLASSES = ("all", "edge", "shadow")
FIGURES = ("hyab", "energy", "off_2", "below_eighth", "ringing")


def class_figures(found, place):
    kept = take(found, list(FIGURES), place)
    off = take(kept["off_2"], ["brighter", "darker"], f"{place}.off_2")
    return {**kept, "off_2": off["brighter"] + off["darker"]}


def read_scene(path, kinds):
    document = read_json(path)
    scene = take(document, ["scene"], path)["scene"]
    by_method = {}
    for method in take(document, ["methods"], path)["methods"]:
        of_classes = {name: class_figures(method[name], f"{path}: {method['weights']}.{name}") for name in CLASSES if name in method}
        by_method[(method["weights"], method["light"])] = of_classes
    return {"scene": scene, "kind": kinds.get(scene) or figures.scene_kind(scene, False), "revision": revision(document, path), "methods": by_method}


def mean_figures(runs):
    """class → figures, of classes that every run has."""
    return {name: {key: float(np.mean([run[name][key] for run in runs])) for key in FIGURES} for name in runs[0] if all(name in run for run in runs)}


def mean_of_offsets(runs, backless):
    """One scene of its runs, which differ in the offset of the lattice. Of DDGI's two rules the one with less error in the scene stands for both."""
    by_method = {}
    for (weights, light), _ in runs[0]["methods"].items():
        found = mean_figures([run["methods"][weights, light] for run in runs])
        key = (weights.replace(backless, ""), light)
        if key not in by_method or found["all"]["hyab"] < by_method[key]["all"]["hyab"]:
            by_method[key] = found
    return {**runs[0], "offsets": len(runs), "methods": by_method}


def method_entry(name, light, scenes):
    """scenes: class → figures, one a scene."""
    entry = {"name": name, "light": light, "scenes": len(scenes)}
    for of_class in CLASSES:
        found = [scene[of_class] for scene in scenes if of_class in scene]
        if found:
            entry[of_class] = {key: float(np.mean([some[key] for some in found])) for key in FIGURES}
    return entry


def methods(scenes):
    names = list(dict.fromkeys(method for scene in scenes for method in scene["methods"]))
    return {slug(" ".join(method)): method_entry(*method, [scene["methods"][method] for scene in scenes if method in scene["methods"]]) for method in names}


def over_best_baseline(scenes, ours, baselines):
    """Ours over the baseline whose pictures differ least, by the geometric mean over scenes of the ratios of mean HyAB."""
    found = []
    for baseline in dict.fromkeys(method for scene in scenes for method in scene["methods"] if method[0] in baselines and method[1] != "solved"):
        pairs = [(scene["methods"][ours]["all"]["hyab"], scene["methods"][baseline]["all"]["hyab"]) for scene in scenes if baseline in scene["methods"]]
        if len(pairs) == len(scenes):
            found.append((figures.figure([mine / theirs for mine, theirs in pairs], figures.geometric_mean), baseline[0]))
    if not found:
        return None
    best, baseline = max(found, key=lambda some: some[0]["mean"])
    low, high = best["interval"] or (None, None)
    return {"value": best["mean"], "low": low, "high": high, "baseline": baseline}


def collect(files, kinds, ours, baselines, backless):
    """files: one or more a scene; kinds: scene → kind, of scenes whose light was measured at places, too; backless: what names of DDGI's other rule hold."""
    runs = {}
    for path in files:
        scene = held_to(lambda path: read_scene(path, kinds), path)
        runs.setdefault(scene["scene"], []).append(scene)
    if len({len(of_scene) for of_scene in runs.values()}) > 1:
        fail(files[0].parent, "as many offsets of every scene", ", ".join(f"{len(some)} of {name}" for name, some in runs.items()))
    revisions = sorted({run["revision"] for of_scene in runs.values() for run in of_scene})
    scenes = [mean_of_offsets(of_scene, backless) for of_scene in runs.values()]
    for scene in scenes:
        if (ours, "solved") not in scene["methods"]:
            fail(f"{files[0].parent}: {scene['scene']}", f"a method {ours} with solved light", ", ".join(sorted({name for name, _ in scene["methods"]})))
    of_kind = {kind: [scene for scene in scenes if scene["kind"] == kind] for kind in figures.SCENE_KINDS}
    rooms = of_kind["furnished"] + of_kind["daylight"]
    ratios = {name: over_best_baseline(some, (ours, "solved"), baselines) for name, some in (("levels", of_kind["levels"]), ("rooms", rooms)) if some}
    return {"revisions": revisions, "offsets": scenes[0]["offsets"],
            "hyab_over_best_baseline": {name: ratio for name, ratio in ratios.items() if ratio},
            "ringing_largest": {name: max(scene["methods"][(ours, "solved")][name]["ringing"] for scene in scenes if name in scene["methods"][(ours, "solved")])
                                for name in ("all", "shadow") if any(name in scene["methods"][(ours, "solved")] for scene in scenes)},
            "methods": {kind: methods(some) for kind, some in of_kind.items() if some}}

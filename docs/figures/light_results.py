"""What was measured of light, reduced to what the documentation quotes or tables: docs/results/light.json. Read by results.py.

A folder of light holds
    SCENE.json            nlg-validate light, one a scene; a figure at a spacing is over the scenes that have it
and, where they are there,
    indirect/SCENE.json   nlg-validate light --light-direct reflected
    views/SCENE_SEED.json nlg-validate views, by seed: of the offset of the lattice, over which figures are means
    bakes/SCENE.json      nlg-bake SCENE --light solved (--json)
    benchmarks/*.json     bench_* --benchmark_out=FILE --benchmark_out_format=json
"""
import dataclasses
import sys
from pathlib import Path

from light_page import NAME
from results_collect import OURS, benchmarks, fail, held_to, read_json, revision, rounded, slug, take, today, trained_on

# the one place that reads light.json, and sums it up over scenes
sys.path.insert(0, str(Path(__file__).resolve().parents[2] / "validate" / "report"))
import packages

packages.need("results.py", "numpy")

import numpy as np

import light_figures as figures
import view_results
from light_figures import GROUPS, SCENE_KINDS

TODAY_M = 1.0  # how far apart probes are of what is tabled, and whose error is to be had for fewer bytes
BYTES_BEFORE = 39  # a probe, of a light grid when the targets of bytes at equal error were set
BASELINES = ("valid trilinear", "APV", "DDGI as shipped", "DDGI as shipped, relocated")
SOLVED_BASELINES = ("valid trilinear", "APV", "DDGI's weights")
NOT_BASELINES = (figures.NOT_STORED, "exact visibility")  # what nobody could ship
DARK_BASELINES = {"valid_trilinear": ("valid trilinear", "point"), "exact_visibility": ("exact visibility", "point")}
DDGI = "DDGI as shipped"
BACKLESS = ", backless sheets"  # DDGI by the other rule for backs of double-sided faces, measured where a scene has them
LEVEL = "kaos2"
INDIRECT = "reflected"  # the light_direct of what is indirect: nothing comes straight from lamps, suns and shining surfaces


def spacing_key(spacing_m):
    """1.0: "1m"; .5: "0_5m": a dot would part the key."""
    return f"{spacing_m:g}m".replace(".", "_")


def estimate(figure):
    low, high = figure["interval"] or (None, None)
    return {"value": figure["mean"], "low": low, "high": high}


def method_entry(points):
    """points: of one method at one spacing."""
    entry = {"scenes": len(points), **{group: estimate(figures.figure([point.rmse[group] for point in points])) for group in GROUPS}, "dark": estimate(figures.figure(figures.in_the_dark(points)))}
    return {**entry, **{key: float(np.mean([getattr(point, key) for point in points])) for key in ("seconds", "per_probe", "edge")}}


def methods(points):
    """spacing → weights → light → figures over scenes; with probes as far apart as today's."""
    here, out = [point for point in points if point.spacing_m == TODAY_M], {}
    for weights, light in figures.methods_of(here):
        thinned_to = weights.partition(figures.THINNED)[2]
        of_weights = out.setdefault(slug(weights), {"name": weights, **({"thinned_to": float(thinned_to)} if thinned_to else {})})
        of_weights[light] = method_entry(figures.of_method(here, (weights, light)))
    return {spacing_key(TODAY_M): out} if out else {}


def by_better_rule(points):
    """DDGI by that one of its two rules which has less error in the scene, at each spacing, under the name of the first."""
    best = {}
    error = lambda point: figures.geometric_mean([point.rmse[group] for group in GROUPS])
    for point in points:
        method = (point.method[0].replace(BACKLESS, ""), point.method[1])
        key = (point.scene, point.spacing_m, method)
        if key not in best or error(point) < error(best[key]):
            best[key] = dataclasses.replace(point, method=method)
    return list(best.values())


def is_ours(point, ours):
    """The one place that says which methods are: the grid of these weights, whole or thinned."""
    return point.method[0].split(figures.THINNED)[0] == ours


def by_room(point, group):
    return point.by_room[group]


def to_best_baseline(points, ours, baselines, solved, error=lambda point, group: point.rmse[group]):
    """Ours over the baseline that does best over the scenes, both at one spacing: by spacing and group. None where there is none."""
    out = {}
    for spacing_m in figures.spacings_of(points):
        of_spacing = [point for point in points if point.spacing_m == spacing_m]
        mine = figures.of_method(of_spacing, (ours, "solved"))
        entry = {}
        for group in GROUPS:
            found = []
            for method in figures.methods_of(of_spacing):
                if method[0] in baselines and (method[1] == "solved") == solved:
                    ratios = figures.ratios_to(mine, {point.scene: point for point in figures.of_method(of_spacing, method)}, group, error)
                    if ratios and len(ratios) == len(mine):
                        found.append({**estimate(figures.figure(ratios, figures.geometric_mean)), "baseline": f"{method[0]} ({method[1]})"})
            if found:
                entry[group] = max(found, key=lambda some: some["value"])
        if entry:
            out[spacing_key(spacing_m)] = entry
    return out


def over_exact(points, ours):
    """Ours over exact functions, which no generator has touched, where the weights have seen the scene and where they have not."""
    here = [point for point in points if point.spacing_m == TODAY_M]
    exact = {point.scene: point for point in figures.of_method(here, (figures.NOT_STORED, "solved"))}
    mine = [point for point in figures.of_method(here, (ours, "solved")) if point.scene in exact]
    known, out = trained_on(ours), {}
    for key, some in (("trained", [point for point in mine if slug(point.scene) in known]), ("unseen", [point for point in mine if slug(point.scene) not in known])):
        if some:
            ratios = [ratio for group in GROUPS for ratio in figures.ratios_to(some, exact, group)]
            out[key] = {"scenes": sorted(point.scene for point in some), "error": figures.geometric_mean(ratios)}
    return out


def front(points, ours):
    """How many of the baselines' points, scene by scene and group by group, some point of ours is neither larger nor worse than.

    missed: by baseline; missed_in: by scene, and what the largest of them takes.
    """
    met, of, missed, missed_in = 0, 0, {}, {}
    for scene in sorted({point.scene for point in points}):
        mine = [point for point in points if point.scene == scene and is_ours(point, ours)]
        baselines = [point for point in points if point.scene == scene and point.method[0] in {*BASELINES, *SOLVED_BASELINES} and point.method[1] != "solved"]
        for baseline in baselines:
            for group in GROUPS:
                of += 1
                if any(point.bytes <= baseline.bytes and point.rmse[group] <= baseline.rmse[group] for point in mine):
                    met += 1
                else:
                    missed[baseline.method[0]] = missed.get(baseline.method[0], 0) + 1
                    entry = missed_in.setdefault(slug(scene), {"points": 0, "largest_bytes": 0})
                    missed_in[slug(scene)] = {"points": entry["points"] + 1, "largest_bytes": max(entry["largest_bytes"], baseline.bytes)}
    return {"met": met, "of": of, "share": met / of if of else None, "missed": missed, "missed_in": missed_in}


def tenth_of_ddgi(points, ours):
    """At a tenth of DDGI's bytes or fewer, the least error over DDGI's, over scenes: by DDGI's spacing and group."""
    out = {}
    for spacing_m in figures.spacings_of(points):
        entry = {}
        for group in GROUPS:
            ratios = []
            for baseline in figures.of_method([point for point in points if point.spacing_m == spacing_m], (DDGI, "own")):
                mine = [point.rmse[group] for point in points if point.scene == baseline.scene and is_ours(point, ours) and point.bytes <= baseline.bytes / 10]
                if mine and baseline.rmse[group] > 0:
                    ratios.append(min(mine) / baseline.rmse[group])
            if ratios:
                entry[group] = {**estimate(figures.figure(ratios, figures.geometric_mean)), "scenes": len(ratios)}
        if entry:
            out[spacing_key(spacing_m)] = entry
    return out


def dark(points, ours):
    """Light in the dark beyond truth, mean over scenes: ours, and what it is held against; by spacing."""
    out = {}
    for spacing_m in figures.spacings_of(points):
        of_spacing = [point for point in points if point.spacing_m == spacing_m]
        named = {"ours": (ours, "solved"), **DARK_BASELINES}
        found = {name: figures.of_method(of_spacing, method) for name, method in named.items()}
        if all(found.values()):
            out[spacing_key(spacing_m)] = {name: estimate(figures.figure(figures.in_the_dark(some))) for name, some in found.items()}
    return out


def thinning(points, ours):
    """What fewer bytes cost beside our whole grid with probes as far apart as today's, geometric means over scenes.

    thinned: by what it was thinned to, bytes and errors over the whole grid's. at_equal_error: of each error the fewest bytes for which ours, at any
    spacing, has no more of it than the whole grid, over its bytes; and over what it took before, BYTES_BEFORE a probe.
    """
    if not any(point.method == (ours, "solved") and point.spacing_m == TODAY_M for point in points):
        return {}
    errors = {**{group: lambda point, group=group: point.rmse[group] for group in GROUPS}, "smape_in_air": lambda point: point.smape}
    whole = {point.scene: point for point in points if point.method == (ours, "solved") and point.spacing_m == TODAY_M}
    ratio = lambda values: estimate(figures.figure(values, figures.geometric_mean))
    over_whole = lambda some, of: ratio([of(point) / of(whole[point.scene]) for point in some])
    mine = [point for point in points if is_ours(point, ours) and point.scene in whole]
    thinned, names = {}, dict.fromkeys(point.method[0] for point in mine if figures.THINNED in point.method[0] and point.spacing_m == TODAY_M)
    for name in names:
        some = [point for point in mine if point.method[0] == name and point.spacing_m == TODAY_M]
        thinned[slug(name)] = {"name": name, "bytes": over_whole(some, lambda point: point.bytes), **{key: over_whole(some, error) for key, error in errors.items()}}
    fewest = {key: {scene: min(point.bytes for point in mine if point.scene == scene and error(point) <= error(today)) for scene, today in whole.items()} for key, error in errors.items()}
    return {"spacings_m": figures.spacings_of(mine), "bytes_before": BYTES_BEFORE, "thinned": thinned, "at_equal_error": {key: {"over_whole": ratio([size / whole[scene].bytes for scene, size in of_scene.items()]),
                                                         "over_before": ratio([size / (BYTES_BEFORE * whole[scene].probes) for scene, size in of_scene.items()])}
                                                   for key, of_scene in fewest.items()}}


def against_bytes(points, ours):
    """What docs/images/light_against_bytes.png draws: geometric means over scenes of every method that can be stored, at every spacing."""
    out = []
    for spacing_m in figures.spacings_of(points):
        of_spacing = [point for point in points if point.spacing_m == spacing_m and point.method[0] not in NOT_BASELINES]
        for method in figures.methods_of(of_spacing):
            some = figures.of_method(of_spacing, method)
            out.append({"weights": method[0], "light": method[1], "is_ours": is_ours(some[0], ours), "spacing_m": spacing_m, "bytes": float(figures.geometric_mean([point.bytes for point in some])),
                        **{group: float(figures.geometric_mean([point.rmse[group] for point in some])) for group in GROUPS}})
    return out


def bytes_below_baselines(points, ours):
    """The fewest bytes for which ours, of this level, has less error everywhere than each baseline, not solved for, with probes as far apart as today's; None where it was not measured so."""
    of_level = [point for point in points if point.scene.endswith(LEVEL)]
    baselines = [point for point in of_level if point.spacing_m == TODAY_M and point.method[0] in BASELINES and point.method[1] != "solved"]
    good = [point.bytes for point in of_level if is_ours(point, ours) and all(point.rmse[group] < baseline.rmse[group] for baseline in baselines for group in GROUPS)]
    return min(good) if baselines and good else None


def targets(points, ours):
    of_kind = {kind: [point for point in points if point.kind == kind] for kind in SCENE_KINDS}
    mine = [point for point in points if point.method == (ours, "solved") and point.spacing_m == TODAY_M]
    largest = lambda key: max(getattr(point, key) for point in mine)
    return {"levels": to_best_baseline(of_kind["levels"], ours, BASELINES, solved=False),
            "furnished": to_best_baseline(of_kind["furnished"], ours, BASELINES, solved=False),
            "levels_solved": to_best_baseline(of_kind["levels"], ours, SOLVED_BASELINES, solved=True),
            "furnished_solved": to_best_baseline(of_kind["furnished"], ours, SOLVED_BASELINES, solved=True),
            "by_room": to_best_baseline(points, ours, BASELINES, solved=False, error=by_room),
            "front": front(points, ours), "tenth_of_ddgi": tenth_of_ddgi(points, ours), "dark": dark(points, ours), "unlit_largest": largest("unlit"),
            "outside_largest": largest("outside"), "per_probe": {key: reduce([point.per_probe for point in mine]) for key, reduce in (("least", min), ("most", max))},
            "bytes_below_baselines": bytes_below_baselines(points, ours)}


def bake(path):
    """One bake with light: its size and its time by the clock."""
    document = read_json(path)
    return {**take(document, ["scene", "threads", "probes", "bytes", "bytes_per_probe"], path), "wall_s": take(document["wall_seconds"], ["all"], path)["all"]}


def blend(document, ours, path):
    """Holes, leaks and shares of our grid with probes as far apart as today's, by class of points; None of results from before they were measured."""
    for spacing in document["spacings"]:
        for found in spacing.get("blends", []):
            if spacing["spacing_m"] == TODAY_M and found["weights"] == ours:
                classes = {"air": found["air"], **{f"{100 * some['from_m']:g}_to_{100 * some['to_m']:g}cm": some for some in found["surface"]}}
                return {name: take(some, ["points", "holes", "leaks", "total_variation"], f"{path}: blends") for name, some in classes.items()}
    return None


def read_scene(path, ours, light_direct):
    """Its revision, and what is kept of it."""
    document = read_json(path)
    options = take(take(document, ["provenance"], path)["provenance"], ["options"], f"{path}: provenance")["options"]
    if take(options, ["light_direct"], f"{path}: provenance.options")["light_direct"] != light_direct:
        fail(f"{path}: provenance.options.light_direct", light_direct, options["light_direct"])
    truth = take(take(document, ["truth"], path)["truth"], ["noise", "places"], f"{path}: truth")
    truth["places"] = take(truth["places"], ["air", "surface"], f"{path}: truth.places")
    floor = take(take(document, ["floor"], path)["floor"], GROUPS, f"{path}: floor")
    blended = blend(document, ours, path)
    return revision(document, path), {"name": document["scene"], "kind": "", "truth": truth, "floor": {group: floor[group]["rmse"] for group in GROUPS}, **({"blend": blended} if blended else {})}


def measured(folder, files, ours, light_direct):
    """Points of scenes; what is kept of each by itself; revisions."""
    points = by_better_rule(figures.read_all([str(path) for path in files]))
    if not any(point.method == (ours, "solved") for point in points):
        fail(folder, f"a method {ours} with solved light", ", ".join(sorted({point.method[0] for point in points})))
    alone = sorted({point.scene for point in points} - {point.scene for point in points if point.method[0] in BASELINES})
    if alone:
        fail(folder, "baselines in the results of every scene", f"grids alone (--grids-only) of {', '.join(alone)}")
    documents = [held_to(lambda path: read_scene(path, ours, light_direct), path) for path in files]
    whole = {(point.scene, point.spacing_m): point for point in points if point.method == (ours, "solved")}
    for point in points:
        if is_ours(point, ours):  # bytes a probe are of all that the whole grid has: those that are left out hold nothing
            point.per_probe = point.bytes / whole[point.scene, point.spacing_m].probes
    kinds = {point.scene: point.kind for point in points}
    return points, {slug(found["name"]): {**found, "kind": kinds[found["name"]]} for _, found in documents}, sorted({made_by for made_by, _ in documents})


def by_scene(points, ours):
    """Ours over the baseline that does best in each scene by itself, with probes as far apart as today's: scene → group."""
    out = {}
    for mine in points:
        if mine.method == (ours, "solved") and mine.spacing_m == TODAY_M:
            baselines = [point for point in points if point.scene == mine.scene and point.spacing_m == mine.spacing_m and not is_ours(point, ours) and point.method[0] not in NOT_BASELINES]
            best = {group: min(baselines, key=lambda point: point.rmse[group]) for group in GROUPS}
            out[slug(mine.scene)] = {group: {"value": mine.rmse[group] / best[group].rmse[group], "rmse": mine.rmse[group], "baseline": f"{best[group].method[0]} ({best[group].method[1]})"}
                                     for group in GROUPS}
            relative = min(baselines, key=lambda point: point.smape)
            out[slug(mine.scene)]["smape_in_air"] = {"value": mine.smape / relative.smape, "baseline": f"{relative.method[0]} ({relative.method[1]})"}
    return out


def indirect(folder, ours):
    """The section `indirect`: all methods without light that comes straight from lamps, suns and shining surfaces."""
    points, scenes, revisions = measured(folder, sorted(folder.glob("*.json")), ours, INDIRECT)
    of_kind = {kind: [point for point in points if point.kind == kind] for kind in SCENE_KINDS}
    best = {kind: {way: to_best_baseline(of_kind[kind], ours, baselines, solved=way == "solved") for way, baselines in (("own", BASELINES), ("solved", SOLVED_BASELINES))}
            for kind in ("levels", "furnished", "daylight")}
    relative = {kind: {spacing: entry["air"] for spacing, entry in to_best_baseline(of_kind[kind], ours, BASELINES, solved=False, error=lambda point, _: point.smape).items()} for kind in best}
    kept = {key: {"name": entry["name"], "places": entry["truth"]["places"]} for key, entry in scenes.items()}
    return {"revisions": revisions, "scenes": kept, "to_best_baseline": best, "smape_in_air": relative, "by_room": to_best_baseline(points, ours, BASELINES, solved=False, error=by_room),
            "by_scene": by_scene(points, ours), "front": front(points, ours), "tenth_of_ddgi": tenth_of_ddgi(points, ours),
            "thinning": {kind: thinning(of_kind[kind], ours) for kind in best if of_kind[kind]}, "against_bytes": {kind: against_bytes(of_kind[kind], ours) for kind in best if of_kind[kind]},
            "methods": {kind: methods(some) for kind, some in of_kind.items() if some}}


def collect(folder):
    """The results of a folder of light."""
    ours = OURS
    files = sorted(folder.glob("*.json"))
    if not files:
        fail(folder, "results of nlg-validate light", "no .json")
    points, scenes, revisions = measured(folder, files, ours, "all")
    kinds = {point.scene: point.kind for point in points}
    out = {"schema_version": 1, "run": NAME, "command": "docs/figures/measure.sh light views bakes", "date": today(), "ours": ours, "revisions": revisions, "scenes": scenes,
           "targets": targets(points, ours), "over_exact": over_exact(points, ours), "thinning": {}, "methods": {}}
    for kind in SCENE_KINDS:
        of_kind = [point for point in points if point.kind == kind]
        if any(point.spacing_m == TODAY_M for point in of_kind):
            out["methods"][kind] = methods(of_kind)
            if kind != "boxes":
                out["thinning"][kind] = thinning(of_kind, ours)
    if any((folder / "indirect").glob("*.json")):
        out["indirect"] = indirect(folder / "indirect", ours)
    if found := sorted((folder / "views").glob("*.json")):
        out["views"] = view_results.collect(found, kinds, ours, BASELINES, BACKLESS)
    if found := sorted((folder / "bakes").glob("*.json")):
        out["bakes"] = {slug(path.stem): held_to(bake, path) for path in found}
    if found := sorted((folder / "benchmarks").glob("*.json")):
        out["benchmarks"] = benchmarks(found)
    return rounded(out, str(folder))

"""docs/reference/light.md: light, against ground truth and baselines. Written by results.py from docs/results/light.json."""
from results_page import spread, table
from results_quotes import number, percent

NAME = "light"
OURS = "tent_mlp4"  # what nlg-bake takes without being told
GROUPS = ("air", "surface", "turned")
KIND_TITLES = {"all": "All scenes", "levels": "Levels that hold their own light", "furnished": "Furnished and thin-walled scenes", "daylight": "Rooms beside daylight", "boxes": "Test boxes"}
LIGHT_ORDER = ("point", "own", "solved")
BOX_BYTES = {8: 1000, 729: 60000}  # by probes
SHOWN_SPACING = "1m"
SHOWN_THINNED = (.03, .06)  # in tables of methods; what is thinned to more is for budgets of bytes

INTRODUCTION = """# Light

*Written by `workflow/results.py write` from `docs/results/light.json`. Change nothing here by hand.*

Errors of every way to light a level, against ground truth by path tracing. All methods have the same probes, the same rays and the same sample points. An error is the RMSE of irradiance over the root mean square of truth, in three groups, always in this order:

- **air**: points uniform in air, any normal.
- **surface**: points 5 to 50 cm before surfaces, with the surface's normal.
- **turned**: the same points, any normal.

The light of probes is *point*, gathered where the probe stands; *solved*, least squares over points in air that no figure uses; or the method's *own* form. *Dark* is the mean light beyond truth at points that should be dark, over the level's mean. *Edges* is the mean light beyond truth within 10 cm of edges, over truth there. Parentheses hold 95 % intervals, by bootstrap over scenes.

DDGI takes the back of a double-sided face for a front. RTXGI's shaders go by the hit alone, which leaves rooms of such sheets unlit: in a room whose faces all look outward 35 % of the points in air were unlit, and none are now (RMSE 1.00 → .49; at surfaces 1.00 → .97); in `meeting:0` the RMSE at surfaces falls from .51 to .35 (probes 1 m apart, 256 rays each). The figures below were measured before.

Methods and measures: [formats](json.md#lightjson). How light is baked: [theory](../theory/light.md). What was tried: [lab](../lab/light.md).
"""


def estimate(found, digits=3):
    text = number(found["value"], digits)
    return text if found.get("low") is None else text + spread(found["low"], found["high"], lambda value: number(value, digits))


def bytes_text(value):
    return f"{value:,.0f} B" if value < 1000 else f"{value / 1000:,.1f} kB" if value < 1e6 else f"{value / 1e6:,.2f} MB"


def spacing_text(key):
    return key.removesuffix("m").replace("_", ".") + " m"


def shown(methods):
    """Without grids that are thinned to more than tables show."""
    return {slug: entry for slug, entry in methods.items() if entry.get("thinned_to", SHOWN_THINNED[0]) in SHOWN_THINNED}


def missed_text(front):
    """Of the baselines' points that none of ours matches: which, where, and how large."""
    if not front["missed"]:
        return "none"
    largest = max(entry["largest_bytes"] for entry in front["missed_in"].values())
    baselines = "; ".join(f"{name} {count}" for name, count in front["missed"].items())
    scenes = ", ".join(f"{scene} {entry['points']}" for scene, entry in front["missed_in"].items())
    return f"{baselines} ({scenes}; the largest has {bytes_text(largest)})"


def reached(holds):
    return {True: "yes", False: "no", None: ""}[holds]


def by_spacing_section(found):
    """What is held against baselines, a column a spacing; a cell that reaches its target is bold."""
    spacings = list(found["levels"])
    least = lambda limits: "; ".join(f"≤ {number(limit, 1)}" for limit in limits) if limits else ""

    def ratios(what, key, limits):
        cells = []
        for spacing in spacings:
            entry = found[key].get(spacing, {})
            text = "; ".join(number(entry[group]["value"], 2) for group in GROUPS if group in entry)
            holds = limits and text and all(entry[group]["value"] <= limit for group, limit in zip(GROUPS, limits) if group in entry)
            cells.append(f"**{text}**" if holds else text)
        return [what, least(limits), *cells]

    def dark(spacing):
        entry = found["dark"].get(spacing)
        if entry is None:
            return ""
        ours, trilinear, exact = (entry[key]["value"] for key in ("ours", "valid_trilinear", "exact_visibility"))
        text = f"{number(ours, 3)}; {number(trilinear, 3)}; {number(exact, 3)}"
        return f"**{text}**" if 5 * ours <= trilinear and ours <= exact else text

    rows = [ratios("levels, over the best baseline", "levels", (.7, .5, .5)), ratios("levels, over the best baseline with solved light", "levels_solved", None),
            ratios("furnished and thin-walled scenes, over the best baseline", "furnished", (.7, .6, .6)), ratios("the same, over the best baseline with solved light", "furnished_solved", None),
            ratios("at a tenth of DDGI's bytes, over DDGI this far apart", "tenth_of_ddgi", (.5, .5, .5)),
            *([ratios("all scenes by room, over the best baseline", "by_room", None), ratios("the same, over the best baseline with solved light", "by_room_solved", None)] if found.get("by_room") else []),
            ["excess light in the dark: ours; valid trilinear; exact visibility", "a fifth of the first, no more than the second", *map(dark, spacings)]]
    text = ("\n### By spacing of the probes\nErrors are *air; surface; turned*, each over that of the baseline that does best over the scenes. Baselines: a validity mask (*valid trilinear*), APV, and DDGI as "
            "RTXGI ships it, with and without relocation. **Bold** reaches the target.\n")
    text += table(["", "target", *map(spacing_text, spacings)], rows)
    interval = lambda key: "; ".join(estimate(found[key][SHOWN_SPACING][group], 2) for group in GROUPS)
    return text + f"\nIntervals at {spacing_text(SHOWN_SPACING)}: levels {interval('levels')}; furnished scenes {interval('furnished')}.\n" if SHOWN_SPACING in found["levels"] and SHOWN_SPACING in found["furnished"] else text


def box_row(found):
    judged = [entry for entry in found.values() if entry["probes"] in BOX_BYTES]
    words = "; ".join(f"{entry['probes']:,} probes: {bytes_text(entry['bytes'])} (DDGI {bytes_text(entry['ddgi_bytes'])}), error {number(entry['rmse_to_ddgi'], 2)} ×, "
                      f"jumps {number(entry['jump_to_ddgi'], 2) + ' ×' if entry['jump_to_ddgi'] is not None else 'none of DDGI’s'}" for entry in found.values())
    holds = all(entry["bytes"] <= BOX_BYTES[entry["probes"]] and entry["rmse_to_ddgi"] <= 1 and entry["jump_to_ddgi"] is not None and entry["jump_to_ddgi"] <= 1 for entry in judged) if judged else None
    return ["Cornell box: bytes, largest error and mean jump over DDGI's (talk: 4 kB of 8 probes, 183 kB of 729)", "8 probes ≤ 1 kB, 729 ≤ 60 kB; ≤ 1 ×", words, reached(holds)]


# positions a second, coherent and scattered, of look-ups in batches
LOOK_UP_TARGETS = {"walk": 12e6, "scattered": 5e6}


def speed_rows(results):
    rows = []
    for found in results.get("noise", {}).values():
        limit = {"integrated": 300, "solved": 1500}.get(found["light"])
        quiet = found["noise"]["median"] <= .02 and found["noise"]["p95"] <= .1
        of = lambda key: f"{percent(found[key]['median'])} and {percent(found[key]['p95'])}"
        rows.append([f"probes lit a second on one core, {found['scene']}, {found['light']} (talk: 34 to 39)", "≥ 1,500 gathered, ≥ 300 path traced, at ≤ 2 % median and ≤ 10 % p95 noise",
                     f"{found['probes_per_s']:,.0f}, noise {of('noise')}; of answers {of('answers')}", reached(quiet and found["probes_per_s"] >= limit if limit else None)])
    for way, target in LOOK_UP_TARGETS.items():
        cases = {case["case"].split("/")[2]: case["items_per_second"] for case in results.get("benchmarks", {}).values() if "/batched/" in case["case"] and case["case"].endswith(f"/{way}")}
        if cases:
            rows.append([f"look-ups to irradiance a second, one core, {way}", f"≥ {target / 1e6:.0f} M", "; ".join(f"`{name}` {speed / 1e6:,.1f} M" for name, speed in cases.items()),
                         reached(all(speed >= target for speed in cases.values()))])
    for found in results.get("bakes", {}).values():
        rows.append([f"whole bake with light, {found['scene']}, {found['threads']} threads", "≤ 40 s", f"{found['wall_s']:.1f} s; {bytes_text(found['bytes'])}, {found['bytes_per_probe']:.0f} bytes a probe", reached(found["wall_s"] <= 40)])
    return rows


def targets_section(results):
    found = results["targets"]
    front, most, unlit, outside = found["front"], found["per_probe"], found["unlit_largest"], found["outside_largest"]
    rows = [box_row(found["box"])] if found["box"] else []
    rows += [["points of baselines that can be stored, matched by one of ours in error at no more bytes", "all", f"{front['met']:,} of {front['of']:,}; the others: {missed_text(front)}", reached(front["met"] == front["of"] if front["of"] else None)],
             ["air that nothing lights, and air outside the tree: largest of all scenes", "≤ .05 %; 0", f"{percent(unlit)}; {percent(outside)}", reached(unlit <= .0005 and outside == 0)],
             ["bytes a live probe, everything (talk 236 to 339, DDGI 1,056)", "≤ 60", f"{most['least']:.0f} to {most['most']:.0f}", reached(most["most"] <= 60)]]
    rows += [[what, "≤ 1 MB", bytes_text(size), reached(size <= 1e6)] for what, size in (("kaos2 at the error of our own probes with point light 1 m apart", found["level_bytes"]),
             ("kaos2 with less error than every baseline 1 m apart", found["bytes_below_baselines"])) if size is not None]
    return (f"\n## All light\nOurs is `{results['ours']}` with solved light, through the engine's own look-up.\n" + by_spacing_section(found) + thinning_section(results.get("thinning", {}), explained="thinning" not in results.get("indirect", {}))
            + "\n### Bytes and times\n" + table(["", "target", "measured", "reached"], rows + speed_rows(results)) + methods_section(results["methods"]))


THINNED_KINDS = {"levels": .4, "furnished": .3, "daylight": None}  # with the target of bytes at equal error
THINNED_ERRORS = (*GROUPS, "smape_in_air")


def thinning_section(found, explained=True):
    """What is left out for fewer bytes, and what fewer bytes the same error takes; empty where nothing was thinned."""
    kinds = [kind for kind in THINNED_KINDS if found.get(kind, {}).get("thinned")]
    if not kinds:
        return ""
    ratios = lambda entry, keys: "; ".join(number(entry[key]["value"], 2) for key in keys)
    spacings, before = (found[kinds[0]][key] for key in ("spacings_m", "bytes_before"))
    rows = [[f"{entry['name'].split(', ')[1]}: bytes; errors", "", *(ratios(found[kind]["thinned"][slug], ("bytes", *THINNED_ERRORS)) for kind in kinds)] for slug, entry in found[kinds[0]]["thinned"].items()]
    for way, what, targets in (("over_whole", "bytes for no more error than the whole grid 1 m apart has", {}), ("over_before", f"the same, over {before} bytes a probe", THINNED_KINDS)):
        cells = []
        for kind in kinds:
            values = [found[kind]["at_equal_error"][key][way]["value"] for key in THINNED_ERRORS]
            text, limit = "; ".join(number(value, 2) for value in values), targets.get(kind)
            cells.append(f"**{text}**" if limit and all(value <= limit for value in values) else text)
        rows.append([what, "; ".join(f"≤ {number(targets[kind], 1)}" if targets[kind] else "" for kind in kinds if targets).strip("; "), *cells])
    if not explained:
        return "\n### For fewer bytes\nAs of indirect light, above.\n" + table(["", "target", *(KIND_TITLES[kind].lower() for kind in kinds)], rows)
    return ("\n### For fewer bytes\n[Thinned](../guide/bake.md#fewer-bytes-for-this-light) grids over the whole one, probes 1 m apart; then the bytes for the same error, of all grids that were measured "
            f"(probes {', '.join(f'{spacing:g}' for spacing in spacings[:-1])} and {spacings[-1]:g} m apart, whole and thinned). Errors are *air; surface; turned; relative error in air*, geometric means "
            f"over scenes. When targets were set a grid took {before} bytes a probe.\n"
            + table(["", "target", *(KIND_TITLES[kind].lower() for kind in kinds)], rows))


FRONT_PICTURE = """
![Error of indirect light against bytes, by kind of scene: the light grid and its baselines](../images/light_against_bytes.png)

*Geometric means over the scenes of a kind. A baseline's line leads from probes 2 m apart to 1 m. Each dot of the light grid is one grid with solved light: filled whole, hollow thinned. Its line is their front.*
"""


INDIRECT_INTRODUCTION = """
## Indirect light
Light that surfaces send back, and the sky's, for engines that draw lamps, suns and emissive surfaces themselves. Neither truth nor any method has light straight from these (`nlg-validate light --light-direct reflected`).
"""
INDIRECT_TARGETS = {"levels": (.7, .5, .5), "furnished": (.7, .6, .6), "daylight": None}


def indirect_ratios(entry, limits=None):
    text = "; ".join(number(entry[group]["value"], 2) for group in GROUPS if group in entry)
    return f"**{text}**" if limits and all(entry[group]["value"] <= limit for group, limit in zip(GROUPS, limits)) else text


def indirect_rows(found):
    spacings = sorted({spacing for kinds in found["to_best_baseline"].values() for spacing in kinds["own"]}, key=lambda key: float(spacing_text(key).removesuffix(" m")))
    least = lambda limits: "; ".join(f"≤ {number(limit, 1)}" for limit in limits) if limits else ""
    rows = []
    for kind, limits in INDIRECT_TARGETS.items():
        for way, words in (("own", "over the best baseline"), ("solved", "over the best baseline with solved light")):
            of_way, held_to = found["to_best_baseline"][kind][way], limits if way == "own" else None
            if of_way:
                rows.append([f"{KIND_TITLES[kind].lower()}, {words}", least(held_to), *(indirect_ratios(of_way.get(spacing, {}), held_to) for spacing in spacings)])
    for key, words in (("by_room", "over the best baseline"), ("by_room_solved", "over the best baseline with solved light")):
        if found[key]:
            rows.append([f"all scenes by room, {words}", "", *(indirect_ratios(found[key].get(spacing, {})) for spacing in spacings)])
    rows.append(["relative error (SMAPE) in air, over the best baseline: levels; furnished scenes; rooms beside daylight", "",
                 *("; ".join(number(of_kind[spacing]["value"], 2) for of_kind in found["smape_in_air"].values() if spacing in of_kind) for spacing in spacings)])
    rows.append(["at a tenth of DDGI's bytes, over DDGI this far apart", "≤ .5; ≤ .5; ≤ .5", *(indirect_ratios(found["tenth_of_ddgi"].get(spacing, {}), (.5, .5, .5)) for spacing in spacings)])
    return ["", "target", *map(spacing_text, spacings)], rows


def behind(found):
    """Where, over the scenes of a kind, the best baseline has less error than ours: a text each."""
    texts = []
    for kind, ways in found["to_best_baseline"].items():
        entries = [(spacing, group, entry[group]) for of_way in ways.values() for spacing, entry in of_way.items() for group in GROUPS if group in entry]
        entries += [(spacing, "relative error in air", entry) for spacing, entry in found["smape_in_air"][kind].items()]
        texts += [f"{KIND_TITLES[kind].lower()} at {spacing_text(spacing)}, {what}: {number(entry['value'], 2)} × {entry['baseline']}" for spacing, what, entry in entries if entry["value"] > 1]
    return texts


def methods_rows(by_kind, kinds, further):
    """A row a method at SHOWN_SPACING: its errors in each kind of scene, then what further makes of its entries, one a kind or none."""
    entries = {kind: shown(by_kind[kind][SHOWN_SPACING]) for kind in kinds}
    titles = {slug: entry["name"] for of_kind in entries.values() for slug, entry in of_kind.items()}
    rows = []
    for slug, title in titles.items():
        for light in LIGHT_ORDER:
            of_light = [entries[kind].get(slug, {}).get(light) for kind in kinds]
            if any(of_light):
                rows.append([title, light, *("; ".join(number(entry[group]["value"], 3) for group in GROUPS) if entry else "" for entry in of_light), *further(of_light)])
    return rows


def per_probe(of_light):
    sizes = [entry["per_probe"] for entry in of_light if entry]
    return f"{sum(sizes) / len(sizes):,.0f}"


def kind_heads(by_kind, kinds):
    scenes = {kind: max(entry[light]["scenes"] for entry in by_kind[kind][SHOWN_SPACING].values() for light in LIGHT_ORDER if light in entry) for kind in kinds}
    return [f"{KIND_TITLES[kind].lower()} ({scenes[kind]})" for kind in kinds]


def behind_by_scene(by_scene, scenes):
    """Where ours has more error than the best baseline of a scene: a text each."""
    titles = {"air": "air", "surface": "surface", "turned": "turned", "smape_in_air": "relative error in air"}
    texts = [f"{scenes[scene]['name']} {title} {number(entry[key]['value'], 2)} × {entry[key]['baseline']}" for scene, entry in by_scene.items() for key, title in titles.items() if entry[key]["value"] > 1]
    return "; ".join(texts) or "nowhere"


def indirect_section(results):
    found = results["indirect"]
    places = next(iter(found["scenes"].values()))["places"]
    kinds = [kind for kind in KIND_TITLES if kind in found["methods"]]
    front = found["front"]
    text = INDIRECT_INTRODUCTION + f"\nRevision {', '.join(f'`{revision}`' for revision in found['revisions'])}; {len(found['scenes'])} scenes, {places['air']:,} points in air of each and {places['surface']:,} before surfaces. Ours is `{results['ours']}` with solved light. Errors and ratios are *air; surface; turned*. **Bold** reaches the target.\n"
    text += table(*indirect_rows(found))
    text += (f"\nOf the points of baselines that can be stored, one of ours matches {front['met']:,} of {front['of']:,} in error at no more bytes (target: all). The others: {missed_text(front)}.\n"
             f"\nWhere the best baseline over the scenes of a kind has less error than ours: {'; '.join(behind(found)) or 'nowhere'}. Against the best baseline of each scene, solved light included: {behind_by_scene(found['by_scene'], found['scenes'])}.\n"
             f"\nMean errors by kind of scene (number of scenes), probes {spacing_text(SHOWN_SPACING)} apart. Exact visibility and target functions cannot be stored:\n"
             + table(["weights", "light", *kind_heads(found["methods"], kinds), "bytes a probe"], methods_rows(found["methods"], kinds, lambda of_light: [per_probe(of_light)])))
    return text + thinning_section(found.get("thinning", {})) + (FRONT_PICTURE if "against_bytes" in found else "")


def methods_section(by_kind):
    """All light: a row a method; empty where nothing was measured at SHOWN_SPACING."""
    kinds = [kind for kind in ("levels", "furnished", "daylight") if SHOWN_SPACING in by_kind.get(kind, {})]
    if not kinds:
        return ""

    def further(of_light):
        of_kinds = lambda write: "; ".join(write(entry) if entry else "" for entry in of_light)
        return [of_kinds(lambda entry: number(entry["dark"]["value"], 3)), of_kinds(lambda entry: number(entry["edge"], 2) if "edge" in entry else ""), per_probe(of_light), of_kinds(lambda entry: f"{entry['seconds']:,.1f}")]

    return (f"\n### By method\nMean errors by kind of scene (number of scenes), probes {spacing_text(SHOWN_SPACING)} apart. Dark, edges and processor seconds of the bake are in the order of the kinds.\n"
            + table(["weights", "light", *kind_heads(by_kind, kinds), "dark", "edges", "bytes a probe", "bake, s"], methods_rows(by_kind, kinds, further)))


SEEN_INTRODUCTION = """
## What the eye sees
Views of every room from where a player stands, drawn by truth and by every method pixel by pixel. Each view is exposed by its own truth. ΔE is the mean HyAB distance in CIE L\\*a\\*b\\* of what is shown: 2.3 is just visible. *Off* is the share of pixels brighter or darker than truth by more than a factor of two, *edges* the same within 10 cm of edges. *Rings* are pixels darker by a third than every truth within 20 cm. A patch of sun smaller than the spacing of the probes is too dark in every grid; engines draw it with shadow maps. How it is measured: [formats](json.md#viewsjson).

Measured with `--width 192 --height 108 --most-views 12 --truth-rays 256 --truth-noise .05 --probe-rays 1024 --target-functions`; the defaults take a fraction of the time.
"""


def seen_targets(found, ours):
    """What pictures are held to."""
    rows = []
    daylight = found["methods"].get("daylight", {})
    off = {name: entry["all"]["off_2"] for name, entry in daylight.items()}
    mine, exact, ddgi = (min((value for name, value in off.items() if name.startswith(start)), default=None) for start in (f"{ours}_solved", "exact_visibility", "DDGI"))
    if None not in (mine, exact, ddgi):
        rows.append(["rooms beside daylight, pixels off by 2 ×: ours; exact visibility; DDGI", "≤ 1 %; no more than the second; a fifth of the third", "; ".join(map(percent, (mine, exact, ddgi))),
                     reached(mine <= .01 and mine <= exact and 5 * mine <= ddgi)])
    for key, title, limit in (("levels", "levels", .6), ("rooms", "furnished scenes and rooms beside daylight", .5)):
        if key in found["hyab_over_best_baseline"]:
            ratio = found["hyab_over_best_baseline"][key]
            rows.append([f"{title}: ΔE over that of the best baseline, {ratio['baseline']}", f"≤ {number(limit, 1)}", estimate(ratio, 2), reached(ratio["value"] <= limit)])
    largest = found["ringing_largest"]
    rows.append(["rings, the scene that has most: of all pixels; in shadow", "≤ .1 %", "; ".join(percent(value) for value in largest.values()), reached(largest["all"] <= .001)])
    return table(["", "target", "measured", "reached"], rows)


def seen_section(results):
    found = results["views"]
    revisions = ", ".join(f"`{revision}`" for revision in found["revisions"])
    kinds = {kind: max(entry["scenes"] for entry in methods.values()) for kind, methods in found["methods"].items()}
    percents = lambda value: number(100 * value, 1)
    rows = []
    for slug, name, light in dict.fromkeys((slug, entry["name"], entry["light"]) for methods in found["methods"].values() for slug, entry in methods.items()):
        entries = [found["methods"][kind].get(slug) for kind in kinds]
        rows.append([name, light, *("; ".join([number(entry["all"]["hyab"], 1), percents(entry["all"]["off_2"]), percents(entry["edge"]["off_2"]) if "edge" in entry else "", percents(entry["all"]["ringing"])])
                                    if entry else "" for entry in entries)])
    return (SEEN_INTRODUCTION + f"\nRevision {revisions}.\n" + seen_targets(found, results["ours"])
            + f"\nBy kind of scene (number of scenes), probes {spacing_text(SHOWN_SPACING)} apart: *ΔE; off; edges; rings*, shares in per cent.\n"
            + table(["method", "light", *(f"{KIND_TITLES[kind].lower()} ({count})" for kind, count in kinds.items())], rows))


def scenes_section(scenes):
    """What bounds every figure: truth's own noise, and what no probe is better than."""
    noise = max(scenes.values(), key=lambda entry: entry["truth"]["noise"])
    floors = "; ".join(f"{group} {number(min(values), 3)} to {number(max(values), 3)}" for group in GROUPS for values in [[entry["floor"][group] for entry in scenes.values()]])
    places = next(iter(scenes.values()))["truth"]["places"]
    return (f"\n## Scenes\n{len(scenes)} scenes, {places['air']:,} points in air of each and {places['surface']:,} before surfaces: {', '.join(sorted(entry['name'] for entry in scenes.values()))}. Truth's standard deviation over its root mean square is at most "
            f"{percent(noise['truth']['noise'])} ({noise['name']}). Harmonics gathered at the sample point itself, the least error that a probe can have: {floors}.\n")


BLEND_INTRODUCTION = """
## Holes, leaks and shares
Errors of blends by the functions of {ours}, probes {spacing} apart, at points in air and before surfaces. A *hole*: no probe has weight, though some should. A *leak*: probes that should have none hold more than a fifth. *TV*: half of the mean error of shares. In the order *holes; leaks; TV*, in per cent. Bounds: [theory](../theory/errors.md).
"""


def blend_section(results):
    """Empty of results without these figures."""
    blends = {entry["name"]: entry["blend"] for entry in results["scenes"].values() if "blend" in entry}
    if not blends:
        return ""
    classes = list(next(iter(blends.values())))
    cell = lambda found: "; ".join(number(100 * found[key], 2) for key in ("holes", "leaks", "total_variation"))
    head = [name.replace("_", " ").replace("cm", " cm") for name in classes]
    return BLEND_INTRODUCTION.format(ours=f"`{results['ours']}`", spacing=spacing_text(SHOWN_SPACING)) + table(["scene", *head], [[name, *(cell(found[some]) for some in classes)] for name, found in blends.items()])


def page(all_results):
    results = all_results[NAME]
    text = INTRODUCTION + f"\nMade by `{results['command']}`, revision {', '.join(f'`{revision}`' for revision in results['revisions'])}. {results.get('note', '')}\n"
    text += (indirect_section(results) if "indirect" in results else "") + targets_section(results)
    text += seen_section(results) if "views" in results else ""
    return text + blend_section(results) + scenes_section(results["scenes"])

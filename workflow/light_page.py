"""docs/reference/light.md: light, against ground truth and rivals. Written by results.py from docs/results/light.json."""
from results_page import spread, table
from results_quotes import number, percent

NAME = "light"
OURS = "tent_mlp4"  # what nlg-bake takes without being told
GROUPS = ("air", "surface", "turned")
KIND_TITLES = {"all": "All scenes", "levels": "Levels that hold their own light", "furnished": "Furnished and thin-walled scenes", "boxes": "Test boxes"}
LIGHT_ORDER = ("point", "own", "solved")
UNKNOWN = "not measured"
BOX_BYTES = {8: 1000, 729: 60000}  # by probes

# of nlg-validate light: 9, 5, 3 and 2 probes an edge, the outermost a millimetre off the walls
BOX_PROBES = """
The probes of the Cornell box stand in its air, 9, 5, 3 or 2 an edge: `cornell --align-lattice --density-growth 0 --extent-m=-0.999,0.001,-0.999,0.999,1.999,0.999 --spacings 0.24975 --spacings 0.4995 --spacings 0.999 --spacings 1.998`.
"""
INTRODUCTION = """# Light

*Written by `workflow/results.py write` from `docs/results/light.json`. Change nothing here by hand.*

What a level looks like under each way to light it, against ground truth by path tracing. All methods have the same probes, the same rays and the same places. Errors are RMSE of irradiance over its root mean square, given in three groups, always in this order:

- **air**: places uniform in air, any normal.
- **surface**: 5 to 50 cm before surfaces, with the surface's normal.
- **turned**: the same places, any normal.

Light at probes is *point*, gathered where the probe stands; *solved*, fitted to light at places in air that no figure uses; or a method's *own* form. *Dark* is the mean light at places that should be dark, beyond what truth has there, over the level's mean. *Jumps* are what neighbouring places differ by beyond truth. Numbers in parentheses are 95 % intervals, by bootstrap over scenes. What is known of a revision's figures beside this page: [lab](../lab/light.md). How it is measured, and what the methods are: [formats](formats.md#lightjson); how light is baked: [light](../theory/light.md).
"""


def estimate(found, digits=3):
    text = number(found["value"], digits)
    return text if found.get("low") is None else text + spread([found["low"], found["high"]], lambda value: number(value, digits))


def bytes_text(value):
    return f"{value:,.0f} B" if value < 1000 else f"{value / 1000:,.1f} kB" if value < 1e6 else f"{value / 1e6:,.2f} MB"


def spacing_text(key):
    return key.removesuffix("m").replace("_", ".") + " m"


def reached(holds):
    return {True: "yes", False: "no", None: ""}[holds]


def box_row(found):
    judged = [entry for entry in found.values() if entry["probes"] in BOX_BYTES]
    words = "; ".join(f"{entry['probes']:,} probes: {bytes_text(entry['bytes'])} (DDGI {bytes_text(entry['ddgi_bytes'])}), error {number(entry['rmse_to_ddgi'], 2)} ×, "
                      f"jumps {number(entry['jump_to_ddgi'], 2) + ' ×' if entry['jump_to_ddgi'] is not None else 'none of DDGI’s'}" for entry in found.values())
    holds = all(entry["bytes"] <= BOX_BYTES[entry["probes"]] and entry["rmse_to_ddgi"] <= 1 and entry["jump_to_ddgi"] is not None and entry["jump_to_ddgi"] <= 1 for entry in judged) if judged else None
    return ["Cornell box: bytes, largest error and mean jump over DDGI's", "talk: 4 kB of 8 probes, 183 kB of 729; DDGI as shipped", "8 probes ≤ 1 kB, 729 ≤ 60 kB; ≤ 1 ×", words or UNKNOWN, reached(holds)]


def ratio_rows(what, rivals, found, limits):
    """One row a spacing: ours over the best rival, of the three groups."""
    rows = []
    for spacing, entry in found.items():
        words = "; ".join(f"{estimate(entry[group], 2)}" for group in GROUPS if group in entry)
        best = ", ".join(dict.fromkeys(entry[group]["rival"] for group in GROUPS if group in entry))
        holds = all(entry[group]["value"] <= limit for group, limit in zip(GROUPS, limits)) if limits and len(entry) == len(GROUPS) else None
        rows.append([f"{what}, {spacing_text(spacing)} apart", f"{rivals}; best: {best}", "; ".join(f"≤ {number(limit, 1)}" for limit in limits) if limits else "shown beside it", words, reached(holds)])
    return rows or [[what, rivals, "; ".join(f"≤ {number(limit, 1)}" for limit in limits) if limits else "shown beside it", UNKNOWN, ""]]


def dark_rows(found):
    rows = []
    for spacing, entry in found.items():
        ours, trilinear, exact = entry["ours"]["value"], entry["valid_trilinear"]["value"], entry["exact_visibility"]["value"]
        rows.append([f"excess light in the dark, {spacing_text(spacing)} apart", "valid trilinear; exact visibility, both with light at probes", "a fifth of the first; no more than the second",
                     f"{estimate(entry['ours'], 4)}; valid trilinear {number(trilinear, 4)}, exact visibility {number(exact, 4)}", reached(5 * ours <= trilinear and ours <= exact)])
    return rows or [["excess light in the dark", "valid trilinear; exact visibility", "a fifth of the first; no more than the second", UNKNOWN, ""]]


# Coherent and scattered positions, a second, of look-ups in batches.
LOOK_UP_TARGETS = {"walk": 12e6, "scattered": 5e6}


def speed_rows(results):
    rows = []
    for name, found in results.get("noise", {}).items():
        limit = {"integrated": 300, "solved": 1500}.get(found["light"])
        quiet = found["noise"]["median"] <= .02 and found["noise"]["p95"] <= .1
        rows.append([f"probes lit a second on one core, {found['scene']}, {found['light']}", "talk 34 to 39", "≥ 1,500 gathered, ≥ 300 path traced, at ≤ 2 % median and ≤ 10 % p95 noise",
                     f"{found['probes_per_s']:,.0f}, noise {percent(found['noise']['median'])} and {percent(found['noise']['p95'])}",
                     reached(quiet and found["probes_per_s"] >= limit if limit else None)])
    for case in results.get("benchmarks", {}).values():
        if "items_per_second" in case:
            target = LOOK_UP_TARGETS.get(case["case"].rsplit("/", 1)[-1]) if "/batched/" in case["case"] else None
            rows.append([f"look-up to irradiance, one core: `{case['case']}`", "", f"≥ {target / 1e6:.0f} M/s" if target else "", f"{case['items_per_second'] / 1e6:,.1f} M/s",
                         reached(case["items_per_second"] >= target) if target else ""])
    for found in results.get("bakes", {}).values():
        rows.append([f"whole bake with light, {found['scene']}, {found['threads']} threads", "", "≤ 40 s, kaos2", f"{found['wall_s']:.1f} s; {bytes_text(found['bytes'])}, {found['bytes_per_probe']:.0f} bytes a probe",
                     reached(found["wall_s"] <= 40) if "kaos2" in found["scene"] else ""])
    return rows


def targets_section(results):
    found = results["targets"]
    rivals, solved = "validity mask, APV, DDGI as shipped", "the same weights with solved light, tetrahedra too"
    front, most = found["front"], found["per_probe"]
    air = found["unlit_largest"], found["outside_largest"]
    rows = [box_row(found["box"]), *ratio_rows("levels: RMSE over the best rival's, air; surface; turned", rivals, found["levels"], (.7, .5, .5)),
            *ratio_rows("levels, rivals with solved light", solved, found["levels_solved"], None),
            *ratio_rows("furnished and thin-walled scenes", rivals, found["furnished"], (.7, .6, .6)),
            *ratio_rows("furnished scenes, rivals with solved light", solved, found["furnished_solved"], None),
            ["rivals' points that one of ours matches in error at no more bytes", "all that can be stored, their own light", "all", f"{front['met']:,} of {front['of']:,}", reached(front["met"] == front["of"] if front["of"] else None)]]
    for spacing, entry in found["tenth_of_ddgi"].items():
        rows.append([f"error at a tenth of the bytes of DDGI {spacing_text(spacing)} apart, over DDGI's", "DDGI as shipped", "≤ .5", "; ".join(estimate(entry[group], 2) for group in GROUPS if group in entry),
                     reached(all(entry[group]["value"] <= .5 for group in entry))])
    rows += dark_rows(found["dark"])
    rows.append(["air that nothing lights; air outside the tree: largest of all scenes", "1.6 % of kaos2 before", "≤ .05 %; 0", f"{percent(air[0])}; {percent(air[1])}", reached(air[0] <= .0005 and air[1] == 0)])
    rows.append(["bytes a live probe, everything: least and most of all scenes and spacings", "talk 236 to 339; DDGI 1,056", "≤ 60", f"{most['least']:.0f} to {most['most']:.0f}", reached(most["most"] <= 60)])
    for what, level in (("kaos2 at the error of our own probes with point light 1 m apart", found["level_bytes"]),
                        ("kaos2 with less error than every rival 1 m apart", found["bytes_below_rivals"])):
        rows.append([what, "validity mask, APV, DDGI as shipped" if "rival" in what else "", "≤ 1 MB", UNKNOWN if level is None else bytes_text(level), reached(None if level is None else level <= 1e6)])
    return f"\n## Targets\nOurs is `{results['ours']}` with solved light, through the engine's own look-up.\n" + table(["what", "rivals", "target", "measured", "reached"], rows + speed_rows(results))


HEAD = ["weights", "light", "air", "surface", "turned", "over valid trilinear: air", "surface", "turned", "dark", "jumps: mean", "unlit", "bytes a probe", "bake, s", "look-ups/s"]


def method_row(name, light, entry):
    ratios = [estimate(entry[group]["ratio"], 2) if "ratio" in entry[group] else "" for group in GROUPS]
    return [name, light, *(estimate(entry[group]) for group in GROUPS), *ratios, estimate(entry["dark"], 4), number(entry["jump_mean"], 4), percent(entry["unlit"]),
            f"{entry['per_probe']:,.0f}", f"{entry['seconds']:,.2f}", f"{entry['look_ups_per_s']:,.0f}" if "look_ups_per_s" in entry else ""]


def methods_section(kind, by_spacing):
    text = ""
    for spacing, found in by_spacing.items():
        scenes = max(entry[light]["scenes"] for entry in found.values() for light in LIGHT_ORDER if light in entry)
        rows = [method_row(f"`{entry['name']}`", light, entry[light]) for entry in found.values() for light in LIGHT_ORDER if light in entry]
        text += f"\n### {KIND_TITLES[kind]}, probes {spacing_text(spacing)} apart\nMeans over {scenes} scene{'s' if scenes != 1 else ''}; ratios are geometric means.\n" + table(HEAD, rows)
    return text


def scenes_section(scenes):
    rows = [[entry["name"], KIND_TITLES[entry["kind"]].lower(), f"{entry['truth']['places']['air']:,}", f"{entry['truth']['places']['surface']:,}", f"{entry['truth']['places']['dark']:,}",
             percent(entry["truth"]["noise"]), *(number(entry["floor"][group], 3) for group in GROUPS)] for entry in scenes.values()]
    text = "\n## Scenes\nThe floor is the error of harmonics gathered at the place itself, which no probe is better than. The truth's noise is its own standard deviation over its root mean square.\n"
    return text + table(["scene", "kind", "places in air", "before surfaces", "dark", "truth's noise", "floor: air", "surface", "turned"], rows)


def page(all_results):
    results = all_results.get(NAME, {"pending": True})
    if results.get("pending"):
        return INTRODUCTION + "\nNot measured at this revision.\n"
    text = INTRODUCTION + BOX_PROBES + f"\nMade by `{results['command']}` of revision {', '.join(f'`{revision}`' for revision in results['revisions'])}.\n" + targets_section(results)
    text += "\n## Every method\n" + "".join(methods_section(kind, by_spacing) for kind, by_spacing in results["methods"].items())
    return text + scenes_section(results["scenes"])

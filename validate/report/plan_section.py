"""What a run was planned to take beside what came of it, and what its data are: the section "data" of the page.

plan.json is of workflow/plan.py, times.json of workflow/run_progress.py, the data card of `nlg-datagen info --json FOLDER`.
"""
import os

from findings import grouped, percent
from tool.duration import duration
from tool.input_file import read_json

SPLITS = {"training": "trained on", "held_out": "held out", "evaluation": "evaluation"}
LEFT_OUT = {"free_space": "open air", "in_solid": "solid", "duplicates": "duplicate", "empty": "dark", "outside": "outside"}
KINDS = {"bare_tents": "bare tent is enough", "hard": "hard", "of_solid": "of probes in solid"}


def totals(card):
    """Split → key → sum over its scenes; splits without shards are left out."""
    sums = {}
    for scene in card["scenes"].items():
        split = sums.setdefault(scene["split"].text(), dict.fromkeys(["probes", "functions", *LEFT_OUT, *KINDS], 0))
        for key in split:
            split[key] += scene[key].count()
    return {split: sums[split] for split in [*SPLITS, *sorted({*sums} - {*SPLITS})] if split in sums}


def card_rows(card):
    for split, sums in totals(card).items():
        functions = max(sums["functions"], 1)
        yield {"scenes": SPLITS.get(split, split), "probes": grouped(sums["probes"]), **{f"left out: {name}": grouped(sums[key]) for key, name in LEFT_OUT.items()},
               "functions": grouped(sums["functions"]), **{name: percent(sums[key] / functions) for key, name in KINDS.items()}}


def hardness_rows(card):
    """How many functions of each split have a bare tent of such a blend RMSE: what training saw beside what it is judged on."""
    bins = {}
    for scene in card["scenes"].items():
        for number, one in enumerate(scene["tent_blend_rmse"].items()):
            row = bins.setdefault(number, {"at most": one["at_most"].value})
            row[scene["split"].text()] = row.get(scene["split"].text(), 0) + one["functions"].count()
    splits = list(totals(card))
    sums = {split: max(sum(row.get(split, 0) for row in bins.values()), 1) for split in splits}
    for row in bins.values():
        yield {"the bare tent's blend RMSE": "more" if row["at most"] is None else f"at most {row['at most']:g}", **{SPLITS.get(split, split): percent(row.get(split, 0) / sums[split]) for split in splits}}


def data_rows(plan, card):
    for split, sums in totals(card).items():
        if split in plan["splits"]:
            planned = plan["splits"][split]
            yield {"scenes": SPLITS[split], **{f"{key}, {which}": grouped(round(value)) for key in ("probes", "functions")
                                               for which, value in (("planned", planned[key].number()), ("made", sums[key]))}}


def stage_rows(plan, times):
    """Seconds of a stage's jobs one after the other, each on the cores that it can use."""
    sums = [0.0, 0.0]
    for stage in plan["stages"].items():
        name, planned = stage["name"].text(), stage["core_s"].number() / stage["cores"].number(1)
        found = times["stages"][name] if times and name in times["stages"] else None
        row = {"stage": name, "jobs planned": grouped(stage["jobs"].count()), "jobs done": grouped(found["jobs"].count()) if found else "–", "planned": duration(planned), "took": "–", "took / planned": "–"}
        if found:
            took = found["seconds"].number()
            sums = [sums[0] + planned, sums[1] + took]
            row |= {"took": duration(took), "took / planned": f"{took / planned:.2f}"}
        yield row
    if sums[0]:
        yield {"stage": "all that was timed", "jobs planned": "", "jobs done": "", "planned": duration(sums[0]), "took": duration(sums[1]), "took / planned": f"{sums[1] / sums[0]:.2f}"}


def tables(run, card_path):
    """(title, what it says, rows); the last two only of a run that was planned."""
    card = read_json(card_path)
    collected = sorted({scene["scene"].text() for scene in card["scenes"].items() if scene["split"].text() not in SPLITS})
    of_bakes = f" Functions that failed in bakes were collected of {', '.join(collected)}." * bool(collected)
    result = [("The data", f"{card['shards'].count()} shards.{of_bakes} Probes that no function was made of, by reason; of the functions, how many are of each kind.", list(card_rows(card))),
              ("How hard functions are", "Share of the functions. Where held-out scenes have more of the hard kind than the training saw, more such levels help.", list(hardness_rows(card)))]
    files = [os.path.join(run or "", name) for name in ("plan.json", "times.json")]
    if not run or not os.path.isfile(files[0]):
        return result
    plan, times = read_json(files[0]), read_json(files[1]) if os.path.isfile(files[1]) else None
    if times and times["plan"].value != plan["configuration"].value:
        times = None
    words = f"Planned by a sample of the shards before anything was made: {duration(plan['clock_s'].number())} by the clock on {plan['cores'].count()} cores."
    stages = ("Jobs of a stage one after the other, each on the cores that it can use. A dash: nothing was done under this plan, since it was there already or is not over yet (this page)"
              + ("." if times else "; jobs of a batch system are not timed."))
    return result + [("Planned and made", words, list(data_rows(plan, card))), ("Planned and taken", stages, list(stage_rows(plan, times)))]

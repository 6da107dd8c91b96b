"""docs/reference/reliability.md: what a siege of the whole chain found. Written by results.py from docs/results/reliability.json."""
import json

from results_page import table

NAME = "reliability"
# of kinds of cases, by how their rows begin; the findings have cases of their own
TARGETS = {"kills": 300, "injected errors": 500, "damaged": 3000, "hostile scenes": 400}
INTRODUCTION = """# Reliability

*Written by `workflow/results.py write` from `docs/results/reliability.json`. Change nothing here by hand.*

`tests/siege/run.py` kills, disturbs and deceives every tool and the whole pipeline, some thousand times, the same way for the same seed. A row is a kind of case; a column is what must not happen, and counts the cases in which it did.

- **torn**: a file with a finished file's name is not whole, or a restart ends in other bytes than an undisturbed run, or a file of others was touched.
- **left behind**: a temporary or useless file stays.
- **hang**: a tool does not end within its time.
- **silently accepted**: a reader ends well on bytes that are not the original ones, or a tool does without its result.
- **traceback or abort**: a tool ends by a signal, an assertion or an exception that nobody caught.
- **memory**: more than a scene may take, or what a sanitizer says.
- **wrong ending**: another exit code than those of `tool/error.h`, more or less than one line, or control characters on stderr.

Kills are SIGKILL: at one system call of a tool, or at a random moment of a pipeline. Injected errors make one call fail, or all from there on (a full disk, no more files, memory or threads), or cut a read or write short. Files are damaged by flipped bits, zeroed words, ffff in place of 0000, cuts, appended, swapped and lost bytes, and by FIFOs, folders, links and devices in their places. JSON, CSV and YAML say what they say: of them the ending is judged, and what was changed in a run is found by the run's own record (*artefacts of a run*). Scenes are mutated from small sound ones of every format.
"""


def count_of(rows, kind):
    return sum(row["cases"] for name, row in rows.items() if name.startswith(kind))


def page(all_results):
    results = all_results[NAME]
    rows, origin = results["rows"], results["origin"]
    columns = [column for column in next(iter(rows.values())) if column != "cases"]
    targets = ", ".join(f"{count_of(rows, kind):,} of {target:,} {kind}" for kind, target in TARGETS.items())
    text = INTRODUCTION + f"\nMade by `tests/siege/run.py --seed {origin['seed']}` of revision `{origin['revision']}`, and `workflow/results.py collect-siege build/siege`. Against the targets: {targets}.\n"
    text += "\n## Cases\n" + table(["kind", "cases", *columns], [[name, f"{row['cases']:,}", *(f"{row[column]:,}" for column in columns)] for name, row in rows.items()])
    text += "\n## Findings of the first siege\nEach is a few cases by its name: `tests/siege/run.py findings`.\n"
    text += table(["finding", "cases", "failed"], [[name, entry["cases"], entry["failed"]] for name, entry in results["findings"].items()])
    return text


def collect(folder):
    """What tests/siege/run.py wrote, as it is but for the names of what failed."""
    with open(folder / "table.json") as file:
        found = json.load(file)
    return {key: found[key] for key in ("schema_version", "run", "origin", "rows", "findings")}

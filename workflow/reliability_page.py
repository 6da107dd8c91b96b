"""docs/reference/reliability.md: what fault injection into the whole chain found. Written by results.py from docs/results/reliability.json."""
import json

from results_page import table

NAME = "reliability"
# of kinds of cases, by how their rows begin; the findings have cases of their own
TARGETS = {"kills": 300, "injected errors": 500, "damaged": 3000, "hostile scenes": 400}
INTRODUCTION = """# Reliability

*Written by `workflow/results.py write` from `docs/results/reliability.json`. Change nothing here by hand.*

Fault injection: `tests/fault_injection/run.py` kills, disturbs and deceives every tool and the whole pipeline; the same seed gives the same cases. A column is what must not happen:

- **torn**: a file under its final name is not whole, a restart gives other bytes than an undisturbed run, or a file of others was touched.
- **left behind**: a temporary or useless file stays.
- **hang**: a tool exceeds its time.
- **silently accepted**: a reader succeeds on altered bytes, or a tool without its result.
- **traceback or abort**: a signal, an assertion or an uncaught exception.
- **memory**: more than a scene may take, or a sanitizer's finding.
- **wrong ending**: another exit code than those of `tool/error.h`, not exactly one line, or control characters on stderr.

Kills are SIGKILL at one system call, or at a random moment of a pipeline. Injected errors fail one call, or all from there on, or cut a read or write short. Damage: flipped bits, zeroed words, cuts, appended, swapped and lost bytes, and FIFOs, folders, links and devices in place of files. Of JSON, CSV and YAML the ending is judged; what was changed in a run is found by its record (*artefacts of a run*). Scenes are mutated from small sound ones of every format.
"""


def count_of(rows, kind):
    return sum(row["cases"] for name, row in rows.items() if name.startswith(kind))


def page(all_results):
    results = all_results[NAME]
    rows, origin = results["rows"], results["origin"]
    columns = [column for column in next(iter(rows.values())) if column != "cases"]
    targets = ", ".join(f"{count_of(rows, kind):,} of {target:,} {kind}" for kind, target in TARGETS.items())
    text = INTRODUCTION + f"\nMade by `tests/fault_injection/run.py --seed {origin['seed']}` of revision `{origin['revision']}`, and `workflow/results.py collect-fault-injection build/fault_injection`. Against the targets: {targets}.\n"
    bad = lambda row: "; ".join(f"{column} {row[column]:,}" for column in columns if row[column]) or "0"
    text += "\n## Cases\n" + table(["kind", "cases", "in any bad column"], [[name, f"{row['cases']:,}", bad(row)] for name, row in rows.items()])
    text += "\n## Findings of the first run\nEach is a few cases by its name: `tests/fault_injection/run.py findings`.\n"
    text += table(["finding", "cases", "failed"], [[name, entry["cases"], entry["failed"]] for name, entry in results["findings"].items()])
    return text


def collect(folder):
    """What tests/fault_injection/run.py wrote, as it is but for the names of what failed."""
    with open(folder / "table.json") as file:
        found = json.load(file)
    return {key: found[key] for key in ("schema_version", "run", "origin", "rows", "findings")}

"""The table of fault injection, out of what its cases left: a row for every kind of case, a column for everything that must not happen."""
import json
import os

from trial import COLUMNS

SCHEMA_VERSION = 1


def records_of(folder, part):
    """One of each case: the last, where it was run again."""
    path = os.path.join(folder, f"{part}.jsonl")
    if not os.path.exists(path):
        return []
    with open(path) as file:
        return list({record["name"]: record for record in map(json.loads, file)}.values())


def collect(folder, parts, origin):
    """rows: name → cases and how many of them stand in each bad column; findings: name → whether it holds."""
    rows, finding_rows, failed = {}, {}, []
    for part in parts:
        for record in records_of(folder, part):
            bad = {column for column, _ in record["faults"]}
            if part == "findings":
                entry = finding_rows.setdefault(record["row"], {"cases": 0, "failed": 0})
                entry["cases"] += 1
                entry["failed"] += bool(bad)
            row = rows.setdefault("findings of the first run" if part == "findings" else record["row"], {"cases": 0, **{column: 0 for column in COLUMNS}})
            row["cases"] += record["cases"]
            for column in bad:
                row[column] += 1
            failed += [record["name"]] if bad else []
    return {"schema_version": SCHEMA_VERSION, "run": "reliability", "origin": origin, "rows": rows, "findings": dict(sorted(finding_rows.items(), key=number_of)), "failed": failed}


def number_of(entry):
    """D2 before D10."""
    return int(entry[0].split()[0].lstrip("D").rstrip(":"))


def is_bad(found):
    return bool(found["failed"])


def markdown(found):
    lines = ["| | cases | " + " | ".join(COLUMNS) + " |", "|---|" + "---|" * (len(COLUMNS) + 1)]
    for name, row in found["rows"].items():
        lines.append(f"| {name} | {row['cases']:,} | " + " | ".join(f"{row[column]:,}" for column in COLUMNS) + " |")
    lines += ["", "| finding | cases | failed |", "|---|---|---|"]
    lines += [f"| {name} | {entry['cases']} | {entry['failed']} |" for name, entry in found["findings"].items()]
    return "\n".join(lines)


def write(folder, found):
    with open(os.path.join(folder, "table.json"), "w") as file:
        json.dump(found, file, indent=1)
        file.write("\n")
    with open(os.path.join(folder, "table.md"), "w") as file:
        file.write(markdown(found) + "\n")

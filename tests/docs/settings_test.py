#!/usr/bin/env python3
"""docs/reference/formats.md lists for every section of a configuration the settings that the tool's --help has, no more and no fewer.
settings_test.py BIN"""
import re
import subprocess
import sys
from pathlib import Path

PAGE = Path(__file__).resolve().parents[2] / "docs/reference/formats.md"
# The policy's settings are listed once, for the bake; other sections name the first and the last of them.
POLICY = re.compile(r"those of the policy \(`(\w+)` … `(\w+)`")


def listed(row, bake):
    settings = re.findall(r"`(\w+)`", POLICY.sub("", row))
    if policy := POLICY.search(row):
        settings += bake[bake.index(policy[1]):bake.index(policy[2]) + 1]
    return settings


def offered(folder, tool):
    """Options with a default are settings; the others name files or say what to do."""
    name, *command = tool.split()
    text = subprocess.run([folder / name, *command, "--help"], capture_output=True, text=True, check=True).stdout
    # an option's help may stand on the lines after its name
    options = re.findall(r"^  --([a-z0-9-]+)((?:.*\n)(?:      +.*\n)*)", text, flags=re.MULTILINE)
    return [name.replace("-", "_") for name, help_text in options if re.search(r"; default [^)]*\)", help_text)]


def main():
    folder = Path(sys.argv[1])
    rows = dict(re.findall(r"^\| `(\w+)` \| (nlg-[\w -]+) \| .*$", PAGE.read_text(), flags=re.MULTILINE))
    cells = {section: re.search(rf"^\| `{section}` \| {tool} \| (.*) \|$", PAGE.read_text(), flags=re.MULTILINE)[1] for section, tool in rows.items()}
    if "bake" not in rows:
        sys.exit(f"{PAGE}: no row for the section bake")
    problems = []
    for section, tool in rows.items():
        on_page, in_help = set(listed(cells[section], listed(cells["bake"], []))), set(offered(folder, tool))
        problems += [f"{section}: {name} is a setting of {tool}, and formats.md does not list it" for name in sorted(in_help - on_page)]
        problems += [f"{section}: formats.md lists {name}, which {tool} does not know" for name in sorted(on_page - in_help)]
    print("\n".join(problems) or f"{len(rows)} sections list what their tools know")
    return bool(problems)


if __name__ == "__main__":
    sys.exit(main())

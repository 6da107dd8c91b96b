#!/usr/bin/env python3
"""Every relative link of every Markdown page leads to a file and, where it names one, to a heading of it; and every docs/… path that a source, a
setting or a test names is there. links_test.py (from anywhere inside the sources)."""
import re
import subprocess
import sys
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]
SKIPPED = {".png", ".safetensors"}


def anchors(page):
    """The anchors that GitHub gives a page's headings."""
    headings = re.findall(r"^#+ (.+)$", page.read_text(), flags=re.MULTILINE)
    return {re.sub(r"[^\w\- ]", "", heading.lower()).replace(" ", "-") for heading in headings}


def broken_link(page, target):
    """Why a link of a page leads nowhere, or None."""
    if re.match(r"[a-z]+:", target):
        return None
    path, _, anchor = target.partition("#")
    file = (page.parent / path).resolve() if path else page
    if not file.exists():
        return "no such file"
    if anchor and file.suffix == ".md" and anchor not in anchors(file):
        return "no such heading"
    return None


def main():
    listed = subprocess.run(["git", "-C", str(ROOT), "ls-files", "--cached", "--others", "--exclude-standard"], capture_output=True, text=True, check=True)
    files = [path for path in map(ROOT.joinpath, listed.stdout.splitlines()) if path.suffix not in SKIPPED and path.is_file()]
    problems = []
    for file in files:
        name, text = file.relative_to(ROOT), file.read_text(errors="replace")
        if file.suffix == ".md":
            for target in re.findall(r"\]\(([^)\s]+)\)", text):
                if reason := broken_link(file, target):
                    problems.append(f"{name}: {target}: {reason}")
        for path in re.findall(r"(?<![\w/.-])docs/[\w./-]*\w", text):
            there = any((folder / path).exists() for folder in (ROOT, file.parent))  # tests/ has a docs/ of its own
            if not there and not re.search(r"\b[A-Z]+\b", path):  # docs/results/NAME.json
                problems.append(f"{name}: {path}: no such file")
    print("\n".join(problems), file=sys.stderr)
    return 1 if problems else 0


if __name__ == "__main__":
    sys.exit(main())

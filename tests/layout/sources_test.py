#!/usr/bin/env python3
"""What a linker lets pass: two headers that define one name, which a program may then hold in two shapes, and includes of what
cmake/layers.cmake does not let a library link. sources_test.py (from anywhere inside the sources)"""
import re
import subprocess
import sys
from collections import defaultdict
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]
NO_LIBRARIES = ("tests/", "benchmarks/", "examples/")
BELOW_ALL = "runtime_eval/numbers/"  # headers for everybody
TYPE = re.compile(r"^(?:namespace (?P<space>[\w:]+) \{|\}  // namespace (?P<end>[\w:]+)|(?:template <[^\n]*>\n)?(?:struct|class|union|enum(?: class)?) (?P<name>\w+)(?: final)?(?: : [^;{]*)? \{"
                  r"|using (?P<alias>\w+) =)", re.MULTILINE)
LIBRARY = re.compile(r"^ *nlg_(?:library|tool)\((\S+)\s([^)]*)\)", re.MULTILINE)
ALLOWED = re.compile(r"^set\(NLG_MAY_LINK_(\S+)\s+([^)]*)\)", re.MULTILINE)
INCLUDE = re.compile(r'^#include "([^"]+)"', re.MULTILINE)


def files(*patterns):
    listed = subprocess.run(["git", "-C", str(ROOT), "ls-files", "--cached", "--others", "--exclude-standard", *patterns], capture_output=True, text=True, check=True)
    return [path for path in listed.stdout.splitlines() if (ROOT / path).is_file()]


def types_of(text):
    """The names that a header defines in its namespaces, each with them before it."""
    spaces, found = [], set()
    for match in TYPE.finditer(text):
        if match["space"]:
            spaces.append(match["space"])
        elif match["end"]:
            del spaces[-1:]
        else:
            found.add("::".join([*spaces, match["name"] or match["alias"]]))
    return found


def names_defined_twice(headers):
    places = defaultdict(list)
    for header in headers:
        for name in types_of((ROOT / header).read_text()):
            places[name].append(header)
    if len(places) < 200:
        sys.exit(f"only {len(places)} types were found in {len(headers)} headers: nothing was tested")
    return [f"{name}: defined by {' and '.join(where)}" for name, where in sorted(places.items()) if len(where) > 1]


class Rooms:
    """Which library a file belongs to, and what that one may link."""

    def __init__(self):
        self.may_link = {name: {link[5:] for link in links.split() if link.startswith("nlg::")} for name, links in ALLOWED.findall((ROOT / "cmake/layers.cmake").read_text())}
        # the public headers, of which one is what files are answered with
        self.of_source, self.of_folder = {"include/nlg/result.cpp": "weights_file"}, defaultdict(set, {"include/nlg": {"runtime_eval"}})
        for page in files("*CMakeLists.txt"):
            folder = Path(page).parent
            for name, arguments in [] if page.startswith(NO_LIBRARIES) else LIBRARY.findall((ROOT / page).read_text()):
                for source in re.findall(r"[\w./-]+\.cpp\b", arguments.split("LINKS")[0]):
                    self.of_source[str(folder / source)] = name
                    self.of_folder[str((folder / source).parent)].add(name)

    def of(self, path):
        """The libraries that a file may belong to: that of the source of its name, or, of a header alone, each that has sources in its folder."""
        source = re.sub(r"(-inl)?\.\w+$", ".cpp", path)
        return {self.of_source[source]} if source in self.of_source else self.of_folder[str(Path(path).parent)]

    def allows(self, path, included):
        """Whether one of the libraries of a file may link one of those of another."""
        targets = self.of(included)
        return included.startswith(BELOW_ALL) or any(name in targets or targets & self.may_link[name] for name in self.of(path))


def includes_of_strangers(sources):
    rooms, known, count, problems = Rooms(), set(sources), 0, []
    for path in sources:
        for included in INCLUDE.findall((ROOT / path).read_text()):
            if included in known and rooms.of(path):
                count += 1
                if not rooms.allows(path, included):
                    problems.append(f"{path}: includes {included}, and cmake/layers.cmake does not let {'/'.join(rooms.of(path))} link {'/'.join(rooms.of(included)) or 'it'}")
    if count < 500:
        sys.exit(f"only {count} includes were found: nothing was tested")
    return problems


def includes_beside_the_interface(sources):
    """What an engine could not do: examples and modules that include more than the public headers and what lies beside them."""
    return [f"{path}: includes {included}, which is not installed"
            for path in sources for included in INCLUDE.findall((ROOT / path).read_text())
            if not included.startswith("nlg/") and Path(included).parent != Path(path).parent]


def main():
    own = [path for path in files("*.h", "*.cpp") if not path.startswith(NO_LIBRARIES)]
    problems = names_defined_twice(files("*.h")) + includes_of_strangers(own)
    problems += includes_beside_the_interface(files("examples/*", "integrations/python/*.cpp", "integrations/python/*.h"))
    print("\n".join(problems), file=sys.stderr)
    return 1 if problems else 0


if __name__ == "__main__":
    sys.exit(main())

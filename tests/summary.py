#!/usr/bin/env python3
"""The last line of a run of the suite: how many tests ran, which were skipped and why. summary.py LAST_TEST_LOG"""
import re
import sys

TEST = re.compile(r"^\d+/\d+ Testing: (\S+)\n.*?^Output:\n-+\n(.*?)^<end of output>", re.MULTILINE | re.DOTALL)
# a script that ends with 77 says why; so does a case of GoogleTest, in the line after its place
SKIPPED_SCRIPT = re.compile(r"\Askipped: (.*)", re.IGNORECASE)
SKIPPED_CASE = re.compile(r"^\S*?(\w+\.cpp):\d+: Skipped\n(.*)", re.MULTILINE)


def skipped_in(log):
    """How many tests the log holds, and the words of each that was skipped, whole or a case of it."""
    tests = TEST.findall(log)
    found = []
    for name, output in tests:
        if script := SKIPPED_SCRIPT.search(output):
            found.append(f"{name} ({script[1].strip()})")
        found += [f"a case of {name} ({reason.strip()})" for _, reason in SKIPPED_CASE.findall(output)]
    return len(tests), found


def main():
    with open(sys.argv[1], encoding="utf-8", errors="replace") as file:
        count, skipped = skipped_in(file.read())
    words = f"{len(skipped)} skipped: {'; '.join(skipped)}" if skipped else "none skipped"
    print(f"test.sh: {count} tests, {words}")


if __name__ == "__main__":
    main()

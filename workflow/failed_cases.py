"""Names the cases of a stability table that ran and do not hold, one a line.

    failed_cases.py STABILITY.json

Exit code 6 when there is one (tool/error.h), else 0.
"""
import json
import sys


def main():
    with open(sys.argv[1]) as file:
        cases = json.load(file)["cases"]
    failed = [case for case in cases if case["ran"] and not case["holds"]]
    for case in failed:
        print(f"{case['group']}: {case['name']}: {case['measured']}")
    return 6 if failed else 0


if __name__ == "__main__":
    sys.exit(main())

"""Names the cases of a stability table that ran and do not hold, one a line.

    failed_cases.py STABILITY.json

Exit code 6 when there is one (tool/error.h), else 0.
"""
import json
import sys
from pathlib import Path

sys.path.append(str(Path(__file__).resolve().parents[1] / "tool"))
from regular_file import regular


def main():
    with open(sys.argv[1], opener=regular) as file:
        cases = json.load(file)["cases"]
    failed = [case for case in cases if case["ran"] and not case["holds"]]
    for case in failed:
        print(f"{case['group']}: {case['name']}: {case['measured']}")
    return 6 if failed else 0


if __name__ == "__main__":
    sys.exit(main())

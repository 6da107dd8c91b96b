"""Names the cases of a stability table that do not hold, one a line.

    failed_cases.py STABILITY.json

Exit code 6 when there is one, 3 on a table that cannot be used (tool/error.h), else 0.
"""
import sys
from pathlib import Path

sys.path.insert(0, str(Path(__file__).resolve().parents[1]))  # tool/, which all scripts share
from tool.errors import CHECK_FAILED, one_line, run
from tool.input_file import read_json


def main():
    failed = [case for case in read_json(sys.argv[1])["cases"].items() if not case["holds"].truth()]
    lines = [": ".join(case[key].text() for key in ("group", "name", "measured")) for case in failed]
    for line in lines:
        print(one_line(line))
    return CHECK_FAILED if lines else 0


if __name__ == "__main__":
    sys.exit(run("failed_cases", main))

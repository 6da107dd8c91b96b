"""Sums the plans of a run's shards into one table.

    plan.py --training COUNT FILE ... --held-out COUNT FILE ...

COUNT   shards that the run will make; FILE: plans (nlg-datagen plan --json) of all of them, or of an even sample
"""
import argparse
import math
import sys
from pathlib import Path

sys.path.insert(0, str(Path(__file__).resolve().parents[1]))  # tool/, which all scripts share
from tool.errors import run
from tool.input_file import read_json


def read_plan(path):
    plan = read_json(path)
    return {key: plan[key].number() for key in [key for key, _, _ in COLUMNS] + ["scratch_bytes", "uncertainty"]}


def total(plans, count, key):
    """Sum over all shards from those planned, and its standard error."""
    values = [plan[key] for plan in plans]
    mean = sum(values) / len(values)
    own = sum((plan["uncertainty"] / 2 * plan[key]) ** 2 for plan in plans) * (count / len(plans)) ** 2
    spread = sum((value - mean) ** 2 for value in values) / max(len(values) - 1, 1)
    sampling = count * count * spread / len(values) * (1 - len(values) / count)
    return mean * count, math.sqrt(own + sampling)


COLUMNS = [("visited_probes", "probes", 1), ("functions", "functions", 1), ("bytes", "MB", 1e6), ("core_seconds", "core-hours", 3600)]


def main():
    parser = argparse.ArgumentParser()
    parser.add_argument("--training", nargs="+", required=True)
    parser.add_argument("--held-out", nargs="+", required=True)
    arguments = parser.parse_args()
    sums = {key: [0.0, 0.0] for key, _, _ in COLUMNS}
    scratch = 0.0
    print(f"{'':12}{'shards':>8}" + "".join(f"{title:>22}" for _, title, _ in COLUMNS))

    def row(title, shards, values):
        cells = []
        for (_, _, unit), (value, error) in zip(COLUMNS, values):
            share = 200 * error / value if value else 0
            cells.append(f"{value / unit:,.{0 if unit in (1, 1e6) and value / unit >= 100 else 3}f} +-{share:.0f} %".rjust(22))
        print(f"{title:12}{shards:>8}" + "".join(cells))

    shards = 0
    for name, (count, *paths) in [("training", arguments.training), ("held out", arguments.held_out)]:
        plans = [read_plan(path) for path in paths]
        scratch = max([scratch] + [plan["scratch_bytes"] for plan in plans])
        values = [total(plans, int(count), key) for key, _, _ in COLUMNS]
        row(name, int(count), values)
        shards += int(count)
        for (key, _, _), (value, error) in zip(COLUMNS, values):
            sums[key][0] += value
            sums[key][1] = math.hypot(sums[key][1], error)
    row("all", shards, [tuple(sums[key]) for key, _, _ in COLUMNS])
    print(f"+-: two standard errors. Beside the files each shard at work needs up to {scratch / 1e6:,.0f} MB of scratch space.")


if __name__ == "__main__":
    sys.exit(run("plan", main))

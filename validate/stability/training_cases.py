#!/usr/bin/python3
"""The training cases of `nlg-validate stability`: nlg-train on a tiny set of functions while things go wrong.

    training_cases.py BIN_FOLDER OUT.json

Writes {"schema_version": 1, "cases": [...]} as stability.json holds them (docs/reference/formats.md); `nlg-validate stability --training OUT.json`
takes them over. Exit code 6 when some case does not hold.
"""
import csv
import hashlib
import json
import math
import os
import re
import shutil
import struct
import subprocess
import sys
import tempfile
import time
from pathlib import Path

sys.path.insert(0, str(Path(__file__).resolve().parents[2]))  # tool/, which all scripts share
from tool.atomic_file import write_atomically
from tool.errors import CHECK_FAILED, run

INPUT_ERROR, NUMERICAL_ERROR = 3, 4  # tool/error.h
HEAD, POINTS, VALIDITY, SUMS, BLOCK = 4096, 8192, 1024, 8192, 512  # docs/reference/formats.md, "Function cache"

CHECKPOINT_STEPS = 10
# a poisoned coefficient is read by a generator of coefficients alone
OPTIONS = ["--input", "coefficients", "--batch", "8", "--checkpoint-steps", str(CHECKPOINT_STEPS), "--start-candidates", "1", "--width", "24", "--layers", "2", "--theta-share", "0.25"]
INPUTS = ["--representation", "tent_mlp", "--basis", "basis.h5", "--held-out", "held_out.h5"]
LONG = 1000000  # steps that no run here comes to the end of


def changed_cache(source, path, change):
    """A copy of a function cache after change(records, record_size, coefficient_count), with digests that fit."""
    with open(source, "rb") as file:
        whole = bytearray(file.read())
    footer_first = struct.unpack_from("<Q", whole, 16)[0]
    json_text, _, tail = bytes(whole[footer_first:]).partition(b"\n")
    values = json.loads(json_text)
    size = POINTS + 2 * VALIDITY + SUMS + 4 * values["coefficient_count"]
    records = whole[HEAD:footer_first]
    change(records, size)
    values["block_sha256"] = [hashlib.sha256(records[i : i + BLOCK * size]).hexdigest() for i in range(0, len(records), BLOCK * size)]
    footer = json.dumps(values).encode() + b"\n" + tail
    whole[24:88] = hashlib.sha256(footer).hexdigest().encode()
    with open(path, "wb") as file:
        file.write(whole[:HEAD] + records + footer)


def poisoned_cache(source, path, function):
    """One function's first coefficient is 1e30."""
    changed_cache(source, path, lambda records, size: struct.pack_into("<f", records, function * size + POINTS + 2 * VALIDITY + SUMS, 1e30))


def extreme_cache(source, path):
    """Functions of nothing but 255, of nothing but 0, and without a valid point, every fifth one each."""
    def change(records, size):
        for first in range(0, len(records) - 2 * size, 5 * size):
            for n, (phi, validity) in enumerate([(255, 255), (0, 255), (0, 0)]):
                if first + (n + 1) * size > len(records):
                    continue
                at = first + n * size
                records[at : at + POINTS] = bytes([phi]) * POINTS
                records[at + POINTS : at + POINTS + VALIDITY] = bytes([validity]) * VALIDITY
    changed_cache(source, path, change)


class Training:
    """nlg-train in a folder of its own."""

    def __init__(self, bin_folder, name, data, steps, rate="0.003"):
        self.name = name
        self.process = subprocess.Popen(
            [os.path.join(bin_folder, "nlg-train"), *INPUTS, *OPTIONS, *data, "--steps", str(steps), "--out", f"{name}.ckpt",
             "--run", f"{name}_run", "--log", f"{name}.csv", "--learning-rate", rate], stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True)

    def wait_for_checkpoint(self):
        deadline = time.time() + 120
        while self.process.poll() is None and not os.path.exists(f"{self.name}_run/latest") and time.time() < deadline:
            time.sleep(0.01)

    def end(self, timeout_s=240):
        """Waits; a run that is still at work then is ended and has no exit code."""
        self.stopped = True
        try:
            self.out, self.err = self.process.communicate(timeout=timeout_s)
        except subprocess.TimeoutExpired:
            self.stopped = False
            self.process.kill()
            self.out, self.err = self.process.communicate()
        self.code = self.process.returncode if self.stopped else None
        errors = [line for line in self.err.splitlines() if "error:" in line]
        self.line = errors[-1].split("error: ", 1)[1] if errors else ""
        self.result = json.loads(self.out) if self.code == 0 else {}
        return self

    @property
    def has_checkpoint(self):
        return os.path.exists(f"{self.name}_run/latest")

    def held_out(self):
        """The held-out blend RMSE at every checkpoint."""
        path = f"{self.name}.csv" if os.path.exists(f"{self.name}.csv") else f"{self.name}_run/log.csv"
        with open(path, newline="") as file:
            return [float(row["held_out_blend_rmse"]) for row in csv.DictReader(file)]


def case(name, must_hold, holds, measured, figures, note=""):
    return {"group": "training", "name": name, "must_hold": must_hold, "measured": measured, "figures": figures, "holds": bool(holds), "note": note}


def stopped_with_cause(run, code, words):
    return run.code == code and words in run.line and len(run.line.splitlines()) == 1 and run.has_checkpoint


def poisoned_batch(bin_folder):
    poisoned_cache("functions.cache", "poisoned.cache", 3)
    run = Training(bin_folder, "poisoned", ["--cache", "poisoned.cache"], 120).end()
    errors, rollbacks = run.held_out(), run.result.get("rollbacks", 0)
    return case("poisoned batch", "training goes back to the last good state, says so, and learns all the same",
                run.code == 0 and 0 < rollbacks <= 5 and run.err.count("rollback") == rollbacks and errors[-1] < errors[0]
                and all(map(math.isfinite, errors)),
                f"a coefficient of 1e30 in one of 700 functions: {rollbacks} rollbacks, held-out blend RMSE {errors[0]:.4f} -> {errors[-1]:.4f}",
                {"rollbacks": rollbacks, "held_out_blend_rmse_first": errors[0], "held_out_blend_rmse_last": errors[-1]})


def poisoned_without_end(bin_folder):
    run = Training(bin_folder, "lasting", ["--cache", "poisoned.cache"], 2000).end()
    return case("poisoned batches without end", "after five rollbacks the run ends with exit code 4 and one line; its last checkpoint stays",
                stopped_with_cause(run, NUMERICAL_ERROR, "after 5 rollbacks"), f"exit code {run.code}: {run.line}", {"exit_code": run.code})


def exploding_rate(bin_folder):
    measured, figures, holds = [], {}, True
    for rate in ["1", "1000"]:
        run = Training(bin_folder, f"rate_{rate}", ["--cache", "functions.cache"], 120, rate).end()
        errors = run.held_out() if run.has_checkpoint else []
        step = re.search(r"step (\d+)", run.line)
        # a run that diverges up to its first checkpoint has none to leave
        gave_up = run.code == NUMERICAL_ERROR and step and (run.has_checkpoint or int(step[1]) <= CHECKPOINT_STEPS)
        holds = holds and all(map(math.isfinite, errors)) and (gave_up or (run.code == 0 and errors))
        measured.append(f"rate {rate}: " + (f"held-out blend RMSE {errors[-1]:.4f} after {run.result['rollbacks']} rollbacks" if run.code == 0
                                            else f"exit code {run.code}: {run.line}; {len(errors)} checkpoints' errors, all finite"))
        figures[f"exit_code_rate_{rate}"] = run.code
    return case("exploding learning rate",
                "no error of a checkpoint is ever not finite; the run goes on at half the rate, or ends with exit code 4 and one line and leaves its last checkpoint",
                holds, "; ".join(measured), figures)


def vanished_shard(bin_folder):
    shutil.copy("training.h5", "vanishing.h5")
    run = Training(bin_folder, "vanishing", ["--shards", "vanishing.h5"], 120)
    run.wait_for_checkpoint()
    os.remove("vanishing.h5")
    run.end()
    again = Training(bin_folder, "again", ["--shards", "vanishing.h5"], 120).end()
    return case("shard that vanishes", "a run that has read it goes on to its end; one that has not ends with exit code 3 and a line that names it",
                run.code == 0 and again.code == INPUT_ERROR and "vanishing.h5" in again.line,
                f"midway: exit code {run.code}; before the start: exit code {again.code}: {again.line}",
                {"exit_code_midway": run.code, "exit_code_before": again.code})


def vanished_cache(bin_folder):
    shutil.copy("functions.cache", "vanishing.cache")
    run = Training(bin_folder, "unlinked", ["--cache", "vanishing.cache"], 120)
    run.wait_for_checkpoint()
    os.remove("vanishing.cache")
    run.end()
    undisturbed = Training(bin_folder, "undisturbed", ["--cache", "functions.cache"], 120).end()
    same = run.code == 0 and undisturbed.code == 0 and open("unlinked.ckpt", "rb").read() == open("undisturbed.ckpt", "rb").read()
    return case("cache that vanishes midway", "the run goes on and ends in the bytes of one that was left alone",
                same, f"exit code {run.code}, {'the same' if same else 'other'} bytes", {"exit_code": run.code})


def truncated_cache(bin_folder):
    shutil.copy("functions.cache", "truncated.cache")
    run = Training(bin_folder, "truncated", ["--cache", "truncated.cache"], LONG)
    run.wait_for_checkpoint()
    os.truncate("truncated.cache", 3 * 4096)
    run.end(timeout_s=60)
    return case("cache that is truncated midway", "the run ends with exit code 3 and one line that names the cause; its last checkpoint stays",
                stopped_with_cause(run, INPUT_ERROR, "cache"), f"exit code {run.code}: {run.line}", {"exit_code": run.code})


def extreme_targets(bin_folder):
    extreme_cache("functions.cache", "extreme.cache")
    run = Training(bin_folder, "extreme", ["--cache", "extreme.cache"], 120).end()
    errors = run.held_out()
    return case("extreme targets", "training on them ends with finite errors",
                run.code == 0 and all(map(math.isfinite, errors)),
                f"three of five functions are all 255, all 0 or without a valid point: exit code {run.code}, {run.result.get('rollbacks')} rollbacks, held-out blend RMSE {errors[0]:.4f} -> {errors[-1]:.4f}",
                {"exit_code": run.code, "rollbacks": run.result.get("rollbacks"), "held_out_blend_rmse_last": errors[-1]},
                "Samples are bytes: 0 and 255 are the largest targets there are.")


CASES = [poisoned_batch, poisoned_without_end, exploding_rate, extreme_targets, vanished_shard, vanished_cache, truncated_cache]


def prepare(bin_folder):
    """A tiny set: shards, basis, cache."""
    tools = [["nlg-datagen", "--scene", "house:1", "--max-functions", "700", "--out", "training.h5"],
             ["nlg-datagen", "--scene", "house:2", "--max-functions", "24", "--held-out", "--out", "held_out.h5"],
             ["nlg-pca", "--components", "16", "--shards", "training.h5", "--held-out", "held_out.h5", "--out", "basis.h5"],
             ["nlg-cache", "--basis", "basis.h5", "--shards", "training.h5", "--out", "functions.cache"]]
    for tool, *arguments in tools:
        subprocess.run([os.path.join(bin_folder, tool), *arguments], check=True, stdout=subprocess.DEVNULL)


def main():
    bin_folder, out = os.path.abspath(sys.argv[1]), os.path.abspath(sys.argv[2])
    for variable in ["OPENBLAS_NUM_THREADS", "OMP_NUM_THREADS"]:
        os.environ[variable] = "1"
    with tempfile.TemporaryDirectory() as folder:
        os.chdir(folder)
        prepare(bin_folder)
        cases = [run_case(bin_folder) for run_case in CASES]
        os.chdir("/")
    write_atomically(out, (json.dumps({"schema_version": 1, "cases": cases}, indent=1) + "\n").encode())
    for result in cases:
        print("holds " if result["holds"] else "FAILED", f"{result['name']}: {result['measured']}")
    return 0 if all(result["holds"] for result in cases) else CHECK_FAILED


if __name__ == "__main__":
    sys.exit(run("training_cases", main))

#!/usr/bin/python3
"""Every tool where the system refuses threads, from the first on, from the second, …: it ends by itself, and either it needs no more of them or
one line says so. Nothing hangs, nothing aborts, nothing half-written stays.

    refused_threads_test.py BIN_FOLDER REFUSE_THREADS MOST

MOST   threads that are started before the first is refused, at most; no tool below starts more than 8 at once
"""
import os
import subprocess
import sys
import tempfile

BIN, REFUSE_THREADS = map(os.path.abspath, sys.argv[1:3])
TIMEOUT_S = 60 * float(os.environ.get("NLG_TEST_TIMEOUT_FACTOR", "1"))  # of sanitizers, which slow everything down
MOST = int(sys.argv[3])
failures = []


def run(tool, *arguments, **environment):
    return subprocess.run([os.path.join(BIN, tool), *arguments], capture_output=True, text=True, timeout=TIMEOUT_S, env={**os.environ, **environment})


def must(tool, *arguments):
    result = run(tool, *arguments)
    if result.returncode != 0:
        sys.exit(f"{tool} {' '.join(arguments)}: exit code {result.returncode}\n{result.stderr}")


def check(tool, *arguments, words="threads: expected"):
    """words   of the one line that a refusal ends in"""
    refusals = 0
    for first in range(1, MOST + 1):
        before = set(os.listdir("."))
        case = f"{tool} {' '.join(arguments)}, threads refused from number {first}"
        try:
            result = run(tool, *arguments, LD_PRELOAD=REFUSE_THREADS, NLG_TEST_REFUSE_THREADS_FROM=str(first))
        except subprocess.TimeoutExpired:
            failures.append(f"{case}: still running after {TIMEOUT_S:g} s")
            continue
        left = set(os.listdir(".")) - before
        for path in left:
            os.remove(path) if os.path.isfile(path) else subprocess.run(["rm", "-r", path], check=True)
        if result.returncode == 0:
            continue
        refusals += 1
        errors = [line for line in result.stderr.splitlines() if line and not line.startswith("weights: ")]
        is_own = errors[:1] and errors[0].startswith(f"{tool}: error: ") and words in errors[0]
        if result.returncode != 1 or len(errors) != 1 or not is_own:
            failures.append(f"{case}: exit code {result.returncode}, {result.stderr.strip()[-400:]!r}")
        if left:
            failures.append(f"{case}: left {left}")
    if refusals == 0:
        failures.append(f"{tool} {' '.join(arguments)}: took no thread at all: nothing was tested")


def main():
    os.environ["OPENBLAS_NUM_THREADS"] = "1"  # as workflow/environment.sh has it: OpenBLAS ends the process by a signal of its own
    with tempfile.TemporaryDirectory() as folder:
        os.chdir(folder)
        must("nlg-datagen", "--scene", "house:1", "--max-functions", "60", "--out", "training.h5")
        must("nlg-datagen", "--scene", "house:2", "--max-functions", "12", "--held-out", "--out", "held_out.h5")
        must("nlg-pca", "--components", "8", "--shards", "training.h5", "--held-out", "held_out.h5", "--out", "basis.h5")
        must("nlg-cache", "--basis", "basis.h5", "--shards", "training.h5", "--out", "functions.cache")
        train = ["--representation", "tent_mlp", "--basis", "basis.h5", "--held-out", "held_out.h5", "--steps", "4", "--batch", "4", "--start-candidates", "1",
                 "--width", "16", "--layers", "2", "--out", "bad.ckpt", "--run", "bad_run", "--log", "bad.csv"]
        check("nlg-datagen", "--scene", "house:1", "--max-functions", "60", "--threads", "4", "--out", "bad.h5")
        check("nlg-bake", "house:1", "--spacing-m", "1.5", "--extent-m=0,0,0,2,2,2", "--refine-rounds", "0", "--threads", "3", "--out", "bad.safetensors")
        check("nlg-train", *train, "--cache", "functions.cache")
        check("nlg-train", *train, "--shards", "training.h5", "--threads", "3")
        if (os.cpu_count() or 1) > 1:
            check("nlg-pca", "--components", "8", "--shards", "training.h5", "--held-out", "held_out.h5", "--out", "bad.h5")
        os.chdir("/")
    for failure in failures:
        print("FAILED:", failure)
    return 1 if failures else 0


if __name__ == "__main__":
    sys.exit(main())

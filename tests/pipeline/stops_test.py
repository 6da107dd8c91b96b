#!/usr/bin/python3
"""A whole run that is stopped at random moments, by Ctrl-C and other signals: one line, and the same command ends in the bytes of an unbroken run.

    stops_test.py BIN_FOLDER STOPS          (from the source folder)    STOPS: how many, of each signal in turn
"""
import os
import random
import shutil
import signal
import subprocess
import sys
import tempfile
import time
from pathlib import Path

sys.dont_write_bytecode = True
ROOT = Path(__file__).resolve().parents[2]
sys.path.append(str(ROOT / "tests"))
from tools import room  # noqa: E402

BIN, STOPS = Path(sys.argv[1]).resolve(), int(sys.argv[2])
# as little as the stages take
SMALL = ["scenes.families=[]", "scenes.per_family=0", "scenes.jitters=1", "datagen.max_functions=40", "datagen.test_points=512", "basis.components=16", "train.steps=60", "train.batch=8", "train.start_candidates=4",
         "train.width=16", "train.layers=2", "representations={tent_mlp4: {}}", "split.held_out=[room1]", "export.parity_tolerance=1", "validate.direct_functions=2", "validate.direct_adam_steps=20",
         "validate.direct_lm_iterations=2", "validate.direct_restarts=1", "frontier.functions=2", "frontier.repeats=1", "frontier.direct_adam_steps=[20]", "report.savings=[]"]
SAME = ["basis.h5", "basis.json", "training/tent_mlp4.ckpt", "training/tent_mlp4.csv", "weights/tent_mlp4.safetensors"]  # in which no time stands


def main():
    with tempfile.TemporaryDirectory() as folder:
        folder, draw = Path(folder), random.Random(1)
        levels = folder / "levels"
        levels.mkdir()
        for seed in range(3):
            (levels / f"room{seed}.obj").write_text(room(seed))

        def start(out):
            command = ["./pipeline.sh", "--bin", str(BIN), *(word for setting in SMALL for word in ("--set", setting)), str(levels)]
            return subprocess.Popen(command, cwd=ROOT, env={**os.environ, "NLG_OUT": str(folder / out)}, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True, start_new_session=True)

        def finish(out):
            process = start(out)
            said, errors = process.communicate()
            assert process.returncode == 0, f"{out}: {process.returncode}\n{said}\n{errors}"
            return errors

        def results(out):
            run = folder / out / "levels"
            return {path: (run / path).read_bytes() for path in [*SAME, *(str(shard.relative_to(run)) for shard in run.glob("dataset/*/*.h5"))]}

        began = time.time()
        finish("unbroken")
        took_s = time.time() - began
        for number in range(STOPS):
            by = (signal.SIGINT, signal.SIGTERM, signal.SIGINT, signal.SIGKILL)[number % 4]
            process = start("stopped")
            try:
                # two of eight while interpreters start
                process.wait(draw.uniform(0.3, 3) if number % 8 < 2 else draw.uniform(0.05, 0.5) * took_s)
            except subprocess.TimeoutExpired:
                # of those that end it by SIGTERM every second one tells pipeline.sh alone, as `docker stop` does
                os.kill(process.pid, by) if number % 8 == 1 else os.killpg(process.pid, by)
            _, errors = process.communicate()
            if process.returncode == 0:  # it was done: the next one begins anew
                assert results("stopped") == results("unbroken"), "a stopped run ends otherwise"
                shutil.rmtree(folder / "stopped")
            elif by != signal.SIGKILL:
                lines = errors.splitlines()
                assert process.returncode == 128 + by, f"{by}: {process.returncode}\n{errors}"
                assert lines[-1:] == ["pipeline.sh: stopped; the same command goes on"] and "Traceback" not in errors and " failed" not in errors, f"{by}:\n{errors}"
        finish("stopped")
        # of a run that was killed while it wrote a cache that no later one needs
        left = folder / "stopped/levels/training/functions.cache.tmp.machine.7.0"
        left.touch()
        assert "nothing to be done" in finish("stopped") and not left.exists()
        found, wanted = results("stopped"), results("unbroken")
        assert len(wanted) == len(SAME) + 3 and found == wanted, f"a stopped run ends otherwise: {[path for path in wanted if found.get(path) != wanted[path]]}"


if __name__ == "__main__":
    main()

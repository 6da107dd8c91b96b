#!/usr/bin/python3
"""README's line for own levels, on a folder that nothing has seen: six small rooms to weights, a report and a bake with them.

    own_levels_test.py BIN_FOLDER short|whole          (from the source folder)

whole: with a run from given weights, and a sweep.
"""
import json
import os
import re
import shutil
import subprocess
import sys
import tempfile
from pathlib import Path

sys.dont_write_bytecode = True
sys.path.append(os.path.join(os.path.dirname(os.path.abspath(__file__)), ".."))
from tools import room

ROOT = Path(__file__).resolve().parents[2]
BIN = Path(sys.argv[1]).resolve()
# as little as the stages take; what a user would leave alone
SMALL = ["scenes.families=[house]", "scenes.per_family=1", "scenes.jitters=1", "datagen.max_functions=120", "datagen.test_points=512", "basis.components=64",
         "train.steps=40", "train.batch=32", "train.start_candidates=16", "representations={tent_mlp4: {}}", "validate.direct_functions=4",
         "validate.direct_adam_steps=300", "validate.direct_lm_iterations=4", "validate.direct_restarts=1",
         "frontier.functions=4", "frontier.repeats=2", "frontier.direct_adam_steps=[250]", "bake.spacing_m=1.5"]


def main():
    with tempfile.TemporaryDirectory() as folder:
        folder = Path(folder)
        levels = folder / "six rooms"
        levels.mkdir()
        for seed in range(6):
            (levels / f"room{seed}.obj").write_text(room(seed))
        environment = {**os.environ, "NLG_OUT": str(folder / "out")}
        pipeline = ["./pipeline.sh", "--bin", str(BIN), *(word for setting in SMALL for word in ("--set", setting))]

        def run(*command, code=0):
            done = subprocess.run(command, cwd=ROOT, env=environment, capture_output=True, text=True)
            assert done.returncode == code, f"{command}: {done.returncode}, expected {code}\n{done.stdout}\n{done.stderr}"
            return done

        refused = run(*pipeline, "--set", "split.held_out=[room1, room7]", str(levels), code=2).stderr
        assert "room7" in refused and "room0, room1" in refused and refused.split(": ")[2].startswith("--set"), refused
        overruled = run(*pipeline, "--set", "representations={tent_mlp4: {steps: 7}}", "--set", "train.steps=9", str(levels), code=2).stderr
        assert "representations.tent_mlp4.steps" in overruled, overruled
        # a copy has the same geometry in other bytes, under another name
        copy = levels / "backup.obj"
        copy.write_text("# backup\n" + room(0))
        for more in (["--plan"], []):
            refused = run(*pipeline, "--set", "split.held_out=[room0]", *more, str(levels), code=2).stderr
            assert "room0 is not to be trained on, and backup is the same level" in refused, refused
        assert not (folder / "out").exists(), "a refused run that makes something"
        said = run(*pipeline, "--set", "split.held_out=[room1]", "--plan", str(levels)).stderr
        assert "backup, room0: the same level" in said, said
        copy.unlink()
        # whose bytes the message quotes
        (levels / "rubbish.glb").write_bytes(b"\xb8\x01rubbish")
        refused = run(*pipeline, "--plan", str(levels), code=3).stderr
        assert "rubbish.glb" in refused and "bug" not in refused, refused
        (levels / "rubbish.glb").unlink()
        planned = run(*pipeline, str(levels), "--plan")
        plan = planned.stdout
        assert "1 held-out scene: the verdict will be undecided; name 3 or more by split.held_out" in planned.stderr, planned.stderr
        assert re.search(r" [1-9]\d % of the functions are of your levels", plan), plan
        for words in ("six_rooms", "held out", "data set", "basis", "train tent_mlp4", "validate", "frontier", "report", "functions"):
            assert words in plan, f"the plan lacks '{words}':\n{plan}"
        assert not (folder / "out/six_rooms/dataset").exists(), "a plan that makes data"

        said = run(*pipeline, str(levels))
        out = folder / "out/six_rooms"
        held_out = [path.name.split(".")[0] for path in (out / "dataset/held_out").glob("*.h5")]
        trained = {path.name.split(".")[0] for path in (out / "dataset/training").glob("*.h5")}
        assert len(held_out) == 1 and held_out[0].startswith("room") and held_out[0] in plan, f"{held_out}\n{plan}"
        assert len(trained) == 6 and not trained & set(held_out), trained
        assert "tent_mlp4" in said.stdout and str(out / "report.html") in said.stdout, said.stdout
        page = (out / "report.html").read_text()
        assert held_out[0] in page, "a report without the held-out level"
        times = json.loads((out / "times.json").read_text())["stages"]
        stages = {stage["name"]: stage["jobs"] for stage in json.loads((out / "plan.json").read_text())["stages"]}
        assert {name: stage["jobs"] for name, stage in times.items()} == stages, f"{times}\n{stages}"
        assert "Planned and taken" in page and "train tent_mlp4" in page, "a report without the plan beside what came"
        assert "room" in (out / "configuration.yaml").read_text() or str(levels) in (out / "configuration.yaml").read_text()

        card = run(str(BIN / "nlg-datagen"), "info", str(out / "dataset")).stdout
        assert "7 shards" in card and held_out[0] in card and "bare tent" in card, card
        counted = json.loads(run(str(BIN / "nlg-datagen"), "info", str(out / "dataset"), "--json").stdout)
        assert counted["all"]["functions"] == sum(row["functions"] for row in counted["scenes"]) == sum(b["functions"] for b in counted["all"]["tent_blend_rmse"]) > 0

        weights = out / "weights/tent_mlp4.safetensors"
        run(str(BIN / "nlg-bake"), str(levels / "room0.obj"), "--weights", str(weights), "--spacing-m", "1.5", "--light", "none", "--refine-rounds", "0", "--tau-rmse", "1e-6", "--collect", str(folder / "hard"),
            "--out", str(folder / "room0.safetensors"), "--json", str(folder / "room0.json"))
        baked = json.loads((folder / "room0.json").read_text())
        assert baked["still_failing"] == baked["functions"] > 0, "a bake of which everything was to fail"
        # what it collected is trained on, unless the level is held out, under whatever name
        collecting = [*pipeline, "--set", f"scenes.collected=[{folder / 'hard'}]", "--plan", str(levels)]
        planned = run(*collecting, "--set", "split.held_out=[room1]").stdout
        assert "1 shards of functions that failed in bakes: room0.collected.h5" in planned, planned
        left_out = run(*collecting, "--set", "split.held_out=[room0]")
        assert "left out, because they are of levels that are not to be trained on" in left_out.stderr and "room0.collected.h5" in left_out.stderr and "failed in bakes" not in left_out.stdout, left_out
        (folder / "hard/room0.collected.h5").rename(folder / "hard/attic.collected.h5")
        for name in ("room0", "cellar"):
            (levels / "room0.obj").rename(levels / f"{name}.obj")
            refused = run(*collecting, "--set", f"split.held_out=[{name}]", code=2).stderr
            assert f"attic.collected.h5 is of {name}, which is not to be trained on" in refused, refused
        (levels / "cellar.obj").rename(levels / "room0.obj")
        # another folder of the same name does not replace the results of this one
        other = folder / "elsewhere" / "six rooms"
        other.mkdir(parents=True)
        for seed in range(2):
            (other / f"room{seed}.obj").write_text(room(seed))
        assert "keeps both" in run(*pipeline, str(other), code=2).stderr
        # what is there is not made again
        again = run(*pipeline, str(levels)).stderr
        assert "nothing to be done" in again, again
        # weights to begin with, refused before any data are made
        (folder / "mlp").mkdir()
        shutil.copy(ROOT / "weights/mlp.safetensors", folder / "mlp/tent_mlp4.safetensors")
        seen = min(name for name in trained if name.startswith("room"))
        for asked, words in ((["init=nowhere"], "nowhere/tent_mlp4"), ([f"init={folder / 'mlp'}"], "expected weights of tent_mlp4"),
                             ([f"init={out / 'weights'}", f"split.held_out=[{seen}]"], f"{seen} is not to be trained on, and init's")):
            refused = run(*pipeline, "--set", "name=finer", *(word for setting in asked for word in ("--set", setting)), "--plan", str(levels), code=2).stderr
            assert words in refused, refused
        if sys.argv[2] == "short":
            return 0
        # trained on from these weights, at a rate that changes nothing: the same network, but for what float16 rounds
        run(*pipeline, "--set", "name=finer", "--set", f"init={out / 'weights'}", "--set", "train.learning_rate=1e-9", str(levels))
        for file, error in (("training/tent_mlp4.json", "held_out_network_blend_rmse"), ("weights/tent_mlp4.json", "held_out_blend_rmse")):
            first, finer = (json.loads((folder / "out" / name / file).read_text())[error] for name in ("six_rooms", "finer"))
            assert abs(finer - first) < 2e-3 * first, f"{file}: {first}, {finer}"
        # a sweep: runs over one data set and basis, compared
        compared = run(*pipeline, "--set", "name=sweep", "--set", "train.steps=20,40", "--set", "train.batch=[32]", str(levels)).stdout
        assert "tent_mlp4, steps: 20 -> 40" in compared and "stored, mean blend RMSE" in compared, compared
        swept = [folder / "out" / f"sweep-steps-{steps}-batch-32" for steps in (20, 40)]
        assert all((one / "weights/tent_mlp4.safetensors").is_file() and not (one / "dataset").exists() and not (one / "basis.h5").exists() for one in swept), swept
        assert len(list((folder / "out/sweep/dataset").glob("*/*.h5"))) == 7
        for more in (["--plan"], []):
            assert "jitters" in run(*pipeline, "--set", "name=another", "--set", "data=sweep", "--set", "scenes.jitters=2", *more, str(levels), code=2).stderr
    return 0


if __name__ == "__main__":
    sys.exit(main())

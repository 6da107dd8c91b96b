#!/usr/bin/python3
"""Configurations of the whole pipeline: what the workflow makes of sound ones, and one line that names what is wrong in the others.

    configurations_test.py
"""
import os
import sys
import zipfile

sys.dont_write_bytecode = True
sys.path.append(os.path.join(os.path.dirname(os.path.abspath(__file__)), ".."))
from tools import INPUT_ERROR, SOURCES, USAGE_ERROR, Tools, run_checks, write

sys.path.append(os.path.join(SOURCES, "workflow"))
import configuration
from configuration import ConfigurationError

BASIS, HELD_OUT = "families: [house], per_family: 3, folder: '', jitters: 1", "held_out: [house_2]"
SNAKEMAKE = ["/usr/bin/snakemake", "-n", "-p", "-s", os.path.join(SOURCES, "workflow", "Snakefile"), "--cores", "1", "--nolock"]


def configured(scenes=BASIS, split=HELD_OUT, more=""):
    """A file with this configuration. Absolute folders of archives lie in the working folder."""
    return os.path.abspath(write("workflow.yaml", f"name: run\nrepresentations: [mlp]\nscenes: {{{scenes}}}\nsplit: {{{split}}}\n{more}\n"))


def check_sound(tools):
    """The commands that Snakemake would run."""
    os.mkdir("game")
    # two levels; one of them in both archives counts once, and what lies in a folder below is none
    for name, entries in (("a", ("maps/one.bsp", "maps/Two.bsp", "maps/sub/three.bsp")), ("b", ("maps/TWO.bsp", "textures/two.tga"))):
        with zipfile.ZipFile(f"game/{name}.pk3", "w") as archive:
            for entry in entries:
                archive.writestr(entry, b"")
    os.mkdir("homes")
    write("homes/Big Shop.sh3f", "")
    # of a trained-on scene, a held-out one and one for the evaluation
    os.mkdir("hard")
    for name in ("house_0", "house_1", "house_2"):
        write(f"hard/{name}.collected.h5", "x")
    os.mkdir("named")
    for name, text in (("house_0.OBJ", "v 0 0 0"), ("room_0.obj", "v 0 0 1"), ("empty.glb", ""), ("empty.pk3", "")):
        write(f"named/{name}", text)
    named = BASIS.replace("''", os.path.abspath("named"))
    own, game = BASIS.replace("''", os.path.abspath("game")), BASIS + ", archives: [{folder: /game, maps: ['*']}]"
    homes = BASIS.replace("jitters: 1", "jitters: 3") + ", furniture: [{archives: [/homes/Big Shop.sh3f], plans: [flat, villa], seeds: 2, first_seed: 5}]"
    full = "full: {train: {steps: 77}, datagen: {max_functions: 9, scale: 0.5}, scenes: {per_family: 5}, report: {stability: full, savings: []}}\nreport: {stability: short, savings: [house_2]}"
    for scenes, split, more, held, absent in [
            # by lot, of the folder's own scenes: the maps of its archives; whole scenes
            (own, "held_out_share: 0.17, seed: 4", "", ["/game:one --jitter 0 --held-out", "dataset/training/two.0.h5", "dataset/training/house_2.0.h5"], []),
            # beside a procedural scene of its name a level keeps its ending; an empty one is left out
            (named, "held_out: [house_0, room_0]", "", ["dataset/held_out/house_0.0.h5", "dataset/training/house_0.obj.0.h5", "dataset/held_out/room_0.0.h5"], ["empty"]),
            (BASIS + f", collected: [{os.path.abspath('hard')}]", HELD_OUT + ", evaluation: [house_1]", "", ["hard/house_0.collected.h5 --held-out"], ["house_1.collected", "house_2.collected"]),
            (homes, HELD_OUT + ", evaluation: ['villa_*_big-shop']", "",
             ["/homes/Big Shop.sh3f:flat:5", "dataset/training/flat_6_big-shop.0.h5", "dataset/training/house_0.2.h5", "dataset/evaluation/villa_6_big-shop.0.h5"],
             ["dataset/training/villa", "big-shop.1.h5"]),
            # one scene of each split in the reports' tables of savings, with what a bake can take of the scene's options
            (game + ", by_scene: {'*': {max_functions: 3, extent_m: [0, 0, 0, 3, 3, 3]}}", HELD_OUT + ", evaluation: [two, house_1]", "",
             ["nlg-bake house:2 ", "nlg-bake house:1 ", "--extent-m=0,0,0,3,3,3 --weights", "out/run/evaluation/report.html"], ["dataset/training/two"]),
            # a short run, and the full one by one key: what `full` holds goes over the file's own, a scene's own over that
            (BASIS + ", by_scene: {house_1: {max_functions: 4}}", HELD_OUT, full, ["stability --short", "nlg-bake", "--max-functions=4"], ["--steps", "--scale", "house:4"]),
            (BASIS + ", by_scene: {house_1: {max_functions: 4}}", HELD_OUT, "effort: full\n" + full,
             ["nlg-validate stability  --weights", "--steps=77", "--max-functions=4 --scale=0.5", "--max-functions=9 --scale=0.5", "house:4"], ["nlg-bake"]),
            # light, and processes of a training on a core each
            (BASIS, HELD_OUT, "validate_light: {scenes: ['cornell:0'], spacings: [1, 0.5], walks: 3}\ntrain: {processes: 3, threads: 2}",
             ["nlg-validate light cornell:0", "--walks=3", "--spacings 1 0.5 --pictures", "light/cornell_0.json", "workflow/train_together.sh 3 "], [])]:
        tools.cases += 1
        result = tools.run([*SNAKEMAKE, "--configfile", configured(scenes, split, more)], cwd=SOURCES)
        wrong = [word for word in held if word not in result.stdout] + [word for word in absent if word in result.stdout]
        tools.check(result.returncode == 0 and not wrong, f"workflow with {scenes}, {split}, {more}: {wrong}\n{(result.stdout + result.stderr)[-1500:]}")


def check_refused(tools):
    """pipeline.sh's judgement, which is Snakemake's too: one line that holds the words."""
    os.mkdir("bad_game")
    write("bad_game/a.pk3", "no archive")
    os.mkdir("hollow")
    write("hollow/a.glb", "")
    shop, own = "archives: [/homes/Big Shop.sh3f]", BASIS.replace("''", os.path.abspath("homes"))
    furniture, archives = (lambda text, key=key: f"{BASIS}, {key}: [{text}]" for key in ("furniture", "archives"))
    for scenes, split, more, words in [
            *((BASIS, HELD_OUT, more, words) for more, words in [
                ("effort: half", "one of short, full, got 'half'"), ("full: {train: {Steps: 1}}", "unknown key 'Steps' (did you mean 'steps'?)"), ("train: [steps]", "a map of settings"),
                ("bake: {spacing_m: -1}", "bake: spacing_m: expected a number from 0 to 100000, got -1"), ("frontier: {corrected_lm_steps: 8}", "a list, got 8"), ("colour: red", "unknown key 'colour'"),
                ("train: {a: 1, a: 2}", "workflow.yaml:5:15: expected each key once"), ("train: {processes: true}", "train: processes: expected an integer from 1 to 4096"),
                ("validate_light: {scenes: ['cornell:0', 'cornell:0']}", "scenes with different names"), ("validate_light: {spacings: [0]}", "a list of numbers"),
                ("train: {dictionary_resolution: 6}", "train: dictionary_resolution: expected 3, 5, 7 or 9, got 6"), ("train: {batch: 64, processes: 65}", "train: processes: expected at most batch, 64, got 65"),
                ("train: {input: foo}", "train: input: expected one of samples, coefficients, got 'foo'"),
                ("report: {savings: [house_0]}", "held out or for the evaluation, got 'house_0'"), ("report: {stability: brief}", "one of short, full, got 'brief'")]),
            *((BASIS, split, "", words) for split, words in [
                (HELD_OUT + ", evaluation: [castle_*]", "expected a pattern of some scene out of house_0, house_1, house_2, got 'castle_*'"),
                # a slip of the pen would be trained on
                ("held_out: [house_2, house_9]", "held_out: expected a pattern of some scene out of house_0, house_1, house_2, got 'house_9'"),
                ("held_out: []", "some of the scenes held out, but not all"), ("held_out: ['*']", "got '3 of 3'"), ("held_out_share: 1", "a number from 0 to 0.9"),
                (HELD_OUT + ", evaluation: [house_2]", "house_2 is in held_out and in evaluation")]),
            *((scenes, HELD_OUT, "", words) for scenes, words in [
                (furniture(f"{{{shop}, plans: [flat]}}"), "missing key 'seeds'"), (furniture(f"{{{shop}, plans: [castle], seeds: 1}}"), "a list out of flat, townhouse, office, villa"),
                (furniture(f"{{{shop}, plans: [flat, flat], seeds: 1}}"), "two scenes are named flat_0_big-shop"),
                (furniture("{archives: [/nowhere/A.sh3f], plans: [flat], seeds: 1, install: apt install some-furniture}"), "nowhere/A.sh3f, got none; install it: apt install some-furniture"),
                (own, "/homes, got 'none'"), (BASIS.replace("''", os.path.abspath("hollow")), "/hollow, got '1 empty files'"), (BASIS.replace("per_family: 3", "per_family: 200000, jitters: 200").replace(", jitters: 1", ""), "at most 1000000 shards"),
                (archives("{folder: /game, maps: [four]}"), "got 'four'"), (archives("{folder: /game, maps: ['*']}, {folder: /game, maps: [one]}"), "two levels are named one"),
                (archives("{folder: /nowhere, maps: ['*'], install: apt install some-game}"), "nowhere, got none; install them: apt install some-game"),
                (archives("{folder: /bad_game, maps: ['*']}"), "bad_game/a.pk3"), (BASIS + ", by_scene: {castle: {max_functions: 3}}", "expected a pattern of some scene, got 'castle'"),
                (BASIS + ", collected: [hollow]", "collected: expected shards of nlg-bake --collect, .h5 files, in hollow, got 'none'"), (BASIS + ", collected: hollow", "a list of texts, got 'hollow'"),
                (BASIS + ", by_scene: {house_1: {out: x}}", "unknown key 'out'")])]:
        tools.cases += 1
        try:
            configuration.load(configured(scenes, split, more))
            text = "nothing"
        except ConfigurationError as error:
            text = str(error)
        tools.check(words in text and "workflow.yaml:" in text and "\n" not in text, f"{scenes}, {split}, {more}: expected a refusal with '{words}', got\n    {text[-600:]}")


def check_broken(tools):
    """Files that are no configuration, and command lines that are none."""
    script, bad = os.path.join(SOURCES, "workflow", "configuration.py"), os.path.abspath("bad.yaml")
    for content, words in [(b"", "bad.yaml: top level"), (b"representations: [mlp]\n", "expected the key 'name'"), (b"name: x\nscenes: [1,\n", "bad.yaml:3:1"), (b"name: x\n#\xff", "bad.yaml:2:2"),
                           (b"\nname: 2020-13-45\n", "bad.yaml:2:7"), (b"[" * 100000, "bad.yaml"), (b"&a [*a]\n", "bad.yaml"), (b"name: a\nname: b\n", "bad.yaml:2:1"),
                           (b"a: !!python/object:os.system x\n", "bad.yaml:1:4")]:
        write(bad, content)
        tools.refuses(USAGE_ERROR, words, ["/usr/bin/python3", script, bad])
    # what Snakemake takes for a configuration, and we do not
    write(bad, "{}\n")
    tools.refuses(USAGE_ERROR, "'name'", [*SNAKEMAKE, "--configfile", bad], cwd=SOURCES)
    tools.refuses(USAGE_ERROR, "unknown key 'tests'", [*SNAKEMAKE, "--configfile", configured(split=HELD_OUT + ", tests: []")], cwd=SOURCES)
    for arguments, words in [(["-x"], "unknown option -x"), (["a", "b", "c"], "got 3 arguments"), (["--set", "steps"], "SECTION.KEY=VALUE"), (["--set", "train.step=3"], "did you mean 'steps'?"),
                             (["--bin", "none"], "--bin"), (["docs"], ".glb, .gltf, .obj or .pk3 files in"), (["none.yaml"], "none.yaml")]:
        tools.refuses(USAGE_ERROR, words, ["./pipeline.sh", *arguments], cwd=SOURCES)
    # a table that the workflow's scripts read; tests/tool/scripts_test.py has what may be wrong in one
    table = os.path.abspath(write("many_digits.json", b'{"cases": [{"holds": ' + b"9" * 400 + b"}]}"))
    tools.refuses(INPUT_ERROR, "many_digits.json", ["/usr/bin/python3", os.path.join(SOURCES, "workflow", "failed_cases.py"), table])


def check_again(tools):
    """What a configuration alone has made is gone on with by --set; data of it that would be made otherwise are refused."""
    command = ["/usr/bin/python3", os.path.join(SOURCES, "workflow", "configuration.py"), configured(), "--write"]
    tools.check(tools.run(command).returncode == 0, "a run without changes")
    os.makedirs("out/run/dataset")
    for settings in (["train.steps=100"], ["name=other", "data=run"]):
        again = tools.run(command + [f"--set={setting}" for setting in settings])
        tools.check(again.returncode == 0, f"{settings}: {again.stderr}")
    # runs of a sweep share the data that are named, or else make their own
    for settings, data in (["data=run"], "run"), ([], "several"):
        swept = tools.run([*command[:-1], "--sweep", "--set=name=several", "--set=train.steps=[20,40]", *(f"--set={setting}" for setting in settings)])
        tools.check(swept.stdout.count(f"--set=data={data}\n") == 2, f"a sweep with {settings}: {swept.stdout}{swept.stderr}")
    # fits of the bake that are not those that the verdict is of
    said = tools.run([*command[:-1], "--set=bake.refine_rounds=1"]).stderr
    tools.check("refine_rounds is 1 in bake, 3 in validate" in said, f"other fits in the bake: {said}")
    tools.refuses(USAGE_ERROR, "datagen", [*command, "--set=name=third", "--set=data=run", "--set=datagen.seed=5"])
    os.mkdir("levels")
    write("levels/a.glb", "x")
    tools.refuses(USAGE_ERROR, "keeps both", [*command, "--set=scenes.folder=" + os.path.abspath("levels")])


def check_all(tools):
    os.environ.update({"NLG_OUT": os.path.abspath("out"), "NLG_ARCHIVE_ROOT": os.getcwd()})
    for check in (check_sound, check_refused, check_broken, check_again):
        check(tools)


if __name__ == "__main__":
    sys.exit(run_checks(Tools("/usr/bin"), (check_all,)))

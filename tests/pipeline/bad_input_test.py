#!/usr/bin/python3
"""Configurations of the whole pipeline: what the workflow makes of sound ones, and one line that names what is wrong in the others.

    bad_input_test.py short|whole

The short form asks Snakemake about fewer sound ones.
"""
import os
import subprocess
import sys
import tempfile

sys.dont_write_bytecode = True
sys.path.append(os.path.join(os.path.dirname(os.path.abspath(__file__)), ".."))
from bad_scenes_test import write_archive
from tools import INPUT_ERROR, SECONDS, SOURCES, USAGE_ERROR, write

sys.path.append(os.path.join(SOURCES, "workflow"))
import configuration
from configuration import ConfigurationError

is_short = sys.argv[1] == "short"
failures = []
cases = 0


def few(items):
    return items[-2:] if is_short else items


def configured(scenes, split, report, more):
    """A file with this configuration. Absolute folders of archives lie in the working folder."""
    return os.path.abspath(write("workflow.yaml", f"name: run\nrepresentations: [mlp]\nscenes: {{{scenes}}}\nsplit: {{{split}}}\nreport: {report}\n{more}\n"))


def workflow(scenes, split, report="{}", more=""):
    """Whether snakemake takes a configuration, and its words: a dry run."""
    result = subprocess.run(["/usr/bin/snakemake", "-n", "-p", "-s", os.path.join(SOURCES, "workflow", "Snakefile"), "--cores", "1", "--nolock", "--configfile",
                             configured(scenes, split, report, more)], capture_output=True, text=True, timeout=2 * SECONDS, cwd=SOURCES)
    return result.returncode == 0, result.stdout + result.stderr


def refuses_configuration(scenes, split, report, words, more=""):
    """pipeline.sh's judgement, which is snakemake's too: one line that holds the words."""
    global cases
    cases += 1
    text = "nothing"
    try:
        configuration.load(configured(scenes, split, report, more))
    except ConfigurationError as error:
        text = str(error)
    if words not in text or len(text.splitlines()) != 1 or "workflow.yaml:" not in text:
        failures.append(f"configuration with {scenes}, {split}, {report}, {more}: expected a refusal with '{words}', got\n    {text[-600:]}")


def ends_in_one_line(exit_code, words, *command, environment=None):
    """A script that must end with this code and one line that holds the words."""
    global cases
    cases += 1
    result = subprocess.run(command, capture_output=True, text=True, timeout=2 * SECONDS, cwd=SOURCES, env={**os.environ, **(environment or {})})
    if result.returncode != exit_code or len(result.stderr.splitlines()) != 1 or words not in result.stderr or "Traceback" in result.stderr:
        failures.append(f"{' '.join(command)}: expected exit code {exit_code} and one line with '{words}', got {result.returncode} and\n    {result.stderr.strip()[-600:]}")


def check_broken_configurations():
    """Files that are no configuration, by the script, by pipeline.sh and by Snakemake: one line, with line and column where there is one."""
    broken = {"empty": (b"", "bad.yaml: top level"), "null": (b"null\n", "bad.yaml: top level"), "map": (b"{}\n", "'name'"), "list": (b"- 1\n", "bad.yaml: top level"),
              "nameless": (b"representations: [mlp]\n", "expected the key 'name'"), "cut": (b"name: x\nscenes: [1,\n", "bad.yaml:3:1"), "bytes": (b"name: x\n#\xff", "bad.yaml:2:2"),
              "control": (b"name: x\nsplit: \x01\n", "bad.yaml:2:8"), "date": (b"\nname: 2020-13-45\n", "bad.yaml:2:7"), "digits": (b"name: " + b"9" * 5000, "bad.yaml:1:7"),
              "surrogate": (b'name: "a\\ud800"\n', "name"), "deep": (b"[" * 100000, "bad.yaml"), "loop": (b"&a [*a]\n", "bad.yaml"), "key": (b"? [a]\n: b\n", "bad.yaml:1:3"),
              "twice": (b"name: a\nname: b\n", "bad.yaml:2:1"), "two": (b"a: b\n---\nc: d\n", "bad.yaml:2:1"), "tag": (b"a: !!python/object:os.system x\n", "bad.yaml:1:4")}
    path = os.path.abspath("bad.yaml")
    snakemake = ["/usr/bin/snakemake", "-n", "-s", os.path.join(SOURCES, "workflow", "Snakefile"), "--cores", "1", "--nolock"]
    for name, (content, words) in broken.items():
        write(path, content)
        ends_in_one_line(USAGE_ERROR, words, "/usr/bin/python3", "workflow/configuration.py", path)
        if name in ("empty", "cut"):
            ends_in_one_line(USAGE_ERROR, words, *snakemake, "--config", f"file={path}")
    # what Snakemake takes for a configuration, and we do not
    write(path, "{}\n")
    ends_in_one_line(USAGE_ERROR, "'name'", *snakemake, "--configfile", path)
    ends_in_one_line(USAGE_ERROR, "'name'", *snakemake, "--configfile", "configs/smoke.yaml", "--config", "name=other")
    ends_in_one_line(USAGE_ERROR, "pipe.yaml", "/usr/bin/python3", "workflow/configuration.py", os.path.abspath("pipe.yaml"))
    ends_in_one_line(USAGE_ERROR, "CONFIG", "/usr/bin/python3", "workflow/configuration.py")
    for arguments, words in [(["-x"], "unknown option -x"), (["--plan", "--plam"], "unknown option --plam"), (["a", "b", "c"], "got 3 arguments"), (["--set", "steps"], "SECTION.KEY=VALUE"), (["--set", "train.steps=["], "--set train.steps"), (["--set", "train.step=3"], "did you mean 'steps'?"),
                             (["--set", "name.first=x"], "--set name.first: name: expected a section"), (["--bin", "none"], "--bin"), (["tests", "docs"], "two folders"),
                             (["docs"], ".glb, .gltf, .obj or .pk3 files in"),
                             (["none.yaml"], "none.yaml"), (["configs/smoke.yaml", "none"], "none")]:
        ends_in_one_line(USAGE_ERROR, words, "./pipeline.sh", *arguments)


def check_tables_of_scripts():
    """JSON and CSV that the workflow's scripts read: one line that names the file. tests/tool/scripts_test.py has what may be wrong in them."""
    path = os.path.abspath(write("many_digits.json", b'{"cases": [{"ran": ' + b"9" * 400 + b"}]}"))
    for script in (["workflow/failed_cases.py", path], ["workflow/training_curve.py", "--log", path, "--title", "x", "--out", os.path.abspath("bad.png")]):
        ends_in_one_line(INPUT_ERROR, "many_digits.json", "/usr/bin/python3", *script)
    if os.path.exists("bad.png"):
        failures.append("a refused curve left a picture")


def check_workflow():
    global cases
    os.makedirs("game", exist_ok=True)
    # two levels; one of them in both archives counts once, and what lies in a folder below is none
    write_archive("game/a.pk3", {"maps/one.bsp": b"", "maps/Two.bsp": b"", "maps/sub/three.bsp": b""})
    write_archive("game/b.pk3", {"maps/TWO.bsp": b"", "textures/two.tga": b""})
    os.makedirs("bad_game", exist_ok=True)
    write_archive("bad_game/a.pk3", {"maps/a b.bsp": b""})
    os.makedirs("text_game", exist_ok=True)
    write("text_game/a.pk3", "no archive")
    basis = "families: [house], per_family: 3, folder: '', jitters: 1"
    game = basis + ", archives: [{folder: /game, maps: ['*']}]"
    held_out = "held_out: [house_2]"
    # what the configuration needs of an archive of furniture is that it is there
    os.makedirs("homes", exist_ok=True)
    write("homes/Big Shop.sh3f", "")
    homes = basis.replace("jitters: 1", "jitters: 3") + ", furniture: [{archives: [/homes/Big Shop.sh3f], plans: [flat, villa], seeds: 2, first_seed: 5}]"

    os.makedirs("own", exist_ok=True)
    write("own/hall.obj", "")

    accepted = [
        # by lot, of the folder's own scenes: the maps of its archives; whole scenes
        (basis.replace("''", os.path.abspath("game")), "held_out_share: 0.17, seed: 4", ["/game:one --jitter 0 --held-out", "dataset/training/two.0.h5", "dataset/training/house_2.0.h5"]),
        # none where one of them is named
        (basis.replace("''", os.path.abspath("game")), "held_out_share: 0.17, held_out: [two]", ["/game:two --jitter 0 --held-out", "dataset/training/one.0.h5"]),
        (homes, held_out + ", evaluation: ['villa_*_big-shop']",
         ["/homes/Big Shop.sh3f:flat:5", "dataset/training/flat_6_big-shop.0.h5", "dataset/training/house_0.2.h5", "dataset/evaluation/villa_6_big-shop.0.h5"]),
        (basis, held_out, ["--scene house:0"]),
        (game, held_out + ", evaluation: [two]", ["/game:one", "dataset/evaluation/two.0.h5", "dataset/training/one.0.h5", "/game:two --jitter 0 --held-out"]),
        # one scene of each split in the reports' tables of savings, with what a bake can take of the scene's options
        (game + ", by_scene: {'*': {max_functions: 3, extent_m: [0, 0, 0, 3, 3, 3]}}", held_out + ", evaluation: [two, house_1]",
         ["nlg-bake house:2 ", "nlg-bake house:1 ", "--extent-m=0,0,0,3,3,3 --weights", "out/run/evaluation/report.html"]),
        (basis + ", by_scene: {'house_*': {max_functions: 3, scale: 0.5}, house_1: {max_functions: 4, extent_m: [0, 0, 0, 3, 3, 3]}}", held_out,
         ["--max-functions=3 --scale=0.5", "--extent-m=0,0,0,3,3,3 --max-functions=4 --scale=0.5"]),
    ]
    for scenes, split, words in few(accepted):
        cases += 1
        is_taken, text = workflow(scenes, split)
        for word in [] if is_taken else ["a configuration that is taken"]:
            failures.append(f"workflow with {scenes}, {split}: expected {word}, got\n    {text}")
        for word in words:
            if is_taken and word not in text:
                failures.append(f"workflow with {scenes}, {split}: its commands do not hold '{word}'")
        if is_taken and any(word in text for word in ("dataset/training/villa", "big-shop.1.h5")):
            failures.append(f"workflow with {scenes}, {split}: trains on a plan of the evaluation, or on a variant of an interior")
        if is_taken and "evaluation" in split and "dataset/training/two" in text:
            failures.append(f"workflow with {scenes}, {split}: trains on a scene of the evaluation")

    for report, words, absent in [("{savings: [], stability: short}", ["stability --short"], ["nlg-bake", "training_cases", "--savings"]),
                                  ("{stability: long, savings: ['*_2']}", ["stability --long", "nlg-bake house:2 ", "training_cases"], [])]:
        cases += 1
        is_taken, text = workflow(basis, held_out, report)
        if not is_taken or any(word not in text for word in words) or any(word in text for word in absent):
            failures.append(f"workflow with report {report}: expected {words} and no {absent}, got\n    {text.strip()[-1500:]}")
    # a short run, and the full one by one key: what `full` holds goes over the file's own, a representation's or scene's own over that
    full = "full: {train: {steps: 77}, datagen: {max_functions: 9, scale: 0.5}, scenes: {per_family: 5}, report: {stability: long, savings: []}}"
    options = (basis + ", by_scene: {house_1: {max_functions: 4}}", held_out, "{stability: short, savings: [house_2]}")
    for effort, words, absent in [("", ["stability --short", "nlg-bake", "--max-functions=4"], ["--steps", "--scale", "house:4"]),
                                  ("effort: full\n", ["stability --long", "--steps=77", "--max-functions=4 --scale=0.5", "--max-functions=9 --scale=0.5", "house:4"],
                                   ["nlg-bake"])]:
        cases += 1
        is_taken, text = workflow(*options, more=effort + full)
        if not is_taken or any(word not in text for word in words) or any(word in text for word in absent):
            failures.append(f"workflow with {effort}: expected {words} and no {absent}, got\n    {text.strip()[-1500:]}")
    for more, words in [("effort: half", "one of short, full, got 'half'"), ("effort: [full]", "one of short, full"), ("full: {name: x}", "unknown key 'name'"), ("full: 3", "full: expected a map"),
                        ("full: {train: {Steps: 1}}", "unknown key 'Steps' (did you mean 'steps'?)"), ("train: [steps]", "a map of settings"), ("bake: {spacing_m: -1}", "bake: spacing_m: expected a number from 0 to 100000, got -1"), ("frontier: {corrected_lm_steps: 8}", "a list, got 8"), ("colour: red", "unknown key 'colour'"),
                        ("train: {steps: 2001-01-01}", "a text, a number"), ("train: {1: 2}", "keys that are texts"), ("train: {a: 1, a: 2}", "workflow.yaml:6:15: expected each key once"),
                        ("effort: full\nfull: {report: {savings: [house_0]}}", "held out or for the evaluation")]:
        refuses_configuration(basis, held_out, "{}", words, more)
    for light, words in [("{colour: red}", "unknown key 'colour'"), ("{scenes: 'cornell:0'}", "a list of texts"), ("{scenes: ['cornell:0', 'cornell:0']}", "scenes with different names"),
                         ("{scenes: ['::']}", "scenes with different names"), ("{spacings: []}", "a list of numbers"), ("{spacings: [0]}", "a list of numbers"), ("{spacings: [true]}", "a list of numbers"),
                         ("{air_samples: 4}", "an integer from 8 to 10000000, got 4"), ("{walks: 1.5}", "an integer from 1"), ("{look_up_seconds: -1}", "a number from 0 to 600")]:
        refuses_configuration(basis, held_out, "{}", words, f"validate_light: {light}")
    cases += 1
    is_taken, text = workflow(basis, held_out, more="validate_light: {scenes: ['cornell:0'], spacings: [1, 0.5], walks: 3}")
    for word in ("nlg-validate light cornell:0", "--walks=3", "--spacings 1 0.5 --pictures", "light/cornell_0_places", "light/cornell_0.json", "--light "):
        if not is_taken or word not in text:
            failures.append(f"workflow with light: expected '{word}', got\n    {text.strip()[-1500:]}")
    for report, words in [("{colour: red}", "unknown key 'colour'"), ("[a]", "report: expected a map"), ("{savings: house_2}", "a list of texts"),
                          ("{savings: [house_0]}", "held out or for the evaluation, got 'house_0'"),
                          ("{stability: brief}", "one of short, full, long, got 'brief'"),
                          ("{stability: [full]}", "one of short, full, long")]:
        refuses_configuration(basis, held_out, report, words)

    def archives(text):
        return f"{basis}, archives: [{text}]", held_out

    def furniture(text):
        return f"{basis}, furniture: [{text}]", held_out

    shop = "archives: [/homes/Big Shop.sh3f]"
    refused = [
        (*furniture("homes"), "furniture: 0: expected keys"),
        (*furniture(f"{{{shop}, plans: [flat]}}"), "missing key 'seeds'"),
        (*furniture(f"{{{shop}, plans: [flat], seeds: 1, colour: red}}"), "unknown key 'colour'"),
        (*furniture(f"{{{shop}, plans: [castle], seeds: 1}}"), "a list out of flat, townhouse, office, villa"),
        (*furniture(f"{{{shop}, plans: [flat], seeds: 0}}"), "an integer from 1"),
        (*furniture(f"{{{shop}, plans: [flat], seeds: 1, first_seed: -1}}"), "an integer from 0"),
        (*furniture(f"{{{shop}, plans: [flat], seeds: 1000000000}}"), "at most 1000000 scenes"),
        (*furniture(f"{{{shop}, plans: [flat, flat], seeds: 1}}"), "two scenes are named flat_0_big-shop"),
        (*furniture("{archives: [/game/a.pk3], plans: [flat], seeds: 1}"), "a list of .sh3f files"),
        (*furniture("{archives: [/nowhere/A.sh3f], plans: [flat], seeds: 1, install: apt install some-furniture}"),
         "nowhere/A.sh3f, got none; install it: apt install some-furniture"),
        (basis + ", colour: red", held_out, "unknown key 'colour'"),
        (basis, held_out + ", tests: []", "unknown key 'tests'"),
        (basis, held_out + ", evaluation: [castle_*]", "expected a pattern of some scene out of house_0, house_1, house_2, got 'castle_*'"),
        # a slip of the pen would be trained on
        (basis, "held_out: [house_2, house_9]", "held_out: expected a pattern of some scene out of house_0, house_1, house_2, got 'house_9'"),
        (basis, "held_out: []", "some of the scenes held out, but not all"), (basis, "held_out: ['*']", "got '3 of 3'"),
        (basis, "held_out_share: 1", "a number from 0 to 0.9"),
        (basis.replace("''", os.path.abspath("own")), "held_out_share: 0.5", "at least two levels, one to train on and one to hold out, got '1'"),
        (basis.replace("''", os.path.abspath("homes")), held_out, "/homes, got 'none'"),
        (basis, held_out + ", evaluation: [house_2]", "house_2 is in held_out and in evaluation"),
        (basis.replace("per_family: 3", "per_family: 200000, jitters: 200").replace(", jitters: 1", ""), held_out, "at most 1000000 shards"),
        (*archives("{folder: /game, maps: ['*'], colour: red}"), "unknown key 'colour'"),
        (*archives("{folder: /game}"), "missing key 'maps'"),
        (*archives("game"), "archives: 0"),
        (*archives("{folder: /game, maps: [four]}"), "got 'four'"),
        (*archives("{folder: /game, maps: ['*']}, {folder: /game, maps: [one]}"), "two levels are named one"),
        (*archives("{folder: /nowhere, maps: ['*'], install: apt install some-game}"), "nowhere, got none; install them: apt install some-game"),
        (*archives("{folder: /bad_game, maps: ['*']}"), "a b"),
        (*archives("{folder: /text_game, maps: ['*']}"), "text_game/a.pk3"),
        (basis + ", by_scene: {castle: {max_functions: 3}}", held_out, "expected a pattern of some scene, got 'castle'"),
        (basis + ", by_scene: {house_1: {out: x}}", held_out, "unknown key 'out'"),
        (basis + ", by_scene: {house_1: {seed: [x]}}", held_out, "seed: expected an integer from 0"),
    ]
    for scenes, split, words in refused:
        refuses_configuration(scenes, split, "{}", words)
    for value in ["0", "4097", "two", "true", "1.5", "null"]:
        refuses_configuration(basis, held_out, "{}", "train: processes: expected an integer from 1 to 4096", more=f"train: {{processes: {value}}}")
    # processes of a training are started where they are asked for, on a core each
    is_taken, text = workflow(basis, held_out, more="train: {processes: 3, threads: 2}")
    if not is_taken or "workflow/train_together.sh 3 " not in text:
        failures.append(f"three processes that train together: {text}")
    # snakemake ends with the same words
    is_taken, text = workflow(basis, held_out + ", tests: []")
    if is_taken or "unknown key 'tests'" not in text:
        failures.append(f"snakemake takes what pipeline.sh refuses: {text}")


def main():
    with tempfile.TemporaryDirectory() as folder:
        os.chdir(folder)
        os.environ.update({"NLG_OUT": os.path.join(folder, "out"), "NLG_ARCHIVE_ROOT": folder})
        os.mkfifo("pipe.yaml")
        check_workflow()
        check_broken_configurations()
        check_tables_of_scripts()
        os.chdir("/")
    for failure in failures:
        print("FAILED:", failure)
    print(f"{cases} cases, {len(failures)} failures")
    return 1 if failures else 0


if __name__ == "__main__":
    sys.exit(main())

#!/usr/bin/env python3
"""One source for every number that the documentation states: docs/results/NAME.json.

    docs/figures/results.py collect RUN [--config CONFIG] [--no-pictures] [--made-by COMMAND]    measured → docs/results, then write
    docs/figures/results.py collect-light FOLDER [--no-pictures]    what was measured of light → docs/results/light.json, then write
    docs/figures/results.py collect-fault-injection FOLDER                   what fault injection found → docs/results/reliability.json, then write
    docs/figures/results.py collect-cycles FOLDER                            light against Cycles → docs/results/cycles.json, then write
    docs/figures/results.py write                                            docs/results → every text
    docs/figures/results.py check [--release]                                names every text that says something else, and figures of another revision

collect takes a run's result folder, out/NAME, reduces what it measured to docs/results/NAME.json, draws the plots of docs/images anew and fills the texts.
collect-light takes what nlg-validate light wrote of scenes, FOLDER/SCENE.json (light_results.py says what else may lie there; of that, what
is not there stays as it was collected before).
collect-fault-injection takes what tests/fault_injection/run.py left in its --out, collect-cycles what docs/figures/cycles/compare.py left in its own.
write makes docs/reference/results.md, docs/reference/light.md, docs/reference/reliability.md, docs/reference/cycles.md and weights/README.md whole, and fills the phrases that docs/figures/quotes.json names.
What a run's folder does not have by itself, and is taken when it is there:
    nlg-bake LEVEL --threads 1 --out GRID --json RUN/bakes/LEVEL.json
    bench_runtime_eval --benchmark_repetitions=7 --benchmark_out=RUN/benchmarks/runtime_eval.json --benchmark_out_format=json
check changes nothing; exit code 6 when a text disagrees, or a results file is of several revisions (with --release: of other sources than the present ones), 3 when a text quotes what no results file holds.
"""
import argparse
import re
import subprocess
import sys
from pathlib import Path

sys.dont_write_bytecode = True

import cycles_page
import light_page
import model_card
import reliability_page
import results_collect
import results_page
from results_quotes import MAIN, fill, load_results
from tool.atomic_file import write_atomically
from tool.errors import run as run_script
from tool.errors import say
from tool.input_file import as_documented, read_json, read_text

ROOT = Path(__file__).resolve().parents[2]
RESULTS = ROOT / "docs" / "results"
IMAGES = ROOT / "docs" / "images"
GENERATED = {ROOT / "docs" / "reference" / "results.md": results_page.page, ROOT / "docs" / "reference" / "light.md": light_page.page,
             ROOT / "docs" / "reference" / "reliability.md": reliability_page.page, ROOT / "docs" / "reference" / "cycles.md": cycles_page.page,
             ROOT / "weights" / "README.md": model_card.page}
OF_ONE_FILE = (light_page.NAME, reliability_page.NAME, cycles_page.NAME)  # pages of a results file of their name; without it they are left alone


RULE = ROOT / "docs" / "guide" / "training.md"  # which says in words when a generator may ship
RULE_BEGINS, RULE_ENDS = "<!-- the rule, by validate/report/verdict.py: docs/figures/results.py write -->\n", "<!-- so far -->\n"


def with_rule(text, problems):
    """The guide with the rule as verdict.py has it, its taus being the bake's defaults."""
    defaults = {setting["name"]: setting["default"] for setting in read_json(ROOT / "workflow" / "settings.json").value if setting["section"] == "bake"}
    begin, end = text.find(RULE_BEGINS), text.find(RULE_ENDS)
    if not 0 <= begin < end:
        problems.append((f"{RULE.relative_to(ROOT)}: expected the lines that begin and end the rule, got none", True))
        return text
    sentences = results_page.verdict.rule(results_page.verdict.Limits(), defaults["tau_rmse"], defaults["tau_blend"])
    whole = text[: begin + len(RULE_BEGINS)] + "".join(f"{i}. {sentence}\n" for i, sentence in enumerate(sentences, 1)) + f"\n{results_page.verdict.UNDECIDED_WHEN}\n" + text[end:]
    if whole != text:
        problems.append((f"{RULE.relative_to(ROOT)}: expected the rule as validate/report/verdict.py has it, got another text", False))
    return whole


def expected_texts(all_results, problems):
    """Path → the text as the results have it; problems gets a line and whether it is the key that is wrong."""
    texts = {}
    for path, page in GENERATED.items():
        if path.stem in all_results or path.stem not in OF_ONE_FILE:
            with as_documented(RESULTS):
                texts[path] = page(all_results)
            if not path.exists() or read_text(path) != texts[path]:
                problems.append((f"{path.relative_to(ROOT)}: expected what docs/results says, got another text", False))
    for name, phrases in read_json(ROOT / "docs" / "figures" / "quotes.json").value.items():
        texts[ROOT / name] = fill(read_text(ROOT / name), phrases, all_results, problems, name)
    if RULE.exists():
        texts[RULE] = with_rule(texts.get(RULE) or read_text(RULE), problems)
    return texts


def report(problems, *, only_keys):
    """Says what is wrong; returns the exit code."""
    shown = [(line, is_key) for line, is_key in problems if is_key or not only_keys]
    for line, _ in shown:
        say("results", line)
    return 3 if any(is_key for _, is_key in shown) else 6 if shown else 0


def revisions(found):
    """Revisions of figures, wherever they stand in results."""
    if isinstance(found, list):
        return set().union(*map(revisions, found))
    if not isinstance(found, dict):
        return set()
    own = {found["revision"]} if isinstance(found.get("revision"), str) else set(found.get("revisions", []))
    return own.union(*map(revisions, found.values()))


def of_several_revisions(all_results):
    """A line for every revision of a results file that has several, or one that nobody can look up: its page names one."""
    lines = []
    for name, results in all_results.items():
        found = revisions(results)
        if len(found) > 1 or any(revision.endswith("-dirty") for revision in found):
            lines += [f"docs/results: expected one revision without changes in {name}, got {revision}" for revision in sorted(found)]
    return lines


# What tools are built from, and the weights that are measured. A page, a test or a comment may change without changing a figure.
MEASURED_FILES = ["*.cpp", "*.h", "*.def", "weights/*.safetensors", ":!tests", ":!viewer", ":!examples"]
COMMENTS_AND_SPACE = re.compile(rb"//[^\n]*|/\*.*?\*/|\s+", re.DOTALL)
# By results file: folders whose sources no figure of it goes through. Fault injection goes through all.
OF_NONE, OF_FUNCTIONS, OF_LIGHT = ["train", "export"], ["validate/generators", "validate/frontier", "validate/stability"], ["render", "validate/light", "validate/views"]
NOT_MEASURED = {light_page.NAME: [*OF_NONE, *OF_FUNCTIONS, "render/irradiance_table.cpp"], cycles_page.NAME: [*OF_NONE, *OF_FUNCTIONS, "bake", "validate/views"], MAIN: [*OF_NONE, *OF_LIGHT]}


def code_of(revision, path):
    """A source as compilers see it; None where the revision has no such file."""
    shown = subprocess.run(["git", "-C", ROOT, "show", f"{revision}:{path}"], capture_output=True)
    return COMMENTS_AND_SPACE.sub(b" ", shown.stdout).split() if shown.returncode == 0 else None


def older_than_sources(all_results):
    """A line for every results file that describes other sources than those of this commit."""
    lines = []
    for name, results in all_results.items():
        for revision in sorted(revisions(results)):
            changed = subprocess.run(["git", "-C", ROOT, "diff", "--name-only", revision, "HEAD", "--", *MEASURED_FILES, *(f":!{folder}" for folder in NOT_MEASURED.get(name, []))], capture_output=True, text=True)
            files = [path for path in changed.stdout.split() if path.endswith(".safetensors") or code_of(revision, path) != code_of("HEAD", path)]
            if changed.returncode != 0:
                lines.append(f"docs/results: expected {name} of a revision of this repository, got {revision}")
            elif files:
                lines.append(f"docs/results: expected {name} of the present sources, got {revision}, since which {len(files)} files changed: {', '.join(files[:3])}{' …' if len(files) > 3 else ''}")
    return lines


def write(all_results):
    problems = []
    for path, text in expected_texts(all_results, problems).items():
        if not path.exists() or read_text(path) != text:
            write_atomically(path, text.encode())
            print(path.relative_to(ROOT))
    for line in of_several_revisions(all_results):
        print(line)
    return report(problems, only_keys=True)


def draw(run):
    """The plots of README and the results page, from the same run."""
    evaluation = run / "evaluation"
    for script, sources, picture in [("frontier.py", ["frontier"], "error_against_time.png"), ("curve.py", ["summary"], "error_against_bytes.png"), ("slices.py", ["summary", "slices"], "slices.png")]:
        files = {name: evaluation / f"{name}.json" for name in sources}
        if all(path.exists() for path in files.values()):
            flags = [word for name, path in files.items() for word in (f"--{name}", path)]
            subprocess.run(["/usr/bin/python3", ROOT / "validate" / "report" / script, *flags, "--out", IMAGES / picture], check=True)


def keep(results):
    """Writes one results file; returns all of them."""
    all_results = {**load_results(RESULTS), results["run"]: results}
    expected_texts(all_results, [])  # refuses figures of other weights than those supplied, before anything is written
    write_atomically(RESULTS / f"{results['run']}.json", (results_collect.dump(results) + "\n").encode())
    return all_results


def collect(run, configuration, pictures, made_by):
    run = run.resolve()
    results = results_collect.collect(run, configuration)
    if made_by:
        results["command"] = made_by
    all_results = keep(results)
    if pictures and results["run"] == MAIN:
        draw(run)
    return write(all_results)


def collect_light(folder, pictures):
    import light_results  # which alone needs numpy
    results, earlier = light_results.collect(folder), load_results(RESULTS).get(light_page.NAME, {})
    for section in ("indirect", "views", "bakes", "benchmarks"):
        # each measured by itself: what the folder lacks stays as it was
        if section not in results and section in earlier:
            results[section] = earlier[section]
    all_results = keep(results)
    if pictures and "against_bytes" in results.get("indirect", {}):
        subprocess.run(["/usr/bin/python3", ROOT / "validate" / "report" / "light_front.py", "--results", RESULTS / f"{light_page.NAME}.json", "--out", IMAGES / "light_against_bytes.png"], check=True)
    return write(all_results)


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    commands = parser.add_subparsers(dest="command", required=True)
    collecting = commands.add_parser("collect", help="measured → docs/results, then write")
    collecting.add_argument("run", type=Path, help="result folder of the run, out/NAME")
    collecting.add_argument("--config", default=f"configs/{MAIN}.yaml", help="configuration of the run (%(default)s)")
    collecting.add_argument("--no-pictures", action="store_true", help="do not draw docs/images again")
    collecting.add_argument("--made-by", default="", help="command that made RUN (./pipeline.sh CONFIG)")
    collecting_light = commands.add_parser("collect-light", help="what was measured of light → docs/results/light.json, then write")
    collecting_light.add_argument("folder", type=Path, help="folder with SCENE.json of nlg-validate light, one per scene")
    collecting_light.add_argument("--no-pictures", action="store_true", help="do not draw docs/images again")
    collecting_faults = commands.add_parser("collect-fault-injection", help="what fault injection found → docs/results, then write")
    collecting_faults.add_argument("folder", type=Path, help="--out of tests/fault_injection/run.py")
    collecting_cycles = commands.add_parser("collect-cycles", help="light against Cycles → docs/results, then write")
    collecting_cycles.add_argument("folder", type=Path, help="--out of docs/figures/cycles/compare.py")
    commands.add_parser("write", help="docs/results → every text")
    checking = commands.add_parser("check", help="names every text that says something else, and figures of another revision")
    checking.add_argument("--release", action="store_true", help="expects all figures to be of the present sources: no file that tools are built from has changed since")
    arguments = parser.parse_args()
    if arguments.command == "collect":
        return collect(arguments.run, arguments.config, not arguments.no_pictures, arguments.made_by)
    if arguments.command == "collect-light":
        return collect_light(arguments.folder, not arguments.no_pictures)
    if arguments.command == "collect-fault-injection":
        return write(keep(reliability_page.collect(arguments.folder)))
    if arguments.command == "collect-cycles":
        return write(keep(cycles_page.collect(arguments.folder)))
    if arguments.command == "write":
        return write(load_results(RESULTS))
    problems, all_results = [], load_results(RESULTS)
    expected_texts(all_results, problems)
    problems += [(line, False) for line in of_several_revisions(all_results) + (older_than_sources(all_results) if arguments.release else [])]
    return report(problems, only_keys=False)


if __name__ == "__main__":
    sys.exit(run_script("results", main))

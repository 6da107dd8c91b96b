#!/usr/bin/env python3
"""Draws nlg-validate's results as one self-contained page, report.html; beside it the slices as slices.png and the verdict as verdict.txt.

    report.py --summary S.json --functions F.csv --slices L.json --logs mlp.csv tent_mlp.csv
        [--frontier FRONTIER.json] [--stability STABILITY.json] [--savings BAKE_REPORT.json ... [--bakes OTHER_REPORT.json ...]] [--light LIGHT.json ...] [--data DATASET.json [--run FOLDER]] [--evaluation] [--against FOLDER ...] --out report.html

The same inputs give the same bytes. A file that cannot be used ends it with one line on stderr and exit code 3, an output that
cannot be written with 5, a Python without its packages with 2 (tool/error.h); nothing half-written is left behind. docs/reference/formats.md says what the inputs hold.
"""
import argparse
import logging
import os
import sys
import time
from dataclasses import dataclass, field

sys.dont_write_bytecode = True
logging.getLogger("matplotlib").setLevel(logging.ERROR)

import packages

packages.need("report.py", "jinja2", "markupsafe", "matplotlib", "numpy")

import jinja2
from markupsafe import Markup

import curve
import decision as decision_module
import findings as findings_module
import frontier as frontier_module
import inputs as inputs_module
import light_figures
import light_section
import plan_section
import plots
import proof_inputs
import slices
import verdict
from tool.atomic_file import write_files
from tool.errors import run
from tool.input_file import sha256


@dataclass
class Proof:
    """What is given beside nlg-validate's results; a section of the page appears only where its part is."""
    frontier: object = None  # proof_inputs.Frontier
    cases: object = None     # of proof_inputs.Case
    savings: object = None   # of (scene, rows)
    light: object = None     # light_figures.Point of all scenes and methods
    data: object = None         # tables of plan_section
    against: list = field(default_factory=list)  # folders of other weights' results
    bakes: dict = field(default_factory=dict)    # proof_inputs.Bake of one scene, by weights
    paths: dict = field(default_factory=dict)  # role → path
    is_evaluation: bool = False  # the scenes that published figures are of
    left_out: list = field(default_factory=list)  # what the run did less of than a full one, in words
    name: str = ""         # of the run, and the day of its measurements
    measured_on: str = ""


def draw_plots(inputs, frontier, scene_order):
    """Section name → one SVG a representation (or a figure, or a scene)."""
    log_limits = plots.error_limits([array for log in inputs.logs.values() for array in (log.training_loss, log.held_out_network, log.held_out)])
    return {
        "curve": [plots.finish(curve.draw(inputs.summary), "curve", "Blend RMSE against bytes a function and against evaluation time")],
        "frontier": frontier_module.whole_svgs(frontier) if frontier else [],
        "frontier_scenes": frontier_module.scene_svgs(frontier, scene_order) if frontier else [],
        "training": [plots.training_curve(inputs, n, log_limits) for n in inputs.representations],
    }


# section's id → its name in the list of contents
CONTENTS = {"stages": "Stages", "frontier": "Error against time", "scenes": "Scenes", "slices": "Worst functions", "stability": "Stability",
            "savings": "Savings", "light": "Light", "training": "Training", "figures": "Every figure", "sample": "Best known", "data": "Data and time", "provenance": "Provenance"}


def contents(proof):
    absent = {*(() if proof.frontier else ("frontier",)), *(() if proof.cases else ("stability",)), *(() if proof.savings else ("savings",)), *(() if proof.light else ("light",)), *(() if proof.data else ("data",))}
    return [(section, name) for section, name in CONTENTS.items() if section not in absent]


def provenance_rows(inputs, proof, limits):
    origin = inputs.summary["provenance"]
    rows = [("made by", f"{origin['tool'].text()}, revision {origin['revision'].text()}")]
    rows += [("left out of this run; effort: full brings it back", text) for text in proof.left_out]
    rows += [(f"option {key}", str(node.value)) for key, node in origin["options"].entries()]
    rows += [(f"SHA-256 of {key}", node.text()) for key, node in origin["inputs"].entries()]
    rows += [(f"SHA-256 of the weights of {n}", inputs.summary["representations"][n]["weights_sha256"].text()) for n in inputs.representations]
    rows += [(f"limit {key}", f"{value:g}") for key, value in vars(limits).items()]
    rows += [(f"SHA-256 of the {role} read here", sha256(path)) for role, path in {**inputs.paths, **proof.paths}.items()]
    return rows


def proof_values(proof, decision):
    """What the template shows of the proof's files."""
    values = {"decision": decision, "frontier": proof.frontier, "savings": proof.savings, "light": None, "data_tables": proof.data, "is_evaluation": proof.is_evaluation, "left_out": [proof_inputs.setting_words(text) for text in proof.left_out], "contents": contents(proof), "table": decision_module.table,
              "percent": findings_module.percent, "talk_fitted": findings_module.TALK_FITTED, "stage_tables": decision.stage_tables(proof.frontier), "run_name": proof.name, "measured_on": proof.measured_on}
    if proof.frontier:
        views = frontier_module.views(proof.frontier)
        values |= {"frontier_views": [(view, decision_module.front_rows(proof.frontier, view)) for view in views], "front_summary": decision_module.front_summary}
    if proof.savings:
        values |= {"saving_groups": decision_module.saving_groups(proof.savings), "savings_sentence": decision_module.savings_sentence(proof.savings)}
    if proof.light:
        light = light_section.LightSection(proof.light, decision.leader)
        values |= {"light": light, "light_plots": {cost: [Markup(text) for text in light.panels(cost)] for cost in light_section.COSTS}}
    return values


def render(inputs, proof, limits):
    findings = findings_module.Findings(inputs)
    decision = decision_module.Decision(inputs, limits, proof.cases, proof.frontier, proof.against, proof.bakes)
    limit = slices.difference_limit(inputs.slices)
    environment = jinja2.Environment(loader=jinja2.FileSystemLoader(os.path.dirname(os.path.abspath(__file__))), autoescape=True,
                                     undefined=jinja2.StrictUndefined, trim_blocks=True, lstrip_blocks=True)
    galleries = [(name, light_section.data_uri(slices.plate(inputs.slices, [name], limit))) for name in [decision.leader, *decision.others()]]
    scene_order = [row["scene"] for row in decision.scene_rows()]
    svg = {name: [Markup(text) for text in panels] for name, panels in draw_plots(inputs, proof.frontier, scene_order).items()}
    page = environment.get_template("report.html.j2").render(
        findings=findings, grouped=findings_module.grouped, plural=findings_module.plural, plots=svg, galleries=galleries,
        colour=plots.colour, representation_colour=plots.representation_colour,
        revision=inputs.summary["provenance"]["revision"].text(), provenance=provenance_rows(inputs, proof, limits), quantiles=inputs_module.QUANTILES, names=plots.NAMES, shown=curve.SHOWN, **proof_values(proof, decision))
    return page.encode(), slices.plate(inputs.slices, inputs.representations[:slices.PLATE_REPRESENTATIONS], limit), decision.text().encode()


def read_proof(arguments, summary):
    proof = Proof(is_evaluation=arguments.evaluation, left_out=arguments.left_out, against=arguments.against)
    proof.paths |= {f"summary of {os.path.basename(folder)}": os.path.join(folder, "summary.json") for folder in arguments.against}
    if arguments.frontier:
        proof.frontier, proof.paths["frontier"] = proof_inputs.read_frontier(arguments.frontier), arguments.frontier
        proof_inputs.refuse_other_weights(arguments.frontier, summary, {point.representation for point in proof.frontier.points})
        proof_inputs.check_same_scenes(proof.frontier, summary)
    if arguments.stability:
        proof.cases, proof.paths["stability"] = proof_inputs.read_stability(arguments.stability), arguments.stability
        proof_inputs.refuse_other_weights(arguments.stability, summary, {name for name, _ in summary["representations"].entries()})
    if arguments.savings:
        proof.savings = [proof_inputs.read_savings(path) for path in arguments.savings]
        proof.paths |= {f"savings of {scene}": path for path, (scene, _) in zip(arguments.savings, proof.savings)}
    if arguments.bakes:
        paths = {"these": arguments.savings[0], **{os.path.splitext(os.path.basename(path))[0]: path for path in arguments.bakes}}
        proof.bakes = {name: proof_inputs.read_bake(path) for name, path in paths.items()}
        proof.paths |= {f"bake, {name}": path for name, path in paths.items() if name != "these"}
    if arguments.light:
        proof.light = light_figures.read_all(arguments.light)
        proof.paths |= {f"light of {os.path.splitext(os.path.basename(path))[0]}": path for path in arguments.light}
    if arguments.run:
        proof.name, proof.measured_on = os.path.basename(os.path.abspath(arguments.run)), time.strftime("%-d %B %Y", time.localtime(os.path.getmtime(arguments.summary)))
    if arguments.data:
        proof.data, proof.paths["data card"] = plan_section.tables(arguments.run, arguments.data), arguments.data
    return proof


def parse_arguments():
    parser = argparse.ArgumentParser(description="Draws nlg-validate's results as one self-contained page.")
    parser.add_argument("--summary", required=True, help="summary.json of nlg-validate")
    parser.add_argument("--functions", required=True, help="functions.csv of nlg-validate")
    parser.add_argument("--slices", required=True, help="slices.json of nlg-validate")
    parser.add_argument("--logs", required=True, nargs="+", help="training curves of nlg-train, each named after its representation")
    parser.add_argument("--frontier", help="frontier.json of nlg-validate frontier")
    parser.add_argument("--stability", help="output of nlg-validate stability")
    parser.add_argument("--savings", nargs="+", help="reports of nlg-bake --json, one per scene")
    parser.add_argument("--bakes", nargs="+", default=[], help="reports of the first of --savings baked otherwise: supplied.json, init.json (weights), without.json (no generator)")
    parser.add_argument("--light", nargs="+", help="light.json of nlg-validate light, one per scene")
    parser.add_argument("--data", help="output of nlg-datagen info --json on the data set")
    parser.add_argument("--against", nargs="+", default=[], help="folders of nlg-validate's results on the same functions, of other weights: supplied, init")
    parser.add_argument("--run", help="folder of the run, whose plan and times are compared if it has a plan")
    parser.add_argument("--evaluation", action="store_true", help="say on the page that the scenes are those of the published figures")
    parser.add_argument("--left-out", nargs="*", default=[], help="what the run did less of than a full one, a text each: stands in the page's provenance")
    limits = verdict.Limits()
    parser.add_argument("--max-share-failing", type=float, default=limits.share_failing, help="maximum share of functions with a theta that fail the check in the stored stage of a generator that may ship (default: %(default)g)")
    parser.add_argument("--max-error-hard", type=float, default=limits.error_hard, help="maximum median ratio of stored to best known blend RMSE on hard functions of a generator that may ship (default: %(default)g)")
    parser.add_argument("--min-speedup", type=float, default=limits.speedup, help="minimum speed, fitted, over the fastest direct fit to the same mean blend RMSE, of a generator that may ship (default: %(default)g)")
    parser.add_argument("--out", required=True, help="page to write. slices.png and verdict.txt are written beside it")
    arguments = parser.parse_args()
    if arguments.bakes and not arguments.savings:
        parser.error("--bakes: expected --savings, whose first bake they are compared with")
    return arguments


def main():
    arguments = parse_arguments()

    def make():
        inputs = inputs_module.read_inputs(arguments.summary, arguments.functions, arguments.slices, arguments.logs)
        limits = verdict.Limits(arguments.max_share_failing, arguments.max_error_hard, arguments.min_speedup)
        page, plate, text = render(inputs, read_proof(arguments, inputs.summary), limits)
        beside = lambda name: os.path.join(os.path.dirname(arguments.out), name)
        return {beside("slices.png"): plate, beside("verdict.txt"): text, arguments.out: page}
    return run("report.py", lambda: write_files(make()))


if __name__ == "__main__":
    sys.exit(main())

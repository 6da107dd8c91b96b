#!/usr/bin/env python3
"""Draws nlg-validate's results as one self-contained page, report.html, and the slices as slices.png beside it.

    report.py --summary S.json --functions F.csv --slices L.json --basis B.json --logs mlp.csv tent_mlp.csv --out report.html

The same inputs give the same bytes. A file that cannot be used ends it with one line on stderr and exit code 3, an output that
cannot be written with 5 (tool/error.h); nothing half-written is left behind. docs/formats.md says what the inputs hold.
"""
import argparse
import logging
import os
import sys

sys.dont_write_bytecode = True
logging.getLogger("matplotlib").setLevel(logging.ERROR)

import jinja2
import numpy as np
from markupsafe import Markup

import curve
import findings as findings_module
import inputs as inputs_module
import output
import plots
import slices


def draw_plots(inputs, findings):
    """Section name → one SVG a representation (or a figure)."""
    tau, names = findings.tau_rmse, inputs.representations
    tent = inputs.samples["tent", "tent"]
    shown = [inputs.samples[key].rmse for key in inputs.samples if key[1] in ("tent", "uncorrected", "generator", "refined", "direct")]
    all_limits = plots.error_limits(shown)
    generated = [inputs.samples[n, "generator"] for n in names]
    time_limits = run_time_limits(inputs)
    chosen = [inputs.chosen(n, m).rmse for n in names for m in inputs_module.METHODS]
    fit_limits = plots.error_limits([np.quantile(c, (0.05, 0.95)) for c in chosen] + [[np.median(inputs.chosen(names[0], "tent").rmse)]])
    seen_limits = plots.error_limits([s.rmse for s in generated] + [s.rmse_unseen for s in generated])
    spread = lambda values: np.quantile(values[np.isfinite(values)], (0.05, 0.95)) if np.isfinite(values).any() else values
    shadow_limits = plots.error_limits([spread(getattr(s, key)) for (_, m), s in inputs.samples.items()
                                        if m in ("tent", "uncorrected", "generator", "refined", "direct") for key in ("rmse", "rmse_shadow")])
    order = findings.scene_order()
    both = generated + [inputs.samples[n, "uncorrected"] for n in names]
    scene_limits = plots.error_limits([np.quantile(s.rmse[s.scene == scene], (0.5, 0.95)) for s in both for scene in order])
    log_limits = plots.error_limits([array for log in inputs.logs.values() for array in (log.training_loss, log.held_out_generated, log.held_out_rmse)])
    tent_median = float(np.median(inputs.chosen(names[0], "tent").rmse)) if len(tent) else 0.0
    return {
        "curve": [plots.finish(curve.draw(inputs.summary), "curve", "Error against bytes a function and against evaluation time")],
        "histogram": [plots.histogram(inputs, n, all_limits, tau) for n in names],
        "run_time": [plots.run_time(inputs, n, fit_limits, time_limits, tent_median) for n in names],
        "by_scene": [plots.by_scene(inputs, n, order, scene_limits, tau) for n in names],
        "unseen_points": [plots.unseen_points(inputs, n, seen_limits) for n in names],
        "shadow": [plots.shadow(inputs, n, shadow_limits) for n in names],
        "training": [plots.training_curve(inputs, n, log_limits) for n in names],
        "spectrum": [plots.spectrum(inputs.basis), plots.kept_variance(inputs.basis)],
    }


def run_time_limits(inputs):
    """Whole decades around all methods; a method without a time stands at the left edge."""
    times = [float(np.mean(inputs.chosen(n, m).elapsed_us)) for n in inputs.representations for m in inputs_module.METHODS]
    times = [t for t in times if t > 0] or [1.0]
    return 10 ** np.floor(np.log10(min(times) / 1.3)), 10 ** np.ceil(np.log10(max(times) * 1.3))


def provenance_rows(inputs):
    origin = inputs.summary["provenance"]
    rows = [("made by", f"{origin['tool'].text()}, revision {origin['revision'].text()}")]
    rows += [(f"option {key}", str(node.value)) for key, node in origin["options"].entries()]
    rows += [(f"SHA-256 of {key}", node.text()) for key, node in origin["inputs"].entries()]
    rows += [(f"SHA-256 of the weights of {n}", inputs.summary["representations"][n]["weights_sha256"].text()) for n in inputs.representations]
    rows += [(f"SHA-256 of the {role} read here", inputs_module.sha256(path)) for role, path in inputs.paths.items()]
    return rows


def render(inputs):
    findings = findings_module.Findings(inputs)
    limit = slices.difference_limit(inputs.slices)
    environment = jinja2.Environment(loader=jinja2.FileSystemLoader(os.path.dirname(os.path.abspath(__file__))), autoescape=True,
                                     undefined=jinja2.StrictUndefined, trim_blocks=True, lstrip_blocks=True)
    galleries = [(name, slices.gallery([s for s in inputs.slices if s.representation == name], limit)) for name in inputs.representations]
    svg = {name: [Markup(text) for text in panels] for name, panels in draw_plots(inputs, findings).items()}
    page = environment.get_template("report.html.j2").render(
        findings=findings, grouped=findings_module.grouped, plural=findings_module.plural, plots=svg, galleries=galleries,
        scales=slices.scales(limit), colour=plots.colour, representation_colour=plots.representation_colour, provenance=provenance_rows(inputs), quantiles=inputs_module.QUANTILES)
    return page.encode(), slices.plate(inputs, limit)


def parse_arguments():
    parser = argparse.ArgumentParser(description="Draws nlg-validate's results as one self-contained page.")
    parser.add_argument("--summary", required=True, help="summary.json of nlg-validate")
    parser.add_argument("--functions", required=True, help="functions.csv of nlg-validate")
    parser.add_argument("--slices", required=True, help="slices.json of nlg-validate")
    parser.add_argument("--basis", required=True, help="what nlg-pca printed")
    parser.add_argument("--logs", required=True, nargs="+", help="training curves of nlg-train, each named after its representation")
    parser.add_argument("--out", required=True, help="the page to write; slices.png is written beside it")
    return parser.parse_args()


def main():
    arguments = parse_arguments()

    def make():
        inputs = inputs_module.read_inputs(arguments.summary, arguments.functions, arguments.slices, arguments.basis, arguments.logs)
        page, plate = render(inputs)
        return {os.path.join(os.path.dirname(arguments.out), "slices.png"): plate, arguments.out: page}
    return output.run("report.py", arguments.out, make)


if __name__ == "__main__":
    sys.exit(main())

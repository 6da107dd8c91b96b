"""The report's plots: one panel, one SVG with its text as text, so that panels wrap like words in a narrow window.

Colours of words are those of Okabe and Ito (2008), told apart by colour-blind readers; a colour means one word everywhere.
Representations have colours and shapes of their own, dark enough for print: networks cold, product fields warm.
"""
import html
import io
import re

import matplotlib

matplotlib.use("Agg")
import matplotlib.pyplot as plt
import numpy as np
from matplotlib.ticker import FuncFormatter, LogLocator, NullFormatter

INK, MUTED, RULE = "#1d232a", "#5d6772", "#d5dbe1"
COLOURS = {"tent": "#7a828a", "network": "#56B4E9", "corrected": "#0072B2", "fitted": "#E69F00", "stored": "#D55E00", "direct": "#CC79A7",
           "best_known": "#009E73", "other": "#9b6a8f"}
NAMES = {"tent": "bare tent", "network": "network", "corrected": "corrected", "fitted": "fitted", "stored": "stored",
         "direct": "direct", "best_known": "best known"}
POPULATION_NAMES = {"theta": "functions that take a θ", "hard": "hard functions", "all": "all distinct functions"}
REPRESENTATIONS = {"mlp": ("#1d232a", "s"), "tent_mlp": ("#0b4f9c", "o"), "tent_mlp44": ("#118a7e", "^"),
                   "tent_mlp4": ("#7a3fb0", "v"), "pf3": ("#c08a00", "<"), "pf5": ("#d95f0e", ">"), "pf7": ("#b3173c", "p"),
                   "pf9": ("#6b2d0f", "h"), "code16": ("#7fbf7b", "D"), "code32": ("#4d9b4b", "D"), "code48": ("#2f7d32", "D"),
                   "code64": ("#1b5e20", "D"), "code128": ("#0b3d10", "D")}
OTHER_REPRESENTATION = (MUTED, "o")
PANEL = (4.7, 3.15)  # inches; scaled to its column by the page

plt.rcParams.update({
    "text.parse_math": False, "font.family": "DejaVu Sans", "font.size": 8.5, "svg.fonttype": "none", "axes.edgecolor": MUTED, "axes.labelcolor": INK,
    "axes.linewidth": 0.7, "axes.spines.top": False, "axes.spines.right": False, "axes.titlelocation": "left",
    "axes.titlesize": 9.5, "axes.titleweight": "bold", "axes.titlecolor": INK, "axes.axisbelow": True, "text.color": INK,
    "xtick.color": MUTED, "ytick.color": MUTED, "xtick.labelcolor": MUTED, "ytick.labelcolor": MUTED, "grid.color": RULE,
    "grid.linewidth": 0.6, "legend.frameon": False, "legend.fontsize": 8, "lines.solid_capstyle": "round"})


def png(figure):
    """The figure's PNG, closed afterwards; no version inside, so that the same figure gives the same bytes."""
    buffer = io.BytesIO()
    figure.savefig(buffer, format="png", dpi=150, facecolor="white", metadata={"Software": None})
    plt.close(figure)
    return buffer.getvalue()


def colour(word):
    return COLOURS.get(word, COLOURS["other"])


def representation_colour(name):
    return REPRESENTATIONS.get(name, OTHER_REPRESENTATION)[0]


def representation_marker(name):
    return REPRESENTATIONS.get(name, OTHER_REPRESENTATION)[1]


def short(value):
    """A tick's number without trailing zeros."""
    return f"{value:.10f}".rstrip("0").rstrip(".") if abs(value) < 1e4 else f"{value:,.0f}".replace(",", " ")


def duration(us):
    """12 µs, 3.4 ms, 1.2 s."""
    for unit, scale in (("µs", 1.0), ("ms", 1e3)):
        if us < 999.5 * scale:
            return f"{us / scale:.3g} {unit}"
    return f"{us / 1e6:.3g} s"


def start(title, size=PANEL, x=None, y=None, grid="both"):
    figure, axes = plt.subplots(figsize=size, layout="constrained")
    axes.set_title(title, color=REPRESENTATIONS.get(title, (INK,))[0])
    axes.set_xlabel(x)
    axes.set_ylabel(y)
    axes.grid(True, axis=grid)
    return figure, axes


def finish(figure, name, description, hover=None):
    """The figure as inline SVG: ids made unique in the page, no fixed size, the page's own font.

    hover   gid of an artist → what the page shows while the pointer is on it
    """
    buffer = io.StringIO()
    with matplotlib.rc_context({"svg.hashsalt": name}):
        figure.savefig(buffer, format="svg", dpi=160, transparent=True, metadata={"Date": None, "Creator": None})
    plt.close(figure)
    svg = buffer.getvalue()
    svg = svg[svg.index("<svg"):]
    svg = re.sub(r"<metadata>.*?</metadata>", "", svg, flags=re.S)
    svg = re.sub(r'(<svg[^>]*?) width="[^"]*" height="[^"]*"|(<svg[^>]*?) height="[^"]*"', r"\1\2", svg, count=1)
    svg = re.sub(r'(<svg[^>]*?) width="[^"]*"', r"\1", svg, count=1)
    svg = re.sub(r"\b(id=\"|url\(#|href=\"#)", rf"\g<1>{name}-", svg)
    svg = re.sub(r"(font: [^;\"]*?)'DejaVu Sans'[^;\"]*", r"\1var(--sans)", svg)
    for gid, text in (hover or {}).items():
        svg = svg.replace(f'<g id="{name}-{gid}">', f'<g id="{name}-{gid}" class="tip"><title>{html.escape(text)}</title>', 1)
    return svg.replace("<svg", f'<svg role="img" aria-label="{html.escape(description)}"', 1)


def log_error_axis(axis, low, high):
    """Errors from .001 to .1 read as numbers, not as powers of ten."""
    axis.axes.set(**{f"{axis.axis_name}scale": "log", f"{axis.axis_name}lim": (low, high)})
    ratio = high / low
    subs = (1, 1.5, 2, 3, 5, 7) if ratio < 8 else (1, 2, 5) if ratio < 500 else (1,)
    axis.set_major_locator(LogLocator(subs=subs, numticks=20))
    axis.set_major_formatter(FuncFormatter(lambda v, _: short(v)))
    axis.set_minor_formatter(NullFormatter())


def error_limits(arrays, low=0.0006):
    """Limits for errors on a logarithmic axis: what lies below is drawn at the edge."""
    values = np.concatenate([np.asarray(a, dtype=float) for a in arrays])
    values = values[np.isfinite(values) & (values > 0)]
    bottom = max(low, values.min() * 0.8) if len(values) else low
    top = values.max() * 1.25 if len(values) else 1.0
    return bottom, max(top, 4 * bottom)


# ---- one function a plot ----------------------------------------------------------------------------------------------


def pareto(points):
    """Of (time, error, …) those that no other beats in both, by rising time."""
    front = []
    for point in sorted(points):
        if not front or point[1] < front[-1][1]:
            front.append(point)
    return front


def training_curve(inputs, representation, limits):
    log = inputs.logs[representation]
    figure, axes = start(representation, x="training step", y="mean blend RMSE")
    axes.plot(log.step, np.clip(log.training_loss, *limits), color=MUTED, linewidth=1.2, linestyle=(0, (3, 2)), label="training loss")
    if not np.array_equal(log.held_out_network, log.held_out):
        axes.plot(log.step, np.clip(log.held_out_network, *limits), color=colour("network"), linewidth=1.4, marker="o", markersize=2.6,
                  label="held-out scenes, network")
    axes.plot(log.step, np.clip(log.held_out, *limits), color=colour("corrected"), linewidth=1.8, marker="o", markersize=3.2,
              label="held-out scenes, best stage")
    log_error_axis(axes.yaxis, *limits)
    axes.set_xlim(0, log.step.max() * 1.02)
    axes.xaxis.set_major_formatter(FuncFormatter(lambda v, _: short(v)))
    axes.annotate(f"{log.held_out[-1]:.4f}", (log.step[-1], log.held_out[-1]), xytext=(0, 7), textcoords="offset points",
                  ha="right", fontsize=8, color=colour("corrected"))
    axes.legend(loc="best")
    return finish(figure, f"training-{representation}", f"Training curve, {representation}")


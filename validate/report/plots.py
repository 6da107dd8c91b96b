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

from inputs import FITS, WORDS

INK, MUTED, RULE = "#1d232a", "#5d6772", "#d5dbe1"
COLOURS = {"tent": "#7a828a", "network": "#56B4E9", "corrected": "#0072B2", "fitted": "#E69F00", "stored": "#D55E00", "direct": "#CC79A7",
           "best_known": "#009E73", "other": "#9b6a8f"}
NAMES = {"tent": "bare tent", "network": "network", "corrected": "corrected", "fitted": "fitted", "stored": "stored", "adam_theta0": "Adam from θ₀",
         "lm_theta0": "LM from θ₀", "adam_random": "Adam from a random start", "direct": "direct", "best_known": "best known"}
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


def mark_tau(axes, tau, vertical):
    """The error above which a function fails the check."""
    low, high = axes.get_xlim() if vertical else axes.get_ylim()
    if not low <= tau <= high:
        return
    line = axes.axvline if vertical else axes.axhline
    line(tau, color=INK, linewidth=0.9, linestyle=(0, (1, 2)), zorder=1)
    place = dict(x=tau, y=1.0, xytext=(3, -1), va="top", ha="left") if vertical else dict(x=1.0, y=tau, xytext=(-2, 2), va="bottom", ha="right")
    transform = axes.get_xaxis_transform() if vertical else axes.get_yaxis_transform()
    axes.annotate(f"the check: {short(tau)}", (place.pop("x"), place.pop("y")), xycoords=transform, textcoords="offset points", fontsize=7.5,
                  color=MUTED, **place)


DIRECTIONS = [(np.cos(a), np.sin(a)) for a in np.arange(0, 2 * np.pi, np.pi / 8)]


def overlap(a, b):
    return a[0] < b[2] and b[0] < a[2] and a[1] < b[3] and b[1] < a[3]


def box_beside(x, y, direction, distance, size):
    """The box of this size that touches the point at `distance` from (x, y) from outside; (left, bottom, right, top)."""
    dx, dy = direction
    left = x + dx * distance - size[0] * (0.5 - 0.5 * np.clip(1.6 * dx, -1, 1))
    bottom = y + dy * distance - size[1] * (0.5 - 0.5 * np.clip(1.6 * dy, -1, 1))
    return left, bottom, left + size[0], bottom + size[1]


def place_labels(figure, axes, labels, lines, fixed):
    """Names points without overlap: each label takes the cheapest place around its point, with a thin leader when it is far.

    labels   (x, y, text, colour), data coordinates; no label may cover another, a point, or `fixed` (artists)
    lines    lists of (x, y), data coordinates: bars and curves that labels should rather not cover
    """
    figure.canvas.draw()
    renderer, scale = figure.canvas.get_renderer(), figure.dpi / 72.0
    frame = axes.get_window_extent()
    points = axes.transData.transform([label[:2] for label in labels])
    radius = 4.5 * scale
    taken = [(x - radius, y - radius, x + radius, y + radius) for x, y in points] + [a.get_window_extent(renderer).extents for a in fixed]
    dots = [tuple(p) for line in lines for p in sample_path(axes.transData.transform(line), 3.0 * scale)]
    for (x, y), (data_x, data_y, text, text_colour) in zip(points, labels):
        artist = axes.annotate(text, (data_x, data_y), xytext=(0, 0), textcoords="offset points", fontsize=7.5, color=text_colour, zorder=6)
        extent = artist.get_window_extent(renderer)
        best = None
        for distance in (7, 14, 22, 32, 44, 58, 74, 92, 112):
            for direction in DIRECTIONS:
                box = box_beside(x, y, direction, distance * scale, (extent.width, extent.height))
                if box[0] < frame.x0 or box[2] > frame.x1 or box[1] < frame.y0 or box[3] > frame.y1 or any(overlap(box, t) for t in taken):
                    continue
                cost = distance + 4 * sum(box[0] < dx < box[2] and box[1] < dy < box[3] for dx, dy in dots)
                if best is None or cost < best[0]:
                    best = cost, box, distance
        _, box, distance = best or (0, (x, y, x + extent.width, y + extent.height), 0)
        taken.append((box[0] - 2, box[1] - 1, box[2] + 2, box[3] + 1))
        artist.set_position(((box[0] - x) / scale, (box[1] - y) / scale))
        if distance >= 14:
            end = axes.transData.inverted().transform((np.clip(x, box[0], box[2]), np.clip(y, box[1], box[3])))
            axes.plot([data_x, end[0]], [data_y, end[1]], color=text_colour, linewidth=0.5, zorder=4)


def sample_path(corners, step):
    """Points along a polyline, no farther apart than step."""
    for (x0, y0), (x1, y1) in zip(corners[:-1], corners[1:]):
        count = max(2, int(np.hypot(x1 - x0, y1 - y0) / step) + 1)
        yield from zip(np.linspace(x0, x1, count), np.linspace(y0, y1, count))


# ---- one function a plot ----------------------------------------------------------------------------------------------


def histogram(inputs, representation, limits, tau):
    figure, axes = start(representation, x="blend RMSE of a function that takes a θ", y="share of functions, % a bin")
    bins = np.geomspace(*limits, 41)
    top = 0.0
    for word in ("tent", *WORDS):
        samples = inputs.over(representation, word)
        share = 100.0 * np.histogram(np.clip(samples.blend_rmse, *limits), bins)[0] / max(1, len(samples))
        top = max(top, share.max())
        # what is fitted and what is stored differ by rounding alone: dots over a line
        axes.stairs(share, bins, color=colour(word), linewidth=1.5, linestyle=(0, (1, 1.5)) if word == "stored" else "-", label=NAMES[word], zorder=3)
        if word == "stored":
            axes.stairs(share, bins, color=colour(word), alpha=0.15, fill=True, zorder=2)
    axes.set_ylim(0, 1.6 * max(top, 1.0))  # the legend lies above the bars
    log_error_axis(axes.xaxis, *limits)
    mark_tau(axes, tau, vertical=True)
    axes.legend(loc="upper left", ncol=3, borderaxespad=0.2, columnspacing=1.0, handlelength=1.6, bbox_to_anchor=(0, 0.95))
    return finish(figure, f"histogram-{representation}", f"Histogram of blend RMSE over functions that take a θ, {representation}")


def pareto(points):
    """Of (time, error, …) those that no other beats in both, by rising time."""
    front = []
    for point in sorted(points):
        if not front or point[1] < front[-1][1]:
            front.append(point)
    return front


def test_points(inputs, representation, limits):
    samples = inputs.over(representation, "stored")
    figure, axes = start(representation, size=(4.7, 4.1), x="RMSE on support points", y="RMSE on test points")
    axes.plot(limits, limits, color=INK, linewidth=0.9, zorder=3)
    axes.annotate("equal", (limits[0], limits[0]), xytext=(14, 5), textcoords="offset points", fontsize=7.5, color=MUTED)
    size = 9 if len(samples) < 1000 else 3
    for hard, shade, label in ((False, "#F0B27A", "easy"), (True, "#D55E00", "hard")):
        some = samples.hard == hard
        axes.scatter(np.clip(samples.rmse[some], *limits), np.clip(samples.rmse_test_points[some], *limits), s=size, linewidths=0,
                     color=shade, alpha=0.6, rasterized=True, zorder=2)
        axes.plot([], [], "o", color=shade, markersize=4, label=label)
    log_error_axis(axes.xaxis, *limits)
    log_error_axis(axes.yaxis, *limits)
    axes.set_aspect("equal")
    axes.legend(loc="upper left", handletextpad=0.1)
    return finish(figure, f"test-points-{representation}", f"RMSE on test points against support points, {representation}")


def occluded(inputs, representation, limits):
    figure, axes = start(representation, size=(4.7, 2.75), x="RMSE of a function that takes a θ (median; bar p5–p95)", grid="x")
    rows = ("tent", *WORDS)
    for row, word in enumerate(rows):
        samples = inputs.over(representation, word)
        has_occluded = np.isfinite(samples.rmse_occluded)
        for values, offset, filled in ((samples.rmse[has_occluded], -0.17, False), (samples.rmse_occluded[has_occluded], 0.17, True)):
            if not len(values):
                continue
            low, middle, high = np.clip(np.quantile(values, (0.05, 0.5, 0.95)), *limits)
            axes.plot([low, high], [row + offset] * 2, color=colour(word), linewidth=2.2, alpha=0.8 if filled else 0.3, zorder=2)
            axes.plot(middle, row + offset, "o", markersize=6, color=colour(word), zorder=3,
                      markerfacecolor=colour(word) if filled else "white")
    for filled, label in ((False, "all valid points"), (True, "occluded points")):
        axes.plot([], [], "o-", color=MUTED, markersize=5.5, markerfacecolor=MUTED if filled else "white", label=label)
    axes.set_yticks(range(len(rows)), [NAMES[word] for word in rows])
    axes.set_ylim(len(rows) - 0.5, -0.5)
    axes.tick_params(axis="y", length=0)
    log_error_axis(axes.xaxis, *limits)
    axes.legend(loc="lower right", bbox_to_anchor=(1.0, 1.0), ncol=2, borderaxespad=0.1, columnspacing=1.0)
    return finish(figure, f"occluded-{representation}", f"RMSE on occluded points, {representation}")


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


def spectrum(basis):
    values = np.array(basis["spectrum"].numbers(low=0.0), dtype=float)
    kept_count = basis["components"].count()
    values = values[values > 1e-9 * values.max()] if values.max() > 0 else values
    figure, axes = start("Spectrum of the training set", x="component, by falling variance", y="variance (sum over points)")
    axes.plot(np.arange(1, len(values) + 1), values, color=colour("corrected"), linewidth=1.6)
    axes.set(xscale="log", yscale="log", xlim=(1, 2.2 * len(values)))
    axes.xaxis.set_major_formatter(FuncFormatter(lambda v, _: short(v)))
    axes.axvline(kept_count, color=INK, linewidth=0.9, linestyle=(0, (1, 2)))
    axes.annotate(f"{kept_count} are kept", (kept_count, 1.0), xycoords=axes.get_xaxis_transform(), xytext=(-4, -2),
                  textcoords="offset points", ha="right", va="top", fontsize=8, color=MUTED)
    return finish(figure, "spectrum", "Variance of each component")


def kept_variance(basis):
    pairs = sorted((int(name), node.number()) for name, node in basis["held_out_variance_kept"].entries())
    counts, kept = zip(*pairs)
    lost = 100.0 * (1.0 - np.array(kept))
    figure, axes = start("Held-out variance that is lost", x="components", y="lost, %")
    axes.plot(counts, lost, color=colour("corrected"), linewidth=1.6, marker="o", markersize=5)
    axes.set_xscale("log", base=2)
    axes.set_xticks(counts, [short(c) for c in counts])
    axes.set_xlim(counts[0] / 1.35, counts[-1] * 1.5)
    axes.set_ylim(0, lost.max() * 1.18)
    for count, value in zip(counts, lost):
        axes.annotate(f"{value:.1f}", (count, value), xytext=(4, 5), textcoords="offset points", fontsize=8)
    axes.axvline(basis["components"].count(), color=INK, linewidth=0.9, linestyle=(0, (1, 2)))
    return finish(figure, "kept", "Held-out variance lost by number of components")

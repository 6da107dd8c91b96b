#!/usr/bin/env python3
"""Pictures of planes through weighting functions: target, stored, difference, and what stands there.

    slices.py --summary S.json --slices L.json --out slices.png
"""
import argparse
import io
import sys

sys.dont_write_bytecode = True

import packages

packages.need("slices.py", "matplotlib", "numpy")

import inputs as inputs_module
import matplotlib
import numpy as np
from plots import INK, MUTED, plt, representation_colour

from tool.atomic_file import write_files
from tool.errors import run

PHI_MAP = matplotlib.colormaps["inferno"]
DIFFERENCE_MAP = matplotlib.colormaps["PuOr_r"]  # orange: the representation lets more in than the function
KINDS = ("target", "stored", "difference", "geometry cut")
SIGHT, OCCLUDED = "#ffe9a8", "#46566e"  # valid points: in plain sight of the probe, and not
PLATE_REPRESENTATIONS = 2  # beside each other in slices.png
ZOOM = 3


def upright(slice_, picture):
    """Rows downwards and columns rightwards as a person looks at a level: y up, or the floor plan with x rightwards."""
    # as stored, rows run along axis + 2 and columns along axis + 1
    if slice_.axis == 0:  # columns y, rows z
        return picture.T[::-1]
    if slice_.axis == 1:  # columns z, rows x
        return picture.T
    return picture[::-1]  # columns x, rows y


def plane_text(slice_):
    return ("upright plane, z to the right", "floor plan, x to the right", "upright plane, x to the right")[slice_.axis]


def difference_limit(slices):
    """The largest difference that the colours show: 98 % of all valid pixels lie below, rounded up to a plain number."""
    values = np.concatenate([np.abs(s.difference)[s.valid] for s in slices] or [np.zeros(1)])
    needed = np.quantile(values, 0.98) if len(values) else 0.0
    return next((limit for limit in (0.02, 0.05, 0.1, 0.2, 0.5, 1.0) if limit >= needed), 2.0)


def colour_image(slice_, kind, limit):
    """One picture as RGB bytes, enlarged; invalid points hatched grey, the probe a ring in the middle."""
    if kind == "geometry cut":
        sight, occluded = map(matplotlib.colors.to_rgb, (SIGHT, OCCLUDED))
        rgb = np.where(slice_.seen[..., None], sight, occluded)
    elif kind == "difference":
        rgb = DIFFERENCE_MAP(np.clip(0.5 + 0.5 * slice_.difference / limit, 0, 1))[..., :3]
    else:
        values = slice_.target if kind == "target" else slice_.stored
        rgb = PHI_MAP(np.sqrt(np.clip(values, 0, 1)))[..., :3]
    rgb = np.stack([upright(slice_, rgb[..., c]) for c in range(3)], axis=-1)
    valid = np.kron(upright(slice_, slice_.valid), np.ones((ZOOM, ZOOM))) > 0
    rgb = np.kron(rgb, np.ones((ZOOM, ZOOM, 1)))
    row, column = np.indices(valid.shape)
    hatch = np.where(((row + column) % 8 < 2)[..., None], np.array([0.62, 0.65, 0.68]), np.array([0.86, 0.88, 0.89]))
    rgb = np.where(valid[..., None], rgb, hatch)
    distance = np.hypot(row - (len(row) - 1) / 2, column - (len(row) - 1) / 2)
    rgb[(distance > 4.2) & (distance < 6.6)] = 1.0
    rgb[(distance >= 6.6) & (distance < 8.6)] = 0.0
    return (255 * rgb + 0.5).astype(np.uint8)


def plate(slices, names, limit):
    """The functions of some representations as one PNG: a column a function, a row a kind of picture."""
    shown = [s for name in names for s in slices if s.representation == name]
    left, cell, gap = 1.0, 1.42, 0.35
    band_height = 0.69 + cell * len(KINDS)
    width = cell * len(shown) + gap * (len(names) - 1) + left + 0.05
    narrow = width < 11  # of one representation: what the hatching means stands above the scales, not beside them
    height = band_height + (0.75 if narrow else 0.45)
    figure = plt.figure(figsize=(width, height))
    for i, slice_ in enumerate(shown):
        first = i == 0 or shown[i - 1].representation != slice_.representation
        draw_column(figure, slice_, left + cell * i + gap * names.index(slice_.representation), height, limit, first)
    for row, kind in enumerate(KINDS):
        figure.text((left - 0.1) / width, (height - 0.69 - (row + 0.5) * cell) / height, kind, ha="right", va="center", fontsize=9)
    draw_scale(figure, left, 0.2, PHI_MAP, lambda v: v, np.linspace(0, 1, 5) ** 0.5, ("0", ".25", ".5", ".75", "1"), "φ")
    draw_scale(figure, left + 3.2, 0.2, DIFFERENCE_MAP, lambda v: v, (0, 0.5, 1), (f"−{limit:g}", "0", f"+{limit:g}"), "difference")
    place = (left / width, 0.42 / height) if narrow else ((left + 6.6) / width, 0.12 / height)
    figure.text(*place, "above: blend RMSE, scene · hatched: in solid, masked out · ring: the probe\ngeometry cut: pale in plain sight of the probe, dark where it is occluded", fontsize=8, color=MUTED)
    buffer = io.BytesIO()
    figure.savefig(buffer, format="png", dpi=120, facecolor="white")
    plt.close(figure)
    return buffer.getvalue()


def draw_column(figure, slice_, x, top, limit, first):
    """One function: what it is, and its pictures below each other; first: the representation's name above. Inches."""
    width, height = figure.get_size_inches()
    if first:
        figure.text(x / width, (top - 0.12) / height, slice_.representation, weight="bold", fontsize=11, va="top",
                    color=representation_colour(slice_.representation))
    figure.text(x / width, (top - 0.37) / height, f"{slice_.which} · {slice_.blend_rmse:.4f}", fontsize=8, va="top")
    figure.text(x / width, (top - 0.53) / height, slice_.scene[:22], fontsize=7.5, va="top", color=MUTED)
    for row, kind in enumerate(KINDS):
        axes = figure.add_axes([x / width, (top - 0.66 - (row + 1) * 1.42) / height, 1.36 / width, 1.36 / height])
        axes.imshow(colour_image(slice_, kind, limit), interpolation="antialiased")
        axes.axis("off")


def draw_scale(figure, x, y, colour_map, transfer, ticks, labels, name):
    width, height = figure.get_size_inches()
    axes = figure.add_axes([x / width, y / height, 1.9 / width, 0.11 / height])
    axes.imshow(colour_map(transfer(np.linspace(0, 1, 256)))[None], aspect="auto", extent=(0, 1, 0, 1))
    axes.set_yticks([])
    axes.set_xticks(ticks, labels, fontsize=7)
    axes.tick_params(length=2, pad=1)
    for spine in axes.spines.values():
        spine.set_visible(False)
    figure.text((x + 2.0) / width, (y + 0.03) / height, name, fontsize=8, color=INK)


def main():
    parser = argparse.ArgumentParser(description="Draws planes through the functions that nlg-validate names: target, stored, difference, geometry.")
    parser.add_argument("--summary", required=True, help="summary.json of nlg-validate")
    parser.add_argument("--slices", required=True, help="slices.json beside it")
    parser.add_argument("--out", required=True, help="picture to write (.png)")
    arguments = parser.parse_args()

    def make():
        representations = [name for name, _ in inputs_module.read_summary(arguments.summary)["representations"].entries()]
        slices = inputs_module.read_slices(arguments.slices, representations)
        return {arguments.out: plate(slices, representations[:PLATE_REPRESENTATIONS], difference_limit(slices))}
    return run("slices.py", lambda: write_files(make()))


if __name__ == "__main__":
    sys.exit(main())

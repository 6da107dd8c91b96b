#!/usr/bin/python3
"""Pictures of a shard: slices through one function, an atlas of 64 functions, or the level from above.

    workflow/shard_pictures.py house.h5 --probe 40 --out probe.png
"""
import argparse
import io
import json
import os
import subprocess
import sys
from pathlib import Path

ROOT = Path(__file__).resolve().parents[1]
sys.path[:0] = [str(ROOT), str(ROOT / "validate/report")]
import packages

packages.need("shard_pictures.py", "h5py", "matplotlib", "numpy")

import h5py
import matplotlib

matplotlib.use("Agg")
import matplotlib.pyplot as plt
import numpy as np
from matplotlib.collections import LineCollection
from matplotlib.lines import Line2D
from matplotlib.patches import Patch

from tool.atomic_file import write_atomically
from tool.errors import InputError, ToolError, UsageError, run

UNKNOWN, SOLID, DIFFUSED, SEEN = range(4)  # what stands at a support point or pixel; unknown: no support point is in sight
REACH = 0.2  # of a pixel, in spacings: the support points stand 0.1 apart
SLAB = 0.06  # support points this near to a plane are drawn
RIGHT_UP = {0: (2, 1), 1: (0, 2), 2: (0, 1)}  # normal of a plane → axes of its picture; floor plans look down: z points down
BORDER, ONE_SIDED, TWO_SIDED, PALE = "#ff543c", "black", "#0078ff", "#60606c"
PHI = matplotlib.colormaps["viridis"].with_extremes(under="black")  # exactly 0 has a colour of its own: the smallest leak stands out
PHI_RANGE = {"vmin": 1 / 512, "vmax": 1}
NODE_STYLE = (("#2850dc", 2.4), ("#eb6e0a", 1.6), ("#d61e82", 1))  # by level of the probe tree
FLAGS = ((1, "open shell", "open"), (2, "few seen (below 1 %)", "few"), (4, "in solid, seen from an eye in air", "solid"))


class Shard:
    def __init__(self, path, scene, with_tree):
        # the tool verifies the shard first
        tool = Path(os.environ.get("NLG_BIN") or (ROOT / "build/release/bin" if (ROOT / "CMakeLists.txt").exists() else ROOT / "bin")) / "nlg-datagen"
        if not tool.exists():
            raise UsageError("NLG_BIN", "a folder with nlg-datagen", tool.parent)
        command = [tool, "geometry", path, *(["--scene", scene] if scene else []), *(["--tree"] if with_tree else [])]
        done = subprocess.run(command, capture_output=True, text=True)
        if done.returncode:
            error = ToolError(done.stderr.strip().rpartition("error: ")[2])
            error.exit_code = done.returncode
            raise error
        self.geometry = json.loads(done.stdout)
        self.triangles_m = self.geometry and np.array(self.geometry["triangles_m"]).reshape(-1, 3, 3)
        try:
            # HDF5 itself, told that a file cannot be closed, ends the process by a signal
            with h5py.File(io.BytesIO(Path(path).read_bytes()), "r") as file:
                self.points, self.phi, self.position_m, self.spacing_m, self.flags = (file[key][()] for key in ("points", "phi", "probe_position_m", "spacing_m", "flags"))
                valid, seen = (np.unpackbits(file[key][()], axis=1, bitorder="little") for key in ("validity", "seen"))
                self.title = f"{file.attrs['scene_id'].decode()}, jitter {file.attrs['jitter']}"
                self.counts = {key[6:]: int(file.attrs[key]) for key in file.attrs if key.startswith("count_")}
        except OSError as error:
            raise InputError(path, "file", "to be read", error) from None
        if not len(self.phi):
            raise InputError(path, "dataset phi", "at least one function", "none")
        self.kind = np.where(valid == 0, SOLID, np.where(seen, SEEN, DIFFUSED))
        self.seen_share = seen.mean(1)

    def near(self, idx):
        """The triangles around a probe in its local coordinates, and which of them have two sides; none without a scene."""
        if self.geometry is None:
            return None, None
        local = (self.triangles_m - self.position_m[idx]) / self.spacing_m[idx]
        is_near = (local.min(1) <= 1 + REACH).all(1) & (local.max(1) >= -1 - REACH).all(1)
        return local[is_near], np.array(self.geometry["double_sided"], bool)[is_near]


def planes_of(triangles):
    """Three linear functions a triangle (3 × triangles × 4): height above its plane and barycentric coordinates."""
    a, edge1, edge2 = triangles[:, 0], triangles[:, 1] - triangles[:, 0], triangles[:, 2] - triangles[:, 0]
    normal = np.cross(edge1, edge2)
    square = np.maximum((normal**2).sum(1, keepdims=True), 1e-300)
    slopes = np.stack([normal, np.cross(edge2, normal) / square, np.cross(normal, edge1) / square])
    return np.concatenate([slopes, -(slopes * a).sum(-1, keepdims=True)], -1)


def sampled(pixels, points, phi, kind, planes):
    """Kind, value and seen share at each of these places of a plane.

    A place takes the support points within REACH that it sees past the triangles, with a weight that falls to 0 there; its value is that of a
    plane fitted to the points of the winning kind, so that nothing is carried through a wall. Without planes_of the triangles: the nearest point.
    """
    offset = points - pixels[:, None]
    distance = (offset**2).sum(-1)
    weight = np.maximum(0, 1 - distance / REACH**2) ** 2 if planes is not None else (distance == distance.min(1, keepdims=True)).astype(float)
    if planes is not None:
        # linear along the way from a pixel to a point; what lies on one side of a plane, or beside the triangle, is not cut
        h, u, v = planes[..., :3] @ np.concatenate([pixels, points]).T + planes[..., 3:]
        apart = (h > 0).all(1) | (h < 0).all(1) | (u < 0).all(1) | (v < 0).all(1) | (u + v > 1).all(1)
        for h, u, v in np.stack([h, u, v], 1)[~apart]:
            (h0, u0, v0), (h1, u1, v1) = ((part[:len(pixels), None] for part in (h, u, v)), (part[len(pixels):] for part in (h, u, v)))
            with np.errstate(all="ignore"):
                t = h0 / (h0 - h1)
                u, v = u0 + t * (u1 - u0), v0 + t * (v1 - v0)
            weight[(t >= 0) & (t <= 1) & (u >= 0) & (v >= 0) & (u + v <= 1)] = 0
    by_kind = np.stack([(weight * (kind == k)).sum(1) for k in range(4)], 1)
    valid = by_kind[:, DIFFUSED] + by_kind[:, SEEN]
    share = by_kind[:, SEEN] / np.where(valid > 0, valid, 1)
    result = np.where(by_kind.sum(1) == 0, UNKNOWN, np.where(by_kind[:, SOLID] > valid, SOLID, np.where(share >= 0.5, SEEN, DIFFUSED)))
    weight *= kind == result[:, None]
    rows = np.concatenate([np.ones((*weight.shape, 1)), offset / REACH], -1)
    weighted = (weight[..., None] * rows).swapaxes(1, 2)
    matrix = weighted @ rows
    # slopes are damped: a plane through few points stays a sensible one
    matrix += np.maximum(matrix[:, :1, :1], 1e-9) * np.diag([1e-9, 0.02, 0.02, 0.02])
    value = np.linalg.solve(matrix, weighted @ phi[:, None])[:, 0, 0]
    low = np.where(weight > 0, phi, 1).min(1)
    return result, np.where(result >= DIFFUSED, np.clip(value, low, 1), 0), share


def slice_of(shard, idx, normal, triangles, px, tile=12):
    """The plane through the probe, px × px, first row below (floor plans: above)."""
    right, up = RIGHT_UP[normal]
    at = (np.arange(px) + 0.5) * 2 / px - 1
    pictures = np.zeros((3, px, px))
    planes = None if triangles is None else planes_of(triangles)
    reach = 1.5 * REACH if triangles is None else REACH
    for rows in (slice(i, i + tile) for i in range(0, px, tile)):
        for columns in (slice(i, i + tile) for i in range(0, px, tile)):
            y, x = np.meshgrid(at[rows], at[columns], indexing="ij")
            pixels = np.zeros((x.size, 3))
            pixels[:, right], pixels[:, up] = x.ravel(), y.ravel()
            low, high = pixels.min(0) - reach, pixels.max(0) + reach
            near = ((shard.points > low) & (shard.points < high)).all(1)
            between = None if triangles is None else planes[:, ((triangles.min(1) <= high) & (triangles.max(1) >= low)).all(1)]
            pictures[:, rows, columns] = np.reshape(sampled(pixels, shard.points[near], shard.phi[idx, near] / 255, shard.kind[idx, near], between), (3, *x.shape))
    return pictures


def cut(triangles, axis, offset=0.0):
    """Where triangles cross a plane: ends of segments, one a triangle with corners on both sides, and the index of the triangle."""
    height = triangles[:, :, axis] - offset
    above = height >= 0
    crossing = np.flatnonzero(above.any(1) & ~above.all(1))
    triangles, height, above = triangles[crossing], height[crossing], above[crossing]
    alone = np.where(above.sum(1) == 1, above.argmax(1), above.argmin(1))
    rows = np.arange(len(crossing))
    ends = [triangles[rows, alone] + (height[rows, alone] / (height[rows, alone] - height[rows, other]))[:, None] * (triangles[rows, other] - triangles[rows, alone])
            for other in ((alone + 1) % 3, (alone + 2) % 3)]
    return np.stack(ends, 1), crossing


def draw_cut(axes, triangles, double_sided, normal, offset=0.0, width=1.4):
    ends, which = cut(triangles, normal, offset)
    for is_double, colour in ((False, ONE_SIDED), (True, TWO_SIDED)):
        lines = ends[double_sided[which] == is_double][:, :, list(RIGHT_UP[normal])]
        axes.add_collection(LineCollection(lines, colors="white", linewidths=width + 1.4, zorder=2))
        axes.add_collection(LineCollection(lines, colors=colour, linewidths=width, zorder=3))


def draw_slice(axes, shard, idx, normal, px, with_points):
    right, up = RIGHT_UP[normal]
    triangles, double_sided = shard.near(idx)
    kind, phi, share = slice_of(shard, idx, normal, triangles, px)
    extent = {"origin": "lower", "extent": (-1, 1, -1, 1)}
    axes.imshow(np.ma.masked_where(kind < DIFFUSED, phi), cmap=PHI, **PHI_RANGE, **extent)
    axes.set_facecolor("#e2e2e8")
    axes.contourf(kind == SOLID, [0.5, 1.5], colors="#a8a8a8", hatches=["////"], **extent)
    border = np.ma.masked_where(kind < DIFFUSED, share)
    if border.min() < 0.5 <= border.max():
        axes.contour(border, [0.5], colors=BORDER, linewidths=1.2, **extent)
    if triangles is not None:
        draw_cut(axes, triangles, double_sided, normal)
    if with_points:
        near = np.abs(shard.points[:, normal]) < SLAB
        x, y, what, value = shard.points[near, right], shard.points[near, up], shard.kind[idx, near], shard.phi[idx, near] / 255
        axes.scatter(x[what == SOLID], y[what == SOLID], marker="x", s=12, c="white", linewidths=0.9, zorder=4)
        for which, rim in ((SEEN, "white"), (DIFFUSED, BORDER)):
            axes.scatter(x[what == which], y[what == which], c=value[what == which], s=14, cmap=PHI, **PHI_RANGE, edgecolors=rim, linewidths=0.8, zorder=4)
        axes.plot(0, 0, "+", color="black", ms=13, mew=3.5, zorder=5)
        axes.plot(0, 0, "+", color="white", ms=12, mew=1.5, zorder=6)
    axes.set(xlim=(-1, 1), ylim=(1, -1) if normal == 1 else (-1, 1), xticks=[], yticks=[])


def line_key(text, colour, **style):
    return Line2D([], [], color=colour, label=text, **style)


def slice_legend(figure, shard, bottom, with_points):
    bar = figure.colorbar(matplotlib.cm.ScalarMappable(plt.Normalize(**PHI_RANGE), PHI), cax=figure.add_axes((0.03, bottom, 0.22, 0.02)), orientation="horizontal", extend="min")
    bar.set_ticks([0.25, 0.5, 0.75, 1])
    bar.set_label("weighting function φ (black: exactly 0)")
    keys = [Patch(facecolor="#a8a8a8", hatch="////", label="solid (invalid)"), line_key("border of what the probe sees", BORDER)]
    if shard.geometry is not None:
        keys += [Patch(facecolor="#e2e2e8", label="no support point in sight"), line_key("cut of a one-sided face", ONE_SIDED), line_key("cut of a double-sided face", TWO_SIDED)]
    if with_points:
        dot = {"marker": "o", "ls": "", "markerfacecolor": PHI(0.5)}
        keys += [line_key(f"support point within {SLAB} spacings of the plane, seen", "white", **dot), line_key("not seen: φ from diffusion", BORDER, **dot),
                 line_key("invalid", "white", marker="x", ls="")]
    figure.legend(handles=keys, loc="lower right", bbox_to_anchor=(0.98, 0.004), ncol=4, fontsize=9, facecolor="#c8ccd2", framealpha=1, edgecolor="none")


def head(figure, title, *lines, is_missing=False):
    lines = [*lines, *(["The scene is not at hand: no geometry is drawn."] if is_missing else [])]
    figure.text(0.03, 0.98, title, fontsize=16, va="top")
    figure.text(0.03, 0.98 - 0.34 / figure.get_figheight(), "\n".join(lines), fontsize=9, va="top", color=PALE)


def probe_picture(shard, idx, options):
    if idx >= len(shard.phi):
        raise UsageError("--probe", f"0 to {len(shard.phi) - 1}, the functions of {options.shard}", idx)
    figure, all_axes = plt.subplots(1, 3, figsize=(16, 7.2), gridspec_kw={"left": 0.03, "right": 0.98, "top": 0.8, "bottom": 0.18, "wspace": 0.05})
    for axes, normal in zip(all_axes, (2, 1, 0)):  # as seen from the front, from above, and from the side
        right, up = ("xyz"[axis] for axis in RIGHT_UP[normal])
        draw_slice(axes, shard, idx, normal, options.px or 320, True)
        axes.set_title(f"{'xyz'[normal]} = {shard.position_m[idx, normal]:.3f} m     right: {right}, {'down' if normal == 1 else 'up'}: {up}", loc="left", fontsize=10)
    flags = ", ".join(text for bit, text, _ in FLAGS if shard.flags[idx] & bit) or "none"
    head(figure, f"{shard.title}: probe {idx}",
         f"position ({', '.join(f'{p:.3f}' for p in shard.position_m[idx])}) m, spacing {shard.spacing_m[idx]:.3f} m: a picture is two spacings wide; flags: {flags}",
         f"of the support points {(shard.kind[idx] != SOLID).mean():.1%} are valid, {shard.seen_share[idx]:.1%} are seen by the probe", is_missing=shard.geometry is None)
    slice_legend(figure, shard, 0.1, True)
    return figure


def most_telling_plane(shard, idx):
    """The normal of the plane in which a function differs most from the bare tent; one of which less than a quarter is air counts for less."""
    difference = np.abs(shard.phi[idx] / 255 - np.prod(1 - np.abs(shard.points), axis=1))
    distance = np.abs(shard.points)
    score = [difference[distance[:, axis] < 0.08].sum() * min(1, (shard.kind[idx, distance[:, axis] < 0.03] != SOLID).mean() / 0.25) for axis in range(3)]
    # the floor plan, unless another plane says clearly more
    return max(range(3), key=lambda axis: score[axis] * (1.2 if axis == 1 else 1))


def atlas_picture(shard, options):
    chosen = np.sort(np.random.default_rng(options.seed).permutation(len(shard.phi))[:64])
    figure, all_axes = plt.subplots(8, 8, figsize=(16, 20), gridspec_kw={"left": 0.03, "right": 0.98, "top": 0.94, "bottom": 0.08, "wspace": 0.05, "hspace": 0.22})
    for axes in all_axes.flat[len(chosen):]:
        axes.axis("off")
    for axes, idx in zip(all_axes.flat, chosen):
        normal = most_telling_plane(shard, idx)
        draw_slice(axes, shard, idx, normal, options.px or 100, False)
        right, up = ("xyz"[axis] for axis in RIGHT_UP[normal])
        marks = " ".join(mark for bit, _, mark in FLAGS if shard.flags[idx] & bit)
        axes.set_xlabel(f"{idx} {right}{up} {marks}\n{shard.spacing_m[idx]:.2f} m, seen {shard.seen_share[idx]:.0%}", fontsize=8, color="#be1e14" if marks else "black")
    head(figure, shard.title, f"{len(chosen)} of {len(shard.phi)} weighting functions, seed {options.seed}; of each the plane through the probe in which it differs most from the "
         "bare tent", "index and plane (first axis right, second up; xz: z down), flags; spacing, share of points that the probe sees", is_missing=shard.geometry is None)
    slice_legend(figure, shard, 0.035, False)
    return figure


class Raster:
    """Heights of all faces above every pixel of a map, so that the level can be cut at any height."""

    def __init__(self, triangles, double_sided, low, px_per_m, width, height):
        self.shape, parts = (height, width), []
        normal = np.cross(triangles[:, 1] - triangles[:, 0], triangles[:, 2] - triangles[:, 0])
        corners = (triangles[:, :, [0, 2]] - low) * px_per_m
        for p, heights, n, is_double in zip(corners, triangles[:, :, 1], normal, double_sided):
            x0, y0 = np.clip(np.floor(p.min(0)), 0, (width, height)).astype(int)
            x1, y1 = np.clip(np.ceil(p.max(0)), 0, (width, height)).astype(int)
            area = np.cross(p[1] - p[0], p[2] - p[0])
            if area == 0 or x0 >= x1 or y0 >= y1:
                continue
            y, x = np.mgrid[y0:y1, x0:x1]
            to = np.stack([x + 0.5, y + 0.5], -1)
            share = np.stack([np.cross(p[(i + 2) % 3] - p[(i + 1) % 3], to - p[(i + 1) % 3]) / area for i in range(3)], -1)
            inside = (share >= 0).all(-1)
            count = inside.sum()
            parts.append((y[inside] * width + x[inside], share[inside] @ heights, np.full(count, np.abs(n[1]) / np.linalg.norm(n)), np.full(count, 0 if is_double else np.sign(n[1]))))
        self.pixel, self.height_m, self.upward, self.side = (np.concatenate(part) for part in zip(*parts))
        order = np.argsort(self.height_m, kind="stable")
        self.pixel, self.height_m, self.upward, self.side = (part[order] for part in (self.pixel, self.height_m, self.upward, self.side))

    def below(self, cut_m):
        """Of every pixel: the height of the highest face below the cut that looks up or has two sides, how level it is, and whether the cut is in solid.

        Solid: the first one-sided face below shows its back (rooms without outsides), or more backs than fronts lie below (closed solids).
        """
        end = np.searchsorted(self.height_m, cut_m, side="right")
        top, back, upward = np.full((3, self.shape[0] * self.shape[1]), -np.inf)
        front = self.side[:end] >= 0
        top[self.pixel[:end][front]] = self.height_m[:end][front]  # sorted: the last, highest one stays
        upward[self.pixel[:end][front]] = self.upward[:end][front]
        back[self.pixel[:end][~front]] = self.height_m[:end][~front]
        enclosing = np.bincount(self.pixel[:end], -self.side[:end], len(top))
        return top.reshape(self.shape), upward.reshape(self.shape), ((back > top) | (enclosing > 0)).reshape(self.shape)


def most_telling_height(triangles, raster, low_m, high_m):
    """The height in the middle half at which the cut is long and leaves much open: rooms are cut there, not the slabs between them or the ground."""
    heights = low_m + (high_m - low_m) * (0.25 + 0.5 * (np.arange(25) + 0.5) / 25)
    scores = []
    for height in heights:
        ends, _ = cut(triangles, 1, height)
        top, _, is_solid = raster.below(height)
        scores.append(np.linalg.norm(ends[:, 1] - ends[:, 0], axis=1).sum() * (np.isfinite(top) & ~is_solid).sum())
    good = np.flatnonzero(np.array(scores) >= 0.9 * max(scores))
    return heights[good[np.abs(heights[good] - (low_m + high_m) / 2).argmin()]]


def parsed_height(text, low_m, high_m):
    try:
        value = float(text.rstrip("%"))
        if np.isfinite(value) and (not text.endswith("%") or 0 <= value <= 100):
            return low_m + value / 100 * (high_m - low_m) if text.endswith("%") else value
    except ValueError:
        pass
    raise UsageError("--height", "metres (2.5) or a share of the level's height (40%)", f"'{text}'")


def top_picture(shard, options):
    has_scene = shard.geometry is not None and len(shard.triangles_m) > 0
    around = shard.triangles_m.reshape(-1, 3) if has_scene else np.concatenate([shard.position_m + sign * shard.spacing_m[:, None] for sign in (-1, 1)])
    low, high = around.min(0), around.max(0)
    margin = 0.03 * max(high[0] - low[0], high[2] - low[2], 1e-3)
    (x0, x1), (z0, z1) = ((low[axis] - margin, high[axis] + margin) for axis in (0, 2))
    scale = max(x1 - x0, z1 - z0)
    width_in, height_in = 14 * max((x1 - x0) / scale, 0.7), 14 * (z1 - z0) / scale
    figure = plt.figure(figsize=(width_in + 0.6, height_in + 2.8))
    axes = figure.add_axes((0.3 / (width_in + 0.6), 1.7 / (height_in + 2.8), width_in / (width_in + 0.6), height_in / (height_in + 2.8)), facecolor="#f4f4f7")
    cut_m, keys, lines = high[1], [], []
    if has_scene:
        double_sided, px_per_m = np.array(shard.geometry["double_sided"], bool), (options.px or 1000) / scale
        raster = Raster(shard.triangles_m, double_sided, (x0, z0), px_per_m, *(max(1, round(side * px_per_m)) for side in (x1 - x0, z1 - z0)))
        coarse = Raster(shard.triangles_m, double_sided, (x0, z0), 128 / scale, *(max(1, round(side * 128 / scale)) for side in (x1 - x0, z1 - z0)))
        cut_m = parsed_height(options.height, low[1], high[1]) if options.height else most_telling_height(shard.triangles_m, coarse, low[1], high[1])
        top, upward, is_solid = raster.below(cut_m)
        heights = matplotlib.colors.LinearSegmentedColormap.from_list("height", ["#707a92", "#f0e9dc"])
        colour = heights(plt.Normalize(low[1], cut_m)(np.where(np.isfinite(top), top, low[1])))
        colour[..., :3] *= np.where(np.isfinite(top), 0.55 + 0.45 * upward, 1)[..., None]
        colour[..., 3] = np.isfinite(top)
        extent = {"extent": (x0, x1, z0, z1), "origin": "lower"}
        axes.imshow(colour, **extent)
        axes.contourf(is_solid, [0.5, 1.5], colors=[(0.4, 0.4, 0.4, 0.5)], hatches=["////"], **extent)
        draw_cut(axes, shard.triangles_m, double_sided, 1, cut_m)
        for level in (3, 2, 1, 0):  # cells of the bricks, then nodes, coarse ones last
            boxes = np.array(shard.geometry["cells"] if level == 3 else [node[:4] for node in shard.geometry["nodes"] if node[4] == level]).reshape(-1, 4)
            boxes = boxes[(boxes[:, 1] <= cut_m) & (cut_m < boxes[:, 1] + boxes[:, 3])]
            squares = boxes[:, None, [0, 2]] + boxes[:, 3, None, None] * np.array([[0, 0], [1, 0], [1, 1], [0, 1], [0, 0]])
            colour, width = NODE_STYLE[level] if level < 3 else ("#3c3c5059", 0.8)
            axes.add_collection(LineCollection(np.unique(squares, axis=0), colors=colour, linewidths=width))
            keys.append(line_key(f"tree node, level {level}" if level < 3 else "cells of their bricks", colour))
        keys += [Patch(facecolor="#a0a0a0", hatch="////", label="solid at the cut's height"), line_key("cut of a one-sided face", ONE_SIDED), line_key("cut, double-sided", TWO_SIDED)]
        bar = figure.colorbar(matplotlib.cm.ScalarMappable(plt.Normalize(low[1], cut_m), heights), cax=figure.add_axes((0.3, 1.1 / (height_in + 2.8), 0.22, 0.012)), orientation="horizontal")
        bar.set_label("height of what is seen, m")
        lines.append(f"cut at y = {cut_m:.2f} m, {(cut_m - low[1]) / max(high[1] - low[1], 1e-9):.0%} of the height from {low[1]:.2f} to {high[1]:.2f} m; right: x, down: z, metres")
    colours = matplotlib.cm.ScalarMappable(plt.Normalize(0, 1), "viridis")
    x, z, shares, is_above = shard.position_m[:, 0], shard.position_m[:, 2], colours.to_rgba(shard.seen_share), shard.position_m[:, 1] > cut_m
    axes.scatter(x[~is_above], z[~is_above], c=shares[~is_above], s=34, edgecolors="black", linewidths=0.8, zorder=5)
    for width, rim in ((3.4, "black"), (2, shares[is_above])):
        axes.scatter(x[is_above], z[is_above], s=60, facecolors="none", edgecolors=rim, linewidths=width, zorder=6)
    bar = figure.colorbar(colours, cax=figure.add_axes((0.03, 1.1 / (height_in + 2.8), 0.22, 0.012)), orientation="horizontal")
    bar.set_label("probe: share of points it sees")
    dot = {"marker": "o", "ls": ""}
    keys += [line_key("probe below the cut", "#22a884", markeredgecolor="black", **dot), line_key("probe above the cut", "#22a884", markerfacecolor="none", markeredgewidth=2, **dot)]
    figure.legend(handles=keys, loc="lower left", bbox_to_anchor=(0.54, 0.01), ncol=3, fontsize=8, facecolor="#d8d8dc", edgecolor="none")
    axes.set(xlim=(x0, x1), ylim=(z1, z0))
    axes.set_aspect("equal", adjustable="datalim")
    c = shard.counts
    head(figure, f"{shard.title}: from above", *lines, f"{c['visited_probes']} of {c['grid_probes']} probes visited: {c['functions']} functions, {c['free_space']} in free space, "
         f"{c['in_solid']} in solid, {c['duplicates']} duplicates, {c['empty']} empty, {c.get('outside', 0)} outside", is_missing=not has_scene)
    return figure


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("shard", help="shard (.h5)")
    which = parser.add_mutually_exclusive_group(required=True)
    which.add_argument("--probe", type=int, help="index of the function that is drawn as three slices")
    which.add_argument("--atlas", action="store_true", help="draw 64 functions chosen at random")
    which.add_argument("--top", action="store_true", help="draw the level from above, cut open, with its probe tree")
    parser.add_argument("--out", required=True, help="picture to write (.png)")
    parser.add_argument("--scene", default="", help="file of the level. Procedural scenes need none")
    parser.add_argument("--seed", type=int, default=1, help="seed of the choice of functions, with --atlas")
    parser.add_argument("--height", default="", help="height of the cut, in metres (2.5) or as a share of the scene's height (40%%), with --top")
    parser.add_argument("--px", type=int, default=0, choices=range(64, 4097), metavar="64..4096", help="pixels that are sampled along a slice, or along the level's longer side")
    options = parser.parse_args()
    for name in (options.shard, options.scene):
        if os.path.exists(options.out) and os.path.exists(name) and os.path.samefile(options.out, name):
            raise UsageError("--out", "a file that is not an input", options.out)
    shard = Shard(options.shard, options.scene, options.top)
    figure = atlas_picture(shard, options) if options.atlas else top_picture(shard, options) if options.top else probe_picture(shard, options.probe, options)
    png = io.BytesIO()
    figure.savefig(png, format="png", dpi=110, metadata={"Software": None})
    write_atomically(options.out, png.getvalue())


if __name__ == "__main__":
    sys.exit(run("shard_pictures.py", main))

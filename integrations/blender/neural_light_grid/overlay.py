"""Probes in the 3D view: points in the colour of their light."""

import bpy
import gpu
import numpy as np
from gpu_extras.batch import batch_for_shader

from .errors import ToolError

POINT_PX = 6.0
MIDDLE_GREY = 0.18  # as which the geometric mean of light is shown
DARK = 1e-3  # of the brightest probe
# the colour of probes of grids without light, in sRGB
PLAIN = (0.9, 0.7, 0.2)

positions = np.empty((0, 3), np.float32)  # of the probes that have weight, in Blender's axes and units
colours = np.empty((0, 4), np.float32)    # sRGB
_handler, _batch, _shader = None, None, None


def show(table, metres_per_unit):
    """table   what nlg-bake probes prints"""
    global positions, colours, _batch, _handler
    header, *rows = (line.split(",") for line in table.splitlines())
    if header[:4] != ["x_m", "y_m", "z_m", "kind"]:
        raise ToolError(f"nlg-bake probes: expected a table of probes, got {','.join(header)}: the tool is of another version")
    numbers = np.array([row[:3] + row[4:] for row in rows if row[3] != "none"], np.float64).reshape(-1, len(header) - 1)
    at, light = numbers[:, :3], numbers[:, 3:]
    positions = (np.stack([at[:, 0], -at[:, 2], at[:, 1]], -1) / metres_per_unit).astype(np.float32)
    colours = np.ones((len(at), 4), np.float32)
    colours[:, :3] = srgb(light * exposure(light)) if light.shape[1] else PLAIN
    _batch = None
    if _handler is None:
        _handler = bpy.types.SpaceView3D.draw_handler_add(draw, (), "WINDOW", "POST_VIEW")
    redraw()


def exposure(light):
    """Of the probes that are lit at all; others may stand in a dark room, or hold what rounding left."""
    brightness = light.mean(-1)
    lit = brightness[brightness > DARK * brightness.max(initial=0.0)]
    return MIDDLE_GREY / np.exp(np.log(lit).mean()) if len(lit) else 1.0


def srgb(linear):
    linear = np.clip(linear, 0.0, 1.0)
    return np.where(linear <= 0.0031308, 12.92 * linear, 1.055 * np.maximum(linear, 1e-9) ** (1 / 2.4) - 0.055)


def hide():
    global positions, colours, _batch, _handler
    if _handler is not None:
        bpy.types.SpaceView3D.draw_handler_remove(_handler, "WINDOW")
    positions, colours, _batch, _handler = positions[:0], colours[:0], None, None
    redraw()


def redraw():
    for window in bpy.context.window_manager.windows:
        for area in window.screen.areas:
            if area.type in {"VIEW_3D", "PROPERTIES"}:
                area.tag_redraw()


def draw():
    global _batch, _shader
    if not bpy.context.window_manager.nlg_shows_probes or not len(positions):
        return
    if _batch is None:
        # Blender 4 dropped the 3D_
        _shader = gpu.shader.from_builtin("FLAT_COLOR" if bpy.app.version >= (4, 0, 0) else "3D_FLAT_COLOR")
        _batch = batch_for_shader(_shader, "POINTS", {"pos": positions, "color": colours})
    gpu.state.depth_test_set("LESS_EQUAL")
    gpu.state.point_size_set(POINT_PX)
    _batch.draw(_shader)
    gpu.state.point_size_set(1.0)
    gpu.state.depth_test_set("NONE")

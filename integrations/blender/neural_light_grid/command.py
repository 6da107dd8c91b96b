"""The command lines of the tools, all of them."""

import shlex
import shutil

import bpy

from . import settings
from .errors import ToolError

# While a level is worked on: a draft, 16 rays a sample point, a third of these points. docs/guide/blender.md says what that costs and saves.
PREVIEW = ["--draft", "--light-rays", "16", "--light-samples", "4"]
# The page is for walking through: no baselines, and no ground truth.
PAGE = ["--baselines", "none", "--truth-views", "0", "--truth-samples", "0"]


def tool(context, name):
    folder = bpy.path.abspath(context.preferences.addons[__package__].preferences.tools)
    found = shutil.which(name, path=folder or None)
    if found is None:
        place = folder or "the PATH"
        raise ToolError(f"{name} is not in {place}: choose the folder of the tools in Preferences > Add-ons > Neural Light Grid")
    return found


# A .blend may be anybody's: what it says in More must not say which files are written, or replaced.
OF_FILES = ["--out", "--json", "--inputs", "--relight", "--check", "--config"]

# option → where the panel sets it
OF_PANEL = {"--unit": "Unit Scale", "--light-unit": "the add-on", "--sky": "World as sky", "--spacing-m": "Spacing", "--light-direct": "Direct light", "--light-groups": "Lights apart"}


def of_bake(scene, exported):
    """What a grid depends on."""
    chosen = settings.of(scene)
    try:
        more = shlex.split(chosen.more)
    except ValueError as error:
        raise ToolError(f"More: {error}") from error
    if of_files := [word for word in more if word.partition("=")[0] in OF_FILES]:
        raise ToolError(f"More: {of_files[0]} names files, which the add-on chooses")
    if twice := [word for word in more if word.partition("=")[0] in OF_PANEL]:
        raise ToolError(f"More: {twice[0]} is set by {OF_PANEL[twice[0].partition('=')[0]]}")
    return [
        exported.level, "--unit", f"{settings.metres_per_unit(scene):.7g}", "--light-unit", "file", f"--sky={exported.sky}",
        "--spacing-m", f"{chosen.spacing_m:.7g}", "--light-direct", chosen.direct, "--light-groups", chosen.light_groups, *more,
    ]


def bake(context, exported, out):
    return [tool(context, "nlg-bake"), *of_bake(context.scene, exported), "--out", out]


def relight(context, exported, grid, out):
    return [*bake(context, exported, out), "--relight", grid]


def check(context, exported, grid):
    return [tool(context, "nlg-bake"), *of_bake(context.scene, exported), "--check", grid, "--json", "-"]


def probes(context, grid):
    return [tool(context, "nlg-bake"), "probes", grid]


def view(context, exported, grid, out):
    return [tool(context, "nlg-view"), *of_bake(context.scene, exported), "--grid", grid, *PAGE, "--out", out]

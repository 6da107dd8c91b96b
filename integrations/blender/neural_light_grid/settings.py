"""What a scene says of its light grid, and where the tools are."""

from pathlib import Path

import bpy
from bpy.props import BoolProperty, EnumProperty, FloatProperty, PointerProperty, StringProperty
from bpy.types import AddonPreferences, PropertyGroup

from . import overlay
from .errors import ToolError


class NLG_preferences(AddonPreferences):
    bl_idname = __package__

    tools: StringProperty(
        name="Folder of the tools",
        description="Where nlg-bake and nlg-view are. Empty: on the PATH",
        subtype="DIR_PATH",
    )

    def draw(self, context):
        self.layout.prop(self, "tools")


class NLG_settings(PropertyGroup):
    grid: StringProperty(
        name="Light grid",
        description="The file to write. Empty: beside the .blend, of its name",
        subtype="FILE_PATH",
    )
    spacing_m: FloatProperty(
        name="Spacing",
        description="Finest distance between probes, in metres. 0: half a metre in rooms, up to a metre in levels",
        default=0.0, min=0.0, soft_max=10.0, max=1000.0, precision=2, step=10,
    )
    has_world: BoolProperty(
        name="World as sky",
        description="Light comes from the scene's world. Otherwise the sky is black",
        default=True,
    )
    direct: EnumProperty(
        name="Direct light",
        description="Which direct light of lamps and suns the probes hold. What surfaces send back of it they always hold",
        items=(
            ("all", "All", "That of lamps and suns"),
            ("no_suns", "No suns", "That of lamps: the engine draws suns with shadow maps"),
            ("none", "None", "The engine draws lamps and suns itself"),
            ("reflected", "Reflected", "The engine draws lamps, suns and shining surfaces itself"),
        ),
    )
    light_groups: EnumProperty(
        name="Lights apart",
        description="What the game may dim, colour or switch by itself. A custom property light_group of an object or a material names its group",
        items=(
            ("one", "None", "All light is one"),
            ("kind", "By kind", "Sky, suns, lamps and emission"),
            ("name", "By name", "Each lamp and each shining material: Lamp and Lamp.001 are one"),
        ),
    )
    back_faces: EnumProperty(
        name="Back faces",
        description="What the backs of faces bound",
        items=(
            ("MATERIAL", "By material", "Where Backface Culling is ticked a back bounds solid; elsewhere that of closed parts alone does"),
            ("SOLID", "All solid", "As if Backface Culling were ticked in every opaque material: for rooms of single faces that look inward"),
        ),
    )
    more: StringProperty(
        name="More",
        description="Options of nlg-bake besides, as on a command line: nlg-bake --help-all lists them",
    )


def of(scene):
    return scene.neural_light_grid


def metres_per_unit(scene):
    units = scene.unit_settings
    return 1.0 if units.system == "NONE" else units.scale_length


def scene_name():
    return Path(bpy.data.filepath).stem or "untitled"


def grid_path(scene):
    """The path of the scene's light grid."""
    path = of(scene).grid or f"//{scene_name()}.safetensors"
    if path.startswith("//") and not bpy.data.filepath:
        raise ToolError("Light grid: save the .blend first, or choose a file")
    # a .blend may be anybody's, and nlg-bake replaces nothing but a light grid
    if not path.endswith(".safetensors"):
        raise ToolError(f"Light grid: expected a name that ends in .safetensors, got {path}")
    return bpy.path.abspath(path)


def register():
    for cls in (NLG_preferences, NLG_settings):
        bpy.utils.register_class(cls)
    bpy.types.Scene.neural_light_grid = PointerProperty(type=NLG_settings)
    # of the window: how far the tool is, and whether probes are drawn
    bpy.types.WindowManager.nlg_progress = FloatProperty(name="Progress", min=0.0, max=100.0, subtype="PERCENTAGE")
    bpy.types.WindowManager.nlg_shows_probes = BoolProperty(
        name="Show probes",
        description="Draw the probes of the last bake, in the colour of their light. Those that have no weight are left out",
        default=True,
        update=lambda self, context: overlay.redraw(),
    )


def unregister():
    del bpy.types.WindowManager.nlg_shows_probes, bpy.types.WindowManager.nlg_progress, bpy.types.Scene.neural_light_grid
    for cls in (NLG_settings, NLG_preferences):
        bpy.utils.unregister_class(cls)

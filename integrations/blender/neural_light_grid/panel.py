"""The panel, in the 3D view's sidebar and among the scene's properties."""

import textwrap

import bpy
from bpy.types import Panel

from . import overlay, settings
from .operators import state

CHARACTER_PX = 7.0  # of the interface's font, about


class NLG_panel:
    bl_label = "Neural Light Grid"

    def draw(self, context):
        layout = self.layout
        layout.use_property_split = True
        layout.use_property_decorate = False
        chosen = settings.of(context.scene)
        column = layout.column()
        for name in ("grid", "spacing_m", "has_world", "direct", "light_groups", "back_faces", "more"):
            column.prop(chosen, name)
        layout.use_property_split = False
        if state.job is None:
            self.draw_buttons(layout)
        else:
            self.draw_progress(context, layout)
        if len(overlay.positions):
            layout.prop(context.window_manager, "nlg_shows_probes", text=f"Show {len(overlay.positions):,} probes")
        self.draw_words(context, layout)

    def draw_buttons(self, layout):
        layout.operator("nlg.bake", icon="LIGHTPROBE_GRID" if bpy.app.version < (4, 1, 0) else "LIGHTPROBE_VOLUME")
        row = layout.row(align=True)
        for name in ("preview", "relight"):
            row.operator(f"nlg.{name}")
        row = layout.row(align=True)
        for name in ("check", "view"):
            row.operator(f"nlg.{name}")

    def draw_progress(self, context, layout):
        row = layout.row(align=True)
        bar = row.row(align=True)
        bar.enabled = False
        bar.prop(context.window_manager, "nlg_progress", text=state.job.stage or "starting", slider=True)
        row.operator("nlg.cancel", text="", icon="CANCEL")

    def draw_words(self, context, layout):
        said = [*state.said, *(state.job.notes if state.job else [])]
        if not said:
            return
        width = context.region.width / (CHARACTER_PX * context.preferences.system.ui_scale) - 4
        column = layout.box().column(align=True)
        column.scale_y = 0.75
        for words in said:
            column.separator()
            for line in textwrap.wrap(words, max(20, int(width))):
                column.label(text=line)


class NLG_PT_sidebar(NLG_panel, Panel):
    bl_space_type = "VIEW_3D"
    bl_region_type = "UI"
    bl_category = "Light Grid"


class NLG_PT_scene(NLG_panel, Panel):
    bl_space_type = "PROPERTIES"
    bl_region_type = "WINDOW"
    bl_context = "scene"


def register():
    for cls in (NLG_PT_sidebar, NLG_PT_scene):
        bpy.utils.register_class(cls)


def unregister():
    for cls in (NLG_PT_scene, NLG_PT_sidebar):
        bpy.utils.unregister_class(cls)

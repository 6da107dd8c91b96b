"""Neural Light Grid in Blender: bakes the scene into a light grid by nlg-bake, and shows its probes. docs/guide/blender.md"""

bl_info = {
    "name": "Neural Light Grid",
    "description": "Bakes the scene into a light grid that does not leak through walls",
    "version": (0, 1, 0),
    "blender": (3, 4, 0),
    "location": "3D View > Sidebar > Light Grid; Properties > Scene",
    "category": "Lighting",
}

from . import export, operators, overlay, panel, settings

MODULES = (settings, export, operators, panel)


def register():
    for module in MODULES:
        module.register()


def unregister():
    operators.stop()
    overlay.hide()
    for module in reversed(MODULES):
        module.unregister()

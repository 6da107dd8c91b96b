"""The scene as the tools read it: a .glb of all that is rendered, and the sky, which glTF does not hold."""

import contextlib
import json
import math
import os
import struct
from dataclasses import dataclass, field

import bpy
from bpy.app.handlers import persistent

from . import settings
from .errors import ToolError

SKY_FILE = "sky.exr"
SKY_WIDTH = 1024  # texels: what the tools keep of a sky's image
SKY_SAMPLES = 16
DISK_CORNERS = 24
# nodes whose light or colour glTF has words for
SURFACES = {"BSDF_PRINCIPLED", "EMISSION"}
COLOURS = {"TEX_IMAGE", "RGB", "MIX", "MIX_RGB", "VERTEX_COLOR", "ATTRIBUTE", "REROUTE", "SEPRGB", "SEPARATE_COLOR"}
SURFACE_TYPES = {"MESH", "CURVE", "SURFACE", "FONT"}
# objects that no glTF holds
LEFT_OUT = {"META": "metaballs", "VOLUME": "volumes", "POINTCLOUD": "point clouds", "CURVES": "hair", "GPENCIL": "grease pencil"}


drawn = None  # the world that SKY_FILE shows, which takes seconds to draw, and its images


@persistent
def notice(scene, depsgraph):
    """A world that changes is drawn anew. It changes with its groups of nodes and its drivers."""
    global drawn
    if any(isinstance(update.id, bpy.types.World) for update in depsgraph.updates):
        drawn = None


@persistent
def forget(_):
    global drawn
    drawn = None


@dataclass
class Exported:
    folder: str
    level: str  # the .glb, in the folder
    sky: str    # as --sky takes it
    notes: list = field(default_factory=list)


def export_scene(context, folder):
    """Without absolute paths: what a grid says that it was baked of is the same in the next session."""
    os.makedirs(folder, exist_ok=True)
    level = f"{settings.scene_name()}.glb"
    path = os.path.join(folder, level)
    things = rendered(context.view_layer.layer_collection)
    shown = [thing for instance in things if instance.instance_type == "COLLECTION" and instance.instance_collection for thing in instance.instance_collection.all_objects]
    unseen = {thing.name for thing in context.scene.objects} - {thing.name for thing in things}
    with object_mode(context), modifiers_as_rendered([*things, *shown]), area_lamps_as_planes(context, things):
        write_glb(path)
        notes = left_out(context, things, shown) + otherwise([*things, *shown])
    mend(path, context.scene, unseen)
    sky = sky_of(context.scene, folder) if settings.of(context.scene).has_world else "0"
    return Exported(folder, f"./{level}", sky, notes)


def left_out(context, things, shown):
    """What of them the exporter does not write, a line each kind.
    shown   objects of collections whose instances stand among things
    """
    kinds = [LEFT_OUT[thing.type] for thing in [*things, *shown] if thing.type in LEFT_OUT]
    kinds += ["area lamps of collection instances" for thing in shown if is_area_lamp(thing)]
    kinds += ["shape keys" for thing in things if thing.type == "MESH" and thing.data.shape_keys and not thing.modifiers]
    kinds += ["hair" for thing in [*things, *shown] for system in thing.particle_systems if system.settings.type == "HAIR" and system.settings.render_type == "PATH"]
    # instances of particles, vertices and faces are written
    kinds += ["instances of geometry nodes" for copy in context.evaluated_depsgraph_get().object_instances
              if copy.is_instance and copy.parent.original in things and not copy.parent.original.is_instancer and not is_itself(copy)]
    return [f"the exporter leaves out: {kinds.count(kind)} {kind}" for kind in sorted(set(kinds))]


def is_itself(copy):
    """Curves and texts are instances of their own mesh, where they are."""
    return copy.object.original == copy.parent.original and copy.parent.type != "MESH" and copy.matrix_world == copy.parent.matrix_world


def otherwise(things):
    """What the exporter writes otherwise than Cycles shows it, a line each kind: an artist's glass of Glass BSDF is a white wall in the bake."""
    lamps = {thing.data.name for thing in things if thing.type == "LIGHT" and thing.data.use_nodes}
    used = {slot.material for thing in things for slot in thing.material_slots if slot.material and slot.material.use_nodes}
    surfaces, colours, missing = set(), set(), set()
    for material in used:
        output = material.node_tree.get_output_node("CYCLES")
        surface = output.inputs["Surface"].links[0].from_node if output and output.inputs["Surface"].links else None
        if surface is None or surface.type not in SURFACES:
            surfaces.add(material.name)
        elif any(link.from_node.type not in COLOURS for name in ("Base Color", "Color", "Emission", "Emission Color") if name in surface.inputs for link in surface.inputs[name].links):
            colours.add(material.name)
        missing.update(image.name for image in images_of(material.node_tree) if image.source == "FILE" and not image.packed_file and not os.path.exists(path_of(image)))
    unseen = {thing.name for thing in things if thing.type in SURFACE_TYPES and not (thing.visible_diffuse and thing.visible_shadow)}
    said = {"materials whose surface is neither Principled BSDF nor Emission, which are mostly white and opaque in the bake": surfaces,
            "materials whose colour nodes compute, which are mostly white in the bake": colours,
            "images whose file is not there": missing,
            "lamps with Use Nodes, whose light is another in the bake": lamps,
            "objects whose Ray Visibility lacks Diffuse or Shadow, which are as solid as others in the bake": unseen}
    return [f"{what}: {', '.join(sorted(names))}" for what, names in said.items() if names]


def is_area_lamp(thing):
    return thing.type == "LIGHT" and thing.data.type == "AREA"


def rendered(layer):
    """What of the scene a render shows."""
    if layer.collection.hide_render:
        return set()
    things = set() if layer.exclude else {thing for thing in layer.collection.objects if not thing.hide_render}
    return things.union(*map(rendered, layer.children))


@contextlib.contextmanager
def object_mode(context):
    """What is edited is written into the mesh when editing ends."""
    active = context.view_layer.objects.active
    mode = active.mode if active else "OBJECT"
    if mode != "OBJECT":
        bpy.ops.object.mode_set(mode="OBJECT")
    try:
        yield
    finally:
        if mode != "OBJECT":
            bpy.ops.object.mode_set(mode=mode)


@contextlib.contextmanager
def modifiers_as_rendered(things):
    """The exporter applies modifiers as the viewport shows them."""
    changed = []
    for modifier in (modifier for thing in things for modifier in thing.modifiers):
        for seen, drawn_by in (("show_viewport", "show_render"), ("levels", "render_levels")):
            if getattr(modifier, seen, None) != getattr(modifier, drawn_by, None):
                changed.append((modifier, seen, getattr(modifier, seen)))
                setattr(modifier, seen, getattr(modifier, drawn_by))
    try:
        yield
    finally:
        for modifier, seen, value in changed:
            setattr(modifier, seen, value)


def write_glb(path):
    """Lamps and suns go out in W/4 pi and W/m², emission in W/m²/sr: one unit for all, which the tools take as it is (docs/theory/light.md, units)."""
    # Blender 3.6 renamed it
    names = bpy.ops.export_scene.gltf.get_rna_type().properties.keys()
    lighting = next((name for name in ("export_import_convert_lighting_mode", "convert_lighting_mode") if name in names), None)
    if lighting is None:
        raise ToolError("the glTF exporter has no Lighting Mode")
    try:
        bpy.ops.export_scene.gltf(
            filepath=path, check_existing=False, export_format="GLB", export_yup=True, export_apply=True,
            export_lights=True, export_cameras=True, export_extras=True, use_renderable=True, use_active_scene=True,
            export_animations=False, export_skins=False, export_morph=False, **{lighting: "COMPAT"},
        )
    except RuntimeError as error:
        raise ToolError(f"glTF exporter: {error}") from error


@contextlib.contextmanager
def area_lamps_as_planes(context, things):
    """glTF has no area lamps. A plane of the same radiance stands in for each while the file is written."""
    context.view_layer.update()
    lamps = sorted(filter(is_area_lamp, things), key=lambda lamp: lamp.name)
    planes = [plane_of(lamp) for lamp in lamps]
    try:
        for plane in planes:
            context.scene.collection.objects.link(plane)
        context.view_layer.update()
        yield
    finally:
        for plane in planes:
            mesh, material = plane.data, plane.data.materials[0]
            bpy.data.objects.remove(plane)
            bpy.data.meshes.remove(mesh)
            bpy.data.materials.remove(material)


def plane_of(lamp):
    light = lamp.data
    width, height = light.size, light.size_y if light.shape in {"RECTANGLE", "ELLIPSE"} else light.size
    turns = [2 * math.pi * (i + 0.5) / DISK_CORNERS for i in range(DISK_CORNERS)]
    corners = [(0.5 * math.cos(turn), 0.5 * math.sin(turn)) for turn in turns]
    if light.shape in {"SQUARE", "RECTANGLE"}:
        corners = [(-0.5, -0.5), (0.5, -0.5), (0.5, 0.5), (-0.5, 0.5)]
    mesh = bpy.data.meshes.new(lamp.name)
    # clockwise: an area lamp shines down
    mesh.from_pydata([(x * width, y * height, 0.0) for x, y in corners], [], [list(reversed(range(len(corners))))])
    plane = bpy.data.objects.new(lamp.name, mesh)
    plane.matrix_world = lamp.matrix_world.copy()
    for name, value in lamp.items():
        # the group is the material's, below
        if name != "light_group" and isinstance(value, (bool, int, float, str)):
            plane[name] = value
    mesh.update()
    scale = lamp.matrix_world.to_3x3()
    area = mesh.polygons[0].area * (scale.col[0].cross(scale.col[1])).length
    material = bpy.data.materials.new(lamp.name)
    material.use_backface_culling = True
    material.use_nodes = True
    nodes = material.node_tree.nodes
    nodes.clear()
    emission = nodes.new("ShaderNodeEmission")
    emission.inputs["Color"].default_value = (*light.color, 1.0)
    # as Cycles has it: pi / 4 of what a lamp of this power would send
    emission.inputs["Strength"].default_value = light.energy / (4.0 * area) if area > 0.0 else 0.0
    output = nodes.new("ShaderNodeOutputMaterial")
    material.node_tree.links.new(emission.outputs[0], output.inputs["Surface"])
    # what shines belongs to the group of its material
    group = lamp.get("light_group", light.get("light_group"))
    if isinstance(group, str):
        material["light_group"] = group
    mesh.materials.append(material)
    return plane


def mend(path, scene, unseen):
    """What the exporter cannot be asked for.
    unseen   names of the scene's objects that it takes for rendered, and that are not
    """
    with open(path, "rb") as file:
        header, (size, kind) = file.read(12), struct.unpack("<I4s", file.read(8))
        gltf, rest = json.loads(file.read(size)), file.read()
    for root in gltf["scenes"][gltf.get("scene", 0)].get("nodes", []):
        empty_nodes(gltf["nodes"], root, unseen)
    for primitive in (primitive for mesh in gltf.get("meshes", []) for primitive in mesh["primitives"]):
        if not shows_vertex_colours(gltf["materials"][primitive["material"]]["name"] if "material" in primitive else None):
            primitive["attributes"].pop("COLOR_0", None)
    # Blender's lamps know no metres: what is a unit away is as bright whatever a unit is
    unit = settings.metres_per_unit(scene)
    for light in gltf.get("extensions", {}).get("KHR_lights_punctual", {}).get("lights", []):
        if light["type"] != "directional":
            light["intensity"] = light.get("intensity", 1.0) * unit**2
    if settings.of(scene).back_faces == "SOLID":
        for material in gltf.get("materials", []):
            if material.get("alphaMode", "OPAQUE") == "OPAQUE" and "KHR_materials_transmission" not in material.get("extensions", {}):
                material["doubleSided"] = False
    text = json.dumps(gltf, separators=(",", ":")).encode()
    text += b" " * (-len(text) % 4)
    with open(path, "wb") as file:
        file.write(header[:8] + struct.pack("<I", 20 + len(text) + len(rest)) + struct.pack("<I4s", len(text), kind) + text + rest)


def shows_vertex_colours(name):
    """Blender shows those that a material asks for, glTF all: many are masks."""
    material = bpy.data.materials.get(name or "")
    return bool(material and material.use_nodes and any(node.type in {"VERTEX_COLOR", "ATTRIBUTE"} for node in material.node_tree.nodes))


def empty_nodes(nodes, index, names):
    """Nodes of these names hold nothing then, but for those that collections which stand elsewhere show, too."""
    node = nodes[index]
    if node.get("name") in names:
        for content in ("mesh", "camera", "extensions"):
            node.pop(content, None)
    thing = bpy.data.objects.get(node.get("name", ""))
    if thing is None or thing.instance_type != "COLLECTION":
        for child in node.get("children", []):
            empty_nodes(nodes, child, names)


def sky_of(scene, folder):
    """The world as --sky takes it: its colour, or an image of what it shows."""
    global drawn
    world = scene.world
    if world is None:
        return "0"
    colour = plain_colour(world)
    if colour is None:
        path = os.path.join(folder, SKY_FILE)
        look = [world.name_full, *map(as_of_now, images_of(world.node_tree))]
        if drawn != look or not os.path.exists(path):
            draw_sky(world, path)
            drawn = look
        return SKY_FILE
    return ",".join(f"{channel:.6g}" for channel in colour)


def images_of(tree):
    for node in tree.nodes:
        if node.type == "GROUP" and node.node_tree:
            yield from images_of(node.node_tree)
        image = getattr(node, "image", None)
        if image is not None:
            yield image


def path_of(image):
    return bpy.path.abspath(image.filepath, library=image.library)


def as_of_now(image):
    """Which one, and as of when: Blender says nothing of images that are read or painted anew."""
    path = path_of(image)
    # painted and not saved: equal to nothing
    return image.name_full, path, os.stat(path).st_mtime_ns if os.path.exists(path) else 0, object() if image.is_dirty else None


def plain_colour(world):
    """Of a world that is the same all around; None: it is not, or nobody knows."""
    if not world.use_nodes:
        return tuple(world.color)
    output = world.node_tree.get_output_node("CYCLES")
    if output is None or not output.inputs["Surface"].links:
        return (0.0, 0.0, 0.0)
    node = output.inputs["Surface"].links[0].from_node
    if node.type != "BACKGROUND" or any(node.inputs[name].is_linked for name in ("Color", "Strength")):
        return None
    return tuple(max(0.0, channel * node.inputs["Strength"].default_value) for channel in node.inputs["Color"].default_value[:3])


def draw_sky(world, path):
    """Cycles draws all around from a scene of its own. The middle looks along +x, as --sky has it."""
    if not hasattr(bpy.types.Scene, "cycles"):
        raise ToolError(f"World {world.name}: enable the add-on Cycles, which draws worlds of several nodes")
    scene = bpy.data.scenes.new("nlg sky")
    data = bpy.data.cameras.new("nlg sky")
    camera = bpy.data.objects.new("nlg sky", data)
    try:
        scene.collection.objects.link(camera)
        scene.camera, scene.world = camera, world
        camera.rotation_euler = (math.pi / 2, 0.0, -math.pi / 2)
        data.type = "PANO"
        # Blender 4 moved it from Cycles to the camera
        (data if hasattr(data, "panorama_type") else data.cycles).panorama_type = "EQUIRECTANGULAR"
        render, cycles = scene.render, scene.cycles
        render.engine, render.filepath = "CYCLES", path
        render.resolution_x, render.resolution_y, render.resolution_percentage = SKY_WIDTH, SKY_WIDTH // 2, 100
        render.image_settings.file_format, render.image_settings.color_depth = "OPEN_EXR", "32"
        render.image_settings.color_mode, render.use_compositing, render.use_sequencer = "RGB", False, False
        cycles.samples, cycles.use_adaptive_sampling, cycles.use_denoising = SKY_SAMPLES, False, False
        cycles.sample_clamp_direct = 0.0
        bpy.ops.render.render(write_still=True, scene=scene.name)
    except RuntimeError as error:
        raise ToolError(f"World {world.name}: {error}") from error
    finally:
        bpy.data.scenes.remove(scene)
        bpy.data.objects.remove(camera)
        bpy.data.cameras.remove(data)


def register():
    bpy.app.handlers.depsgraph_update_post.append(notice)
    bpy.app.handlers.load_post.append(forget)


def unregister():
    bpy.app.handlers.load_post.remove(forget)
    bpy.app.handlers.depsgraph_update_post.remove(notice)

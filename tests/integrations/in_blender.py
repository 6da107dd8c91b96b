"""Inside Blender: installs the add-on, bakes two rooms and a lamp with it, and holds what comes of it against what was modelled.

    blender [-b] --factory-startup --python tests/integrations/in_blender.py -- nlg_blender.zip TOOLS FOLDER

In a window, without -b, operators run as their buttons start them. Claims that do not hold are lines that begin with FAILED; the last line is "end".
"""
import json
import math
import os
import struct
import subprocess
import sys
import time
import traceback
from pathlib import Path

import bpy
import numpy as np

ADDON = "neural_light_grid"
ZIP, TOOLS, FOLDER = (Path(path) for path in sys.argv[sys.argv.index("--") + 1:])
WALL, HEIGHT = 0.2, 2.6


def check(holds, claim):
    print("holds: " if holds else "FAILED:", claim)


def box(name, low, high):
    """A closed box whose faces look outward."""
    bpy.ops.mesh.primitive_cube_add(size=1.0, location=[(a + b) / 2 for a, b in zip(low, high)])
    thing = bpy.context.object
    thing.name, thing.scale = name, [b - a for a, b in zip(low, high)]
    return thing


def lamp(name, kind, place, energy):
    data = bpy.data.lights.new(name, kind)
    data.energy = energy
    thing = bpy.data.objects.new(name, data)
    thing.location = place
    bpy.context.collection.objects.link(thing)
    return thing


def two_rooms():
    """Rooms of 3 x 3 m beside each other along x, closed; the lamp is in the first."""
    for thing in list(bpy.data.objects):
        bpy.data.objects.remove(thing)
    x, y, z, t = 6 + WALL, 3, HEIGHT, WALL
    box("floor", (-t, -t, -t), (x + t, y + t, 0))
    box("ceiling", (-t, -t, z), (x + t, y + t, z + t))
    box("front", (-t, -t, 0), (x + t, 0, z))
    box("back", (-t, y, 0), (x + t, y + t, z))
    box("left", (-t, 0, 0), (0, y, z))
    box("right", (x, 0, 0), (x + t, y, z))
    box("between", (3, 0, 0), (3 + t, y, z))
    material = bpy.data.materials.new("paint")
    material.use_nodes = True
    material.node_tree.nodes["Principled BSDF"].inputs["Base Color"].default_value = (0.7, 0.7, 0.7, 1)
    for thing in bpy.data.objects:
        thing.data.materials.append(material)
    lamp("bulb", "POINT", (1.5, 1.5, 2.0), 60.0)


def settings():
    return bpy.context.scene.neural_light_grid


def refusal(operator, **more):
    """What an operator that must fail says."""
    try:
        operator(**more)
    except RuntimeError as error:
        return str(error)
    return ""


def overlay():
    return sys.modules[f"{ADDON}.overlay"]


def operators():
    return sys.modules[f"{ADDON}.operators"]


def info(grid):
    return subprocess.run([TOOLS / "nlg-bake", "info", grid], capture_output=True, text=True)


def exported():
    """What the tools are given, and the JSON of its .glb."""
    made = operators().export_scene(bpy.context, operators().folder())
    with open(os.path.join(made.folder, made.level), "rb") as file:
        file.read(12)
        return made, json.loads(file.read(struct.unpack("<I4s", file.read(8))[0]))


def light_of_rooms():
    """Mean of what is shown of the probes in each room, and how many they are."""
    at, colours = overlay().positions, overlay().colours[:, :3]
    inside = (at[:, 1] > 0) & (at[:, 1] < 3) & (at[:, 2] > 0) & (at[:, 2] < HEIGHT)
    return [(colours[inside & (at[:, 0] > a) & (at[:, 0] < a + 3)].mean(), (inside & (at[:, 0] > a) & (at[:, 0] < a + 3)).sum()) for a in (0, 3 + WALL)]


def installs():
    bpy.ops.preferences.addon_install(filepath=str(ZIP))
    bpy.ops.preferences.addon_enable(module=ADDON)
    check(ADDON in bpy.context.preferences.addons, "the zip installs and the add-on is enabled")


def saves():
    bpy.ops.wm.save_as_mainfile(filepath=str(FOLDER / "rooms.blend"))
    bpy.context.preferences.addons[ADDON].preferences.tools = str(TOOLS)


def bakes():
    grid = FOLDER / "rooms.safetensors"
    check(bpy.ops.nlg.bake() == {"FINISHED"} and grid.exists(), "the grid lies beside the .blend")
    check(info(grid).returncode == 0, "nlg-bake info verifies the grid")
    at = overlay().positions
    # probes stand on corners of cells, which reach up to a cell beyond the walls
    low, high = np.array((-WALL, -WALL, -WALL)) - 1, np.array((6 + 2 * WALL, 3 + WALL, HEIGHT + WALL)) + 1
    check(len(at) > 20 and np.all(at >= low) and np.all(at <= high), f"all of {len(at)} probes stand around the rooms, in Blender's axes: {at.min(0)} to {at.max(0)}")
    (first, first_count), (second, second_count) = light_of_rooms()
    check(first_count and second_count and first > 0.2 and second < 0.02, f"the lamp's room is lit and the other dark: {first:.3f} {second:.3f}")


def checks_and_relights():
    grid = FOLDER / "rooms.safetensors"
    bpy.ops.nlg.check()
    check(operators().state.said[-1] == "fresh", f"a grid is fresh that was baked just now: {operators().state.said[-1]}")
    before = grid.read_bytes()
    bpy.data.objects["bulb"].data.energy = 120.0
    bpy.ops.nlg.check()
    check(operators().state.said[-1] == "light changed", f"another lamp is light that changed: {operators().state.said[-1]}")
    bpy.ops.nlg.relight()
    check(grid.read_bytes() != before, "a relight writes the grid")
    relit = grid.read_bytes()
    bpy.ops.nlg.bake()
    check(grid.read_bytes() == relit, "a relight is what a bake makes")
    bpy.data.objects["between"].location.x += 0.5
    said = refusal(bpy.ops.nlg.relight)
    check("is not that of the grid; bake the grid again" in said, f"a relight of other geometry is refused by the tool's sentence: {said}")
    bpy.ops.nlg.check()
    check(operators().state.said[-1] == "geometry changed", f"a wall that moved is geometry that changed: {operators().state.said[-1]}")
    check(grid.read_bytes() == relit and sorted(os.listdir(FOLDER)) == ["rooms.blend", "rooms.safetensors"], f"nothing else was written: {sorted(os.listdir(FOLDER))}")
    bpy.ops.nlg.bake()
    bpy.data.objects["between"].location.x -= 0.5
    bpy.ops.nlg.bake()
    check(grid.read_bytes() == relit, "moved back, it is the grid that it was")


def previews():
    grid = FOLDER / "rooms.safetensors"
    before = grid.read_bytes()
    check(bpy.ops.nlg.preview() == {"FINISHED"} and len(overlay().positions) > 20, "a preview shows probes")
    check(grid.read_bytes() == before, "a preview leaves the grid as it is")


def says_what_the_exporter_changes():
    """Glass that turns into a wall, colours that nodes compute, images that are gone, lamps with nodes."""
    floor, plain = bpy.data.objects["floor"], bpy.data.objects["floor"].material_slots[0].material
    material = bpy.data.materials.new("window")
    material.use_nodes = True
    nodes, links = material.node_tree.nodes, material.node_tree.links
    output, principled = material.node_tree.get_output_node("CYCLES"), nodes["Principled BSDF"]
    floor.material_slots[0].material = material
    check(exported()[0].notes == [], "of Principled BSDF there is nothing to say")
    image = nodes.new("ShaderNodeTexImage")
    image.image = bpy.data.images.new("poster", 4, 4)
    links.new(image.outputs["Color"], principled.inputs["Base Color"])
    check(exported()[0].notes == [], "nor of an image that is there")
    image.image.source, image.image.filepath = "FILE", "//gone.png"
    notes = exported()[0].notes
    check(notes == ["images whose file is not there: poster"], f"an image that is gone is said: {notes}")
    links.new(nodes.new("ShaderNodeTexNoise").outputs["Color"], principled.inputs["Base Color"])
    nodes.remove(image)
    notes = exported()[0].notes
    check(len(notes) == 1 and notes[0].startswith("materials whose colour nodes compute") and notes[0].endswith(": window"), f"a colour of noise is said: {notes}")
    links.new(nodes.new("ShaderNodeBsdfGlass").outputs["BSDF"], output.inputs["Surface"])
    bulb = lamp("noded", "POINT", (1, 1, 2), 10.0)
    bulb.data.use_nodes = True
    notes = exported()[0].notes
    check(len(notes) == 2 and notes[0].endswith("in the bake: window") and "neither Principled BSDF" in notes[0] and notes[1].endswith(": noded"), f"glass and a lamp's nodes are said: {notes}")
    floor.material_slots[0].material = plain
    bpy.data.objects.remove(bulb)
    bpy.data.materials.remove(material)
    check(exported()[0].notes == [], "all of it gone, nothing is said")


def takes_modifiers_and_instances_as_rendered():
    """Modifiers that a render alone shows, particles, instances and hair; what stands in for them is gone afterwards."""
    def triangles():
        made, gltf = exported()
        meshes = [sum(gltf["accessors"][primitive["indices"]]["count"] // 3 for primitive in mesh["primitives"]) for mesh in gltf["meshes"]]
        return made.notes, sum(meshes[node["mesh"]] for node in gltf["nodes"] if "mesh" in node)

    def carrier(mesh=None):
        thing = bpy.data.objects.new("carrier", mesh or bpy.data.meshes.new_from_object(bpy.data.objects["floor"]))
        bpy.context.collection.objects.link(thing)
        return thing

    def particles(thing, kind, drawn):
        system = thing.modifiers.new("particles", "PARTICLE_SYSTEM").particle_system.settings
        system.type, system.count, system.render_type = kind, 5, drawn
        return system

    without = triangles()[1]
    thing = carrier()
    array, other, subdivision = (thing.modifiers.new(kind, kind) for kind in ("ARRAY", "ARRAY", "SUBSURF"))
    array.count = other.count = 3
    array.show_viewport, other.show_render = False, False
    subdivision.levels, subdivision.render_levels = 0, 1
    notes, count = triangles()
    check((notes, count) == ([], without + 3 * 6 * 4 * 2), f"modifiers are applied as rendered: {notes} {count - without}")
    check((array.show_viewport, other.show_viewport, subdivision.levels) == (False, True, 0), "and look afterwards as before")
    bpy.data.objects.remove(thing)

    thing = carrier()
    particles(thing, "HAIR", "OBJECT").instance_object = bpy.data.objects["floor"]
    notes, count = triangles()
    check((notes, count) == ([], without + 6 * 12), f"instances of particles are baked, and nothing is said: {notes} {count - without}")
    bpy.data.objects.remove(thing)

    thing = carrier()
    particles(thing, "HAIR", "PATH")
    tree = bpy.data.node_groups.new("cubes", "GeometryNodeTree")
    tree.inputs.new("NodeSocketGeometry", "Geometry")
    tree.outputs.new("NodeSocketGeometry", "Geometry")
    start, cube, copies, end = (tree.nodes.new(kind) for kind in ("NodeGroupInput", "GeometryNodeMeshCube", "GeometryNodeInstanceOnPoints", "NodeGroupOutput"))
    for out, into in ((start.outputs[0], copies.inputs["Points"]), (cube.outputs[0], copies.inputs["Instance"]), (copies.outputs[0], end.inputs[0])):
        tree.links.new(out, into)
    bare = carrier(bpy.data.objects["floor"].data)
    bare.modifiers.new("cubes", "NODES").node_group = tree
    bare.visible_shadow = False
    notes = triangles()[0]
    check(notes == ["the exporter leaves out: 1 hair", "the exporter leaves out: 8 instances of geometry nodes",
                    f"objects whose Ray Visibility lacks Diffuse or Shadow, which are as solid as others in the bake: {bare.name}"], f"hair, instances of nodes and ray visibility are said: {notes}")
    bpy.data.objects.remove(thing)
    bpy.data.objects.remove(bare)
    text = carrier(bpy.data.curves.new("words", "FONT"))
    text.data.body = "out"
    check(triangles()[0] == [], "a text is no instance")
    bpy.data.objects.remove(text)

    settings().more = "--sky=1"
    said = refusal(bpy.ops.nlg.preview)
    check("More: --sky=1 is set by World as sky" in said, f"an option of the panel is refused by its name: {said}")
    settings().more = ""


def takes_what_is_rendered():
    """Collections that a render leaves out, area lamps, back faces; metres and lamps where a unit is a centimetre."""
    scene = bpy.context.scene
    hidden, excluded = bpy.data.collections.new("hidden"), bpy.data.collections.new("excluded")
    for collection in (hidden, excluded):
        scene.collection.children.link(collection)
        inner = bpy.data.collections.new(f"in {collection.name}")
        collection.children.link(inner)
        inner.objects.link(bpy.data.objects.new(f"box {collection.name}", bpy.data.objects["floor"].data))
    hidden.hide_render = True
    bpy.context.view_layer.layer_collection.children["excluded"].exclude = True
    tube = lamp("tube", "AREA", (1.5, 1.5, 2.5), 40.0)
    tube.data.shape, tube.data.size, tube.data.size_y = "RECTANGLE", 0.5, 0.2
    tube.scale = (2, 1, 1)
    tube["light_group"] = bpy.data.objects["bulb"]["light_group"] = "evening"
    bpy.data.objects["floor"].data.color_attributes.new("mask", "FLOAT_COLOR", "POINT")
    bpy.context.scene.collection.objects.link(bpy.data.objects.new("ball", bpy.data.metaballs.new("ball")))
    things = len(bpy.data.objects), len(bpy.data.meshes), len(bpy.data.materials)
    made, gltf = exported()
    check(made.notes == ["the exporter leaves out: 1 metaballs"], f"what is left out is said: {made.notes}")
    check(things == (len(bpy.data.objects), len(bpy.data.meshes), len(bpy.data.materials)), "the export leaves nothing in the scene")
    check(not [node for node in gltf["nodes"] if node["name"].startswith("box ") and "mesh" in node], "what no render shows is not baked")
    check(not [primitive for mesh in gltf["meshes"] for primitive in mesh["primitives"] if "COLOR_0" in primitive["attributes"]], "colours that no material shows are none")
    groups = [node["name"] for node in gltf["nodes"] if node.get("extras", {}).get("light_group") == "evening" and ("mesh" in node or "extensions" in node)]
    glow = next(material for material in gltf["materials"] if material["name"] == "tube")
    check(groups == ["bulb"] and glow["extras"]["light_group"] == "evening", f"properties of lamps lie where their light is: {groups}")
    strength = glow["extensions"]["KHR_materials_emissive_strength"]["emissiveStrength"]
    check(abs(strength * 4 * 0.2 - 40.0) < 0.01, f"an area lamp's plane shines as Cycles has the lamp: {strength}")
    check([material["name"] for material in gltf["materials"] if material.get("doubleSided")] == ["paint"], "materials have two sides where Blender says so")
    settings().back_faces = "SOLID"
    check(not any(material.get("doubleSided") for material in exported()[1]["materials"]), "and none where all faces are to bound solid")
    settings().back_faces = "MATERIAL"
    bulb = gltf["extensions"]["KHR_lights_punctual"]["lights"][0]["intensity"]
    scene.unit_settings.scale_length = 0.01
    made, gltf = exported()
    small = gltf["extensions"]["KHR_lights_punctual"]["lights"][0]["intensity"]
    check(abs(bulb - 120 / (4 * math.pi)) < 1e-4 * bulb and abs(small / bulb - 1e-4) < 1e-8, f"a lamp is as bright a unit away, whatever a unit is: {bulb} {small}")
    words = operators().command.of_bake(scene, made)
    check(words[words.index("--unit") + 1] == "0.01", f"the tool is told the unit: {words}")
    scene.unit_settings.scale_length = 1.0
    bpy.data.objects.remove(bpy.data.objects["bulb"])
    bpy.ops.nlg.preview()
    check(light_of_rooms()[0][0] > 0.2, f"an area lamp lights its room: {light_of_rooms()}")
    plane = sys.modules[f"{ADDON}.export"].plane_of(tube)
    check(plane.data.polygons[0].normal.z < -0.99, "and shines down")
    bpy.data.objects.remove(plane)
    bpy.data.objects.remove(tube)


def takes_the_world_as_sky():
    world = bpy.context.scene.world
    world.use_nodes = True
    background = world.node_tree.nodes["Background"]
    background.inputs["Color"].default_value, background.inputs["Strength"].default_value = (0.1, 0.2, 0.4, 1), 2.0
    check(exported()[0].sky == "0.2,0.4,0.8", f"a plain world is its colour: {exported()[0].sky}")
    place = world.node_tree.nodes.new("ShaderNodeTexCoord")
    world.node_tree.links.new(place.outputs["Generated"], background.inputs["Color"])
    made = exported()[0]
    image = bpy.data.images.load(os.path.join(made.folder, made.sky))
    image.colorspace_settings.name = "Non-Color"
    width, height = image.size
    pixels = np.empty(width * height * 4, np.float32)
    image.pixels.foreach_get(pixels)
    pixels = pixels.reshape(height, width, 4)[..., :3]
    # red, green and blue are twice what x, y and z of the direction have above 0
    for what, column, row, expected in (("the middle looks along x", width // 2, height // 2, (2, 0, 0)), ("left of it lies y", width // 4, height // 2, (0, 2, 0)), ("the zenith is above", width // 2, height - 1, (0, 0, 2))):
        found = np.maximum(pixels[row, column], 0)
        check(np.allclose(found, expected, atol=0.05), f"{what}: {found}")
    check([scene.name for scene in bpy.data.scenes] == [bpy.context.scene.name], "the sky's own scene is gone")
    settings().has_world = False
    check(exported()[0].sky == "0", "without the world the sky is black")
    settings().has_world = True


def cancels():
    made = exported()[0]
    out = FOLDER / "cancelled.safetensors"
    job = start_a_long_bake(lambda: operators().Job([operators().command.bake(bpy.context, made, str(out))], made.folder))
    end = time.monotonic() + 60
    while not job.percent and job.is_running and time.monotonic() < end:
        time.sleep(0.01)
    check(job.percent > 0 and job.stage != "", f"a job says how far it is: {job.stage}, {job.percent} %")
    job.cancel()
    job.wait()
    check(job.is_cancelled and job.exit_code != 0, f"the tool ended: {job.exit_code}")
    check(sorted(os.listdir(FOLDER)) == ["rooms.blend", "rooms.safetensors"], f"nothing is left of it: {sorted(os.listdir(FOLDER))}")


def start_a_long_bake(start):
    """Of a spacing that takes longer than a test."""
    settings().spacing_m = 0.06
    started = start()
    settings().spacing_m = 1.0
    return started


def in_the_background():
    saves()
    bakes()
    checks_and_relights()
    previews()
    cancels()
    says_what_the_exporter_changes()
    takes_modifiers_and_instances_as_rendered()
    takes_what_is_rendered()
    takes_the_world_as_sky()


def in_a_window():
    """What the buttons do; yields while a tool is at work."""
    grid = FOLDER / "rooms.safetensors"
    saves()
    yield
    check(bpy.ops.nlg.bake("INVOKE_DEFAULT") == {"RUNNING_MODAL"} and not bpy.ops.nlg.bake.poll(), "a bake goes on by itself, one at a time")
    while operators().state.job:
        yield
    check(info(grid).returncode == 0 and len(overlay().positions) > 20, "it writes the grid and shows its probes")
    before = grid.read_bytes()
    start_a_long_bake(lambda: bpy.ops.nlg.bake("INVOKE_DEFAULT"))
    while not operators().state.job.percent:
        yield
    yield
    check(bpy.context.window_manager.nlg_progress > 0, f"the bar moves: {bpy.context.window_manager.nlg_progress}")
    bpy.ops.nlg.cancel()
    while operators().state.job:
        yield
    check(grid.read_bytes() == before and sorted(os.listdir(FOLDER)) == ["rooms.blend", "rooms.safetensors"], "Cancel leaves everything as it was")


def end():
    bpy.ops.preferences.addon_disable(module=ADDON)
    check(not hasattr(bpy.types.Scene, "neural_light_grid"), "the add-on leaves nothing behind when it is disabled")
    print("end")
    bpy.ops.wm.quit_blender()


def main():
    two_rooms()
    installs()
    if bpy.app.background:
        in_the_background()
        end()
    else:
        steps = in_a_window()

        def go_on():
            with bpy.context.temp_override(window=bpy.context.window_manager.windows[0]):
                try:
                    for _ in steps:
                        return 0.3
                except Exception:  # Blender would print it and stay open
                    traceback.print_exc()
                end()

        bpy.app.timers.register(go_on, first_interval=1.0)


main()

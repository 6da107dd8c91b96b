"""Inside Blender 3.4: models a scene of looks, exports it as glTF by Blender's own exporter, and bakes by Cycles what arrives at places.

    blender -b --factory-startup --python-exit-code 1 --python docs/figures/cycles/scenes.py -- SCENE FOLDER PLACES SAMPLES

Writes FOLDER/SCENE.glb, by the exporter's defaults with Punctual Lights ticked, and FOLDER/SCENE.json: places and their normals in glTF's axes, the
irradiance there of each of RUNS bakes, and the sky, which the exporter drops. Its images lie in FOLDER/images.
SCENE@means is the same scene with the mean of every image as its material's factor.
"""
import json
import math
import sys
from dataclasses import replace
from pathlib import Path

sys.dont_write_bytecode = True
sys.path.insert(0, str(Path(__file__).resolve().parent))
import bpy
import numpy as np
from mathutils import Vector
from model import Look, Model, picture

RUNS = 4  # bakes of other seeds: from their spread comes the noise
WIDTH, DEPTH, HEIGHT, WALL = 4.0, 3.0, 2.6, 0.2
BACK_WINDOW, RIGHT_WINDOW = (1.2, 2.8, 0.9, 2.1), (0.9, 2.1, 0.9, 2.1)  # along the wall from, to; z from, to
CRATE = (2.3, 0.5, 0.0), (3.1, 1.2, 0.8)
RECEIVER_M = 0.002  # side of the square that light is baked on
SKY = (0.8, 1.0, 1.3)  # radiance
HIGHEST_CODE = 0.94  # sRGB: below the albedo of .9 that nlg takes whiter surfaces for
NO_SKY = (0.0, 0.0, 0.0)
SUN_RADIUS = 0.00465  # radians: glTF knows none, and nlg takes this one (scene/model/scene_light.h)
LAMP_RADIUS_M = 0.005  # to Cycles a lamp is a disk, not a ball: near a large one it is too dark


def linear(codes):
    return np.where(codes <= 0.04045, codes / 12.92, ((codes + 0.055) / 1.055) ** 2.4)


class Room(Model):
    """A room of closed boxes, 4 x 3 x 2.6 m, with a crate, on a ground."""

    def __init__(self, folder, has_images):
        super().__init__()
        self.folder, self.has_images = folder, has_images
        self.random = np.random.default_rng(33)

    def look_of(self, name, pixels, look, *, form="PNG", shines=False):
        """The look with an image; with the image's mean as its factor when the scene has no images."""
        if self.has_images:
            image = picture(name, pixels, self.folder, form)
            return replace(look, **{"emission_image" if shines else "image": image})
        mean = tuple(float(c) for c in linear(pixels[..., :3]).mean((0, 1)))
        if look.is_cut:
            look = replace(look, is_cut=False, alpha=float(pixels[..., 3].mean()))
        return replace(look, **{"emission" if shines else "colour": mean})

    def bricks(self, rows, columns, brick, mortar):
        """Bricks of many tones, 512 x 512."""
        y, x = np.mgrid[0:512, 0:512] / 512
        row = (y * rows).astype(int)
        along = x * columns + 0.5 * (row % 2)
        tones = self.random.uniform(0.7, 1.25, (rows, columns))[row, along.astype(int) % columns]
        is_mortar = (np.minimum(along % 1, 1 - along % 1) < 0.04) | (y * rows % 1 < 0.12)
        return np.clip(np.where(is_mortar[..., None], mortar, np.asarray(brick) * tones[..., None]), 0, HIGHEST_CODE)

    def screen(self):
        """A picture that shines: a dark blue sky above a red and a yellow field."""
        y, x = np.mgrid[0:384, 0:640] / 384
        x = x * 0.6  # of the width, 0 to 1
        sky = np.stack([0.1 + 0.2 * y, 0.2 + 0.5 * y, 0.5 + 0.4 * y], -1)
        field = np.where((x < 0.4)[..., None], (0.9, 0.15, 0.1), (0.95, 0.8, 0.2))
        return np.where((y > 0.6)[..., None], field, sky)

    def pickets(self):
        """Boards of a fence, 512 x 256, cut out by alpha; two rails hold them."""
        y, x = np.mgrid[0:256, 0:512] / 256
        x = x / 2
        is_there = ((x * 8 % 1 < 0.55) & (y > 0.1)) | (np.abs(y - 0.35) < 0.05) | (np.abs(y - 0.8) < 0.05)
        colour = np.broadcast_to((0.62, 0.5, 0.35), (256, 512, 3))
        return np.concatenate([colour, is_there[..., None]], -1)

    def build(self, *, textured, back=True, right=False):
        plain = [self.material(name, Look(colour=colour)) for name, colour in
                 (("floor", (0.45, 0.35, 0.25)), ("plaster", (0.75, 0.72, 0.65)), ("brick", (0.6, 0.45, 0.4)), ("crate", (0.5, 0.3, 0.15)), ("ground", (0.3, 0.32, 0.25)))]
        floor, plaster, brick, crate, ground = plain
        if textured:
            # turned, scaled and shifted by a Mapping node, which becomes KHR_texture_transform
            floor = self.material("tiles", self.look_of("tiles", self.bricks(6, 6, (0.75, 0.6, 0.45), (0.3, 0.3, 0.3)), Look(mapping=(1.5, 0.5, (0.2, 0.1)))))
            brick = self.material("bricks", self.look_of("bricks", self.bricks(12, 5, (0.75, 0.4, 0.28), (0.85, 0.83, 0.78)), Look()))
            plaster = self.material("paper", self.look_of("paper", self.bricks(8, 8, (0.6, 0.75, 0.85), (0.9, 0.88, 0.8)), Look(), form="JPEG"))
        x, y, z, t = WIDTH, DEPTH, HEIGHT, WALL
        self.box("ground", (-6, -6, -0.5), (10, 9, -t), ground)
        self.box("floor", (-t, -t, -t), (x + t, y + t, 0), floor, 2.0)
        self.box("ceiling", (-t, -t, z), (x + t, y + t, z + t), plaster, 2.0)
        self.box("front wall", (0, -t, 0), (x, 0, z), brick, 2.0)
        self.box("left wall", (-t, -t, 0), (0, y + t, z), plaster, 2.0)
        self.wall("back wall", (0, y), (x, y + t), BACK_WINDOW if back else None, brick)
        self.wall("right wall", (x, -t), (x + t, y + t), RIGHT_WINDOW if right else None, brick)
        self.box("crate", *CRATE, crate)

    def wall(self, name, low, high, window, material):
        """low, high: x and y; the window lies along the longer of both."""
        along = 0 if high[0] - low[0] > high[1] - low[1] else 1
        begin, end = low[along], high[along]
        parts = [(begin, end, 0, HEIGHT)]
        if window is not None:
            from_, to, sill, lintel = window
            parts = [(begin, from_, 0, HEIGHT), (to, end, 0, HEIGHT), (from_, to, 0, sill), (from_, to, lintel, HEIGHT)]
        for i, (a, b, c, d) in enumerate(parts):
            corners = [list(low) + [c], list(high) + [d]]
            corners[0][along], corners[1][along] = a, b
            self.box(f"{name} {i}", *corners, material, 2.0)

    def back_sheet(self, name, behind, margin, look, repeats=(1.0, 1.0)):
        """A sheet across the back window, its front to the room."""
        from_, to, sill, lintel = BACK_WINDOW
        width, height = to - from_ + 2 * margin, lintel - sill + 2 * margin
        self.sheet(name, (from_ - margin, DEPTH + behind, sill - margin), (width, 0, 0), (0, 0, height), self.material(name, look), repeats)

    def fence(self):
        self.back_sheet("fence", 0.5, 0.6, self.look_of("fence", self.pickets(), Look(is_cut=True)), (1.5, 1.0))

    def pane(self):
        self.back_sheet("pane", 0.1, 0.0, Look(colour=(0.3, 0.6, 0.8), alpha=0.15))

    def shining_screen(self):
        look = self.look_of("screen", self.screen(), Look(colour=(0.05, 0.05, 0.05), strength=8.0), shines=True)
        self.sheet("screen", (0.02, 1.9, 1.0), (0, -1.2, 0), (0, 0, 0.75), self.material("screen", look))

    def tinted_glass(self, window):
        from_, to, sill, lintel = RIGHT_WINDOW if window == "right" else BACK_WINDOW
        place, along = ((WIDTH + 0.1, to, sill), (0, from_ - to, 0)) if window == "right" else ((from_, DEPTH + 0.1, sill), (to - from_, 0, 0))
        self.sheet("glass", place, along, (0, 0, lintel - sill), self.material("glass", Look(colour=(0.9, 0.6, 0.35), transmission=0.8)))

    def lamp(self, kind, energy, colour, place, towards=(0, 0, 0)):
        light = bpy.data.lights.new(kind, kind)
        light.energy, light.color = energy, colour
        if kind == "SUN":
            light.angle = 2 * SUN_RADIUS
        else:
            light.shadow_soft_size = LAMP_RADIUS_M
        thing = bpy.data.objects.new(kind, light)
        thing.location = place
        thing.rotation_euler = (Vector(towards) - Vector(place)).to_track_quat("-Z", "Y").to_euler()
        bpy.context.collection.objects.link(thing)

    def sun(self):
        self.lamp("SUN", 6.0, (1.0, 0.83, 0.58), (1.0, 9.0, 6.0), (2.0, 1.5, 0.5))

    def bulb(self):
        self.lamp("POINT", 20.0, (1.0, 0.75, 0.45), (1.0, 1.0, 2.2))


def images(room):
    room.build(textured=True)
    return SKY


def mask(room):
    room.build(textured=False)
    room.fence()
    room.sun()
    return SKY


def blend(room):
    room.build(textured=False)
    room.pane()
    room.bulb()
    return SKY


def emission(room):
    room.build(textured=False, back=False)
    room.shining_screen()
    return NO_SKY


def transmission(room):
    room.build(textured=False)
    room.tinted_glass("back")
    return SKY


def all_together(room):
    room.build(textured=True, right=True)
    room.fence()
    room.pane()
    room.shining_screen()
    room.tinted_glass("right")
    room.sun()
    room.bulb()
    return SKY


SCENES = {"images": images, "mask": mask, "blend": blend, "emission": emission, "transmission": transmission, "sum": all_together}


def places(random, count):
    """In the room's air with any normal, and, of every third, two centimetres before a wall with the wall's."""
    size = np.array((WIDTH, DEPTH, HEIGHT))
    found = []
    while len(found) < count:
        place, normal = random.uniform(0.1, size - 0.1), random.normal(size=3)
        if len(found) % 3 == 0:
            axis, side = random.integers(3), random.integers(2)
            place[axis] = (0.02, size[axis] - 0.02)[side]
            normal = np.eye(3)[axis] * (1 - 2 * side)
        if np.all(place > np.array(CRATE[0]) - 0.05) and np.all(place < np.array(CRATE[1]) + 0.05):
            continue
        # neither in the plane of the screen nor behind it
        if place[0] < 0.05 and 0.65 < place[1] < 1.95 and 0.95 < place[2] < 1.8:
            continue
        found.append((place, normal / np.linalg.norm(normal)))
    return found


def receivers(found):
    """Squares that nothing meets, each on a texel of its own. Returns the image that light is baked into."""
    columns = math.ceil(math.sqrt(len(found)))
    rows = math.ceil(len(found) / columns)
    corners, faces, texels = [], [], []
    for i, (place, normal) in enumerate(found):
        side = np.cross(normal, np.eye(3)[np.argmin(np.abs(normal))])
        side /= np.linalg.norm(side)
        up = np.cross(normal, side)
        faces.append(list(range(len(corners), len(corners) + 4)))
        for u, v in ((0, 0), (1, 0), (1, 1), (0, 1)):
            corners.append(place + RECEIVER_M * ((u - 0.5) * side + (v - 0.5) * up))
            texels.append(((i % columns + u) / columns, (i // columns + v) / rows))
    material = bpy.data.materials.new("receivers")
    material.use_nodes = True
    nodes = material.node_tree.nodes
    nodes.clear()
    diffuse = nodes.new("ShaderNodeBsdfDiffuse")
    diffuse.inputs["Color"].default_value = (1, 1, 1, 1)
    material.node_tree.links.new(diffuse.outputs[0], nodes.new("ShaderNodeOutputMaterial").inputs["Surface"])
    target = nodes.new("ShaderNodeTexImage")
    target.image = bpy.data.images.new("irradiance", columns, rows, float_buffer=True)
    target.image.colorspace_settings.name = "Non-Color"
    nodes.active = target
    mesh = bpy.data.meshes.new("receivers")
    mesh.from_pydata([tuple(corner) for corner in corners], [], faces)
    mesh.uv_layers.new().data.foreach_set("uv", np.asarray(texels, np.float32).ravel())
    mesh.materials.append(material)
    thing = bpy.data.objects.new("receivers", mesh)
    bpy.context.collection.objects.link(thing)
    for ray in ("diffuse", "glossy", "transmission", "volume_scatter", "shadow"):
        setattr(thing, f"visible_{ray}", False)
    thing.select_set(True)
    bpy.context.view_layer.objects.active = thing
    return target.image


def set_up_cycles(samples):
    bpy.context.scene.render.engine = "CYCLES"
    cycles = bpy.context.scene.cycles
    cycles.samples = samples
    cycles.use_adaptive_sampling = cycles.use_denoising = False
    for bounces in ("max_bounces", "diffuse_bounces", "glossy_bounces", "transmission_bounces", "transparent_max_bounces"):
        setattr(cycles, bounces, 64)
    # what Cycles leaves out or blurs by default
    cycles.blur_glossy = cycles.sample_clamp_direct = cycles.sample_clamp_indirect = cycles.light_sampling_threshold = 0.0


def shine(sky):
    world = bpy.data.worlds.new("sky")
    world.use_nodes = True
    world.node_tree.nodes["Background"].inputs["Color"].default_value = (*sky, 1)
    bpy.context.scene.world = world


def bake(image, seed, count):
    """Irradiance of every receiver."""
    bpy.context.scene.cycles.seed = seed
    bpy.ops.object.bake(type="DIFFUSE", pass_filter={"DIRECT", "INDIRECT"}, margin=0, use_clear=True)
    pixels = np.empty(image.size[0] * image.size[1] * 4, np.float32)
    image.pixels.foreach_get(pixels)
    return (math.pi * pixels.reshape(-1, 4)[:count, :3].astype(float)).tolist()


def gltf_axes(vector):
    x, y, z = (float(c) for c in vector)
    return [x, z, -y]


def main(scene, folder, count, samples):
    folder = Path(folder)
    (folder / "images").mkdir(parents=True, exist_ok=True)
    name, _, twin = scene.partition("@")
    room = Room(folder / "images", not twin)
    sky = SCENES[name](room)
    bpy.ops.export_scene.gltf(filepath=str(folder / f"{scene}.glb"), export_lights=True)
    room.for_cycles()
    set_up_cycles(samples)
    shine(sky)
    found = places(np.random.default_rng(5), count)
    image = receivers(found)
    runs = [bake(image, seed, count) for seed in range(1, RUNS + 1)]
    result = {"blender": bpy.app.version_string, "samples": samples, "sky": sky, "places": [[*gltf_axes(p), *gltf_axes(n)] for p, n in found], "runs": runs}
    (folder / f"{scene}.json").write_text(json.dumps(result))


if __name__ == "__main__":
    scene, folder, count, samples = sys.argv[sys.argv.index("--") + 1:]
    main(scene, folder, int(count), int(samples))

#!/usr/bin/python3
"""Nothing stale is called fresh: whatever changes of a level, its light, its images or the settings, --check and --relight agree with a whole bake, byte for byte.

    mutations_test.py FOLDER_OF_TOOLS short|whole    short: every fourth mutation

A row of MUTATIONS is a level, what changes of it, and how. For each the level is baked whole, and then:
    --check     says fresh only where that is the grid of before
    --relight   refuses, or leaves those bytes
    --inputs    of the bake before names every file that changed, came or went: what --watch looks at
"""
import copy
import io
import json
import struct
import subprocess
import sys
import tempfile
import zipfile
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

sys.dont_write_bytecode = True
sys.path.append(str(Path(__file__).resolve().parents[1]))
from tools import CHECK_FAILED, INPUT_ERROR, SECONDS, png

TOOLS, FORM = Path(sys.argv[1]).resolve(), sys.argv[2]
# next to no time for functions and light
QUICK = ["--spacing-m", "1.5", "--light-samples", "2", "--light-rays", "8", "--lm-iterations", "0", "--lm-theta0-iterations", "0", "--adam-steps", "0",
         "--refine-rounds", "0", "--threads", "1"]


# ---- files

def hdr(red, green, blue, exponent=128):
    """A sky of 8 x 4 texels, each of its mantissas times 2^(exponent - 136)."""
    return b"#?RADIANCE\nFORMAT=32-bit_rle_rgbe\n\n-Y 4 +X 8\n" + bytes((red, green, blue, exponent)) * 32


def box(low, high, inward=False):
    """Corners, triangles and places on an image of a box."""
    corners = [(x, y, z) for x in (low[0], high[0]) for y in (low[1], high[1]) for z in (low[2], high[2])]
    positions, triangles, places = [], [], []
    for face in ((0, 1, 3, 2), (4, 6, 7, 5), (0, 4, 5, 1), (2, 3, 7, 6), (0, 2, 6, 4), (1, 5, 7, 3)):
        first = len(positions)
        positions += [list(corners[i]) for i in (face[::-1] if inward else face)]
        places += [[0, 0], [1, 0], [1, 1], [0, 1]]
        triangles += [[first, first + 1, first + 2], [first, first + 2, first + 3]]
    return positions, triangles, places


class Gltf:
    """A room with a wall, a glass and a screen, lamps in groups and a sun; beside it images and a sky."""
    path = "room.gltf"
    arguments = ["--light-groups", "name", "--sky", "sky.hdr", "--light-unit", "file"]

    def __init__(self):
        self.parts = {}
        for name, low, high, inward, material in (("room", (-3, 0, -2), (3, 3, 2), True, 0), ("wall", (-.1, 0, -2), (.1, 2, .7), False, 1),
                                                  ("glass", (1, 0, -2), (1.05, 3, 1), False, 2), ("screen", (-3, 1, -1), (-2.9, 2, 1), False, 3)):
            positions, triangles, places = box(low, high, inward)
            self.parts[name] = {"positions": positions, "triangles": triangles, "places": places, "colours": [[1, 1, 1, 1] for _ in positions], "material": material,
                                "node": {"name": name}}
        # without a lid: the sky is seen
        del self.parts["room"]["triangles"][6:8]
        self.materials = [{"name": "plaster", "pbrMetallicRoughness": {"baseColorFactor": [.7, .7, .6, 1]}},
                          {"name": "paper", "pbrMetallicRoughness": {"baseColorTexture": {"index": 0}}},
                          {"name": "pane", "alphaMode": "BLEND", "doubleSided": True, "pbrMetallicRoughness": {"baseColorFactor": [.5, 1, .5, .4]}},
                          {"name": "screen", "emissiveFactor": [1, 1, 1], "emissiveTexture": {"index": 1}, "extras": {"light_group": "c"}}]
        self.lamps = [{"name": "a lamp", "type": "point", "intensity": 30, "color": [1, .8, .6], "extras": {"light_group": "ab"}, "place": {"translation": [-1.5, 2, 0]}},
                      {"name": "a spot", "type": "spot", "intensity": 60, "spot": {"outerConeAngle": .6, "innerConeAngle": .3}, "place": {"translation": [2, 2.5, 0], "rotation": [-.7071068, 0, 0, .7071068]}},
                      {"name": "sun", "type": "directional", "intensity": 3, "place": {"rotation": [-.6, 0, 0, .8]}}]
        self.images = {"paper.png": png((200, 60, 60, 255)), "glow.png": png((40, 90, 200, 255))}
        self.uris = ["paper.png", "glow.png"]
        self.samplers, self.extent, self.camera = [{}], [[-2.8, .2, -1.8], [2.8, 2.8, 1.8]], [0, 1.6, 1.5]
        self.root = {"asset": {"version": "2.0", "generator": "by hand"}}
        self.others = {"sky.hdr": hdr(90, 120, 200)}

    def files(self):
        return {name: content for name, content in {**self.images, **self.others, **self.own_files("room")}.items() if content is not None}

    def own_files(self, name):
        binary, views, accessors, meshes, nodes, lights = b"", [], [], [], [], []

        def add(kind, component, code, rows, **more):
            nonlocal binary
            data = struct.pack(f"<{len(rows) * len(rows[0])}{code}", *(number for row in rows for number in row))
            views.append({"buffer": 0, "byteOffset": len(binary), "byteLength": len(data)})
            accessors.append({"bufferView": len(views) - 1, "componentType": component, "count": len(rows) * (len(rows[0]) if kind == "SCALAR" else 1), "type": kind, **more})
            binary += data
            return len(accessors) - 1

        for part in self.parts.values():
            ends = {"min": [min(axis) for axis in zip(*part["positions"])], "max": [max(axis) for axis in zip(*part["positions"])]}
            attributes = {"POSITION": add("VEC3", 5126, "f", part["positions"], **ends), "TEXCOORD_0": add("VEC2", 5126, "f", part["places"]),
                          "COLOR_0": add("VEC4", 5126, "f", part["colours"])}
            meshes.append({"primitives": [{"attributes": attributes, "indices": add("SCALAR", 5125, "I", part["triangles"]), "material": part["material"]}]})
            nodes.append({"mesh": len(meshes) - 1, **part["node"]})
        for lamp in self.lamps:
            lights.append({key: value for key, value in lamp.items() if key != "place"})
            nodes.append({"name": lamp["name"], **lamp["place"], "extensions": {"KHR_lights_punctual": {"light": len(lights) - 1}}})
        if self.extent:
            low, high = self.extent
            nodes.append({"name": "nlg_extent", "translation": [(a + b) / 2 for a, b in zip(low, high)], "scale": [(b - a) / 2 for a, b in zip(low, high)]})
        nodes.append({"name": "eye", "camera": 0, "translation": self.camera})
        text = {**self.root, "scene": 0, "scenes": [{"nodes": list(range(len(nodes)))}], "nodes": nodes, "meshes": meshes, "materials": self.materials,
                "textures": [{"source": 0, "sampler": 0}, {"source": 1, "sampler": 0}], "images": [{"uri": uri} for uri in self.uris], "samplers": self.samplers,
                "cameras": [{"type": "perspective", "perspective": {"yfov": 1, "znear": .1}}], "accessors": accessors, "bufferViews": views,
                "buffers": [{"uri": f"{name}.bin", "byteLength": len(binary)}], "extensionsUsed": ["KHR_lights_punctual", "KHR_materials_emissive_strength"],
                "extensions": {"KHR_lights_punctual": {"lights": lights}}}
        return {f"{name}.gltf": json.dumps(text).encode(), f"{name}.bin": binary}


class Obj:
    """The same room as an .obj, with a material library and an image."""
    path = "room.obj"
    arguments = ["--sky", ".5,.6,.8", "--light-groups", "name"]

    def __init__(self):
        self.parts = {"room": [*box((-3, 0, -2), (3, 3, 2), True), "plaster"], "wall": [*box((-.1, 0, -2), (.1, 2, .7)), "paper"], "screen": [*box((-3, 1, -1), (-2.9, 2, 1)), "screen"]}
        del self.parts["room"][1][6:8]
        self.library = {"plaster": {"Kd": ".7 .7 .6"}, "paper": {"Kd": "1 1 1", "map_Kd": "paper.png"}, "screen": {"Kd": "0 0 0", "Ke": "2 2 3"}}
        self.libraries, self.others, self.colours = ["room.mtl"], {"paper.png": png((200, 60, 60, 255))}, {}

    def files(self):
        lines, corners = [f"mtllib {name}" for name in self.libraries], 0
        for name, (positions, triangles, places, material) in self.parts.items():
            lines += [f"o {name}", f"usemtl {material}"]
            lines += [f"v {p[0]} {p[1]} {p[2]}" + (" " + self.colours[name] if name in self.colours else "") for p in positions]
            lines += [f"vt {p[0]} {p[1]}" for p in places]
            lines += ["f " + " ".join(f"{corners + i + 1}/{corners + i + 1}" for i in triangle) for triangle in triangles]
            corners += len(positions)
        library = "".join(f"newmtl {name}\n" + "".join(f"{key} {value}\n" for key, value in entries.items()) for name, entries in self.library.items())
        files = {"room.obj": ("\n".join(lines) + "\n").encode("utf-8", "surrogateescape"), "room.mtl": library.encode("utf-8", "surrogateescape"), **self.others}
        return {name: content for name, content in files.items() if content is not None}


class Bsp:
    """A level of Quake III: a yard under a sky, a wall in it, lit by its vertices; alone, or in an archive with images and scripts."""
    path = "yard.bsp"
    arguments = ["--light-groups", "kind"]
    SKY, NODRAW = 4, 0x80

    def __init__(self):
        self.shaders = [["textures/test/stone", 0], ["textures/test/sky", self.SKY], ["textures/test/glow", 0], ["textures/test/rim", self.SKY]]
        self.quads, self.light = [], {}
        low, high, top = -120, 120, 140
        self.quad(0, (low, low, 0), (low, high, 0), (high, high, 0), (high, low, 0))                                # the floor, from above
        self.quad(1, (low, low, top), (high, low, top), (high, high, top), (low, high, top))                        # the sky, from below
        for a, b in (((low, low), (low, high)), ((low, high), (high, high)), ((high, high), (high, low)), ((high, low), (low, low))):
            # the upper half of one side is sky, too
            self.quad(3 if a == (high, low) else 0, (*a, 70), (*a, top), (*b, top), (*b, 70))
            self.quad(0, (*a, 0), (*a, 70), (*b, 70), (*b, 0))
        for x, turn in ((-8, -1), (8, 1)):
            self.quad(2 if turn == 1 else 0, *[(x, -120, 0), (x, -120, 90), (x, 30, 90), (x, 30, 0)][::turn])
        self.entities = '{ "classname" "worldspawn" }\n{ "classname" "info_player_start" "origin" "50 50 40" }\n{ "classname" "light" "origin" "60 -60 100" "light" "300" }'
        self.light_of = [[90, 80 + 5 * i, 70] for i, _ in enumerate(self.quads)]

    def quad(self, shader, *corners):
        self.quads.append([shader, [list(map(float, corner)) for corner in corners]])

    def level(self):
        words = lambda *values: struct.pack(f"<{len(values)}I", *values)
        lumps = [b""] * 17
        lumps[0] = self.entities.encode()
        for name, flags in self.shaders:
            lumps[1] += name.encode().ljust(64, b"\0") + words(flags, 0)
        lumps[7] = struct.pack("<6f", -200, -200, -10, 200, 200, 200) + words(0, len(self.quads), 0, 0)
        for number, (shader, corners) in enumerate(self.quads):
            for corner in corners:
                lumps[10] += struct.pack("<3f", *corner) + struct.pack("<4f", corner[0] / 64, corner[1] / 64, 0, 0) + b"\0" * 12 + bytes(self.light_of[number]) + b"\xff"
            lumps[11] += words(0, 1, 2, 0, 2, 3)
            lumps[13] += words(shader, 0xffffffff, 1, 4 * number, 4, 6 * number, 6, 0xfffffffd) + b"\0" * 64 + words(0, 0)
        header, body = b"IBSP" + words(46), b""
        for lump in lumps:
            header += words(144 + len(body), len(lump))
            body += lump
        return header + body

    def files(self):
        return {"yard.bsp": self.level()}


class Archive(Bsp):
    path = "base:yard"

    def __init__(self):
        super().__init__()
        self.inside = {"textures/test/stone.tga": png((120, 110, 100, 255)),
                       "scripts/test.shader": b"textures/test/glow\n{\n  q3map_surfacelight 900\n  {\n    map textures/test/stone.tga\n  }\n}\n"}
        self.more = {}

    def files(self):
        archives = {"pak0.pk3": {"maps/yard.bsp": self.level(), **self.inside}, **self.more}
        files = {}
        for name, entries in archives.items():
            buffer = io.BytesIO()
            with zipfile.ZipFile(buffer, "w") as archive:
                for entry, content in entries.items():
                    archive.writestr(zipfile.ZipInfo(entry), content)
            files[f"base/{name}"] = buffer.getvalue()
        return files


# ---- mutations: level, name, what is done to it before, and then; or what is added to the command line

def put(*path):
    """A function that puts the last of the path where the rest leads: put("lamps", 0, "intensity", 5)."""
    *way, last, value = path

    def change(level):
        holder = getattr(level, way[0]) if way else level
        for key in way[1:]:
            holder = holder[key]
        if way:
            holder[last] = value(holder.get(last) if isinstance(holder, dict) else holder[last]) if callable(value) else value
        else:
            setattr(level, last, value)
    return change


def all_of(*changes):
    def change(level):
        for one in changes:
            one(level)
    return change


MATERIAL, GLASS, SCREEN = ("materials", 0), ("materials", 2), ("materials", 3)


def groups(first, second):
    return all_of(put("lamps", 0, "extras", {"light_group": first}), put("lamps", 1, "extras", {"light_group": second}), put(*SCREEN, "extras", {"light_group": "sun"}))


CHANGES = {
    Gltf: {
        "a corner moved": put("parts", "wall", "positions", 3, [.3, 2, .7]), "a wall moved": put("parts", "wall", "node", "translation", [.4, 0, 0]),
        "a wall turned": put("parts", "wall", "node", "rotation", [0, .2588190, 0, .9659258]), "a wall scaled": put("parts", "wall", "node", "scale", [1, .5, 1]),
        "a wall mirrored": put("parts", "wall", "node", "scale", [-1, 1, 1]), "the room elsewhere": put("parts", "room", "node", "translation", [0, .25, 0]),
        "a face turned": put("parts", "wall", "triangles", 0, lambda t: t[::-1]), "a face away": lambda level: level.parts["wall"]["triangles"].pop(),
        "faces in another order": put("parts", "wall", "triangles", lambda t: t[::-1]), "a part away": lambda level: level.parts.pop("glass"),
        "a part more": lambda level: level.parts.update(table=copy.deepcopy(level.parts["screen"])), "a part of another name": put("parts", "wall", "node", "name", "other"),
        "two sides": put(*MATERIAL, "doubleSided", True), "one side": put(*GLASS, "doubleSided", False), "cut out": put(*GLASS, "alphaMode", "MASK"),
        "opaque": put(*GLASS, "alphaMode", "OPAQUE"), "denser glass": put(*GLASS, "pbrMetallicRoughness", "baseColorFactor", [.5, 1, .5, .95]),
        "thinner glass": put(*GLASS, "pbrMetallicRoughness", "baseColorFactor", [.5, 1, .5, .2]),
        "glass that transmits": put(*GLASS, "extensions", {"KHR_materials_transmission": {"transmissionFactor": .5}}),
        "another colour": put(*MATERIAL, "pbrMetallicRoughness", "baseColorFactor", [.2, .7, .6, 1]), "another material": put("parts", "room", "material", 1),
        "shine": put(*SCREEN, "emissiveFactor", [.5, 1, 1]), "stronger shine": put(*SCREEN, "extensions", {"KHR_materials_emissive_strength": {"emissiveStrength": 4}}),
        "another image": put("images", "paper.png", png((60, 200, 60, 255))), "an image with holes": all_of(put("images", "paper.png", png((200, 60, 60, 20))), put("materials", 1, "alphaMode", "MASK")),
        "another image that shines": put("images", "glow.png", png((240, 9, 20, 255))), "an image gone": put("images", "paper.png", None), "an image that is none": put("images", "paper.png", b"none"),
        "an image of another name": put("uris", 0, "glow.png"), "images clamped": put("samplers", 0, {"wrapS": 33071, "wrapT": 33071}),
        "places on an image": put("parts", "wall", "places", 0, [.5, .25]), "a moved image": put("materials", 1, "pbrMetallicRoughness", "baseColorTexture", {"index": 0, "extensions": {"KHR_texture_transform": {"offset": [.3, 0]}}}),
        "a vertex's colour": put("parts", "wall", "colours", 0, [.1, .5, 1, 1]), "a brighter lamp": put("lamps", 0, "intensity", 90), "a lamp's colour": put("lamps", 0, "color", [0, .2, 1]),
        "a lamp moved": put("lamps", 0, "place", {"translation": [-1.5, 1, .5]}), "a lamp far off": put("lamps", 0, "place", {"translation": [-1.5, 9, .5]}), "a lamp away": lambda level: level.lamps.pop(0),
        "a lamp more": lambda level: level.lamps.append({"name": "more", "type": "point", "intensity": 9, "place": {"translation": [2, 1, -1]}}),
        "lamps in another order": lambda level: level.lamps.reverse(), "a narrower spot": put("lamps", 1, "spot", {"outerConeAngle": .4, "innerConeAngle": .3}),
        "a spot turned": put("lamps", 1, "place", "rotation", [-.6, .3741657, 0, .7071068]), "a spot that is a point": put("lamps", 1, "type", "point"),
        "a brighter sun": put("lamps", 2, "intensity", 4), "a sun elsewhere": put("lamps", 2, "place", {"rotation": [-.8, 0, 0, .6]}),
        "a lamp of another name": put("lamps", 1, "name", "another"), "another group": put("lamps", 0, "extras", {"light_group": "d"}), "a group less": put("lamps", 0, "extras", {"light_group": "c"}),
        "no group": put("lamps", 0, "extras", {}), "a shine's group": put(*SCREEN, "extras", {"light_group": "ab"}), "a lamp in the sky's group": put("lamps", 0, "extras", {"light_group": "sky"}),
        "places for probes": put("extent", [[-2.8, .2, -1.8], [1.2, 2.8, 1.8]]), "no places for probes": put("extent", None), "a camera": put("camera", [1, 1, 1]),
        "a material that nothing has": lambda level: level.materials.append({"name": "unused", "doubleSided": True}), "another program": put("root", "asset", {"version": "2.0", "generator": "Khronos glTF Blender I/O v3.6.6"}),
        "another sky": put("others", "sky.hdr", hdr(200, 90, 60)), "a brighter sky": put("others", "sky.hdr", hdr(90, 120, 200, 129)), "no sky": put("others", "sky.hdr", None),
    },
    Obj: {
        "a corner moved": put("parts", "wall", 0, 3, [.3, 2, .7]), "a face away": lambda level: level.parts["wall"][1].pop(), "another material": put("parts", "room", 3, "paper"),
        "Kd": put("library", "plaster", "Kd", ".1 .7 .6"), "Ke": put("library", "screen", "Ke", "2 0 3"), "d": put("library", "paper", "d", ".3"), "Tf": put("library", "paper", "Tf", ".3 .3 .3"), "an image more": put("library", "plaster", "map_Kd", "paper.png"),
        "no library": put("libraries", []), "a library gone": put("library", {}), "another image": put("others", "paper.png", png((60, 200, 60, 255))), "an image gone": put("others", "paper.png", None),
        "a vertex's colour": put("colours", "wall", ".1 .5 1"), "a part of another name": lambda level: level.parts.update(other=level.parts.pop("wall")), "a material of another name": lambda level: (
            level.library.update(lit=level.library.pop("screen")), put("parts", "screen", 3, "lit")(level)),
    },
    Bsp: {
        "sky that is nothing": put("shaders", 3, 1, Bsp.NODRAW), "sky that is stone": put("shaders", 3, 1, 0), "a sky moved": put("quads", 1, 1, 0, [-120, -120, 150]), "sky away": lambda level: (level.quads.pop(1), level.light_of.pop(1)),
        "a floor moved": put("quads", 0, 1, 0, [-120, -120, -9]), "another shader": put("quads", 0, 0, 2), "a vertex's light": put("light_of", 0, [9, 200, 7]), "all light darker": lambda level: setattr(level, "light_of", [[9, 8, 7]] * len(level.quads)),
        "a place to begin": lambda level: setattr(level, "entities", level.entities.replace("50 50 40", "-50 50 40")), "ambient light": lambda level: setattr(level, "entities", level.entities.replace('"worldspawn"', '"worldspawn" "ambient" "10"')),
        "a lamp that is no light": lambda level: setattr(level, "entities", level.entities.replace("300", "600")),
    },
    Archive: {
        "another image": put("inside", "textures/test/stone.tga", png((9, 110, 100, 255))), "an image gone": lambda level: level.inside.pop("textures/test/stone.tga"),
        "a script": put("inside", "scripts/test.shader", b"textures/test/glow\n{\n  surfaceparm sky\n}\n"), "no scripts": lambda level: level.inside.pop("scripts/test.shader"),
        "another archive": put("more", {"pak1.pk3": {"textures/test/stone.tga": png((9, 9, 250, 255))}}), "sky that is nothing": put("shaders", 3, 1, Bsp.NODRAW),
    },
}
# from a level that is not as it was before: before, then
FROM = {
    Gltf: {"groups ab, c and a, bc": (groups("ab", "c"), groups("a", "bc")), "an image that comes back": (put("images", "paper.png", None), lambda level: None), "a sky that was another": (put("others", "sky.hdr", hdr(9, 9, 9)), lambda level: None)},
    Obj: {"a library that comes": (put("libraries", ["later.mtl"]), all_of(put("libraries", ["later.mtl"]), put("others", "later.mtl", b"newmtl plaster\nKd 1 0 0\n"))), "an image that comes back": (put("others", "paper.png", None), lambda level: None),
          "an image whose name is no UTF-8": (all_of(put("library", "paper", "map_Kd", "p\udce4per.png"), put("others", "p\udce4per.png", png((9, 9, 9, 255)))), all_of(put("library", "paper", "map_Kd", "p\udce4per.png"), put("others", "p\udce4per.png", png((9, 250, 9, 255)))))},
    Bsp: {}, Archive: {},
}
SETTINGS = [["--spacing-m", "1"], ["--density-growth", "0"], ["--align-lattice"], ["--seed", "2"], ["--extent-m=-2,.2,-1,2,2,1"], ["--air-only=false"], ["--unit", "1.1"], ["--transmissive-cover", ".3"], ["--cavity-m", "0"], ["--sky", "sky.hdr,90"],
            ["--sky", "0"], ["--sun", "40,50,1,1,1"], ["--light-unit", "watt"], ["--intensity", "2"], ["--light-groups", "kind"], ["--light-groups", "one"], ["--light-state", "dusk"], ["--light", "point"], ["--light", "none"],
            ["--light-direct", "none"], ["--light-samples", "3"], ["--light-rays", "16"], ["--light-cache=false"], ["--light-pull", ".5"], ["--light-error", ".1"], ["--thin-error", ".05"], ["--adam-steps", "5"], ["--duplicate-rms", "2"],
            ["--theta-precision", "float32"], ["--bare-tent-rmse", ".05"], ["--representation", "mlp"], ["--max-probes", "99999"], ["--threads", "2"]]


# ---- what is done with each

def run(folder, *words):
    return subprocess.run([TOOLS / words[0], *words[1:]], cwd=folder, capture_output=True, text=True, errors="replace", timeout=4 * SECONDS)


def save(folder, files, before=()):
    """As programs save that lose nothing: a new file takes the place of the old one."""
    for name in set(before) - set(files):
        (folder / name).unlink()
    for name, content in files.items():
        path = folder / name
        path.parent.mkdir(exist_ok=True)
        if name not in before or before[name] != content:
            path.with_name(path.name + "~").write_bytes(content)
            path.with_name(path.name + "~").rename(path)


def level_with(kind, change):
    level = kind()
    change(level)
    return level


def bytes_of(path):
    return path.read_bytes() if path.exists() else None


def names_of(text):
    """inputsText of tool/input_file.h"""
    return {name[1:].encode("latin-1").decode("utf-8", "surrogateescape") if name.startswith("\1") else name for name in json.loads(text)}


class Base:
    """A level and what a bake leaves of it."""

    def __init__(self, root, kind, change):
        self.kind, self.folder = kind, Path(tempfile.mkdtemp(dir=root))
        self.files = level_with(kind, change).files()
        self.command = [kind.path, *QUICK, *kind.arguments]
        save(self.folder, self.files)
        done = run(self.folder, "nlg-bake", *self.command, "--inputs", "inputs", "--out", "grid")
        if done.returncode != 0:
            sys.exit(f"{kind.__name__}: {done.stderr}")
        self.grid = bytes_of(self.folder / "grid")
        self.inputs = names_of((self.folder / "inputs").read_text(encoding="utf-8"))


class Case:
    def __init__(self, name, base, files, more=()):
        self.name, self.base, self.files, self.command = f"{base.kind.__name__}: {name}", base, files, list(base.command)
        # no option twice
        if more and more[0] in self.command:
            at = self.command.index(more[0])
            del self.command[at:at + 2]
        self.command += more
        self.changed = [path for path in {**base.files, **files} if base.files.get(path) != files.get(path)]
        self.failures, self.whole, self.relights, self.is_fresh = [], None, False, False

    def check(self, holds, claim):
        if not holds:
            self.failures.append(f"{self.name}: {claim}")

    def run(self, root):
        folder = Path(tempfile.mkdtemp(dir=root))
        save(folder, self.files)
        (folder / "grid").write_bytes(self.base.grid)
        baked = run(folder, "nlg-bake", *self.command, "--out", "whole")
        self.whole = bytes_of(folder / "whole")
        self.check((baked.returncode == 0) == (self.whole is not None) and baked.returncode in (0, 2, INPUT_ERROR), f"a bake ends with {baked.returncode}: {baked.stderr[-300:]}")
        checked = run(folder, "nlg-bake", *self.command, "--check", "grid")
        self.is_fresh = checked.returncode == 0
        self.check(not self.is_fresh or self.whole == self.base.grid, "--check says fresh, and a bake makes another grid")
        self.check(checked.returncode in (0, CHECK_FAILED) or self.whole is None, f"--check ends with {checked.returncode}: {checked.stderr[-300:]}")
        relit = run(folder, "nlg-bake", *self.command, "--relight", "grid", "--out", "relit")
        self.relights = relit.returncode == 0
        # a state of light of another name is added to what the grid has
        adds_state = "--light-state" in self.command
        self.check(not self.relights or (bytes_of(folder / "relit") == self.whole) != adds_state, "--relight leaves another grid than a bake")
        self.check(relit.returncode in (0, 2, INPUT_ERROR), f"--relight ends with {relit.returncode}: {relit.stderr[-300:]}")
        for path in self.changed:
            holder = path.rpartition("/")[0]
            self.check(path in self.base.inputs or f"./{path}" in self.base.inputs or holder in self.base.inputs, f"{path} is none of the inputs {sorted(self.base.inputs)}")


def main():
    with tempfile.TemporaryDirectory() as root, ThreadPoolExecutor(2) as pool:
        bases = {kind: Base(root, kind, lambda level: None) for kind in CHANGES}
        cases = [Case(name, bases[kind], level_with(kind, change).files()) for kind, changes in CHANGES.items() for name, change in changes.items()]
        cases += [Case(" ".join(words), bases[Gltf], bases[Gltf].files, words) for words in SETTINGS]
        if FORM == "short":
            cases = cases[::4]
        cases += [Case("nothing", base, base.files) for base in bases.values()]
        # the same under another name, which the grid holds
        renamed = Case("another name of the file", bases[Gltf], {**bases[Gltf].files, "hall.gltf": bases[Gltf].files["room.gltf"]})
        renamed.command[0], renamed.changed = "hall.gltf", []
        cases.append(renamed)
        cases += [Case(name, Base(root, kind, before), level_with(kind, then).files()) for kind, changes in FROM.items() for name, (before, then) in changes.items()]
        list(pool.map(lambda case: case.run(root), cases))
    failures = [failure for case in cases for failure in case.failures]
    # a test that cannot fail would show here
    same = [case for case in cases if case.whole == case.base.grid]
    for name, count, least in (("that change the grid", len(cases) - len(same), 60), ("that are fresh", sum(case.is_fresh for case in cases), 4),
                               ("that are lit anew", sum(case.relights and case not in same for case in cases), 25)):
        if count < (least if FORM == "whole" else least // 4):
            failures.append(f"only {count} mutations {name}")
    for failure in failures:
        print("FAILED:", failure)
    print(f"{len(cases)} mutations, {len(same)} of which leave the grid, {len(failures)} failures")
    return 1 if failures else 0


if __name__ == "__main__":
    sys.exit(main())

"""Scenes of a few bytes, sound ones and hostile ones: glTF, OBJ, .bsp, .pk3, textures, shader scripts."""
import base64
import io
import json
import struct
import zipfile

FLOAT, VERTEX_WORDS = 5126, 11


# ---- a closed room, as each format has it

CORNERS = [(x, y, z) for x in (0.0, 4.0) for y in (0.0, 3.0) for z in (0.0, 4.0)]
# quads whose fronts look inwards
SIDES = [(1, 3, 2, 0), (6, 7, 5, 4), (4, 5, 1, 0), (3, 7, 6, 2), (2, 6, 4, 0), (5, 7, 3, 1)]
TRIANGLES = [i for a, b, c, d in SIDES for i in (a, b, c, a, c, d)]


def gltf(**more):
    """As a dict, its buffer inside."""
    positions = b"".join(struct.pack("<3f", *corner) for corner in CORNERS)
    indices = struct.pack(f"<{len(TRIANGLES)}H", *TRIANGLES)
    data = positions + indices
    return {
        "asset": {"version": "2.0"}, "scene": 0, "scenes": [{"nodes": [0]}],
        "nodes": [{"mesh": 0, "children": [1]}, {"translation": [2, 2, 2], "extensions": {"KHR_lights_punctual": {"light": 0}}}],
        "meshes": [{"primitives": [{"attributes": {"POSITION": 0}, "indices": 1, "material": 0}]}],
        "materials": [{"emissiveFactor": [1, 1, 1], "pbrMetallicRoughness": {"baseColorFactor": [0.5, 0.5, 0.5, 1]}}],
        "extensionsUsed": ["KHR_lights_punctual"], "extensions": {"KHR_lights_punctual": {"lights": [{"type": "point", "intensity": 10}]}},
        "accessors": [{"bufferView": 0, "componentType": FLOAT, "count": 8, "type": "VEC3", "min": [0, 0, 0], "max": [4, 3, 4]},
                      {"bufferView": 1, "componentType": 5123, "count": len(TRIANGLES), "type": "SCALAR"}],
        "bufferViews": [{"buffer": 0, "byteLength": len(positions)}, {"buffer": 0, "byteOffset": len(positions), "byteLength": len(indices)}],
        "buffers": [{"uri": "data:application/octet-stream;base64," + base64.b64encode(data).decode(), "byteLength": len(data)}], **more}


def glb():
    document = gltf()
    data = base64.b64decode(document["buffers"][0].pop("uri").split(",")[1])
    text = json.dumps(document).encode()
    text += b" " * (-len(text) % 4)
    data += bytes(-len(data) % 4)
    chunks = struct.pack("<II", len(text), 0x4E4F534A) + text + struct.pack("<II", len(data), 0x004E4942) + data
    return struct.pack("<4sII", b"glTF", 2, 12 + len(chunks)) + chunks


def obj():
    lines = ["mtllib room.mtl", *(f"v {x} {y} {z}" for x, y, z in CORNERS), "vn 0 1 0", "vt 0 0", "usemtl wall"]
    return "\n".join([*lines, *(f"f {a + 1}/1/1 {b + 1}/1/1 {c + 1}/1/1 {d + 1}/1/1" for a, b, c, d in SIDES), ""]).encode()


MTL = b"newmtl wall\nKd 0.5 0.5 0.5\nKe 1 1 1\nmap_Kd wall.jpg\n"


def bsp(shader_names=("textures/test/stone",), entities='{ "classname" "worldspawn" }\n{ "classname" "light" "origin" "64 64 64" "light" "300" }'):
    """Units of 1/32 m or so, z up; a side for each shader in turn, a patch for a floor, one page of lightmap."""
    vertices, indices, faces = [], [], []
    for number in range(max(len(SIDES), len(shader_names))):
        side = SIDES[number % len(SIDES)]
        first = len(vertices)
        vertices += [tuple(40 * value for value in (CORNERS[i][0], CORNERS[i][2], CORNERS[i][1])) for i in side]
        faces.append((number % len(shader_names), 1, first, 4, len(indices), 6, 0, 0))
        indices += [0, 1, 2, 0, 2, 3]
    first = len(vertices)
    vertices += [(40.0 * x, 40.0 * y, 4.0 + 8.0 * x) for y in range(3) for x in range(3)]
    faces.append((0, 2, first, 9, 0, 0, 3, 3))
    lumps = [b""] * 17
    lumps[0] = entities.encode("latin-1")
    lumps[1] = b"".join(struct.pack("<64sII", name.encode("latin-1")[:64], 0, 1) for name in shader_names)
    lumps[7] = struct.pack("<6f4I", 0, 0, 0, 160, 160, 120, 0, len(faces), 0, 0)
    lumps[10] = b"".join(struct.pack("<3f", *vertex) + bytes(28) + b"\x80\x80\x80\xff" for vertex in vertices)
    lumps[11] = struct.pack(f"<{len(indices)}I", *indices)
    for shader, kind, first_vertex, vertex_count, first_index, index_count, width, height in faces:
        lumps[13] += struct.pack("<IiIIIIIi", shader, -1, kind, first_vertex, vertex_count, first_index, index_count, 0) + bytes(64) + struct.pack("<II", width, height)
    lumps[14] = bytes(range(256)) * 192
    header, body = b"IBSP" + struct.pack("<I", 46), b""
    for lump in lumps:
        header += struct.pack("<II", 144 + len(body), len(lump))
        body += lump
    return header + body


def zipped(files):
    archive = io.BytesIO()
    with zipfile.ZipFile(archive, "w", zipfile.ZIP_DEFLATED) as file:
        for name, data in files.items():
            file.writestr(zipfile.ZipInfo(name), data, zipfile.ZIP_DEFLATED)
    return archive.getvalue()


SCRIPT = b"textures/test/stone\n{\n\tq3map_surfacelight 500\n\tq3map_lightimage textures/test/light.jpg\n\tsurfaceparm nonsolid\n\t{\n\t\tmap textures/test/stone.tga\n\t\trgbGen identity\n\t}\n}\n"


def pk3(level=None, script=SCRIPT, **more):
    return zipped({"maps/room.bsp": level or bsp(), "scripts/test.shader": script, "textures/test/stone.tga": tga(), "textures/test/light.jpg": jpeg(), **more})


# ---- textures

def tga(width=8, height=8):
    return struct.pack("<BBBHHBHHHHBB", 0, 0, 2, 0, 0, 0, 0, 0, width, height, 24, 0) + bytes((40, 80, 120)) * min(width * height, 1 << 16)


def segment(marker, data):
    return struct.pack(">BBH", 0xFF, marker, 2 + len(data)) + data


def jpeg(width=16, height=16, components=1, scans=1, frame=0xC0):
    """Grey of one tone: a code of one bit for each of the tables' only symbols. Components in scans of their own, in turn."""
    data = b"\xff\xd8" + segment(0xDB, b"\0" + b"\1" * 64)
    data += segment(frame, struct.pack(">BHHB", 8, height, width, components) + b"".join(bytes((i + 1, 0x11, 0)) for i in range(components)))
    data += segment(0xC4, b"\x00" + b"\1" + bytes(15) + b"\0") + segment(0xC4, b"\x10" + b"\1" + bytes(15) + b"\0")
    for scan in range(max(scans, components)):
        # a scan without bits: decoders fill up with zeros
        data += segment(0xDA, bytes((1, scan % components + 1, 0, 0, 0 if frame == 0xC2 else 63, 0)))
        data += bytes(min(width * height // 256 + 1, 64)) if scans == 1 else b""
    return data + b"\xff\xd9"


# ---- those that the first run found

def many_scans():
    """D3: a picture that is decoded 20,000 times over."""
    return pk3(**{"textures/test/light.jpg": jpeg(2048, 2048, 3, 20000)})


def one_texture_often():
    """D4: 200 shaders, each of which reads the same large texture 200 times. It ends early: no reading gives a colour, and the next is tried."""
    names = [f"textures/test/s{i}" for i in range(200)]
    stages = "\t{\n\t\tmap textures/test/large.jpg\n\t}\n" * 200
    script = "".join(f"{name}\n{{\n\tq3map_surfacelight 10\n{stages}}}\n" for name in names).encode()
    return pk3(bsp(names), script, **{"textures/test/large.jpg": jpeg(8192, 8192)})


def accessors_of_zeros(count=24, length=(1 << 24) - 1):
    """D5: accessors without bytes, each within its limit; together gigabytes."""
    accessor = {"componentType": FLOAT, "count": length, "type": "VEC3"}
    primitives = [{"attributes": {"POSITION": i}} for i in range(count)]
    return json.dumps({"asset": {"version": "2.0"}, "scene": 0, "scenes": [{"nodes": [0]}], "nodes": [{"mesh": 0}], "meshes": [{"primitives": primitives}],
                       "accessors": [accessor] * count}).encode()


def draco_not_required():
    """D16: a primitive that is compressed only, in a file that does not say so."""
    document = gltf()
    data = base64.b64encode(b"DRACO\2\2\1\1" + bytes(60)).decode()
    document["buffers"] = [{"uri": "data:application/octet-stream;base64," + data, "byteLength": 69}]
    document["bufferViews"] = [{"buffer": 0, "byteLength": 69}]
    document["accessors"] = [{"componentType": FLOAT, "count": 8, "type": "VEC3", "min": [0, 0, 0], "max": [4, 3, 4]}, {"componentType": 5123, "count": 36, "type": "SCALAR"}]
    document["extensionsUsed"].append("KHR_draco_mesh_compression")
    document["meshes"][0]["primitives"][0]["extensions"] = {"KHR_draco_mesh_compression": {"bufferView": 0, "attributes": {"POSITION": 0}}}
    return json.dumps(document).encode()


def large_buffers(names):
    """D12: buffers of 3 GB each, in files that hold nothing but holes."""
    return json.dumps(gltf(buffers=[{"uri": name, "byteLength": 3 << 30} for name in names])).encode()


def control_characters():
    """D16: a level whose names steer a terminal."""
    return bsp(("textures/\x1b[31mred\x07/\r\n", "\x9b2Jtextures"), '{ "classname" "worldspawn" "message" "\x1b]0;title\x07" }\n{ "\x1b[2J" ')

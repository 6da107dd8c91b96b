"""Hostile scenes: variants of sound ones by mutation, and those that the first run wrote by hand (findings.py).

Each ends within the limits of time and memory: with success, or with a documented exit code and one line.
"""
import copy
import json
import os

import damage
import hostile
import trial
from case import Case, random_of

SECONDS, PEAK_MB = 30.0, 1500.0
NUMBERS = (-1, 0, 1, 255, 65536, 2**31 - 1, 2**31, 2**32 - 1, 2**32, 2**53, 2**63, -2**63, 1e-45, 1e38, 1e308, -1e308, 0.1)
VALUES = (*NUMBERS, "", "a" * 5000, "\x1b[2J", "\ud800", None, True, [], {}, [[]] * 100)
MANY_WORDS = 10000  # from there on a text is no longer made fifty times as long
WORDS = (b"nan", b"inf", b"-1", b"1e999", b"4294967296", b"9" * 400, b"", b"\x00", b"\x1b[2J", b"../../../etc/passwd", b"{", b"}", b"//", b"/*", b"\"", b"/", b"a" * 2000, b"\xff\xfe")


# ---- each (bytes, random) → bytes

def mutate_json(data, random):
    """A few values of the document: replaced, dropped, repeated or nested."""
    document = json.loads(data)
    for _ in range(random.choice((1, 1, 2, 4))):
        node, parents = document, []
        while isinstance(node, (dict, list)) and node:
            key = random.choice(sorted(node)) if isinstance(node, dict) else random.randrange(len(node))
            parents.append((node, key))
            node = node[key]
        holder, key = random.choice(parents)
        what = random.random()
        if what < 0.6:
            # a copy: a later change may go into it
            holder[key] = copy.deepcopy(random.choice(VALUES))
        elif what < 0.75:
            del holder[key]
        elif what < 0.9 and isinstance(holder, list):
            holder.extend([holder[key]] * random.choice((1, 100, 10000) if len(parents) == 1 else (1, 100)))
        else:
            holder[key] = [holder[key]]
        if not document:
            return b"{}"
    return json.dumps(document).encode()


def mutate_words(data, random):
    """A few words of a text."""
    words = data.split(b" ")
    for _ in range(random.choice((1, 2, 5, 20))):
        place = random.randrange(len(words))
        what = random.random()
        if what < 0.6:
            words[place] = random.choice(WORDS)
        elif what < 0.8:
            words[place] = words[place].replace(b"\n", b"")
        else:
            words[place:place] = words[:random.randrange(1, len(words))] * random.choice((1, 50) if len(words) < MANY_WORDS else (1,))
    return b" ".join(words)


def mutate_level(data, random):
    """Words of the header, or of any lump."""
    data = bytearray(data)
    for _ in range(random.choice((1, 1, 2, 8))):
        place = 4 * random.randrange(2, 36) if random.random() < 0.5 else 4 * random.randrange(36, len(data) // 4)
        value = random.choice((0, 1, 2, 0x7FFFFFFF, 0x80000000, 0xFFFFFFFF, 0x7F800000, 0x7FC00000, len(data), random.getrandbits(32)))
        data[place:place + 4] = value.to_bytes(4, "little")
    return bytes(data)


def mutate_bytes(data, random):
    how = random.choice(sorted(damage.BYTES))
    return damage.BYTES[how](data, random)


def either(mutate):
    return lambda data, random: mutate_bytes(data, random) if random.random() < 0.3 else mutate(data, random)


def mutate_part(part, make, mutate):
    """An archive one of whose files is hostile, or the archive itself."""
    def mutated(_, random):
        if random.random() < 0.2:
            return mutate_bytes(hostile.pk3(), random)
        return hostile.pk3(**{part: either(mutate)(make(), random)})
    return mutated


# kind → file, its sound bytes, what mutates them
KINDS = {
    "glTF": ("scene.gltf", lambda: json.dumps(hostile.gltf()).encode(), either(mutate_json)),
    "GLB": ("scene.glb", hostile.glb, mutate_bytes),
    "OBJ": ("scene.obj", hostile.obj, either(mutate_words)),
    "materials of OBJ": ("scene.obj", hostile.obj, lambda data, random: data),
    ".bsp": ("scene.bsp", hostile.bsp, either(mutate_level)),
    "entities": ("scene.bsp", hostile.bsp, lambda data, random: hostile.bsp(entities=mutate_words(ENTITIES, random).decode("latin-1"))),
    ".pk3": ("scene.pk3", hostile.pk3, mutate_part("maps/room.bsp", hostile.bsp, mutate_level)),
    "shader scripts": ("scene.pk3", hostile.pk3, mutate_part("scripts/test.shader", lambda: hostile.SCRIPT, mutate_words)),
    "JPEG": ("scene.pk3", hostile.pk3, mutate_part("textures/test/light.jpg", hostile.jpeg, mutate_bytes)),
    "Targa": ("scene.pk3", hostile.pk3, mutate_part("textures/test/stone.tga", hostile.tga, mutate_bytes)),
}
ENTITIES = b'{ "classname" "worldspawn" "gridsize" "64 64 128" } { "classname" "light" "origin" "64 64 64" "light" "300" "_color" "1 0 0" } { "classname" "info_player_start" "origin" "1 2 3" }'


def readers(injection):
    """Programs that read a scene: geometry alone, and with its light."""
    return {
        "datagen": lambda scene: ["nlg-datagen", "--config", "fault_injection.yaml", "--scene", scene, "--out", "shard.h5"],
        "render": lambda scene: ["nlg-render", scene, "--eye", "2,1.5,2", "--look", "3,1,3", "--width", "8", "--height", "8", "--truth-rays", "8", "--out", "picture.png"],
        "bake": lambda scene: ["nlg-bake", scene, "--config", "fault_injection.yaml", "--weights", "tent_mlp.safetensors", "--out", "grid.safetensors"],
    }


def scene_name(file):
    return f"{file}:room" if file.endswith(".pk3") else file


def read_scene(injection, file, data, reader, folder, faults, must_fail=False, seconds=SECONDS, peak_mb=PEAK_MB, **others):
    """Writes a scene and lets a program read it."""
    os.makedirs(folder, exist_ok=True)
    for name in ("fault_injection.yaml", "tent_mlp.safetensors"):
        os.link(os.path.join(injection.store, name), os.path.join(folder, name))
    for name, content in {file: data, **others}.items():
        with open(os.path.join(folder, name), "wb") as stream:
            stream.write(content)
    program, *arguments = readers(injection)[reader](scene_name(file))
    factor = injection.factor
    limits = trial.Limits(seconds * factor, peak_mb * (1 if factor == 1 else 3), injection.limits.address_space)
    before = set(os.listdir(folder))
    ending = trial.run([os.path.join(injection.binaries, program), *arguments], folder, injection.environment, limits)
    trial.judge(ending, limits, faults, is_quiet=ending.code != 0 and reader != "bake")
    if ending.code == 0 and must_fail:
        faults.add(trial.SILENT, f"{file} was accepted: {ending.words()}")
    if ending.code != 0:
        faults.found += [[trial.LEFT, name] for name in sorted(set(os.listdir(folder)) - before - {"stdout"})]
    return f"{file} of {len(data)} bytes, read by {reader}: {ending.words()}"


def mutated_scene(injection, kind, random):
    def run(folder, faults):
        file, sound, mutate = KINDS[kind]
        data = mutate(sound(), random)
        others = {"room.mtl": mutate_words(hostile.MTL, random) if kind == "materials of OBJ" else hostile.MTL} if file == "scene.obj" else {}
        reader = random.choices(("datagen", "render", "bake"), (4, 4, 1))[0]
        return read_scene(injection, file, data, reader, folder, faults, **others)
    return run


def cases(injection, count):
    kinds = list(KINDS)
    for number in range(count):
        kind = kinds[number % len(kinds)]
        yield Case(f"scenes/{number}", "hostile scenes", mutated_scene(injection, kind, random_of(injection, "scenes", number))), 1

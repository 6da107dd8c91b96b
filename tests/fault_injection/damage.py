"""Damage: every kind of file that a stage reads, in every way that disks and people have.

Binary files carry their own proof: a reader that ends well on bytes that are not the original ones has accepted damage silently. Texts
(JSON, CSV, YAML) are what they say: of them a documented ending is asked here, and the pipeline's own record finds what was changed in a run.
"""
import os
import shutil
import threading

import chain
import trial
from case import Case, random_of
from pipeline import Pipeline

WORD, BLOCK = 2, 4096
TEXTS = (".json", ".csv", ".yaml")
REFUSED = (trial.INPUT_ERROR, trial.DAMAGED_FILE)
# a configuration, and what names a file, are settings
REFUSED_TEXT = (trial.USAGE_ERROR, *REFUSED, trial.CHECK_FAILED)


# ---- what is done to bytes: each (bytes, random) → bytes

def flip(data, random):
    """1 to 3 bits."""
    data = bytearray(data)
    for _ in range(random.choice((1, 1, 2, 3))):
        data[random.randrange(len(data))] ^= 1 << random.randrange(8)
    return bytes(data)


def place_of(data, random, size):
    """Anywhere; every fourth time where files keep what holds them together."""
    places = [0, 8, len(data) // 2, len(data) - size, BLOCK, len(data) // BLOCK * BLOCK]
    place = random.choice(places) if random.random() < 0.25 else random.randrange(len(data))
    return max(0, min(place, len(data) - size))


def zero_block(data, random):
    size = min(random.choice((WORD, 64, 512, BLOCK)), len(data))
    place = place_of(data, random, size)
    return data[:place] + bytes(size) + data[place + size:]


def zeros_to_ones(data, random):
    """The words 0000 become ffff, one of them or a run: what a Fletcher sum does not see."""
    zeros = [i for i in range(0, len(data) - 1, WORD) if data[i:i + WORD] == b"\0\0"]
    if not zeros:
        return flip(data, random)
    first = random.randrange(len(zeros))
    data = bytearray(data)
    for i in zeros[first:first + random.choice((1, 1, 16))]:
        data[i:i + WORD] = b"\xff\xff"
    return bytes(data)


def truncate(data, random):
    return data[:random.choice((0, 1, 7, 8, len(data) // 2, len(data) - 1, len(data) // BLOCK * BLOCK, random.randrange(len(data))))]


def append(data, random):
    return data + random.choice((b"\0", b"\n", bytes(64), data[:512], random.randbytes(random.randrange(1, 600))))


def swap_blocks(data, random):
    size = min(random.choice((16, 64, 512, BLOCK)), len(data) // 2)
    first = random.randrange(len(data) - 2 * size + 1)
    second = random.randrange(first + size, len(data) - size + 1)
    return data[:first] + data[second:second + size] + data[first + size:second] + data[first:first + size] + data[second + size:]


def overwrite(data, random):
    size = min(random.choice((1, 4, 64)), len(data))
    place = place_of(data, random, size)
    return data[:place] + random.randbytes(size) + data[place + size:]


def remove(data, random):
    size = min(random.choice((1, 2, 4, 512)), len(data) - 1)
    place = random.randrange(len(data) - size)
    return data[:place] + data[place + size:]


BYTES = {"flipped bits": flip, "zeroed words": zero_block, "0000 to ffff": zeros_to_ones, "cut short": truncate, "appended bytes": append, "swapped blocks": swap_blocks,
         "other bytes": overwrite, "lost bytes": remove}
IN_PLACE = ("a FIFO", "a folder", "a link to nothing", "a link to itself", "/dev/zero")
DRAWS = [*BYTES] * 4 + [*IN_PLACE]


def damage(path, how, random):
    """Puts something damaged in the place of a file. False where the damage changed nothing."""
    original = chain.read(path)
    os.remove(path)
    if how == "a FIFO":
        os.mkfifo(path)
    elif how == "a folder":
        os.mkdir(path)
    elif how == "a link to nothing":
        os.symlink("nowhere", path)
    elif how == "a link to itself":
        os.symlink(os.path.basename(path), path)
    elif how == "/dev/zero":
        os.symlink("/dev/zero", path)
    else:
        changed = BYTES[how](original, random)
        with open(path, "wb") as file:
            file.write(changed)
        return changed != original
    return True


# ---- who reads what

class Reading:
    """One reader of one file: a tool of the chain, or a command of its own."""

    def __init__(self, kind, file, argv, inputs=(), weight=1.0):
        self.kind, self.file, self.argv, self.inputs, self.weight = kind, file, argv, inputs, weight

        self.opens = "grid-header" not in argv  # the header is given bytes

    def is_text(self):
        return self.file.endswith(TEXTS)


def readings(injection):
    """Every file that a stage reads, with each of its readers; where there are several the quick ones are drawn more often."""
    read = lambda kind, file, reader, weight=1.0: Reading(kind, file, [injection.reader, reader, file], weight=weight)
    found = [
        read("weights", "tent_mlp.safetensors", "weights", 6), read("weights", "tent_mlp.safetensors", "weights-c", 3),
        read("light grids", "grid.safetensors", "grid", 6), read("light grids", "grid.safetensors", "grid-c", 3),
        read("shader grids, by the C header", "shader/grid.bin", "grid-header", 6),
    ]
    # each tool describes and verifies what it writes
    for program, kind, file in (("nlg-datagen", "shards", "training.h5"), ("nlg-pca", "bases", "basis.h5"), ("nlg-cache", "function caches", "functions.cache"),
                                ("nlg-train", "checkpoints", "tent_mlp.ckpt"), ("nlg-export", "weights", "tent_mlp.safetensors"), ("nlg-bake", "light grids", "grid.safetensors")):
        found.append(Reading(kind, file, [os.path.join(injection.binaries, program), "info", "--quiet", file], weight=6))
    kinds = {".safetensors": "weights", ".h5": "shards", ".cache": "function caches", ".ckpt": "checkpoints", ".yaml": "configurations", ".json": "JSON", ".csv": "CSV"}
    for tool in injection.tools:
        for name in tool.inputs:
            for path in [os.path.join(name, below) for below in chain.files_in(os.path.join(injection.store, name))] if os.path.isdir(os.path.join(injection.store, name)) else [name]:
                kind = {"grid.safetensors": "light grids", "basis.h5": "bases"}.get(path, kinds.get(os.path.splitext(path)[1]))
                if kind and path in " ".join(tool.command):
                    found.append(Reading(kind, path, tool.argv(injection), tool.inputs, min(2.0, 0.4 / injection.made[tool.name].seconds)))
    return found


def read_damaged(injection, reading, how, random):
    def run(folder, faults):
        inputs = reading.inputs or (reading.file.split("/")[0],)
        chain.lay_out(injection.store, chain.Tool("", [], list(inputs), []), folder)
        is_damaged = damage(os.path.join(folder, reading.file), how, random)
        before = set(chain.files_in(folder))
        # what a cut configuration leaves out has its default, which may take minutes and is no hang
        limits = injection.pipeline_limits if reading.kind == "configurations" else injection.limits
        ending = trial.run(reading.argv, folder, injection.environment, limits)
        trial.judge(ending, limits, faults, REFUSED_TEXT if reading.is_text() else REFUSED, is_quiet=ending.code != 0)
        if ending.code == 0 and is_damaged and (not reading.is_text() or how in IN_PLACE):
            faults.add(trial.SILENT, f"{reading.file} was accepted")
        if ending.code != 0:
            left = [path for path in chain.files_in(folder) if path not in before and path != "stdout"]
            # a training run's own folder stays: the next attempt goes on from there
            faults.found += [[trial.LEFT, path] for path in left if chain.is_temporary(path) or not path.startswith("run")]
        return f"{reading.file}: {how}, read by {' '.join(os.path.basename(word) for word in reading.argv[:2])}: {ending.words()}"
    return run


# ---- a whole run, one of whose artefacts was changed behind its back

class Runs:
    """A few finished runs that are damaged and mended in turn, one for each case at work."""

    def __init__(self, injection):
        self.injection, self.free, self.lock = injection, [], threading.Lock()

    def take(self):
        with self.lock:
            if self.free:
                return self.free.pop()
            number = sum(name.startswith("damaged") for name in os.listdir(os.path.join(self.injection.out, "pipeline"))) + 1
            folder = os.path.join(self.injection.out, "pipeline", f"damaged{number}")
            os.makedirs(folder)
        pipeline = Pipeline(self.injection, folder)
        pipeline.run()
        return pipeline

    def give(self, pipeline):
        with self.lock:
            self.free.append(pipeline)


def damage_artefact(injection, runs, path, how, random):
    def run(folder, faults):
        os.makedirs(folder)
        pipeline = runs.take()
        place = os.path.join(pipeline.results, path)
        times = os.stat(place)
        damage(place, how, random)
        os.utime(place, ns=(times.st_atime_ns, times.st_mtime_ns))
        damaged = chain.read(place)
        ending = pipeline.run()
        trial.judge(ending, injection.pipeline_limits, faults, is_quiet=False)
        if ending.code == 0 and (not os.path.exists(place) or chain.read(place) == damaged):
            faults.add(trial.SILENT, f"{path} is still damaged after a run")
        elif ending.code == 0 and not injection.pipeline.is_final(pipeline.results, path):
            faults.add(trial.TORN, f"{path} was not made again as it was")
        if faults.found:
            shutil.rmtree(pipeline.folder)
        else:
            runs.give(pipeline)
        return f"{path}: {how}, its time kept: {ending.words()}"
    return run


def artefacts(injection):
    """One of each kind that a run leaves and that later stages read."""
    wanted = ("dataset/training/house_0.0.h5", "basis.h5", "basis.json", "training/tent_mlp.ckpt", "training/tent_mlp.csv", "weights/tent_mlp.safetensors",
              "validation/summary.json", "validation/functions.csv", "validation/frontier.json", "stability.json", "light/two_rooms_0.json", "report.html")
    return [path for path in wanted if path in injection.pipeline.listing]


def cases(injection, count):
    if injection.pipeline:
        runs = Runs(injection)
        for path in artefacts(injection):
            for how in ("flipped bits", "cut short"):
                row = "artefacts of a run, their times kept"
                name = f"damage/run/{path}/{how}".replace(" ", "_")
                yield Case(name, row, damage_artefact(injection, runs, path, how, random_of(injection, name))), 1
    known = readings(injection)
    kinds = sorted({reading.kind for reading in known})
    for number in range(count):
        random = random_of(injection, "damage", number)
        # every kind as often, whoever reads it
        kind = kinds[number % len(kinds)]
        some = [reading for reading in known if reading.kind == kind]
        reading = random.choices(some, [reading.weight for reading in some])[0]
        how = random.choice(DRAWS if reading.opens else [*BYTES])
        yield Case(f"damage/{kind}/{number}".replace(" ", "_"), f"damaged: {kind}", read_damaged(injection, reading, how, random)), 1

#!/usr/bin/python3
"""Event files for TensorBoard, read back by protobuf's own wire format; the checksum by its standard's examples."""
import json
import os
import struct
import subprocess
import sys
import tempfile
import time
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]
sys.path.insert(0, str(ROOT / "workflow"))
from tensorboard_events import append, crc32c
from training_so_far import COLUMNS

# RFC 3720, B.4
assert crc32c(b"123456789") == 0xE3069283 and crc32c(bytes(32)) == 0x8A9136AA


def checksum(data):
    crc = crc32c(data)
    return ((crc >> 15 | crc << 17) + 0xA282EAD8) & 0xFFFFFFFF


def records(data):
    while data:
        (length,) = struct.unpack("<Q", data[:8])
        assert struct.unpack("<I", data[8:12])[0] == checksum(data[:8])
        message, rest = data[12:12 + length], data[12 + length:]
        assert struct.unpack("<I", rest[:4])[0] == checksum(message)
        yield message
        data = rest[4:]


def number(data, at):
    value = shift = 0
    while True:
        byte = data[at]
        value, shift, at = value | (byte & 0x7F) << shift, shift + 7, at + 1
        if byte < 128:
            return value, at


def fields(data):
    """(number, value) of a message, in its order."""
    at, found = 0, []
    while at < len(data):
        key, at = number(data, at)
        if key & 7 == 0:
            value, at = number(data, at)
        else:
            length, at = number(data, at) if key & 7 == 2 else ({1: 8, 5: 4}[key & 7], at)
            value, at = data[at:at + length], at + length
            value = struct.unpack({1: "<d", 5: "<f"}[key & 7], value)[0] if key & 7 != 2 else value
        found.append((key >> 3, value))
    return found


def read(path):
    """(times, rows) of an event file; the version first."""
    first, *others = [dict(fields(message)) for message in records(path.read_bytes())]
    assert first[3] == b"brain.Event:2", first
    values = [[dict(fields(value)) for _, value in fields(event[5])] for event in others]
    return [event[1] for event in (first, *others)], [(event[2], {value[1].decode(): value[2] for value in some}) for event, some in zip(others, values)]


rows = [(0, {"loss": 0.5}), (300, {"loss": 0.25, "held_out_blend_rmse": 0.0625}), (10**9, {"loss": float("inf")})]
with tempfile.TemporaryDirectory() as folder:
    path = Path(folder, "events.out.tfevents.0.nlg")
    append(path, rows[:1], 5.0)
    append(path, rows[:1], 6.0)
    # what a kill cut short is written again
    with open(path, "ab") as file:
        file.write(path.read_bytes()[-20:-3])
    append(path, rows, 7.0)
    assert read(path) == ([5.0, 5.0, 7.0, 7.0], rows), read(path)
    # a training that began anew
    append(path, rows[1:], 8.0)
    assert read(path) == ([8.0, 8.0, 8.0], rows[1:]), read(path)

    # one at work: each row at the time when it came
    log, path = Path(folder, "log.csv"), Path(folder, "run", "events.out.tfevents.0.nlg")
    follower = subprocess.Popen(["/usr/bin/python3", ROOT / "workflow/training_so_far.py", "--follow", str(os.getpid()), "--log", log, "--run", path.parent])
    row = ",1e-3,0.5,0.25,0.125,1,0\n"
    log.write_text(f"{','.join(COLUMNS)}\n10{row}")
    os.utime(log, (1e9, 1e9))
    while not path.exists() or len(list(records(path.read_bytes()))) < 2:
        assert follower.poll() is None
        time.sleep(0.05)
    log.write_text(log.read_text() + f"20{row}")
    os.utime(log, (2e9, 2e9))
    worst = path.parent / "worst-000000020.json"
    worst.write_text(json.dumps({"step": 20, "functions": [{"function": 7, "blend_rmse": 0.1, "axis": 1, "points": [[0.5, -0.5, 1.0, 0.25]]}]}))
    follower.terminate()
    assert follower.wait() == 0
    times, found = read(path)
    assert times == [1e9, 1e9, 2e9] and [step for step, _ in found] == [10, 20] and found[1][1]["held_out_blend_rmse"] == 0.125, (times, found)
    # one whose parent was gone before it could ask
    subprocess.run(["/usr/bin/python3", ROOT / "workflow/training_so_far.py", "--follow", "1", "--log", log, "--run", path.parent], check=True, timeout=60)
    assert worst.with_suffix(".png").read_bytes().startswith(b"\x89PNG") and not worst.exists()

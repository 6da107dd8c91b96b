#!/usr/bin/python3
"""Event files for TensorBoard, read back by protobuf's own wire format; the checksum by its standard's examples."""
import struct
import sys
from pathlib import Path

sys.path.insert(0, str(Path(__file__).resolve().parents[2] / "workflow"))
from tensorboard_events import crc32c, events_of

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


rows = [(0, {"loss": 0.5}), (300, {"loss": 0.25, "held_out_blend_rmse": 0.0625}), (10**9, {"loss": float("inf")})]
first, *others = [fields(message) for message in records(events_of(rows))]
assert dict(first) == {1: 0.0, 3: b"brain.Event:2"}, first
read = []
for event in others:
    event = dict(event)
    values = [dict(fields(value)) for number_of, value in fields(event[5])]
    read.append((event[2], {value[1].decode(): value[2] for value in values}))
assert read == rows, read

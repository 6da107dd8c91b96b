"""A training's curve as a TensorBoard event file, row by row: records of a length, a checksum and a protobuf message each
(tensorflow/core/util/event.proto).

Written by hand: the three messages are a dozen lines, and TensorBoard's own package would be the one dependency that nothing else needs.
"""
import os
import struct
from pathlib import Path

TIME_BYTES = 9  # of an event: its first field

EVENT_WALL_TIME, EVENT_STEP, EVENT_VERSION, EVENT_SUMMARY = 1, 2, 3, 5
SUMMARY_VALUE, VALUE_TAG, VALUE_NUMBER = 1, 1, 2
VARINT, DOUBLE, BYTES, FLOAT = 0, 1, 2, 5  # protobuf's wire types


def crc32c(data):
    """Castagnoli's polynomial, reflected; a curve is a few kB, so that no table is needed."""
    crc = 0xFFFFFFFF
    for byte in data:
        crc ^= byte
        for _ in range(8):
            crc = crc >> 1 ^ (0x82F63B78 if crc & 1 else 0)
    return crc ^ 0xFFFFFFFF


def masked(crc):
    """As record files hold checksums: a checksum of bytes that hold checksums would be weak."""
    return ((crc >> 15 | crc << 17) + 0xA282EAD8) & 0xFFFFFFFF


def record(message):
    length = struct.pack("<Q", len(message))
    return length + struct.pack("<I", masked(crc32c(length))) + message + struct.pack("<I", masked(crc32c(message)))


def varint(value):
    low, rest = value & 0x7F, value >> 7
    return bytes([low | 0x80]) + varint(rest) if rest else bytes([low])


def field(number, kind, value):
    packed = {VARINT: varint, DOUBLE: lambda v: struct.pack("<d", v), FLOAT: lambda v: struct.pack("<f", v), BYTES: lambda v: varint(len(v)) + v}
    return varint(number << 3 | kind) + packed[kind](value)


def message_of(step, numbers):
    """An event without its time, which comes before."""
    values = [field(VALUE_TAG, BYTES, tag.encode()) + field(VALUE_NUMBER, FLOAT, number) for tag, number in numbers.items()]
    return field(EVENT_STEP, VARINT, step) + field(EVENT_SUMMARY, BYTES, b"".join(field(SUMMARY_VALUE, BYTES, value) for value in values))


def messages_in(data):
    """(message, where its record ends) of all whole records."""
    end = 0
    while len(data) >= end + 12 and len(data) >= (after := end + 16 + struct.unpack_from("<Q", data, end)[0]):
        yield data[end + 12:after - 4], after
        end = after


def append(path, rows, time_s):
    """Adds the events that the file lacks. One that holds others, of a training that began anew, is begun anew too.

    rows      (step, {tag: number}) of every row so far
    time_s    when the new ones were made, since 1970
    """
    wanted = [field(EVENT_VERSION, BYTES, b"brain.Event:2"), *(message_of(step, numbers) for step, numbers in rows)]
    data = Path(path).read_bytes() if os.path.exists(path) else b""
    found = list(messages_in(data))
    if [message[TIME_BYTES:] for message, _ in found] != wanted[:len(found)]:
        found = []
    with open(path, "r+b" if os.path.exists(path) else "xb") as file:
        # what a kill cut short goes
        file.truncate(file.seek(found[-1][1] if found else 0))
        file.write(b"".join(record(field(EVENT_WALL_TIME, DOUBLE, time_s) + message) for message in wanted[len(found):]))

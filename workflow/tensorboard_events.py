"""Scalars as a TensorBoard event file: records of a length, a checksum and a protobuf message each (tensorflow/core/util/event.proto).

Written by hand: the three messages are a dozen lines, and TensorBoard's own package would be the one dependency that nothing else needs.
"""
import struct

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


def events_of(rows):
    """The bytes of an event file.

    rows      (step, {tag: number}) of every row; the time of all of them is 0: the same curve gives the same bytes
    """
    start = field(EVENT_WALL_TIME, DOUBLE, 0.0)
    parts = [record(start + field(EVENT_VERSION, BYTES, b"brain.Event:2"))]
    for step, numbers in rows:
        values = [field(VALUE_TAG, BYTES, tag.encode()) + field(VALUE_NUMBER, FLOAT, number) for tag, number in numbers.items()]
        summary = b"".join(field(SUMMARY_VALUE, BYTES, value) for value in values)
        parts.append(record(start + field(EVENT_STEP, VARINT, step) + field(EVENT_SUMMARY, BYTES, summary)))
    return b"".join(parts)

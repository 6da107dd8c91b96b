#!/usr/bin/env python3
"""compare.py NATIVE... OTHER: what numbers.c printed on every SIMD target of this machine, and then on another machine.

Targets of one machine, and its two ways of looking light up, differ by the order in which they round, and so may another machine: its largest
difference from any of them is at most four times the largest among them. Where light comes from is the same everywhere."""
import sys

import numpy


def read(path):
    """What should be the same, in as many versions as there are: {name before the point: {whole name: numbers}}."""
    found = {}
    for line in open(path):
        name, *numbers = line.split()
        found.setdefault(name.split(".")[0], {}).setdefault(name, []).append(numpy.array(numbers, float))
    return {kind: [numpy.concatenate(parts) for parts in versions.values()] for kind, versions in found.items()}


def largest_difference(some, others):
    return max(numpy.abs(a - b).max() for a in some for b in others)


def main():
    *files, other = [read(path) for path in sys.argv[1:]]
    if len(files) < 2:
        sys.exit("compare.py: one SIMD target alone says nothing of how far two may differ")
    failed = other.keys() != files[0].keys()
    for kind in files[0]:
        native = [version for file in files for version in file[kind]]
        scale = numpy.abs(native[0]).max()
        here, there = largest_difference(native, native) / scale, largest_difference(native, other[kind]) / scale
        failed |= not (scale > 0 and there <= 4 * here)
        print(f"{kind}: {native[0].size} numbers; largest difference over the largest number {here:.1e} here, {there:.1e} there")
    sys.exit(failed)


main()

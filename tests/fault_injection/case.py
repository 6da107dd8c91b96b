"""A case of fault injection: a name, the row of the table that it counts in, and what it does in a folder of its own."""
from dataclasses import dataclass
from random import Random
from typing import Callable


@dataclass
class Case:
    name: str      # tells it from all others: part/…/number
    row: str       # of the table
    run: Callable  # (folder, faults) → words for the record, or nothing


def random_of(injection, *names):
    """Random numbers of a case's own: the same whatever ran before it, and in whichever thread."""
    return Random("/".join(map(str, (injection.seed, *names))))

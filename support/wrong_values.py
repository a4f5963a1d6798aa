"""Descriptions of photographs with a value of a wrong kind at one key."""

import copy
import datetime

from fitter import DatasetError

WRONG = ("text", "", True, 5, float("nan"), [], {}, [1, "a", 3], [[1, 2, 3], [1, 2, 3], [1, 2, 3], 5],
         [5, [1, 2], [1, 2], [1, 2], [1, 2]], [[1, 2], [1, 2], [1, 2], [1, True]], [{}], 10 ** 400,
         datetime.date(2026, 1, 1))


def keys(value, at=()):
    """The places of all values in tables, and in lists of tables, of which the first counts for all."""
    if isinstance(value, list):
        value = dict(enumerate(value[:1])) if value and isinstance(value[0], dict) else {}
    for key, within in value.items() if isinstance(value, dict) else ():
        yield (*at, key)
        yield from keys(within, (*at, key))


def refusals(read, description):
    """What a reader of descriptions says of each wrong value, by its place: a list of (place, text)."""
    said = []
    for at, made in _wrong(description):
        try:
            read(made)
        except DatasetError as error:
            said.append((at, str(error)))
    return said


def _wrong(description):
    """Each place, and the description with a wrong value there."""
    for at in keys(description):
        for value in WRONG:
            made = copy.deepcopy(description)
            table = made
            for key in at[:-1]:
                table = table[key]
            table[at[-1]] = value
            yield at, made

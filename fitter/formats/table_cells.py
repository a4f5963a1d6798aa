"""The numbers of a table, whatever sign its decimals have.

**A column proves its own decimal sign.** What follows the last sign of a number that has two kinds is its decimals; a
sign that comes twice groups thousands; so does one with never other than three digits after it, where the other sign is
proven; no thousands begin with 0. A column that proves nothing is written as the others are; where none proves
anything, a comma is a decimal sign, and the notes say so. No-break spaces and apostrophes group digits, too.
"""

import re
from array import array
from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from ..arrays import FloatArray
from .table_layout import MISSING, Layout, is_comment, split
from .text import decode, floats, line_error, lines, parse_number

_GROUPING = tuple(space.encode() for space in "\u00a0\u202f\u2009\u2019") + (b"\xa0",)      # the last in Latin-1
_DEGREE = (b"\xc2\xb0", b"\xc2\xba", b"\xb0")
_THOUSANDS = re.compile(rb"[-+]?[1-9]\d{0,2}(?:([.,])\d{3})(?:\1\d{3})*")


class Cells(NamedTuple):
    """The complete rows of a table."""

    numbers: FloatArray         # (n, columns); 0 in columns that are not read
    at: "array[int]"            # where in the content each row begins
    left_out: int               # rows with missing cells
    units: dict[int, str]       # of the columns whose numbers have the sign of degrees or of percent: "deg" or "%"
    notes: list[str]            # what was made of decimal signs, where nothing proves them


def read(content: bytes, layout: Layout, used: Sequence[int]) -> Cells:
    """Read the rows of a table, `used` of its columns."""
    count, separator, rest = len(layout.names), layout.separator, content[layout.start:]
    signs, notes = _decimal_signs(content, layout, used)
    is_plain = rest.isascii() and not any(each in rest for each in (b'"', b"'", b"%")) and len({*signs.values()}) == 1
    sign = signs[used[0]]
    numbers, at, left_out = array("d"), array("q"), 0
    units: dict[int, str] = {}
    for row in lines(content, layout.start):
        line = row[0]
        if is_comment(line):
            continue
        values = None
        if is_plain:                # quickly
            plain = line if separator == b"," else _plain(line, sign)
            if len(cells := plain.split(separator, count)) == count:
                values = floats(plain, [cells[k] for k in used])
        if values is None:          # empty cells (a first one that is white space is not there), signs, or a mistake
            cells = split(line, separator)
            if len(cells) > count:
                raise line_error(row, f"more than {count} cells found, expected one for each name")
            chosen = [cells[k] if k < len(cells) else b"" for k in used]
            if (len(cells) < count and separator is None) or not MISSING.isdisjoint(cell.lower() for cell in chosen):
                left_out += 1
                continue
            for column, cell in zip(used, chosen, strict=True):
                if cell.endswith(b"%"):
                    units[column] = "%"
                elif cell.endswith(_DEGREE):
                    units.setdefault(column, "deg")
            values = [parse_number(_plain(_bare(cell), signs[column]), row)
                      for column, cell in zip(used, chosen, strict=True)]
        numbers.extend(values)
        at.append(row.start())
    whole = np.zeros((len(at), count))
    whole[:, used] = np.frombuffer(numbers).reshape(-1, len(used))
    return Cells(whole, at, left_out, units, notes)


def _bare(cell: bytes) -> bytes:
    """A number without the sign of degrees or percent, and without what groups its digits."""
    cell = cell.removesuffix(b"%")
    if not cell.isascii():
        for sign in (*_DEGREE, *_GROUPING):
            cell = cell.removesuffix(sign) if sign in _DEGREE else cell.replace(sign, b"")
    return cell.replace(b"'", b"").strip()


def _plain(cell: bytes, sign: bytes) -> bytes:
    """A number as `float` reads it: with a point, and without groups."""
    return cell.replace(b".", b"").replace(b",", b".") if sign == b"," else cell.replace(b",", b"")


def _decimal_signs(content: bytes, layout: Layout, used: Sequence[int]) -> tuple[dict[int, bytes], list[str]]:
    """The decimal sign of each column, and notes on those that prove nothing."""
    rest, proven, is_open = content[layout.start:], dict.fromkeys(used, b""), dict.fromkeys(used, b"")
    if b"," not in rest or (layout.separator == b"," and b'"' not in rest):
        return dict.fromkeys(used, b"."), []
    known = 0
    for row in lines(content, layout.start):
        line = row[0]
        # of a comma in each column that has proven them, there is nothing more to learn
        if is_comment(line) or (b"." not in line and layout.separator != b"," and line.count(b",") == known):
            continue
        cells = split(line, layout.separator)
        for k in used:
            sign, is_proof = _sign(_bare(cells[k])) if k < len(cells) else (b"", False)
            if not is_proof:
                is_open[k] = is_open[k] or (_bare(cells[k]) if sign else b"")
            elif sign != (proven[k] or sign):
                raise line_error(row, f"'{decode(cells[k])[:24]}' found in the column {layout.names[k][:24]!r}, whose "
                                 "numbers above have another decimal sign")
            else:
                proven[k] = sign
        known = sum(sign == b"," for sign in proven.values())
    found = {sign for sign in proven.values() if sign}
    common = found.pop() if len(found) == 1 else b""
    guessed = {k: cell for k, cell in is_open.items() if b"," in cell and not (proven[k] or common)}
    return ({k: proven[k] or common or (b"," if k in guessed else b".") for k in used},
            [f"{layout.names[k]}: {decode(cell)} is read as {decode(_plain(cell, b','))}, since no number proves the "
             "comma to group thousands" for k, cell in guessed.items()])


def _sign(cell: bytes) -> tuple[bytes, bool]:
    """The decimal sign that a number has, and whether it proves it: one before three digits may group thousands."""
    commas, points = cell.count(b","), cell.count(b".")
    if commas and points:
        return (b"," if cell.rindex(b",") > cell.rindex(b".") else b"."), True
    if max(commas, points) > 1:
        return (b"." if commas else b","), True
    return (b"," if commas else b"." if points else b""), bool(commas or points) and not _THOUSANDS.fullmatch(cell)

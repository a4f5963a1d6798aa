"""The numbers of a table, whatever sign its decimals have.

**A column proves its own decimal sign.** What follows the last sign of a number, where it has two kinds, is its
decimals; a sign that comes twice groups thousands; so does one after which there are never other than three digits,
where the other sign is proven. 987.5 beside 1,234 is a thousand and more; 0,5 and 1,234 are decimals, since no
thousands begin with 0. A column that proves nothing is written as the other columns are; where none proves anything, a
comma is a decimal sign, and the notes say so. A column that proves both is refused.

No-break spaces and apostrophes group digits, too. The signs of degrees and of percent may follow a number.
"""

import re
from array import array
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from ..arrays import FloatArray
from ..errors import DatasetError
from .table_layout import MISSING, Layout, is_comment, split
from .text import decode, floats, line_number, lines, parse_number

_GROUPING = tuple(space.encode() for space in "\u00a0\u202f\u2009\u2019") + (b"\xa0",)      # the last in Latin-1
_DEGREE = (b"\xc2\xb0", b"\xc2\xba", b"\xb0")
_COMMA, _POINT = 1, 2       # a decimal sign that is proven
_THOUSANDS = re.compile(rb"[-+]?[1-9]\d{0,2}(?:([.,])\d{3})(?:\1\d{3})*")


@dataclass(frozen=True)
class Cells:
    """The complete rows of a table.

    Attributes
    ----------
    numbers : (n, columns) float64
        Of the columns that are read.
    at : array of int
        Where in the content each row begins.
    left_out : int
        Rows with missing cells.
    in_degrees, in_percent : set of int
        The columns, counted among those that are read, whose numbers have the sign of degrees, or of percent.
    notes : list of str
        What was made of the decimal signs, where they prove nothing.
    """

    numbers: FloatArray
    at: "array[int]"
    left_out: int
    in_degrees: set[int]
    in_percent: set[int]
    notes: list[str]


class _Column:
    """What the numbers of a column prove."""

    def __init__(self) -> None:
        self.proven, self.is_open = 0, b""

    def see(self, cell: bytes) -> None:
        """Take a number into account that has a comma, or a point."""
        commas, points = cell.count(b","), cell.count(b".")
        if not commas and not points:
            return
        if commas and points:
            self.proven |= _COMMA if cell.rindex(b",") > cell.rindex(b".") else _POINT
        elif commas > 1 or points > 1:
            self.proven |= _POINT if commas else _COMMA
        elif _THOUSANDS.fullmatch(cell):
            self.is_open = self.is_open or cell
        else:
            self.proven |= _COMMA if commas else _POINT


def read(content: bytes, layout: Layout, used: Sequence[int], path: str | Path) -> Cells:
    """Read the rows of a table.

    Raises DatasetError if a cell is no number, if a row has more cells than there are names, or if the decimal signs of
    a column contradict each other.

    Parameters
    ----------
    used : sequence of int
        The columns that are read.
    """
    count, separator = len(layout.names), layout.separator
    odd = _has_odd_numbers(content, layout)
    signs, notes = _decimal_signs(content, layout, used, path) if odd else ([_POINT] * count, [])
    numbers, at, left_out = array("d"), array("q"), 0
    in_degrees: set[int] = set()
    in_percent: set[int] = set()
    every = list(used) == list(range(count))
    alike = _alike(content, layout, signs) if odd else _POINT
    for row in lines(content, layout.start):
        line = row[0]
        if is_comment(line):
            continue
        values = None
        if alike and not (odd and alike == _COMMA and b"." in line):        # quickly
            plain = _plain(line, alike) if odd else line
            cells = plain.split(separator, count)
            if len(cells) == count:
                values = floats(plain, cells if every else [cells[k] for k in used])
        if values is None:          # empty cells (a first one that is white space is not there), signs, or a mistake
            cells = split(line, separator)
            if len(cells) > count:
                raise DatasetError(f"more than {count} cells found, expected one for each name", path,
                                   line_number(content, row.start()))
            chosen = [cells[k] if k < len(cells) else b"" for k in used]
            if (len(cells) < count and separator is None) or not MISSING.isdisjoint(cell.lower() for cell in chosen):
                left_out += 1
                continue
            values = []
            for k, (column, cell) in enumerate(zip(used, chosen, strict=True)):
                bare = _bare(cell)
                if bare != cell:
                    ending = cell.rstrip()
                    if ending.endswith(_DEGREE):
                        in_degrees.add(k)
                    elif ending.endswith(b"%"):
                        in_percent.add(k)
                values.append(parse_number(_plain(bare, signs[column]), path, content, row.start()))
        numbers.extend(values)
        at.append(row.start())
    return Cells(np.frombuffer(numbers).reshape(-1, len(used)), at, left_out, in_degrees, in_percent, notes)


def _alike(content: bytes, layout: Layout, signs: list[int]) -> int:
    """The decimal sign of all columns of a table without other signs; 0 of any other table."""
    rest = content[layout.start:]
    is_plain = rest.isascii() and not any(sign in rest for sign in (b'"', b"'", b"%"))
    return signs[0] if is_plain and layout.separator != b"," and len({*signs}) == 1 else 0


def _has_odd_numbers(content: bytes, layout: Layout) -> bool:
    """Whether numbers may have commas, or other signs that `float` does not read."""
    rest = content[layout.start:]
    return (not rest.isascii() or b'"' in rest or b"'" in rest or b"%" in rest
            or (layout.separator != b"," and b"," in rest))


def _bare(cell: bytes) -> bytes:
    """A number without the sign of degrees or percent, and without what groups its digits."""
    cell = cell.removesuffix(b"%")
    if not cell.isascii():
        for sign in _DEGREE:
            cell = cell.removesuffix(sign)
        for space in _GROUPING:
            cell = cell.replace(space, b"")
    return cell.replace(b"'", b"").strip()


def _plain(cell: bytes, sign: int) -> bytes:
    """A number as `float` reads it: with a point, and without groups."""
    return cell.replace(b".", b"").replace(b",", b".") if sign == _COMMA else cell.replace(b",", b"")


def _decimal_signs(content: bytes, layout: Layout, used: Sequence[int],
                   path: str | Path) -> tuple[list[int], list[str]]:
    """The decimal sign of each column, and notes on those that prove nothing."""
    columns, known = [_Column() for _ in layout.names], 0
    for row in lines(content, layout.start):
        line = row[0]
        # of a comma in each column that has proven them, there is nothing more to learn
        if is_comment(line) or (b"." not in line and layout.separator != b"," and line.count(b",") == known):
            continue
        cells = split(line, layout.separator)
        for k in used:
            if k < len(cells):
                column = columns[k]
                column.see(_bare(cells[k]))
                if column.proven == _COMMA | _POINT:
                    raise DatasetError(f"'{decode(cells[k])[:24]}' found in the column {layout.names[k][:24]!r}, whose "
                                       "numbers above have another decimal sign", path,
                                       line_number(content, row.start()))
        known = sum(column.proven == _COMMA for column in columns)
    proven = {column.proven for column in columns if column.proven}
    common = proven.pop() if len(proven) == 1 else 0
    signs, notes = [], []
    for name, column in zip(layout.names, columns, strict=True):
        sign = column.proven or common
        if not sign:
            sign = _COMMA if b"," in column.is_open else _POINT
            if column.is_open and sign == _COMMA:
                notes.append(f"{name}: {decode(column.is_open)} is read as {decode(_plain(column.is_open, sign))}, "
                             "since no number proves the comma to group thousands")
        signs.append(sign)
    return signs, notes

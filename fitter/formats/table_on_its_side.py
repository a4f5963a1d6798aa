"""A table that lies on its side, as instruments' spreadsheets have it: a line for each name, a column for each
measurement. The second cell of the lines may be a unit. Where the names come again, further lines have further
measurements. Lines of text are columns of text, and lines before the table are its titles.
"""

from itertools import islice

from . import names
from .table_layout import LONGEST, MOST_COLUMNS, SEPARATORS, find, is_cell, is_comment, is_number, split
from .text import decode, lines

_BEGIN_NUMBERS = b"0123456789.+-"
_MOST_LINES = 1000          # before a line of angles


def transpose_table(content: bytes) -> tuple[bytes, int] | None:
    r"""A table that lies on its side, upright, and the line of its names, from 1; None of what is none. Each line below
    is a measurement, or the units.

    Examples
    --------
    >>> transpose_table(b"a scan\nIncidence,10,10\nReceive,0,10\nBRDF,.31,.32\n")
    (b'a scan\nIncidence\tReceive\tBRDF\n10\t0\t.31\n10\t10\t.32\n', 2)
    """
    first = [line[0] for line in islice(lines(content), _MOST_LINES) if line[0][:1] not in _BEGIN_NUMBERS]
    for separator in SEPARATORS[:-1]:       # a colon is in times
        if any(_is_of_angles(_cells(line, separator)) for line in first):
            return _transpose_lines([line[0] for line in lines(content)], separator)
    return None


def _cells(line: bytes, separator: bytes) -> list[bytes]:
    return split(line, separator) if separator in line and len(line) <= LONGEST and not is_comment(line) else []


def _is_of_angles(cells: list[bytes]) -> bool:
    """Whether a line has the polar angles of two measurements or more."""
    if not 3 <= len(cells) <= MOST_COLUMNS or names.role(decode(cells[0])) not in ("theta_i", "theta_s", names.THETA):
        return False
    numbers = cells[2 if names.find_unit(decode(cells[1])) else 1:]
    return all(map(is_cell, numbers)) and sum(map(is_number, numbers)) > 1


def _transpose_lines(every: list[bytes], separator: bytes) -> tuple[bytes, int] | None:
    """The table of the lines that have as many cells as those of angles or fewer, and two after the name or more."""
    count = max(len(cells) for line in every if _is_of_angles(cells := _cells(line, separator)))
    titles: list[bytes] = []
    blocks: list[dict[bytes, list[bytes]]] = [{}]
    for line in every:
        cells = _cells(line, separator)
        if not 3 <= len(cells) <= count or is_number(cells[0]):
            titles += [] if blocks[0] else [line]
        elif cells[0]:
            if cells[0] in blocks[-1]:
                blocks.append({})
            blocks[-1][cells[0]] = [*cells[1:], *[b""] * (count - len(cells))]
    heads = list(blocks[0])
    if any(block.keys() != blocks[0].keys() for block in blocks):
        return None
    has_units = any(names.find_unit(decode(cells[0])) for cells in blocks[0].values())
    rows = [b"\t".join(row) for number, block in enumerate(blocks)
            for row in islice(zip(*map(block.__getitem__, heads), strict=True), int(has_units and number > 0), None)]
    made = b"".join(line + b"\n" for line in (*titles, b"\t".join(heads), *rows))
    return None if find(made) is None else (made, len(titles) + 1)

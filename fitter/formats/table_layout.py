"""How a table is laid out: what separates its cells, which line has the names of the columns, and where rows begin.

Before the names there may be comments, title lines, and Excel's line ``sep=;``; after them a line of units. What
`Reading.columns` says stands for the line of names.
"""

import csv
import re
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from itertools import islice

from . import names
from .text import decode, floats, line_number, lines

MOST_COLUMNS = 1000
SKIPPED = "-"               # in the place of a name: a column that is not read
LONGEST = 1 << 16           # bytes of a line of names, or of numbers
_MOST_TITLES = 100          # lines before the names
_SOME = 20                  # rows by which a column of text is told
_PREVIEWED = 4              # rows
SEPARATORS = b"\t", b";", b",", b"|", b":"
_SAID = re.compile(rb"\"?sep=([^\w\r\n])\"?[ \t]*\Z")
_QUOTED = re.compile(rb"\"[^\"]*\"")
_POLAR = re.compile(rb"theta|zenith|polar|angle|incidence|\b(?:ao[ieorsv]|[siov]za)\b|"
                    rb"\xce\xb8|\xce\x98|\xcf\x91|\xcf\xb4", re.IGNORECASE)      # the last ones: theta in UTF-8
_ERRORS = (b"#n/a", b"#div/0!", b"#value!", b"#ref!", b"#name?", b"#num!", b"#null!", b"#spill!", b"#calc!")
MISSING = frozenset((b"", b"na", b"n/a", b"nan", b"null", b"none", b"-", b"--", b"*", b"nan(ind)", b"-nan",
                     b"-nan(ind)", b"1.#qnan", b"-1.#ind", b"1.#inf", *_ERRORS))
_WIDE = b"  "               # two blanks or more: names may have single ones
_BLANKS = re.compile(rb"\s{2,}")


@dataclass(frozen=True)
class Layout:
    """How a table is laid out."""

    names: list[str]                # of the columns
    units: list[str | None]         # as `find_unit` has them; None where neither name nor line of units says one
    separator: bytes | None         # None: blanks
    titles: int                     # where the part of the content before the names ends
    start: int                      # where in the content the rows begin
    line: int                       # of the names, or of the first row where `Reading.columns` names them
    texts: tuple[str, ...] = ()     # names that mean nothing here, of columns of text: in `names` they are `SKIPPED`


def is_comment(line: bytes) -> bool:
    """Whether a line is a comment: it begins with #, and not with an error of Excel."""
    return line.startswith(b"#") and not line[:8].lower().startswith(_ERRORS)


def find(content: bytes, columns: str | None = None) -> Layout | None:
    """The layout of a table; None for what is none. `columns` names them, separated by commas, whatever the table calls
    them.
    """
    if columns is not None:
        return _layout_of_names(content, split(columns.encode(), b","))
    first, fallback = -1, None
    for line, separator, cells in _attempts(content):
        if line[0].startswith(b"VARS"):
            break
        first = line.start() if first < 0 else first
        if not _POLAR.search(line[0]) or not _are_names(cells):
            continue
        layout = _layout(content, line, cells, separator)
        if _has_rows(content, layout):
            return layout
        if line.start() == first and fallback is None:      # a table without rows, or with damaged ones
            fallback = layout
    return fallback


def _attempts(content: bytes, every: bool = False) -> Iterator[tuple[re.Match[bytes], bytes | None, list[bytes]]]:
    """The first lines, each with what may separate its cells, and these; what Excel says separates them all. `every`
    separator that a line has, or the first ones."""
    said = None
    for line in islice(_lines(content), _MOST_TITLES + 1):
        if said is None and (found := _SAID.match(line[0])):
            said = found[1]
            continue
        if len(line[0]) > LONGEST:
            return
        every_one = [*(each for each in SEPARATORS if each in line[0]), None]
        for separator in [said] if said else every_one if every else _candidates(line[0]):
            yield line, separator, split(line[0], separator)


def preview(content: bytes) -> tuple[list[str] | None, list[list[str]]] | None:
    r"""The first rows of numbers of a text, and the cells of the line before them where it has as many; None where
    there are no rows.

    Examples
    --------
    >>> preview(b"a scan\nalpha;beta\n1;2\n3;4,5\n")
    (['alpha', 'beta'], [['1', '2'], ['3', '4,5']])
    """
    for line, separator, cells in _attempts(content):
        if 1 < len(cells) <= MOST_COLUMNS and all(map(is_cell, cells)):
            rows = [[*map(decode, split(row[0][:LONGEST], separator))]
                    for row in islice(_lines(content, line.start()), _PREVIEWED)]
            *_, before = b"", *(each[0] for each in _lines(content[:line.start()]))
            heads = ([*map(decode, split(before, each))] for each in ([separator] if separator else [_WIDE, None]))
            return next((names for names in heads if len(names) == len(rows[0])), None), rows
    return None


def split(line: bytes, separator: bytes | None) -> list[bytes]:
    """The cells of a line, without quotes; empty ones at its end, as spreadsheets leave them, do not count.

    A separator within quotes belongs to its cell.
    """
    if separator == _WIDE:
        cells = _BLANKS.split(line.strip(), MOST_COLUMNS + 1)
    elif b'"' in line and separator is not None:
        text = line.decode("latin-1")
        try:
            cells = [cell.encode("latin-1") for cell in next(csv.reader(
                [text], delimiter=separator.decode("latin-1"), skipinitialspace=True))[:MOST_COLUMNS + 2]]
        except (csv.Error, StopIteration):
            cells = line.split(separator, MOST_COLUMNS + 1)
    else:
        cells = line.split(separator, MOST_COLUMNS + 1)
    cells = [cell.strip().strip(b"\"'").strip() for cell in cells]
    while cells and not cells[-1]:
        cells.pop()
    return cells


def _lines(content: bytes, start: int = 0) -> Iterator[re.Match[bytes]]:
    return (line for line in lines(content, start) if not is_comment(line[0]))


def _candidates(line: bytes) -> Sequence[bytes | None]:
    """What may separate the cells of a line."""
    bare = _QUOTED.sub(b"", line.strip())
    found = [each for each in SEPARATORS if each in bare]
    return [*found[:1], *(() if found else (None, _WIDE))]


def _are_names(cells: list[bytes]) -> bool:
    """Whether cells name a polar angle, and two other columns, or one and values."""
    if not 2 <= len(cells) <= MOST_COLUMNS + 1:
        return False
    shown = [decode(cell) for cell in cells[:MOST_COLUMNS]]
    roles = [names.role(name) for name in shown]
    if not any(role in ("theta_i", "theta_s", names.THETA) for role in roles) or any(map(is_number, cells[:1])):
        return False
    return len(cells) > 2 or (not is_number(cells[1]) and any(names.value(name) is not None for name in shown))


def _has_rows(content: bytes, layout: Layout) -> bool:
    """Whether a row follows: of as many cells as there are names, or fewer where empty ones may be left out at its end;
    two of them are numbers."""
    row = next(_lines(content, layout.start), None)
    cells = [] if row is None else split(row[0][:LONGEST], layout.separator)
    fits = len(cells) == len(layout.names) if layout.separator is None else 0 < len(cells) <= len(layout.names)
    return fits and sum(map(is_number, cells)) >= 2


def _are_units(cells: list[bytes]) -> bool:
    """Whether cells are units, or empty."""
    found = [names.find_unit(decode(cell)) for cell in cells]
    return None not in found and any(found) and not any(map(is_number, cells))


def _layout(content: bytes, line: re.Match[bytes], cells: list[bytes], separator: bytes | None) -> Layout:
    shown = [decode(cell).replace("\u00a0", " ") for cell in cells]
    units = [names.parse(name).unit for name in shown]
    separator = None if separator == _WIDE else separator
    start = line.end()
    following = next(_lines(content, start), None)
    if following is not None and len(following[0]) <= LONGEST:
        below = split(following[0], separator)
        if len(below) <= len(units) and _are_units(below):
            units = [unit or names.find_unit(decode(under)) or None
                     for unit, under in zip(units, below + [b""] * len(units), strict=False)]
            start = following.end()
    rows = [split(line[0][:LONGEST], separator) for line in islice(_lines(content, start), _SOME)] if separator else []
    texts = [k for k, name in enumerate(shown) if name not in ("", SKIPPED) and names.role(name) is None
             and names.value(name) is None and _is_text([row[k] for row in rows if k < len(row)])]
    return Layout([SKIPPED if k in texts else name for k, name in enumerate(shown)], units, separator,
                  line.start(), start, line_number(line), tuple(shown[k] for k in texts))


def _is_text(cells: list[bytes]) -> bool:
    """Whether cells of a column are text, and none is a number."""
    return not any(map(is_number, cells)) and not all(map(is_cell, cells))


def _layout_of_names(content: bytes, cells: list[bytes]) -> Layout | None:
    """The layout of a table whose columns a user has named: rows begin where there is one for these names."""
    shown = [decode(cell) for cell in cells]
    used = [k for k, name in enumerate(shown) if name not in ("", SKIPPED)]
    for line, separator, row in _attempts(content, every=True):
        if len(row) > max(used, default=MOST_COLUMNS) and all(is_cell(row[k]) for k in used) and any(
                is_number(row[k]) for k in used):
            shown += [SKIPPED] * (len(row) - len(shown))
            return Layout(shown, [names.parse(name).unit for name in shown], separator, line.start(),
                          line.start(), line_number(line))
    return None


def is_number(cell: bytes) -> bool:
    """Whether a cell is a number, however its decimals are written, with or without the sign of degrees or percent."""
    bare = cell.replace(b",", b".")
    for sign in (b"\xc2\xb0", b"\xb0", b"%"):
        bare = bare.removesuffix(sign).strip()
    if bare.count(b".") > 1:
        bare = bare.replace(b".", b"")
    return floats(bare, [bare]) is not None


def is_cell(cell: bytes) -> bool:
    """Whether a cell is a number, or one that is missing."""
    return cell.lower() in MISSING or is_number(cell)

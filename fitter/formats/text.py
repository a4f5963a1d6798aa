"""Reading numbers from text files, with errors that say where they are.

Content stays bytes, is gone through in pieces of about 64 kB, and the numbers go into one array of doubles: so neither
time nor memory can be driven far beyond those of an honest file of the same size.
"""

import math
import re
import sys
from array import array
from bisect import bisect_right
from itertools import islice
from pathlib import Path

import numpy as np

from .. import files
from ..errors import DatasetError
from ..samples import HORIZON
from .format import LARGEST_TEXT

_PIECE = rb"(?s:.{0,65535})"
_LINE = re.compile(rb"\S[^\r\n]*")
_LINES = re.compile(rb"\S%b[^\r\n]*" % _PIECE)
_TOKENS = re.compile(rb"\S%b\S*" % _PIECE)
_COMMENT = re.compile(rb"#[^\r\n]*")
_COMMENT_OR_TOKEN = re.compile(rb"#[^\r\n]*|[^\s#]+")


def read_bytes(path: str | Path, largest: int = LARGEST_TEXT) -> bytes:
    """The content of a file of measurements, which has at most `largest` bytes and is not blank."""
    content = files.read_bytes(path, largest)
    if not content.strip():
        raise DatasetError("empty, expected measurements", path)
    return content


def plain_text(content, path):
    """Content without a byte-order mark, if it can be text of one byte a character."""
    if b"\0" in content:
        raise DatasetError("binary (or UTF-16) content, expected plain text", path)
    return content.removeprefix(b"\xef\xbb\xbf")


def decode(text):
    """Words of a file, which may be in UTF-8 or, as an old one, in Latin-1."""
    try:
        return text.decode()
    except UnicodeDecodeError:
        return text.decode("latin-1")


def lines(content, start=0):
    """The lines that are not blank, whatever their ends: matches, stripped of leading white space."""
    return _LINE.finditer(content, start)


def line_number(content, position):
    """The number of the line, from 1, that holds a position."""
    ends = sum(content.count(end, 0, position) for end in (b"\n", b"\r"))
    return 1 + ends - content.count(b"\r\n", 0, position)


def parse_rows(content, start, count, what, path):
    """The lines from `start` on as rows of `count` numbers, separated by commas; `what` says what they are.

    Returns
    -------
    (rows, count) float64
    """
    values = array("d")
    for piece in _LINES.finditer(content, start):
        rows = [line for line in piece[0].splitlines() if line.strip()]
        regular = all(line.count(b",") == count - 1 for line in rows)
        numbers = _floats(piece[0], b",".join(rows).split(b",")) if regular else None
        if numbers is None:
            numbers = [number for line in lines(piece[0])
                       for number in parse_row(line[0], b",", count, what, path, content, piece.start() + line.start())]
        values.extend(numbers)
    return np.frombuffer(values).reshape(-1, count)


def parse_row(line, separator, count, what, path, content, position):
    """A line of `count` numbers, which stands at `position` in the content."""
    tokens = line.split(separator, count)
    if len(tokens) != count:
        found = f"{len(tokens)}" if len(tokens) < count else f"more than {count}"
        raise DatasetError(f"{found} entries found, expected {count}: {what}", path, line_number(content, position))
    numbers = _floats(line, tokens)
    if numbers is None:
        numbers = [parse_number(token, path, content, position) for token in tokens]
    return numbers


def nth_line(content, start, row):
    """The number of the line that holds a row of `parse_rows`."""
    return line_number(content, next(islice(lines(content, start), row, None)).start())


def parse_numbers(content, path):
    """All numbers of a text with comments, separated by white space.

    Returns
    -------
    numbers : (n,) float64
    line : callable
        The number of the line that holds the k-th of them.
    """
    values, counts, starts = array("d"), [], []
    for piece in _LINES.finditer(content):
        counts.append(len(values))
        starts.append(piece.start())
        text = _COMMENT.sub(b"", piece[0]) if b"#" in piece[0] else piece[0]
        for some in _TOKENS.finditer(text):
            numbers = _floats(some[0], some[0].split())
            if numbers is None:
                for token in _tokens(content, *piece.span()):
                    parse_number(token[0], path, content, token.start())
            values.extend(numbers)

    def line(index):
        piece = bisect_right(counts, index) - 1
        return line_number(content, next(islice(_tokens(content, starts[piece]), index - counts[piece], None)).start())

    return np.frombuffer(values), line


def _tokens(content, start, end=sys.maxsize):
    return (found for found in _COMMENT_OR_TOKEN.finditer(content, start, end) if not found[0].startswith(b"#"))


def parse_number(token, path, content=b"", position=None):
    """A finite number, which stands at `position` in the content."""
    try:
        if b"_" in token:
            raise ValueError
        number = float(token)
        if math.isfinite(number):
            return number
        expected = "a finite number"
    except ValueError:
        expected = "a number"
    line = None if position is None else line_number(content, position)
    raise DatasetError(f"{_quote(token)} found, expected {expected}", path, line)


def check_thetas(thetas, line, path):
    """Complain about the first row with a polar angle outside 0 to pi/2.

    Parameters
    ----------
    thetas : (n, k) array
    line : callable
        The number of the line that holds a row, or None.
    """
    bad = np.argwhere((thetas < 0) | (thetas > HORIZON + 1e-5))
    if len(bad):
        row, column = bad[0]
        raise DatasetError(f"a polar angle of {thetas[row, column]:g} found, expected 0 to pi/2 radians", path,
                           line(row))


def _floats(text, tokens):
    """The numbers of a piece of text, or None where `parse_number` must have a closer look at its tokens."""
    if b"_" in text:            # float() would read 1_000
        return None
    try:
        numbers = list(map(float, tokens))
    except ValueError:
        return None
    return numbers if all(map(math.isfinite, numbers)) else None


def _quote(token):
    shown = decode(token if len(token) <= 24 else token[:21] + b"...")
    return f"'{shown}'" if shown.isprintable() else ascii(shown)

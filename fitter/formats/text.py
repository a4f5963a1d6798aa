"""Parsing numbers in text files, with errors that name the line.

The content stays bytes, and is parsed in lines, or in pieces of about 64 kB, into one array of doubles: a hostile file
takes hardly more time and memory than a valid one of the same size.
"""

import math
import re
import sys
from array import array
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from itertools import islice
from pathlib import Path

import numpy as np

from ..arrays import FloatArray
from ..errors import DatasetError
from ..samples import HORIZON, LARGEST_AZIMUTH
from ..storage import files
from .format import LARGEST_TEXT

_BEGINNING = 400            # bytes by which UTF-16 without a byte-order mark is told: they are in ASCII
_PRINTED = frozenset(b"\t\r\n" + bytes(range(0x20, 0x7f)))
_LINE_PATTERN = re.compile(rb"\S[^\r\n]*")
_TOKENS = re.compile(rb"\S(?s:.{0,65535})\S*")
_COMMENT = re.compile(rb"#[^\r\n]*")
_TOKEN = re.compile(rb"\S+")


def read_bytes(path: str | Path, largest: int = LARGEST_TEXT) -> bytes:
    """Read a file of measurements; `DatasetError` if it is blank or has more than `largest` bytes."""
    content = files.read_bytes(path, largest)
    if not content.strip():
        raise DatasetError("empty, expected measurements", path)
    return content


@contextmanager
def name_file(path: str | Path) -> Iterator[None]:
    """Errors that name no file are of this one."""
    try:
        yield
    except DatasetError as error:
        if error.path is not None:
            raise
        raise type(error)(str(error), path, error.line) from error


def is_plain(content: bytes) -> bool:
    """Whether content is text: without zero bytes, but for those of UTF-16."""
    return b"\0" not in content or _utf_16(content) is not None


def plain_text(content: bytes) -> bytes:
    """Text in UTF-8, or as it is, without a byte-order mark; `DatasetError` if the content is binary."""
    if (encoding := _utf_16(content)) is not None:
        try:
            content = content.decode(encoding).encode()
        except UnicodeDecodeError as error:
            raise DatasetError(f"damaged text in UTF-16 ({error.reason})") from None
    if b"\0" in content:
        raise DatasetError("binary content, expected plain text")
    return content.removeprefix(b"\xef\xbb\xbf")


def _utf_16(content: bytes) -> str | None:
    """The encoding of content in UTF-16, with or without a byte-order mark; None of any other."""
    if content.startswith((b"\xff\xfe\0\0", b"\0\0\xfe\xff")):
        return None             # UTF-32
    if content.startswith((b"\xff\xfe", b"\xfe\xff")):
        return "utf-16"
    beginning = content[:_BEGINNING]
    for encoding, zeros, others in (("utf-16-le", beginning[1::2], beginning[::2]),
                                    ("utf-16-be", beginning[::2], beginning[1::2])):
        if len(zeros) > 3 and not any(zeros) and all(byte in _PRINTED for byte in others):
            return encoding
    return None


def decode(text: bytes) -> str:
    """Decode text in UTF-8 or, as old files have it, in Latin-1."""
    try:
        return text.decode()
    except UnicodeDecodeError:
        return text.decode("latin-1")


def lines(content: bytes, start: int = 0, end: int = sys.maxsize) -> Iterator[re.Match[bytes]]:
    """Matches of the lines that are not blank, without leading white space. Lines end with CR, LF or both."""
    return _LINE_PATTERN.finditer(content, start, end)


def line_number(match: re.Match[bytes]) -> int:
    """The number, from 1, of the line of the content in which a match begins."""
    content, position = match.string, match.start()
    ends = sum(content.count(end, 0, position) for end in (b"\n", b"\r"))
    return 1 + ends - content.count(b"\r\n", 0, position)


def line_error(match: re.Match[bytes], message: str) -> DatasetError:
    """An error of the line in which a match begins; `formats.load` names the file."""
    return DatasetError(message, line=line_number(match))


def parse_rows(content: bytes, start: int, count: int, what: str, separator: bytes | None = b",",
               end: int = sys.maxsize) -> FloatArray:
    """Parse the lines of `count` numbers from the position `start` to `end`, which a character separates, or None:
    white space: (rows, count) float64. Errors say `what` they are.
    """
    values = array("d")
    for line in lines(content, start, end):
        values.extend(parse_row(line, separator, count, what))
    return np.frombuffer(values).reshape(-1, count)


def parse_row(line: re.Match[bytes], separator: bytes | None, count: int, what: str) -> list[float]:
    """Parse one line of `count` numbers."""
    tokens = line[0].split(separator, count)
    if len(tokens) != count:
        shown = f"{len(tokens)}" if len(tokens) < count else f"more than {count}"
        raise line_error(line, f"{shown} entries found, expected {count}: {what}")
    return floats(line[0], tokens) or [parse_number(token, line) for token in tokens]


def parse_numbers(content: bytes) -> tuple[FloatArray, Callable[[int], int]]:
    """Parse all numbers of a text with comments, which are separated by white space: (n,), and a function from the
    index of a number to its line.
    """
    text = _COMMENT.sub(b"", content)        # the lines stay
    values = array("d")
    for piece in _TOKENS.finditer(text):
        numbers = floats(piece[0], piece[0].split())
        if numbers is None:         # parse_number raises at the token that is wrong
            numbers = [parse_number(token[0], token) for token in _TOKEN.finditer(text, *piece.span())]
        values.extend(numbers)
    return np.frombuffer(values), lambda index: line_number(next(islice(_TOKEN.finditer(text), index, None)))


def parse_number(token: bytes, at: re.Match[bytes] | None = None) -> float:
    """Parse a finite number; `at` is where it was found, for the error."""
    try:
        if b"_" in token:
            raise ValueError
        number = float(token)
        if math.isfinite(number):
            return number
        expected = "a finite number"
    except ValueError:
        expected = "a number"
    message = f"{_quote(token)} found, expected {expected}"
    raise DatasetError(message) if at is None else line_error(at, message)


def check_angles(angles: FloatArray, line: Callable[[int], int], in_degrees: bool = False,
                 signed: bool = False) -> None:
    """Raise `DatasetError` for the first row of `names.ANGLES`, (n, 4) radians or degrees, with a polar angle outside 0
    to pi/2, or with an azimuth beyond `LARGEST_AZIMUTH`, which is no angle.

    Polar angles may be `signed`; `line` maps a row to its line number.
    """
    check_thetas(np.abs(angles[:, [0, 2]]) if signed else angles[:, [0, 2]], line, in_degrees)
    phis = angles[:, [1, 3]]
    bad = np.argwhere(np.abs(phis) > LARGEST_AZIMUTH)
    if len(bad):
        row, column = bad[0]
        raise DatasetError(f"an azimuth of {phis[row, column]:g} found, expected at most {LARGEST_AZIMUTH:,.0f}",
                           line=line(row))


def check_thetas(thetas: FloatArray, line: Callable[[int], int], in_degrees: bool = False) -> None:
    """`check_angles` of polar angles alone, (n, k)."""
    most, expected = (90 + 5e-4, "90 degrees") if in_degrees else (HORIZON + 1e-5, "pi/2 radians")
    bad = np.argwhere((thetas < 0) | (thetas > most))
    if len(bad):
        row, column = bad[0]
        raise DatasetError(f"a polar angle of {thetas[row, column]:g} found, expected 0 to {expected}", line=line(row))


def floats(text: bytes, tokens: Sequence[bytes]) -> list[float] | None:
    """The numbers of a piece of text, or None if a token is not a finite number; quicker than `parse_number`."""
    if b"_" in text:            # float() would read 1_000
        return None
    try:
        numbers = list(map(float, tokens))
    except ValueError:
        return None
    return numbers if all(map(math.isfinite, numbers)) else None


def _quote(token: bytes) -> str:
    """A token in quotes for a message, shortened, without control characters."""
    shown = decode(token if len(token) <= 24 else token[:21] + b"...")
    return f"'{shown}'" if shown.isprintable() else ascii(shown)

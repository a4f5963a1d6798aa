"""Reading numbers from text files, with errors that say where they are."""

import math
import re
from pathlib import Path

import numpy as np

from ..errors import DatasetError
from ..samples import HORIZON

_LINE_END = re.compile(r"\r\n|\r|\n")


def read_bytes(path):
    """The content of a regular file."""
    path = Path(path)
    try:
        if path.exists() and not path.is_file():
            raise DatasetError("not a file, expected a file of measurements", path)
        content = path.read_bytes()
    except (OSError, ValueError) as error:
        if isinstance(error, DatasetError):
            raise
        raise DatasetError(f"cannot be read: {getattr(error, 'strerror', None) or error}", path) from error
    if not content.strip():
        raise DatasetError("empty, expected measurements", path)
    return content


def to_lines(content, path):
    """Decode a text file into lines, whatever their ends."""
    if b"\0" in content:
        raise DatasetError("binary (or UTF-16) content, expected plain text", path)
    try:
        text = content.decode("utf-8-sig")
    except UnicodeDecodeError:
        text = content.decode("latin-1")        # an umlaut in a comment must not make a file unreadable
    return _LINE_END.split(text)


def parse_number(token, path, line):
    """A finite number."""
    try:
        if "_" in token or len(token) > 400:    # float() would read 1_000; the longest double has 309 digits
            raise ValueError
        number = float(token)
    except ValueError:
        raise DatasetError(f"{_quote(token)} found, expected a number", path, line) from None
    if not math.isfinite(number):
        raise DatasetError(f"{_quote(token)} found, expected a finite number", path, line)
    return number


def parse_row(tokens, count, what, path, line):
    """A line of `count` numbers; `what` says what they are."""
    if len(tokens) != count:
        raise DatasetError(f"{len(tokens)} entries found, expected {count}: {what}", path, line)
    return [parse_number(token, path, line) for token in tokens]


def check_thetas(thetas, line_numbers, path):
    """Complain about the first row with a polar angle outside 0 to pi/2: thetas (n, k), line_numbers (n,)."""
    bad = np.argwhere((thetas < 0) | (thetas > HORIZON + 1e-5))
    if len(bad):
        row, column = bad[0]
        raise DatasetError(f"a polar angle of {thetas[row, column]:g} found, expected 0 to pi/2 radians", path,
                           line_numbers[row])


def _quote(token):
    shown = token if len(token) <= 24 else token[:21] + "..."
    return f"'{shown}'" if shown.isprintable() else ascii(shown)

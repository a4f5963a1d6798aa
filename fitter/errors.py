"""The one exception that bad input raises, and its kinds: what a user can be asked about."""

import unicodedata
from pathlib import Path

# categories of Unicode: control characters, line breaks among them, formats, halves of characters, ends of lines
_UNSHOWN = {"Cc", "Cf", "Cs", "Zl", "Zp"}


def printable(text: str) -> str:
    r"""Text from a file, or the name of one, as terminals and Blender can show it in a line: what would steer them or
    begin another line, or is no character at all, as an escape.

    Examples
    --------
    >>> print(printable("gold \x1b[31m \udcff\nerror: none"))
    gold \x1b[31m \udcff\nerror: none
    """
    return "".join(ascii(each)[1:-1] if unicodedata.category(each) in _UNSHOWN else each for each in text)


class DatasetError(ValueError):
    """A file, or the numbers in it, cannot be used; the message says where and what was expected.

    Attributes
    ----------
    path : path-like, or None
        The file, where there is one.
    line : int, or None
        The number of the line, from 1, where it is known.

    Examples
    --------
    >>> print(DatasetError("12 rows found, expected 14", "paint.astm", 7))
    paint.astm:7: 12 rows found, expected 14
    """

    def __init__(self, message: str, path: str | Path | None = None, line: int | None = None) -> None:
        where = "" if path is None else f"{path}:{line}: " if line is not None else f"{path}: "
        super().__init__(printable(where + message))
        self.path = path
        self.line = line


class SampleUnknownError(DatasetError):
    """A file holds several samples, and not the one that was asked for."""


class UnitsUnknownError(DatasetError):
    """A file does not say what its numbers mean; the options `angles` and `quantity` of reading do."""


class ImplausibleError(UnitsUnknownError):
    """The numbers of a file are those of no surface: it would reflect more light than arrives, or next to none."""


class ColumnsUnknownError(DatasetError):
    """The columns of a table are not understood; the option `columns` of reading says which is which."""

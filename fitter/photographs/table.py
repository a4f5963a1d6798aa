"""A table of a description, whose values are taken out by key and kind; errors name file and key."""

from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np

from ..arrays import FloatArray
from ..errors import DatasetError, printable

LEAST, LARGEST = 1e-9, 1e9  # of numbers: their squares and quotients are within double precision by far
POSITIVE = f"a number of {LEAST:g} to {LARGEST:g}"
_LONGEST = 80               # characters of a value in a message


class Table:
    """A table, of the description at a path or of this name; files are beside it."""

    def __init__(self, values: Any, where: str, path: Path) -> None:
        if not isinstance(values, dict):
            raise DatasetError(f"{where} is {_abbreviate(values)}, expected a table", path)
        self._values, self._where, self.path = dict(values), where, path

    def _name(self, key: str) -> str:
        return f"{self._where}.{key}" if self._where else key

    def error(self, key: str, expected: str) -> DatasetError:
        """What to raise where the value of a key is not as expected."""
        value = f"is {_abbreviate(self._values[key])}" if key in self._values else "is missing"
        return DatasetError(f"{self._name(key)} {value}, expected {expected}", self.path)

    def has(self, key: str) -> bool:
        """Whether there is a key."""
        return key in self._values

    def number(self, key: str, default: float | None = None) -> float | None:
        """A number above 0."""
        if key not in self._values:
            return default
        value = self._values[key]
        if not is_number(value) or value < LEAST:
            raise self.error(key, POSITIVE)
        return float(value)

    def needed(self, key: str) -> float:
        """A number above 0, which must be there."""
        value = self.number(key)
        if value is None:
            raise self.error(key, POSITIVE)
        return value

    def numbers(self, key: str, count: int, default: Sequence[float] | None = None) -> FloatArray:
        """So many numbers."""
        value = self._values.get(key, default)
        if not isinstance(value, list | tuple) or len(value) != count or not all(map(is_number, value)):
            raise self.error(key, f"{count} numbers")
        return np.array(value, dtype=float)

    def rows(self, key: str, shape: tuple[int, int], expected: str) -> FloatArray:
        """So many lists of so many numbers, as `expected` says it: an array of this shape."""
        rows = self._values.get(key)
        if not isinstance(rows, list) or len(rows) != shape[0] or not all(
                isinstance(row, list) and len(row) == shape[1] and all(map(is_number, row)) for row in rows):
            raise self.error(key, expected)
        return np.array(rows, dtype=float)

    def text(self, key: str, default: str) -> str:
        """A text, as terminals can show it."""
        value = self._values.get(key, default)
        if not isinstance(value, str):
            raise self.error(key, "a text")
        return printable(value)

    def files(self, key: str) -> list[Path]:
        """The files that a key names: one or more."""
        value = self._values.get(key)
        names = [value] if isinstance(value, str) else value
        if not isinstance(names, list) or not names or not all(isinstance(name, str) for name in names):
            raise self.error(key, "the name of a file, or a list of them")
        return [self.path.parent / name for name in names]

    def table(self, key: str) -> "Table":
        """A table within; empty where there is none."""
        return Table(self._values.get(key, {}), self._name(key), self.path)

    def tables(self, key: str) -> list["Table"]:
        """A list of tables within: one or more."""
        value = self._values.get(key)
        if not isinstance(value, list) or not value:
            raise self.error(key, f"one table [[{key}]] or more")
        return [Table(each, f"{self._name(key)} {number}", self.path) for number, each in enumerate(value, start=1)]

    def only(self, *keys: str) -> "Table":
        """This table, if it has no other keys."""
        for key in self._values:
            if key not in keys:
                raise DatasetError(f"{self._name(key)} is not known, expected one of {', '.join(keys)}", self.path)
        return self

    def value(self, key: str) -> Any:
        """The value of a key, whatever it is."""
        return self._values.get(key)


def is_number(value: object) -> bool:
    """Whether a value is a number of a size that cameras, lamps and exposures have."""
    return isinstance(value, int | float) and not isinstance(value, bool) and abs(value) <= LARGEST


def _abbreviate(value: object) -> str:
    text = repr(value)
    return text if len(text) <= _LONGEST else text[:_LONGEST] + "..."

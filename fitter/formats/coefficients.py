"""A table of translucent materials, one a row: what they scatter and absorb, or their albedo and mean free path
(docs/formats.md, Translucent materials). `data/translucent.csv` is one.

Its columns are `name` and those of `model.translucent.WORDS`. What is below the surface is in `Samples.subsurface`.
"""

import csv

from ..errors import DatasetError
from ..model.published import sample_words
from ..samples import Samples
from .format import Format

_PAIRS = {b"scattering", b"absorption"}, {b"albedo", b"path"}
_LINES_LOOKED_AT = 200      # among which the first row is looked for
_Row = tuple[int, str, dict[str, str]]      # its line, its name, and cells by column


def recognises(content: bytes) -> bool:
    """Whether the first row names either pair of columns."""
    first = next((line for line in content.splitlines()[:_LINES_LOOKED_AT] if line.strip() and line[:1] != b"#"), b"")
    return any(pair <= {name.strip() for name in first.split(b",")} for pair in _PAIRS)


def list_samples(content: bytes) -> list[tuple[int, str]]:
    """The number and the name of each row."""
    return [(number, name) for number, (_, name, _) in enumerate(_rows(content), 1)]


def read(content: bytes, sample: int) -> Samples:
    """Read one row. Raises DatasetError if it describes no material."""
    line, name, cells = _rows(content)[sample - 1]
    try:
        return sample_words(cells, name, "")
    except ValueError as error:
        raise DatasetError(str(error), line=line) from error


def _rows(content: bytes) -> list[_Row]:
    lines = [(number, line) for number, line in enumerate(content.decode("utf-8", "replace").splitlines(), 1)
             if line.strip() and not line.startswith("#")]
    names, *cells = csv.reader(line for _, line in lines)
    rows = [(number, {name.strip(): cell for name, cell in zip(names, row, strict=False)})
            for (number, _), row in zip(lines[1:], cells, strict=False)]
    if not rows:
        raise DatasetError("no rows below the names of columns")
    return [(number, row.get("name", "").strip() or f"Line {number}", row) for number, row in rows]


FORMAT = Format("Translucent", "translucent materials .csv", (".csv",), recognises, read, list_samples=list_samples)

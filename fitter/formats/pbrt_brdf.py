"""pbrt-v2's text format for measured BRDFs (.brdf): numbers, of which the first is that of wavelengths
(docs/layouts.md, pbrt)."""

import re

import numpy as np

from ..arrays import map_directions
from ..errors import DatasetError
from ..samples import RGB, Samples
from .format import Format
from .reading import BY_DEFAULT, Reading
from .spectra import to_linear_srgb
from .text import check_angles, parse_numbers

_FEWEST, _MOST = 3, 1000    # plausible numbers of wavelengths
_FIRST = re.compile(rb"(?:\A|[\r\n])[ \t\f\v]*([^\s#])")      # of the first line that is not a comment
_COUNT_LINE = re.compile(rb"([0-9]{1,4})[ \t\f\v]*(?=[\r\n#]|\Z)")


def recognises(content: bytes) -> bool:
    """Whether the first line that is not a comment holds one whole number, the number of wavelengths."""
    first = _FIRST.search(content)
    count = first and _COUNT_LINE.match(content, first.start(1))
    return count is not None and _FEWEST <= int(count[1]) <= _MOST


def read(content: bytes, reading: Reading = BY_DEFAULT) -> Samples:
    """Read a .brdf file; spectra become linear sRGB. Raises DatasetError if the file is malformed."""
    values, line = parse_numbers(content)
    bands = int(values[0])
    columns = 4 + bands
    rows, over = divmod(len(values) - 1 - bands, columns)
    if rows < 1 or over:
        raise DatasetError(f"{len(values)} numbers found, expected {bands} wavelengths and rows of {columns}: "
                           f"theta_i phi_i theta_s phi_s and a value for each wavelength", line=line(len(values) - 1))
    table = values[1 + bands:].reshape(rows, columns)
    check_angles(table[:, :4], lambda row: line(1 + bands + row * columns))
    reflectance = to_linear_srgb(values[1:1 + bands], table[:, 4:], line(1), reading.illuminant)
    return Samples(*map_directions(np.asarray, table[:, :4].T), reflectance, RGB, "", notes=reading.notes)


FORMAT = Format("pbrt-v2", "pbrt-v2 .brdf", (".brdf",), recognises, read, ("illuminant",))

"""pbrt-v2's text format for measured BRDFs: a count, wavelengths in nm, then theta_i phi_i theta_s phi_s values."""

import re
from pathlib import Path

from ..errors import DatasetError
from ..samples import RGB, Samples
from .format import Format
from .spectra import to_linear_srgb
from .text import check_thetas, parse_numbers

_FEW, _MANY = 3, 1000       # plausible numbers of wavelengths
_FIRST = re.compile(rb"(?:\A|[\r\n])[ \t\f\v]*([^\s#])")      # of the first line that is not a comment
_COUNT = re.compile(rb"([0-9]{1,4})[ \t\f\v]*(?=[\r\n#]|\Z)")


def recognises(content):
    """Whether the first line that is not a comment holds one whole number: the number of wavelengths."""
    first = _FIRST.search(content)
    count = first and _COUNT.match(content, first.start(1))
    return bool(count) and _FEW <= int(count[1]) <= _MANY


def read(path, content):
    """Read a .brdf file; spectra become linear sRGB.

    Returns
    -------
    Samples
    """
    values, line = parse_numbers(content, path)
    bands = int(values[0])
    columns = 4 + bands
    rows, over = divmod(len(values) - 1 - bands, columns)
    if rows < 1 or over:
        raise DatasetError(f"{len(values)} numbers found, expected {bands} wavelengths and rows of {columns}: "
                           f"theta_i phi_i theta_s phi_s and a value for each wavelength", path, line(len(values) - 1))
    table = values[1 + bands:].reshape(rows, columns)
    check_thetas(table[:, [0, 2]], lambda row: line(1 + bands + row * columns), path)
    reflectance = to_linear_srgb(values[1:1 + bands], table[:, 4:], path, line(1))
    angles = table[:, :4].T.copy()
    del values, table           # of a long file they take more memory than it does
    return Samples(*angles, reflectance, RGB, Path(path).stem, str(path))


FORMAT = Format("pbrt-v2", "pbrt-v2 .brdf", (".brdf",), recognises, read)

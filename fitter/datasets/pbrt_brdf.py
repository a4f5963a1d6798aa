"""pbrt-v2's text format for measured BRDFs: a count, wavelengths in nm, then theta_i phi_i theta_s phi_s values."""

import re
from pathlib import Path

import numpy as np

from ..errors import DatasetError
from ..samples import Samples
from ..spectra import RGB, to_linear_srgb
from .text import check_thetas, parse_number

_FEW, _MANY = 3, 1000       # plausible numbers of wavelengths


def recognises(lines):
    """Whether the first line that is not a comment holds one whole number: the number of wavelengths."""
    for line in lines:
        content = line.partition("#")[0].split()
        if content:
            whole = len(content) == 1 and re.fullmatch("[0-9]{1,4}", content[0])
            return bool(whole) and _FEW <= int(content[0]) <= _MANY
    return False


def read(path, lines):
    """Read a .brdf file; spectra become linear sRGB.

    Returns
    -------
    Samples
    """
    values, numbers = [], []
    for number, line in enumerate(lines, 1):
        tokens = line.partition("#")[0].split()
        values.extend(parse_number(token, path, number) for token in tokens)
        numbers.extend([number] * len(tokens))
    bands = int(values[0])
    columns = 4 + bands
    rows, over = divmod(len(values) - 1 - bands, columns)
    if rows < 1 or over:
        raise DatasetError(f"{len(values)} numbers found, expected {bands} wavelengths and rows of {columns}: "
                           f"theta_i phi_i theta_s phi_s and a value for each wavelength", path, numbers[-1])
    table = np.array(values[1 + bands:]).reshape(rows, columns)
    check_thetas(table[:, [0, 2]], numbers[1 + bands::columns], path)
    reflectance = to_linear_srgb(values[1:1 + bands], table[:, 4:], path, numbers[1])
    return Samples(*table[:, :4].T, reflectance, RGB, Path(path).stem, str(path))

"""Cornell's gonioreflectometer files in ASTM E1392 style: keyword lines, a VARS line, comma-separated rows."""

import re
from pathlib import Path

import numpy as np

from ..errors import DatasetError
from ..samples import Samples
from ..spectra import RGB, to_linear_srgb
from .text import check_thetas, parse_number, parse_row

ANGLES = ("theta_i", "phi_i", "theta_s", "phi_s")
_BAND = re.compile(r"(\d+(?:\.\d+)?)\s*nm", re.IGNORECASE)


def recognises(lines):
    """Whether there is a line that starts with VARS."""
    return any(line.startswith("VARS") for line in lines)


def read(path, lines):
    """Read an ASTM file; spectra become linear sRGB.

    Returns
    -------
    Samples
    """
    header, variables, first = _header(path, lines)
    columns, values, numbers = len(variables), [], []
    what = "the variables of the VARS line"
    for number, line in enumerate(lines[first:], first + 1):
        if line.strip():
            values.append(parse_row(line.split(","), columns, what, path, number))
            numbers.append(number)
    if not values:
        raise DatasetError("no rows after VARS, expected measurements", path, first)
    expected = header.get("NUM_POINTS")
    if expected is not None and parse_number(expected[0], path, expected[1]) != len(values):
        raise DatasetError(f"{len(values)} rows found, expected {expected[0]} as NUM_POINTS says", path, expected[1])

    table = np.array(values)
    check_thetas(table[:, [0, 2]], numbers, path)
    channels, reflectance = _reflectance(variables[4:], table[:, 4:], path, first)
    name = header.get("SAMPLE_NAME", (Path(path).stem,))[0]
    return Samples(*table[:, :4].T, reflectance, channels, name, str(path))


def read_spectrum(path, lines):
    """The bands of a spectral file as they stand: wavelengths (bands,) nm and values (n, bands), 1/sr."""
    _, variables, first = _header(path, lines)
    rows = [[float(token) for token in line.split(",")] for line in lines[first:] if line.strip()]
    return _wavelengths(variables[4:]), np.array(rows)[:, 4:]


def _header(path, lines):
    """Keywords as {key: (text, line)}, the variables, and the index of the line after VARS."""
    keywords = {}
    for number, line in enumerate(lines, 1):
        key, _, text = line.strip().partition(" ")
        if key == "VARS":
            variables = [name.strip() for name in text.split(",")]
            if tuple(variables[:4]) != ANGLES or len(variables) < 5:
                raise DatasetError(f"VARS must begin with {','.join(ANGLES)} and go on with channels", path, number)
            return keywords, variables, number
        if key:
            keywords[key] = (text.strip(), number)
    raise DatasetError("no VARS line", path)


def _reflectance(names, values, path, line):
    if tuple(name.upper() for name in names) == RGB:
        return RGB, values
    wavelengths = _wavelengths(names)
    if wavelengths is None:
        raise DatasetError(f"channels {','.join(names[:4])}... found, expected R,G,B or wavelengths such as 400nm",
                           path, line)
    return RGB, to_linear_srgb(wavelengths, values, path, line)


def _wavelengths(names):
    matches = [_BAND.fullmatch(name) for name in names]
    return np.array([float(match[1]) for match in matches]) if all(matches) else None

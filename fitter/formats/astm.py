"""Cornell's gonioreflectometer files in ASTM E1392 style: keyword lines, a VARS line, comma-separated rows."""

import re
from pathlib import Path

import numpy as np

from ..errors import DatasetError
from ..samples import RGB, Samples
from .format import Format
from .spectra import to_linear_srgb
from .text import check_thetas, decode, line_number, nth_line, parse_number, parse_rows

ANGLES = ("theta_i", "phi_i", "theta_s", "phi_s")
MOST_VARIABLES = 1000
_BAND = re.compile(r"(\d+(?:\.\d+)?)\s*nm", re.IGNORECASE)
_VARS = re.compile(rb"(?:\A|(?<=[\r\n]))VARS\b([^\r\n]*)")
_KEYWORD = re.compile(rb"(?:\A|(?<=[\r\n]))[ \t]*(SAMPLE_NAME|NUM_POINTS)[ \t]([^\r\n]*)")


def recognises(content):
    """Whether there is a line that starts with VARS."""
    return _VARS.search(content) is not None


def read(path, content):
    """Read an ASTM file; spectra become linear sRGB.

    Returns
    -------
    Samples
    """
    variables, start, where = _variables(path, content)
    table = parse_rows(content, start, len(variables), "the variables of the VARS line", path)
    if not len(table):
        raise DatasetError("no rows after VARS, expected measurements", path, where)
    header = {keyword[1]: keyword for keyword in _KEYWORD.finditer(content, 0, start)}
    _check_count(header.get(b"NUM_POINTS"), len(table), path, content)
    check_thetas(table[:, [0, 2]], lambda row: nth_line(content, start, row), path)
    channels, reflectance = _reflectance(variables[4:], table[:, 4:], path, where)
    name = decode(header[b"SAMPLE_NAME"][2].strip()) if b"SAMPLE_NAME" in header else Path(path).stem
    return Samples(*table[:, :4].T, reflectance, channels, name, str(path))


def read_spectrum(path, content):
    """The bands of a spectral file as they stand: wavelengths (bands,) nm and values (n, bands), 1/sr."""
    variables, start, _ = _variables(path, content)
    table = parse_rows(content, start, len(variables), "the variables of the VARS line", path)
    return _wavelengths(variables[4:]), table[:, 4:]


def _variables(path, content):
    """The variables, where the line after them starts, and the number of theirs."""
    found = _VARS.search(content)
    where = line_number(content, found.start())
    names = found[1].count(b",") + 1
    if names > MOST_VARIABLES:
        raise DatasetError(f"{names} variables found, expected at most {MOST_VARIABLES}", path, where)
    variables = [decode(name).strip() for name in found[1].split(b",")]
    if tuple(variables[:4]) != ANGLES or len(variables) < 5:
        raise DatasetError(f"VARS must begin with {','.join(ANGLES)} and go on with channels", path, where)
    return variables, found.end(), where


def _check_count(keyword, rows, path, content):
    """Compare the number of rows with what the header says, if it does."""
    if keyword is not None:
        text = keyword[2].strip()
        if parse_number(text, path, content, keyword.start(1)) != rows:
            raise DatasetError(f"{rows} rows found, expected {decode(text)} as NUM_POINTS says", path,
                               line_number(content, keyword.start(1)))


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


FORMAT = Format("Cornell", "Cornell ASTM (.astm)", (".astm",), recognises, read)

"""Cornell's gonioreflectometer files, text in the style of ASTM E1392.

Measured by the Cornell Program of Computer Graphics: S. C. Foo: A Gonioreflectometer for Measuring the Bidirectional
Reflectance of Material for Use in Illumination Computation, Master's thesis, Cornell University, 1997. Owner's page:
https://www.graphics.cornell.edu/online/measurements/reflectance/

Layout: lines of a keyword and text; a line VARS, which names four angles in radians and then the channels, R,G,B or
wavelengths; and rows of as many numbers, separated by commas. The keywords SAMPLE_NAME and NUM_POINTS are used ::

    SAMPLE_NAME Krylon Blue
    VARS theta_i,phi_i,theta_s,phi_s,R,G,B
    0.872665,0.000000,0.573513,0.000000,-0.000794,0.005163,0.030536

Limits: at most 1,000 variables. The owners warn of noise at short wavelengths and grazing angles, and of unreliable
mirror peaks of smooth surfaces; values in RGB may be negative.
"""

import re
from collections.abc import Sequence
from pathlib import Path

import numpy as np

from ..arrays import FloatArray
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


def recognises(content: bytes) -> bool:
    r"""Whether a line starts with VARS.

    Examples
    --------
    >>> recognises(b"SAMPLE_NAME Blue\nVARS theta_i,phi_i,theta_s,phi_s,R,G,B\n"), recognises(b"1 0.2 0.3")
    (True, False)
    """
    return _VARS.search(content) is not None


def read(path: str | Path, content: bytes) -> Samples:
    """Read an ASTM file; spectra become linear sRGB.

    Returns
    -------
    Samples

    Raises
    ------
    DatasetError
        If the file is malformed.
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
    theta_i, phi_i, theta_o, phi_o = table[:, :4].T
    return Samples(theta_i, phi_i, theta_o, phi_o, reflectance, channels, name, str(path))


def read_spectrum(path: str | Path, content: bytes) -> tuple[FloatArray | None, FloatArray]:
    """The bands of a spectral file, not converted to sRGB.

    Returns
    -------
    wavelengths : (bands,) float64, or None
        nm; None if the channels are not wavelengths.
    values : (n, bands) float64
        1/sr.
    """
    variables, start, _ = _variables(path, content)
    table = parse_rows(content, start, len(variables), "the variables of the VARS line", path)
    return _wavelengths(variables[4:]), table[:, 4:]


def _variables(path: str | Path, content: bytes) -> tuple[list[str], int, int]:
    """The variables of the VARS line, the position of its end, and its line number."""
    found = _VARS.search(content)
    if found is None:
        raise DatasetError("no VARS line", path)
    where = line_number(content, found.start())
    names = found[1].count(b",") + 1
    if names > MOST_VARIABLES:
        raise DatasetError(f"{names} variables found, expected at most {MOST_VARIABLES}", path, where)
    variables = [decode(name).strip() for name in found[1].split(b",")]
    if tuple(variables[:4]) != ANGLES or len(variables) < 5:
        raise DatasetError(f"VARS must begin with {','.join(ANGLES)} and go on with channels", path, where)
    return variables, found.end(), where


def _check_count(keyword: re.Match[bytes] | None, rows: int, path: str | Path, content: bytes) -> None:
    """Compare the number of rows with NUM_POINTS, if the header has it."""
    if keyword is not None:
        text = keyword[2].strip()
        if parse_number(text, path, content, keyword.start(1)) != rows:
            raise DatasetError(f"{rows} rows found, expected {decode(text)} as NUM_POINTS says", path,
                               line_number(content, keyword.start(1)))


def _reflectance(names: Sequence[str], values: FloatArray, path: str | Path,
                 line: int) -> tuple[tuple[str, ...], FloatArray]:
    """The channels, and the values converted to them."""
    if tuple(name.upper() for name in names) == RGB:
        return RGB, values
    wavelengths = _wavelengths(names)
    if wavelengths is None:
        raise DatasetError(f"channels {','.join(names[:4])}... found, expected R,G,B or wavelengths such as 400nm",
                           path, line)
    return RGB, to_linear_srgb(wavelengths, values, path, line)


def _wavelengths(names: Sequence[str]) -> FloatArray | None:
    """Wavelengths in nm, or None if the names are anything else."""
    matches = [match for name in names if (match := _BAND.fullmatch(name))]
    return np.array([float(match[1]) for match in matches]) if len(matches) == len(names) else None


FORMAT = Format("Cornell", "Cornell ASTM (.astm)", (".astm",), recognises, read)

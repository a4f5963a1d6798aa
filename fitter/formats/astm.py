"""Tables of goniometers, text in the style of ASTM E1392: Cornell's, Light Tec's and others.

Measured first by the Cornell Program of Computer Graphics: S. C. Foo: A Gonioreflectometer for Measuring the
Bidirectional Reflectance of Material for Use in Illumination Computation, Master's thesis, Cornell University, 1997.
Owner's page: https://www.graphics.cornell.edu/online/measurements/reflectance/

Layout: lines of a keyword and text; a line VARS, which names the columns; and rows of as many numbers, separated by
commas or white space. The keywords SAMPLE_NAME and NUM_POINTS are used ::

    SAMPLE_NAME Krylon Blue
    VARS theta_i,phi_i,theta_s,phi_s,R,G,B
    0.872665,0.000000,0.573513,0.000000,-0.000794,0.005163,0.030536

Columns may be in any order. The outgoing direction is theta_s and phi_s, or _r, _o, _v. Angles are radians; degrees
where a name says so, theta_i[deg], or where more than half of those that are not zero are beyond 2 pi; or as `Reading`
says. Values are the BRDF, unless `Reading` says that a cosine is in them, as E1392 calls cosine-corrected. The other
columns are R,G,B; or wavelengths, 400nm; or one wavelength, or BRDF, which is grey. Light Tec's VARS leaves out phi_s,
whose column comes after theta_s. Where phi_i takes three values or more, it is found from the values whether the
material is isotropic (`isotropy`). In Light Tec's files what is beyond 75 degrees is drawn, not measured
(`unmeasured`).

Limits: at most 1,000 variables. Three wavelengths, one of them red, one green and one blue, as of an instrument with
three lamps, are taken as R, G and B where they do not span enough for a spectrum. Cornell warns of noise at short
wavelengths and grazing angles, and of unreliable mirror peaks of smooth surfaces; values in RGB may be negative.
"""

import re
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from ..arrays import FloatArray, map_directions
from ..errors import DatasetError
from ..samples import Samples
from . import unmeasured
from .columns import angle, angles_note, look_like_degrees, reflectance, to_brdf
from .format import Format
from .isotropy import finished
from .names import ANGLES
from .reading import BY_DEFAULT, QUANTITIES, Reading
from .text import check_azimuths, check_thetas, decode, line_number, lines, nth_line, parse_number, parse_rows

MOST_VARIABLES = 1000
_VARS = re.compile(rb"(?:\A|(?<=[\r\n]))VARS\b([^\r\n]*)")
_KEYWORD = re.compile(rb"(?:\A|(?<=[\r\n]))[ \t]*(SAMPLE_NAME|NUM_POINTS)[ \t]([^\r\n]*)")


def recognises(content: bytes) -> bool:
    """Whether a line starts with VARS."""
    return _VARS.search(content) is not None


def read(path: str | Path, content: bytes, reading: Reading = BY_DEFAULT) -> Samples:
    """Read an ASTM file; spectra become linear sRGB. Raises DatasetError if the file is malformed."""
    columns = _columns(path, content)
    table = _table(columns, path, content)
    if not len(table):
        raise DatasetError("no rows after VARS, expected measurements", path, columns.line)
    header = {keyword[1]: keyword for keyword in _KEYWORD.finditer(content, 0, columns.start)}
    _check_count(header.get(b"NUM_POINTS"), len(table), path, content)
    angles = table[:, columns.angles]
    in_degrees = reading.angles == "degrees" if reading.angles else (
        columns.unit == "deg" or (columns.unit is None and look_like_degrees(angles)))

    def find_line(row: int) -> int:
        return nth_line(content, columns.start, row)

    check_thetas(angles[:, [0, 2]], find_line, path, in_degrees)
    check_azimuths(angles[:, [1, 3]], find_line, path)
    directions, values = np.radians(angles) if in_degrees else angles, table[:, columns.values]
    notes = [angles_note(in_degrees, columns.unit, reading)] if reading.angles else []
    directions, values, of_quantity = to_brdf(directions, values, QUANTITIES[reading.quantity or "brdf"],
                                              ", as asked" if reading.quantity else "", path, columns.line)
    channels, values, more = reflectance(columns.channels, values, path, columns.line, reading)
    name = decode(header[b"SAMPLE_NAME"][2].strip()) if b"SAMPLE_NAME" in header else Path(path).stem
    samples = Samples(*map_directions(np.asarray, directions.T), values, channels, name, str(path),
                      (*notes, *of_quantity, *more))
    return finished(unmeasured.remove_unmeasured(samples, reading), reading)


@dataclass(frozen=True)
class _Columns:
    """What the VARS line says.

    Attributes
    ----------
    angles, values : list of int
        The columns of `ANGLES`, and those of the channels.
    channels : list of str
    unit : str, or None
        "deg" or "rad", if the names say it.
    start, line : int
        The end of the VARS line, and its number.
    """

    angles: list[int]
    values: list[int]
    channels: list[str]
    unit: str | None
    start: int
    line: int


def _columns(path: str | Path, content: bytes) -> _Columns:
    """Read the VARS line."""
    named = _VARS.search(content)
    if named is None:
        raise DatasetError("no VARS line", path)
    line = line_number(content, named.start())
    separator = b"," if b"," in named[1] else None
    count = named[1].count(b",") + 1 if separator else len(named[1].split(None, MOST_VARIABLES))
    if count > MOST_VARIABLES:
        raise DatasetError(f"{count} variables found, expected at most {MOST_VARIABLES}", path, line)
    names = [decode(name).strip() for name in named[1].split(separator)]
    kinds = [angle(name) for name in names]
    roles = [kind[0] for kind in kinds]
    first_row = next(lines(content, named.end()), None)
    entries = 0 if first_row is None else len(first_row[0].split(_separator(content, named.end()), MOST_VARIABLES + 1))
    if entries == len(names) + 1 and sorted(filter(None, roles)) == sorted(set(ANGLES) - {"phi_s"}):
        after = roles.index("theta_s") + 1
        names[after:after], roles[after:after] = ["phi_s"], ["phi_s"]
    units = {unit for role, unit in kinds if role}
    if sorted(filter(None, roles)) != sorted(ANGLES) or len(roles) <= len(ANGLES) or len(units) > 1:
        raise DatasetError(f"VARS must name {', '.join(ANGLES)} once each, in one unit, and channels", path, line)
    values = [column for column, role in enumerate(roles) if not role]
    return _Columns([roles.index(role) for role in ANGLES], values, [names[column] for column in values], units.pop(),
                    named.end(), line)


def _separator(content: bytes, start: int) -> bytes | None:
    """What separates the numbers of the first row, and so of all: commas, or None for white space."""
    row = next(lines(content, start), None)
    return b"," if row is not None and b"," in row[0] else None


def _table(columns: _Columns, path: str | Path, content: bytes) -> FloatArray:
    """The rows: (n, variables)."""
    count = len(columns.angles) + len(columns.values)
    return parse_rows(content, columns.start, count, "the variables of the VARS line", path,
                      _separator(content, columns.start))


def _check_count(keyword: re.Match[bytes] | None, rows: int, path: str | Path, content: bytes) -> None:
    """Compare the number of rows with NUM_POINTS, if the header has it."""
    if keyword is not None:
        text = keyword[2].strip()
        if parse_number(text, path, content, keyword.start(1)) != rows:
            raise DatasetError(f"{rows} rows found, expected {decode(text)} as NUM_POINTS says", path,
                               line_number(content, keyword.start(1)))


FORMAT = Format("Cornell", "Cornell or Light Tec ASTM (.astm)", (".astm",), recognises, read,
                ("angles", "quantity", "illuminant", "isotropic", "symmetry", "keep_unmeasured"))

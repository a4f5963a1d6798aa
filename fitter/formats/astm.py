"""Tables of goniometers, text in the style of ASTM E1392: Cornell's, Light Tec's and others.

A line VARS names the columns of the rows below; of the other keywords SAMPLE_NAME and NUM_POINTS are read
(docs/layouts.md, ASTM).
"""

import re
from itertools import islice

import numpy as np

from ..arrays import map_directions
from ..errors import DatasetError
from ..samples import Samples
from . import unmeasured
from .columns import angles_note, look_like_degrees, reflectance, to_brdf
from .format import Format
from .isotropy import decide_symmetry
from .names import ANGLES, UNSAID, Value, parse, role
from .reading import BY_DEFAULT, QUANTITIES, Reading
from .table_columns import Columns, unit_of_angles
from .text import check_angles, decode, line_error, line_number, lines, parse_number, parse_rows

MOST_VARIABLES = 1000
_VARS = re.compile(rb"(?:\A|(?<=[\r\n]))VARS\b([^\r\n]*)")
_KEYWORD = re.compile(rb"(?:\A|(?<=[\r\n]))[ \t]*(SAMPLE_NAME|NUM_POINTS)[ \t]([^\r\n]*)")


def read(content: bytes, reading: Reading = BY_DEFAULT) -> Samples:
    """Read an ASTM file; spectra become linear sRGB. Raises DatasetError if the file is malformed."""
    columns, start, separator = _columns(content)
    table = parse_rows(content, start, len(columns.units), "the variables of the VARS line", separator)
    if not len(table):
        raise DatasetError("no rows after VARS, expected measurements", line=columns.line)
    header = {keyword[1]: keyword for keyword in _KEYWORD.finditer(content, 0, start)}
    if (points := header.get(b"NUM_POINTS")) is not None:
        said = points[2].strip()
        if parse_number(said, points) != len(table):
            raise line_error(points, f"{len(table)} rows found, expected {decode(said)} as NUM_POINTS says")
    angles, unit = columns.angles(table), unit_of_angles(columns, reading)
    in_degrees = reading.angles == "degrees" if reading.angles else (
        unit == "deg" or (unit is None and look_like_degrees(angles)))

    def find_line(row: int) -> int:
        return line_number(next(islice(lines(content, start), row, None)))

    check_angles(angles, find_line, in_degrees)
    directions, values = np.radians(angles) if in_degrees else angles, table[:, [*columns.values]]
    notes = [angles_note(in_degrees, unit, reading)] if reading.angles else []
    directions, values, of_quantity = to_brdf(directions, values, QUANTITIES[reading.quantity or "brdf"],
                                              ", as asked" if reading.quantity else "", columns.line)
    channels, values, more = reflectance([value.channel for value in columns.values.values()], values, columns.line,
                                         reading)
    name = decode(header[b"SAMPLE_NAME"][2].strip()) if b"SAMPLE_NAME" in header else ""
    samples = Samples(*map_directions(np.asarray, directions.T), values, channels, name,
                      notes=(*notes, *of_quantity, *more))
    return decide_symmetry(unmeasured.remove_unmeasured(samples, reading), reading)


def _columns(content: bytes) -> tuple[Columns, int, bytes | None]:
    """What the VARS line says, where it ends, and what separates the numbers below: a comma, or None: white space."""
    named = _VARS.search(content)
    if named is None:
        raise DatasetError("no VARS line")
    line, start = line_number(named), named.end()
    names = [decode(name).strip() for name in named[1].split(b"," if b"," in named[1] else None, MOST_VARIABLES)]
    if len(names) > MOST_VARIABLES:
        raise DatasetError(f"more than {MOST_VARIABLES} variables found", line=line)
    roles = [found if (found := role(name)) in ANGLES else "" for name in names]
    units = [unit if (unit := parse(name).unit) in ("deg", "rad") else None for name in names]
    is_one_unit = len({unit for unit, kind in zip(units, roles, strict=True) if kind}) < 2
    first = next((row[0] for row in lines(content, start)), b"")
    separator = b"," if b"," in first else None
    if (len(first.split(separator, MOST_VARIABLES + 1)) == len(names) + 1
            and sorted(filter(None, roles)) == sorted(set(ANGLES) - {"phi_s"})):
        after = roles.index("theta_s") + 1      # Light Tec's
        names[after:after], roles[after:after], units[after:after] = ["phi_s"], ["phi_s"], [units[after - 1]]
    if sorted(filter(None, roles)) != sorted(ANGLES) or len(roles) <= len(ANGLES) or not is_one_unit:
        raise DatasetError(f"VARS must name {', '.join(ANGLES)} once each, in one unit, and channels", line=line)
    values = {column: Value(names[column], UNSAID, "", False) for column, kind in enumerate(roles) if not kind}
    angles = {kind: column for column, kind in enumerate(roles) if kind}
    return Columns(line, units, {}, angles, values), start, separator


FORMAT = Format("Cornell", "Cornell or Light Tec ASTM (.astm)", (".astm",), _VARS.search, read,
                ("angles", "quantity", "illuminant", "isotropic", "symmetry", "keep_unmeasured"))

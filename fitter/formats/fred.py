"""FRED's table of scattered light, text, as scatterometers write it for Photon Engineering's FRED: for each mirrored
ray the directions of the detector and the values (docs/layouts.md, FRED)."""

import re
from array import array

import numpy as np

from ..arrays import FloatArray
from ..errors import DatasetError
from ..samples import Samples
from . import unmeasured
from .format import Format
from .isotropy import decide_symmetry
from .reading import BY_DEFAULT, Reading
from .text import check_angles, decode, floats, line_error, line_number, lines, parse_number

_TYPE = re.compile(rb"\s*type[ \t]+bsdf_data\b[^\r\n]*", re.IGNORECASE)
_SETTING = re.compile(rb"(\w+)[ \t]*=[ \t]*([^\s=]+)")
_FRED_UNITS = {"deg": np.pi / 180, "rad": 1.0}
_LARGEST_LOGARITHM = 30.0
_LARGEST = 8 << 20          # bytes: half a million directions


def read(content: bytes, reading: Reading = BY_DEFAULT) -> Samples:
    """Read a FRED file. Raises DatasetError if it is malformed."""
    start, settings = _settings(content)
    table, at = _rows(content, start)
    unit = settings["angles"]

    def find_line(row: int) -> int:
        return line_number(next(lines(content, at[row])))

    check_angles(table[:, :4], find_line, unit == "deg", signed=True)
    angles = table[:, :4] * _FRED_UNITS[unit]
    theta_i, theta_o = np.abs(angles[:, [0, 2]]).T
    # where the light is: opposite to where it is mirrored to; a negative polar angle is on the other side
    phi_i = angles[:, 1] + np.pi * (angles[:, 0] < 0)
    phi_o = angles[:, 3] + np.pi * (angles[:, 2] >= 0)
    values = table[:, 4:]
    notes = ["phi_s = 0 is on the mirror's side"]
    if settings["bsdf"] == "log":
        too_large = np.flatnonzero(values[:, 0] > _LARGEST_LOGARITHM)
        if len(too_large):
            raise DatasetError(f"a logarithm of {values[too_large[0], 0]:g} found, expected one to the base of 10",
                               line=find_line(too_large[0]))
        values = 10 ** values
        notes.append("The values are logarithms to the base of 10")
    values = values * float(settings["scale"])
    samples = Samples(theta_i, phi_i, theta_o, phi_o, values, ("grey",), "", notes=tuple(notes))
    return decide_symmetry(unmeasured.remove_unmeasured(samples, reading), reading)


def _settings(content: bytes) -> tuple[int, dict[str, str]]:
    """Where the numbers begin, and what the line `format` says of them."""
    head = _TYPE.match(content)
    line = None if head is None else next(lines(content, head.end()), None)
    if line is None or not line[0].lower().startswith(b"format"):
        raise DatasetError("expected a line such as 'format angles=deg bsdf=value scale=1'", line=2)
    said = {decode(key).lower(): decode(value).lower() for key, value in _SETTING.findall(line[0])}
    settings = {"angles": "deg", "bsdf": "value", "scale": "1"} | said
    if settings["angles"] not in _FRED_UNITS:
        raise line_error(line, f"angles={settings['angles'][:20]} found, expected deg or rad: direction cosines are "
                         "not read")
    if settings["bsdf"] not in ("value", "log"):
        raise line_error(line, f"bsdf={settings['bsdf'][:20]} found, expected value or log")
    parse_number(settings["scale"].encode(), line)
    return line.end(), settings


def _rows(content: bytes, start: int) -> tuple[FloatArray, "array[int]"]:
    """Each value with its directions, (n, 5), and where in the content its line begins."""
    numbers, at = array("d"), array("q")
    light: list[float] | None = None
    for line in lines(content, start):
        if line[0].startswith((b"#", b"!")):
            continue
        tokens = line[0].split(None, 3)
        row = floats(line[0], tokens) if len(tokens) in (2, 3) else None
        if row is None:
            for token in tokens[:3]:
                parse_number(token, line)
            shown = "1 number" if len(tokens) == 1 else "more than 3 numbers"
            raise line_error(line, f"{shown} found, expected the two angles of a mirrored ray, or theta_s, phi_s and "
                             "the value")
        if len(row) == 2:
            light = row
        elif light is None:
            raise line_error(line, "expected first a line of two numbers, the mirrored ray")
        else:
            numbers.extend((*light, *row))
            at.append(line.start())
    if not at:
        raise DatasetError("no rows of theta_s, phi_s and a value, expected measurements")
    return np.frombuffer(numbers).reshape(-1, 5), at


FORMAT = Format("FRED", "FRED's text (.txt)", (".txt",), _TYPE.match, read, ("isotropic", "keep_unmeasured"),
                largest=_LARGEST)

"""CURET, the Columbia-Utrecht reflectance database: 61 samples, each measured at the same 205 geometries.

K. J. Dana, B. van Ginneken, S. K. Nayar, J. J. Koenderink: Reflectance and Texture of Real-World Surfaces, ACM TOG
18(1), 1999. The geometries come with the project, so that the measurements are all that a user needs.
"""

import difflib
import re
from functools import cache
from pathlib import Path

import numpy as np

from ..errors import DatasetError
from ..samples import RGB, Samples
from .format import Format
from .text import line_number, lines, parse_number, parse_row, plain_text, read_bytes

GEOMETRIES = 205
NAMES = (
    "felt", "polyester", "terrycloth", "rough plastic", "leather", "sandpaper", "velvet", "pebbles", "frosted glass",
    "plaster a", "plaster b", "rough paper", "artificial grass", "roof shingle", "aluminum foil", "cork", "rough tile",
    "rug a", "rug b", "styrofoam", "sponge", "lambswool", "lettuce leaf", "rabbit fur", "quarry tile", "loofa",
    "insulation", "crumpled paper", "polyester zoomed", "plaster b zoomed", "rough paper zoomed",
    "roof shingle zoomed", "slate a", "slate b", "painted spheres", "limestone", "brick a", "ribbed paper",
    "human skin", "straw", "brick b", "corduroy", "salt crystals", "linen", "concrete a", "cotton", "stones",
    "brown bread", "concrete b", "concrete c", "corn husk", "white bread", "plant", "wood a", "orange peel", "wood b",
    "peacock feather", "tree bark", "cracker a", "cracker b", "moss")
_WHAT = f"a sample number and {GEOMETRIES} values"
_NUMBER = re.compile(rb"([0-9]{1,9})(?!\S)")


def recognises(content):
    """Whether the first line is a sample number and about as many numbers as there are geometries."""
    tokens = next(lines(content), [b"-"])[0].split(None, GEOMETRIES // 2)
    return tokens[0].isdigit() and len(tokens) > GEOMETRIES // 2


def list_samples(path, content):
    """The samples of a file: a list of (number, name)."""
    return [(number, sample_name(number)) for number in _rows(path, content)]


def sample_name(number):
    """The name of a CURET sample, 1 to 61."""
    return NAMES[number - 1]


def read(path, content, sample=None):
    """Read one sample, in colour where `path` is one of rbrdf.dat, gbrdf.dat, bbrdf.dat and all three are there.

    Returns
    -------
    Samples
    """
    path = Path(path)
    rows = _rows(path, content)
    number = _sample_number(sample, rows, path)
    trio = _trio(path)
    if trio is None:
        channels, columns = ("grey",), [_values(path, content, rows[number])]
    else:
        channels, columns = RGB, []
        for member in trio:
            text = content if member == path else plain_text(read_bytes(member), member)
            member_rows = _rows(member, text)
            if number not in member_rows:
                raise DatasetError(f"no sample {number}, which {path.name} has", member)
            columns.append(_values(member, text, member_rows[number]))
    theta_v, phi_v, theta_i, phi_i = geometry().T
    return Samples(theta_i, phi_i, theta_v, phi_v, np.stack(columns, axis=1), channels, sample_name(number), str(path))


def overflowed(path, content, sample=None):
    """Which measurements overflowed the camera: (205,) bool, or None.

    Known where `rover.dat`, `gover.dat` or `bover.dat` lie beside `path`: each has the share of overflowed pixels.
    """
    path = Path(path)
    number = _sample_number(sample, _rows(path, content), path)
    found = None
    for letter in RGB:
        member = path.with_name(f"{letter.lower()}over.dat")
        if not member.is_file():
            continue
        text = plain_text(read_bytes(member), member)
        rows = _rows(member, text)
        if number in rows:
            share = np.array(_values(member, text, rows[number]))
            found = (share > 0) | (False if found is None else found)
    return found


def read_with(path):
    """The file of red values where `path` is that of green or blue beside it: they are read as one."""
    if path.name.lower() not in {"gbrdf.dat", "bbrdf.dat"}:
        return None
    names = (red + path.name[1:] for red in "rR")
    return next((path.with_name(name) for name in names if path.with_name(name).is_file()), None)


@cache
def geometry():
    """The directions of the measurements: (205, 4), theta_v, phi_v, theta_i, phi_i in radians."""
    table = Path(__file__).parent / "data" / "curet_geometry.csv"
    return np.loadtxt(table, delimiter=",", comments="#", skiprows=2)[:, 1:]


def _rows(path, content):
    """Where the line of each sample starts: {sample number: position}."""
    rows = {}
    for line in lines(content):
        number = _NUMBER.match(line[0])
        if number is None or not 1 <= int(number[1]) <= len(NAMES):
            raise DatasetError(f"the line must start with a sample number from 1 to {len(NAMES)}: {_WHAT}", path,
                               line_number(content, line.start()))
        first = rows.setdefault(int(number[1]), line.start())
        if first != line.start():
            raise DatasetError(f"sample {int(number[1])} a second time, first on line {line_number(content, first)}",
                               path, line_number(content, line.start()))
    return rows


def _values(path, content, position):
    return parse_row(next(lines(content, position))[0], None, GEOMETRIES + 1, _WHAT, path, content, position)[1:]


def _sample_number(sample, rows, path):
    if sample is None or sample == "":
        return next(iter(rows))
    text = str(sample).strip().lower()
    if text.isdecimal() or isinstance(sample, int | float):
        number = parse_number(text.encode(), path)
        if number not in rows:
            raise DatasetError(f"no sample {text}, expected a number from {min(rows)} to {max(rows)} or a name", path)
        return int(number)
    named = {sample_name(number): number for number in rows}
    if text not in named:
        near = difflib.get_close_matches(text, named, n=3) or [name for name in named if text in name][:3]
        hint = f"; did you mean {' or '.join(near)}?" if near else ""
        raise DatasetError(f"no sample named '{text}'{hint}", path)
    return named[text]


def _trio(path):
    """The files of red, green and blue where `path` is one of them and none is missing, else None."""
    if path.name[:1].lower() not in {"r", "g", "b"} or path.name[1:].lower() != "brdf.dat":
        return None
    upper = path.name[0].isupper()
    trio = [path.with_name((letter if upper else letter.lower()) + path.name[1:]) for letter in RGB]
    return trio if all(member.is_file() for member in trio) else None


FORMAT = Format("CURET", "CURET abrdf.dat", (".dat",), recognises, read, list_samples=list_samples,
                overflowed=overflowed, read_with=read_with)

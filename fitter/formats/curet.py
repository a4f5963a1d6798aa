"""CURET, the Columbia-Utrecht reflectance database: 61 samples, each measured at the same 205 geometries.

Layout, authors and what the files beside `abrdf.dat` hold: docs/layouts.md, CURET. The directions come with this
project; `Samples.saturated` are those that overflowed.
"""

import re
from functools import cache
from pathlib import Path

import numpy as np

from ..arrays import FloatArray
from ..errors import DatasetError
from ..samples import RGB, Samples
from .format import Format
from .text import line_error, line_number, lines, name_file, parse_row, plain_text, read_bytes

GEOMETRIES = 205
SAMPLE_NAMES = (
    "felt", "polyester", "terrycloth", "rough plastic", "leather", "sandpaper", "velvet", "pebbles", "frosted glass",
    "plaster a", "plaster b", "rough paper", "artificial grass", "roof shingle", "aluminum foil", "cork", "rough tile",
    "rug a", "rug b", "styrofoam", "sponge", "lambswool", "lettuce leaf", "rabbit fur", "quarry tile", "loofa",
    "insulation", "crumpled paper", "polyester zoomed", "plaster b zoomed", "rough paper zoomed",
    "roof shingle zoomed", "slate a", "slate b", "painted spheres", "limestone", "brick a", "ribbed paper",
    "human skin", "straw", "brick b", "corduroy", "salt crystals", "linen", "concrete a", "cotton", "stones",
    "brown bread", "concrete b", "concrete c", "corn husk", "white bread", "plant", "wood a", "orange peel", "wood b",
    "peacock feather", "tree bark", "cracker a", "cracker b", "moss")
_EXPECTED = f"a sample number and {GEOMETRIES} values"
_NUMBER = re.compile(rb"([0-9]{1,9})(?!\S)")


def recognises(content: bytes) -> bool:
    """Whether the first line has a sample number and at least half as many values as there are geometries."""
    first = next(lines(content), None)
    tokens = b"-".split() if first is None else first[0].split(None, GEOMETRIES // 2)
    return tokens[0].isdigit() and len(tokens) > GEOMETRIES // 2


def list_samples(content: bytes) -> list[tuple[int, str]]:
    """The (number, name) of each sample of a file."""
    return [(number, SAMPLE_NAMES[number - 1]) for number in _rows(content)]


def read(content: bytes, sample: int, path: Path) -> Samples:
    """Read one sample; in colour if `path` is one of rbrdf.dat, gbrdf.dat, bbrdf.dat and all three exist."""
    parts = list_parts(path)
    members, overflows = parts[:-len(RGB)], parts[-len(RGB):]
    columns = []
    for member in members:
        if (column := _values(member, content if member == path else None, sample)) is None:
            raise DatasetError(f"no sample {sample}, which {path.name} has", member)
        columns.append(column)
    over = [column for member in overflows if member.is_file()
            and (column := _values(member, None, sample)) is not None]
    theta_v, phi_v, theta_i, phi_i = geometry().T
    return Samples(theta_i, phi_i, theta_v, phi_v, np.stack(columns, axis=1), RGB if len(members) > 1 else ("grey",),
                   SAMPLE_NAMES[sample - 1], saturated=np.max(over, axis=0) > 0 if over else None)


def list_parts(path: Path) -> list[Path]:
    """The files of values that are read with one, itself included: red first, or all; and those that say of each
    channel which measurements overflowed the camera."""
    members = []
    if path.name[:1].upper() in RGB and path.name[1:].lower() == "brdf.dat":
        letters = RGB if path.name[0].isupper() else map(str.lower, RGB)
        members = [path.with_name(letter + path.name[1:]) for letter in letters]
    whole = members if members and all(member.is_file() for member in members) else [path]
    return [*whole, *(path.with_name(f"{letter.lower()}over.dat") for letter in RGB)]


@cache
def geometry() -> FloatArray:
    """The directions of the measurements: (205, 4), theta_v, phi_v, theta_i, phi_i, radians."""
    table = Path(__file__).parent / "data" / "curet_geometry.csv"
    return np.loadtxt(table, delimiter=",", comments="#", skiprows=2)[:, 1:]


def _rows(content: bytes) -> dict[int, re.Match[bytes]]:
    """The line of each sample, by sample number."""
    rows: dict[int, re.Match[bytes]] = {}
    for line in lines(content):
        number = _NUMBER.match(line[0])
        if number is None or not 1 <= int(number[1]) <= len(SAMPLE_NAMES):
            raise line_error(line, f"the line must start with a sample number from 1 to {len(SAMPLE_NAMES)}: "
                             f"{_EXPECTED}")
        first = rows.setdefault(int(number[1]), line)
        if first is not line:
            raise line_error(line, f"sample {int(number[1])} a second time, first on line {line_number(first)}")
    return rows


def _values(path: Path, content: bytes | None, sample: int) -> list[float] | None:
    """The values of a sample in a file, of which the content may be known; None if it is not in it."""
    with name_file(path):
        row = _rows(plain_text(read_bytes(path)) if content is None else content).get(sample)
        return None if row is None else parse_row(row, None, GEOMETRIES + 1, _EXPECTED)[1:]


FORMAT = Format("CURET", "CURET abrdf.dat", (".dat",), recognises, read, list_samples=list_samples,
                list_parts=list_parts)

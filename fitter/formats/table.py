"""A table of one's own: text with a line of column names, as spreadsheets and instruments export it.

Layout: one line of names, then rows of as many cells. The separator is the first of tab, semicolon, comma, ``|``,
colon and blanks that the line of names has, or what a line ``sep=;`` before it says, as Excel has it. Lines that begin
with # are comments; some of them say what the names do not ::

    # name: Gold foil
    # angles: degrees
    # values: BRDF * cos_o
    theta_i, phi_i, theta_o, phi_o, R, G, B
    30, 0, 30, 180, 0.21, 0.18, 0.11
    30, 0, 45, 180, 0.09, , 0.05

Columns may be in any order:

theta_i, phi_i, theta_o, phi_o
    The polar angle from the normal and the azimuth; toward the light and toward the detector. Also theta_in, theta_r,
    theta_v, zenith_out, azimuth_i and the like. Instead of two azimuths there may be one between the directions, phi:
    180 degrees to the mirror direction. The unit stands in the name, theta_i[deg] or theta_i (°), or in a comment
    ``angles: degrees``; where neither does, and no angle is too large for radians, reading asks: `Reading.angles`.
R, G, B; or wavelengths, 550nm or 550; or one value, BRDF
    1/sr. ``R*cos_i``, or a comment ``values: BRDF * cos_o``, says that the cosine is in them, and which; or
    `Reading.quantity` does.
standard
    What the detector read of a reflectance standard. Values are then divided by it, and by pi; a comment
    ``standard: 0.98`` has the standard's reflectance, which is 1 by default.

Where phi_i takes three values or more, it is found from the values whether the material is isotropic (`isotropy`).
phi = 0 is the surface's tangent, and azimuths rise toward the bitangent. A comment ``symmetry: 180 degrees`` says
that the material is the same after half a turn, so that a half was measured; ``symmetry: mirror`` that the plane of
normal and tangent is a mirror; ``symmetry: 180 degrees and mirror`` both: a quarter was measured.

Where a cell is empty, or NaN, or NA, the row is left out. Measurements of one pair of directions are averaged. With any
separator but commas, numbers may have decimal commas; no-break spaces may group their digits. Limits: 8 MB, 1,000
columns.
"""

import re
from array import array
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from ..arrays import FloatArray, IntArray, mapped
from ..errors import DatasetError, UnitsUnknownError
from ..samples import HALF_TURN, HALF_TURN_AND_MIRROR, MIRROR, NO_SYMMETRY, RGB, Samples
from . import unmeasured
from .columns import ANGLES, GREY, angle, angles_note, look_like_degrees, reflectance, without_cosine
from .format import Format
from .isotropy import finished
from .reading import BY_DEFAULT, QUANTITIES, Reading
from .text import check_thetas, decode, floats, line_number, lines, parse_number

MOST_COLUMNS = 1000
_LONGEST_NAMES = 1 << 16        # bytes of the line of names
_SEPARATORS = b"\t", b";", b",", b"|", b":"
_SAID_SEPARATOR = re.compile(rb"\"?sep=([^\w\r\n])\"?[ \t]*\Z")
_NO_BREAK_SPACES = tuple(space.encode() for space in "\u00a0\u202f\u2009") + (b"\xa0",)       # the last in Latin-1
_MISSING = frozenset((b"", b"na", b"n/a", b"nan", b"null", b"none", b"-", b"--", b"*"))
_RELATIVE = re.compile(r"(?:d|delta_?|relative_?)?(?:phi|azimuth)(?:_?d)?(?:[ _]*[\[(]?[ ]*(deg|rad)[a-z]*[ ]*[\])]?)?",
                       re.IGNORECASE)
_COSINE = re.compile(r"(.*?)[ ]*(?:\*|_|times)[ ]*cos[ ]*[_(]?[ ]*(?:theta_?)?([iosrv]?)[ ]*\)?", re.IGNORECASE)
_COMMENT = re.compile(rb"#+[ \t]*(\w+)[ \t]*[:=][ \t]*(.*?)[ \t]*\Z")
_SYMMETRY = re.compile(rb"#+[ \t]*symmetry[ \t]*[:=][ \t]*", re.IGNORECASE)
_SYMMETRIES = ((NO_SYMMETRY, {"none"}), (HALF_TURN, {"180"}), (MIRROR, {"mirror"}),
               (HALF_TURN_AND_MIRROR, {"180", "mirror"}))       # and the words that say it
_FILLERS = {"degrees", "deg", "and", "+"}
_NUMBER = re.compile(r"\d+(?:\.\d+)?")
_COLOURS = {"red": "R", "green": "G", "blue": "B"}
_STANDARD = ("standard", "reference")
_ONE_VALUE = (*GREY, "bsdf", "value", "f", "y")
_EXPECTED = "theta_i, theta_o, phi (or phi_i and phi_o), and values: BRDF, or R, G and B"
_SAME = 1e-6                    # radians between directions that count as one
_PRIOR_COUNT = 3                # further measurements of each pair of directions, with the scatter of those as bright
_ALIKE, _MOST_BINS = 10, 10     # pairs in a bin of brightness, and bins
_DARK = 1e-3                    # of the mean: scatter is relative to no less


def recognises(content: bytes) -> bool:
    """Whether the first line that is no comment names a polar angle, and two other columns."""
    names, separator = _names_line(content)
    if names is None or names[0].startswith(b"VARS"):
        return False
    columns = _names(names[0], separator)
    return len(columns) > 2 and any(angle(name)[0].startswith("theta") for name in columns[:MOST_COLUMNS])


def describe(content: bytes) -> str | None:
    r"""What a table lacks whose columns mean nothing here, as a part of a message; None for what is no table.

    Examples
    --------
    >>> describe(b"alpha;beta\n1;2\n3;4\n")
    'columns alpha, beta found; expected theta_i, theta_o, phi (or phi_i and phi_o), and values: BRDF, or R, G and B'
    >>> describe(b"Tuesday: measured\nthe blue one\n")
    """
    names, separator = _names_line(content)
    if names is None or separator is None:
        return None
    columns = _names(names[0], separator)[:MOST_COLUMNS]
    row = _split(content[names.end():].lstrip(b"\r\n").split(b"\n", 1)[0], separator)
    numbers = [cell for cell in row if _is_number(cell)]
    if len(columns) < 2 or not len(columns) == len(row) == len(numbers) or any(map(_is_number, columns)):
        return None
    shown = ", ".join(columns[:8]) + (" ..." if len(columns) > 8 else "")
    return f"columns {shown} found; expected {_EXPECTED}"


def _is_number(cell: str | bytes) -> bool:
    try:
        float(cell.replace(",", ".") if isinstance(cell, str) else cell.replace(b",", b"."))
    except ValueError:
        return False
    return True


def read(path: str | Path, content: bytes, reading: Reading = BY_DEFAULT) -> Samples:
    """Read a table; spectra become linear sRGB. What `reading` says is true, whatever the table says.

    Raises DatasetError if the table is malformed; `UnitsUnknownError` if it says too little, and `reading` does not
    say it.

    Returns
    -------
    Samples
        Its `notes` say what was made of the table.
    """
    names, separator = _names_line(content)
    if names is None:
        raise DatasetError("no line of column names", path)
    line = line_number(content, names.start())
    said = _comments(content, names.start())
    symmetry = _symmetry(content, names.start(), reading, path)
    columns = _columns(_names(names[0], separator), said, reading, path, line)
    cells, at, left_out = _cells(content, names.end(), columns.count, separator, path)
    if not len(cells):
        raise DatasetError(f"{left_out} rows found, none of them complete, expected measurements", path, line)
    notes = []
    if left_out:
        notes.append(f"{left_out:,} of {len(cells) + left_out:,} rows have empty cells and are left out")

    def line_of(row: int) -> int:
        return line_number(content, at[row])

    angles = columns.angles_of(cells)
    in_degrees = _in_degrees(columns.unit, angles, reading, path, line)
    check_thetas(angles[:, [0, 2]], line_of, path, in_degrees)
    directions = np.radians(angles) if in_degrees else angles
    notes.append(angles_note(in_degrees, columns.unit, reading))
    values = cells[:, columns.values]
    if columns.standard is not None:
        values = _by_standard(values, cells[:, columns.standard], columns.reflectance, line_of, path)
        notes.append(f"Divided by a standard of reflectance {columns.reflectance:g}")
    cosine = columns.cosine if reading.quantity is None else QUANTITIES[reading.quantity]
    asked = _as_asked(columns.cosine, reading)
    if cosine:
        directions, values, note = without_cosine(directions, values, cosine, path, line)
        notes.append(note + asked)
    elif asked:
        notes.append("Values are the BRDF" + asked)
    channels, values, more = reflectance(columns.channels, values, path, line, reading)
    directions, values, deviation, repeated = _averaged(directions, values)
    name = said.get("name") or Path(path).stem
    samples = Samples(*mapped(np.asarray, directions.T), values, channels, name, str(path),
                      (*notes, *more, *repeated), deviation=deviation)
    return finished(unmeasured.without(samples, reading), reading, symmetry)


@dataclass(frozen=True)
class _Columns:
    """What the line of names and the comments say.

    Attributes
    ----------
    count : int
        Of the columns.
    angles : dict
        The column of each of `ANGLES` that is there.
    values : list of int
    channels : list of str
        The name of each of `values`.
    unit : str, or None
        "deg" or "rad", if it is said; anything that is said, where `Reading` has the unit.
    cosine : str
        "i" or "s" if that angle's cosine is in the values, or ""; likewise.
    standard : int, or None
        The column of the standard, ...
    reflectance : float
        ... and what it reflects.
    """

    count: int
    angles: dict[str, int]
    values: list[int]
    channels: list[str]
    unit: str | None
    cosine: str
    standard: int | None
    reflectance: float

    def angles_of(self, cells: FloatArray) -> FloatArray:
        """(n, 4); azimuths that the table does not have are 0."""
        angles = np.zeros((len(cells), len(ANGLES)))
        for role, column in self.angles.items():
            angles[:, ANGLES.index(role)] = cells[:, column]
        return angles


def _names_line(content: bytes) -> tuple[re.Match[bytes] | None, bytes | None]:
    """The first line that is no comment, unless it is very long, and what separates its cells; None: blanks."""
    said = None
    for line in lines(content):
        if line[0].startswith(b"#"):
            continue
        if len(line[0]) > _LONGEST_NAMES:
            break
        if said is None and (said := _SAID_SEPARATOR.match(line[0])):
            continue
        return line, said[1] if said else next((each for each in _SEPARATORS if each in line[0].strip()), None)
    return None, None


def _names(line: bytes, separator: bytes | None) -> list[str]:
    """The names of the columns, with deg for the sign of degrees."""
    return [decode(name).replace("\u00b0", "deg").replace("\u00a0", " ") for name in _split(line, separator)]


def _split(line: bytes, separator: bytes | None) -> list[bytes]:
    """The cells of a line, without quotes; empty ones at its end, as spreadsheets leave them, do not count."""
    cells = [cell.strip().strip(b"\"'").strip() for cell in line.split(separator, MOST_COLUMNS + 1)]
    while cells and not cells[-1]:
        cells.pop()
    return cells


def _comments(content: bytes, end: int) -> dict[str, str]:
    """What comments before the line of names say, by keyword in lower case."""
    matches = (_COMMENT.match(line[0]) for line in lines(content[:end]))
    return {decode(match[1]).lower(): decode(match[2]).replace("\u00b0", "deg") for match in matches if match}


def _symmetry(content: bytes, end: int, reading: Reading, path: str | Path) -> str:
    """The symmetry that a comment says, one of `SYMMETRIES`; of none, if `reading` says it."""
    comment = next((line for line in lines(content[:end]) if _SYMMETRY.match(line[0])), None)
    if comment is None or reading.symmetry is not None:
        return NO_SYMMETRY
    text = decode(_SYMMETRY.sub(b"", comment[0]))
    words = set(text.lower().replace("°", " ").replace(",", " ").split()) - _FILLERS
    for symmetry, known in _SYMMETRIES:
        if words == known:
            return symmetry
    raise DatasetError(f"symmetry {text[:40]!r} found, expected 180 degrees, or mirror, or 180 degrees and mirror, "
                       f"or none", path, line_number(content, comment.start()))


def _columns(names: list[str], said: dict[str, str], reading: Reading, path: str | Path, line: int) -> _Columns:
    """The meaning of the columns."""
    if len(names) > MOST_COLUMNS:
        raise DatasetError(f"more than {MOST_COLUMNS} columns found", path, line)
    angles: dict[str, int] = {}
    units, cosines, values, channels, standard = set(), set(), [], [], None
    for column, name in enumerate(names):
        role, unit = angle(name)
        relative = _RELATIVE.fullmatch(name)
        if not role and relative:
            role, unit = "phi_s", relative[1] and relative[1].lower()
        if role:
            if role in angles:
                raise DatasetError(f"'{name}' is the second column of its kind", path, line)
            angles[role] = column
            units.add(unit)
        elif name.lower() in _STANDARD:
            standard = column
        else:
            channel, cosine = _channel(name)
            values.append(column)
            channels.append(channel)
            cosines.add(cosine)
    missing = [name for role, name in (("theta_i", "theta_i"), ("theta_s", "theta_o"), ("phi_s", "phi_o or phi"))
               if role not in angles]
    if missing or not values:
        missing += [] if values else ["values, such as R, G and B"]
        raise DatasetError(f"columns {', '.join(names[:8])} found, expected also {', '.join(missing)}", path, line)
    if len(channels) == 1 and channels[0].lower() in _ONE_VALUE:
        channels = ["BRDF"]
    if "angles" in said:
        units.add({"d": "deg", "r": "rad"}.get(said["angles"][:1].lower(), said["angles"]))
    if "values" in said:
        comment = _channel(said["values"])[1]
        cosines = {*(cosines - {""}), comment or ("?" if "cos" in said["values"].lower() else "")}
    told = sorted(unit for unit in units if unit)
    if reading.angles is None and (len(told) > 1 or not {*told} <= {"deg", "rad"}):
        raise DatasetError("angles must all be in degrees, or all in radians", path, line)
    if reading.quantity is None and (len(cosines) > 1 or not cosines <= {"", "i", "s"}):
        raise UnitsUnknownError("values with a cosine must name it, one for all: BRDF*cos_i or BRDF*cos_o; or choose "
                                "what they are (the option quantity of reading; in Blender's import, Values)", path,
                                line)
    reflected = parse_number(said.get("standard", "1").encode(), path)
    if not 0 < reflected <= 2:
        raise DatasetError(f"a standard of reflectance {reflected:g} found, expected 0 to 1", path)
    return _Columns(len(names), angles, values, channels, " and ".join(told) or None,
                    " and ".join(sorted(cosines)), standard, reflected)


def _channel(name: str) -> tuple[str, str]:
    """The channel that a column's name says, as `reflectance` knows it, and the angle whose cosine is in the values.

    Examples
    --------
    >>> _channel("550"), _channel("green"), _channel("BRDF * cos(theta_o)"), _channel("R*cos")
    (('550nm', ''), ('G', ''), ('BRDF', 's'), ('R', '?'))
    """
    cosine = ""
    with_cosine = _COSINE.fullmatch(name)
    if with_cosine:
        name, angle_name = with_cosine.groups()
        cosine = "?" if not angle_name else "i" if angle_name.lower() == "i" else "s"
    name = _COLOURS.get(name.lower(), name)
    if name[:5].lower() == "brdf_" and name[5:].upper() in RGB:
        name = name[5:]
    return (f"{name}nm" if _NUMBER.fullmatch(name) else name), cosine


def _cells(content: bytes, start: int, count: int, separator: bytes | None,
           path: str | Path) -> tuple[FloatArray, "array[int]", int]:
    """The complete rows, (n, count); where in the content each begins; and the number of the others."""
    numbers, at, left_out = array("d"), array("q"), 0
    for row in lines(content, start):
        line = row[0]
        if line.startswith(b"#"):
            continue
        if not line.isascii():
            for space in _NO_BREAK_SPACES:
                line = line.replace(space, b"")
        if b"," in line and separator != b",":
            line = line.replace(b",", b".")
        cells = line.split(separator, count)
        values = floats(line, cells) if len(cells) == count else None
        if values is None:          # empty cells (a first one that is white space is not there), quotes, or a mistake
            cells = _split(line, separator)
            if len(cells) > count:
                raise DatasetError(f"more than {count} cells found, expected one for each name", path,
                                   line_number(content, row.start()))
            if len(cells) < count or not _MISSING.isdisjoint(cell.lower() for cell in cells):
                left_out += 1
                continue
            values = [parse_number(cell, path, content, row.start()) for cell in cells]
        numbers.extend(values)
        at.append(row.start())
    return np.frombuffer(numbers).reshape(-1, count), at, left_out


def _in_degrees(unit: str | None, angles: FloatArray, reading: Reading, path: str | Path, line: int) -> bool:
    """Whether angles are degrees; `UnitsUnknownError` if that is not known."""
    if reading.angles is not None:
        return reading.angles == "degrees"
    if unit is None and not look_like_degrees(angles):
        raise UnitsUnknownError("the angles may be degrees or radians: choose which (the option angles of reading; in "
                                "Blender's import, Angles), or write theta_i[deg] or theta_i[rad], or before this "
                                "line '# angles: degrees'", path, line)
    return unit != "rad"


def _as_asked(said: str, reading: Reading) -> str:
    """What to add to a note of what the values are, if a user chose it; `said` as in `_Columns.cosine`."""
    if reading.quantity is None:
        return ""
    against = said in ("i", "s") and said != QUANTITIES[reading.quantity]
    return ", as asked" + ("; the file says otherwise" if against else "")


def _by_standard(values: FloatArray, standard: FloatArray, reflected: float, line_of: Callable[[int], int],
                 path: str | Path) -> FloatArray:
    """The BRDF, from what the detector read of the sample and of a diffuse standard: a ratio times its BRDF."""
    dark = np.flatnonzero(standard <= 0)
    if len(dark):
        raise DatasetError(f"the standard reads {standard[dark[0]]:g}, expected more than 0", path, line_of(dark[0]))
    return np.asarray(values / standard[:, None] * (reflected / np.pi))


def _averaged(directions: FloatArray, values: FloatArray,
              ) -> tuple[FloatArray, FloatArray, FloatArray | None, tuple[str, ...]]:
    """One sample for each pair of directions: directions, values, their relative standard deviations, and notes.

    A few measurements hardly tell how much they scatter: each pair's variance is drawn to that of others as bright.
    """
    keys = [np.round((np.mod(column, 2 * np.pi) if name.startswith("phi") else column) / _SAME)
            for name, column in zip(ANGLES, directions.T, strict=True)]
    order = np.lexsort(keys)        # of equal ones, in the order of the table
    starts = np.ones(len(order), bool)
    starts[1:] = np.any([key[order[1:]] != key[order[:-1]] for key in keys], axis=0)
    if starts.all():
        return directions, values, None, ()
    first = order[starts]
    group = np.empty(len(order), np.int64)
    group[order] = np.cumsum(starts) - 1
    count = np.bincount(group)
    mean = np.stack([np.bincount(group, column) / count for column in values.T], axis=1)
    size = np.sqrt((mean ** 2).mean(axis=1))
    relative = (values - mean[group]) / np.maximum(size, _DARK * size.mean() + np.finfo(float).tiny)[group, None]
    squares, several = np.bincount(group, (relative ** 2).mean(axis=1)).astype(float), count > 1
    like_it = _scatter(size, squares, count - 1)
    deviation = np.sqrt((squares + _PRIOR_COUNT * like_it) / (count - 1 + _PRIOR_COUNT) / count)
    scatter = 100 * np.sqrt(np.median(squares[several] / (count[several] - 1)))
    pairs = f"{several.sum():,} pair{'s' if several.sum() > 1 else ''} of directions"
    note = f"{pairs} measured more than once: averaged, with a scatter of {scatter:.2g} %"
    as_written = np.argsort(first)
    return directions[first[as_written]], mean[as_written], deviation[as_written], (note,)


def _scatter(size: FloatArray, squares: FloatArray, freedom: IntArray) -> FloatArray:
    """The relative variance of measurements as bright as each pair of directions: (n,).

    It is that of all pairs, or where many were measured again the median of those of similar brightness: what an
    instrument adds to dark directions is no noise of bright ones.

    Parameters
    ----------
    size : (n,) float64
        Of the pairs.
    squares : (n,) float64
        The sum of the squared relative deviations of each.
    freedom : (n,) int
        How many measurements more than one it has.
    """
    again = np.flatnonzero(freedom)
    order = again[np.argsort(size[again], kind="stable")]
    bins = np.array_split(order, min(max(len(order) // _ALIKE, 1), _MOST_BINS))
    if len(bins) == 1:
        variances = [squares.sum() / freedom.sum()]
    else:       # the median of chi squared over its degrees of freedom (E. B. Wilson, M. M. Hilferty 1931)
        variances = [np.median(squares[part] / freedom[part] / (1 - 2 / (9 * freedom[part])) ** 3) for part in bins]
    return np.asarray(np.array(variances)[np.searchsorted([size[part[0]] for part in bins[1:]], size, side="right")])


FORMAT = Format("Table", "table with column names (.csv, .tsv, .txt)", (".csv", ".tsv", ".txt"), recognises, read,
                ("angles", "quantity", "illuminant", "isotropic", "symmetry", "keep_unmeasured"), largest=8 << 20)

"""A table of one's own: text with a line of column names, as spreadsheets and instruments export it (docs/formats.md, A
table of your own, with all that it may say).

`table_layout` finds the line of names, `names` and `table_columns` what the columns mean, `table_cells` the numbers.
What the table does not say, and its numbers do not tell, reading asks for: `Reading.angles`, `Reading.quantity`,
`Reading.columns`. Limits: 8 MB, 1,000 columns.
"""

import re
from collections.abc import Callable, Sequence
from dataclasses import replace

import numpy as np

from ..arrays import FloatArray, map_directions
from ..errors import ColumnsUnknownError, DatasetError, UnitsUnknownError
from ..samples import HALF_TURN, HALF_TURN_AND_MIRROR, MIRROR, NO_SYMMETRY, Samples
from . import plane, table_cells, table_columns, table_layout, table_on_its_side, unmeasured
from .columns import angles_note, look_like_degrees, reflectance, to_brdf
from .format import Format
from .isotropy import decide_symmetry
from .names import STANDARD, WAVELENGTH
from .reading import BY_DEFAULT, Reading
from .repeats import average_repeats
from .table_columns import Columns, shorten
from .table_layout import Layout
from .text import check_angles, decode, line_error, line_number, lines, parse_number

_SYMMETRY = re.compile(rb"#+[ \t]*symmetry[ \t]*[:=][ \t]*", re.IGNORECASE)
_SYMMETRIES = {frozenset(words): symmetry for symmetry, words in (     # by the words that say them
    (NO_SYMMETRY, ("none",)), (HALF_TURN, ("180",)), (MIRROR, ("mirror",)), (HALF_TURN_AND_MIRROR, ("180", "mirror")))}
_NAMES = ("name", "sample", "sample name", "material")
_FILLERS = {"degrees", "deg", "and"}
_MOST_WAVELENGTHS = 1000    # of a table with a row for each
_MICRONS = 20               # a wavelength below it is in micrometres
_SAME_WRITTEN = 1e-9        # of angles, as they are written
_LEAST_SHARED = 0.5         # of the cells that directions and wavelengths make, at least this share must be there


def recognises(content: bytes) -> bool:
    """Whether a line names a polar angle, and two other columns; after title lines, whether rows follow it. Or such a
    table lies on its side."""
    return table_layout.find(content) is not None or table_on_its_side.transpose_table(content) is not None


def unknown_columns(content: bytes) -> ColumnsUnknownError | None:
    """What to say of a table whose columns mean nothing here, or have no names; None of what is no table."""
    found = table_layout.preview(content)
    if found is None or (len(found[1][0]) < 3 and (found[0] is None or len(found[1]) < 2)):
        return None
    heads, rows = found
    what = f"columns {shorten(heads)} found" if heads else f"{len(rows[0])} columns of numbers without names found"
    line = None if heads is None else 1 + next((number for number, text in enumerate(content.splitlines())
                                                if heads[0].encode() in text), 0)
    return ColumnsUnknownError(f"{what}; expected {table_columns.EXPECTED}; {table_columns.OTHERWISE}", line=line)


def read(content: bytes, reading: Reading = BY_DEFAULT) -> Samples:
    """Read a table; spectra become linear sRGB. What `reading` says is true, whatever the table says.

    Raises ColumnsUnknownError if its columns are not understood, UnitsUnknownError if it says too little.
    """
    if reading.columns is None and (found := table_on_its_side.transpose_table(content)) is not None:
        return _on_its_side(*found, reading)
    layout = table_layout.find(content, reading.columns)
    if layout is None:
        raise ColumnsUnknownError(f"no row of numbers for the columns {reading.columns} found" if reading.columns else
                                  "no line of column names")
    symmetry = _symmetry(content, layout, reading)
    columns = table_columns.assign_columns(content, layout)
    cells = table_cells.read(content, layout, columns.indices)
    if not len(cells.numbers):
        raise DatasetError(f"{cells.left_out} rows found, none of them complete, expected measurements",
                           line=layout.line)
    notes = [*cells.notes]
    if layout.texts:
        notes.append(f"Columns of text are not read: {shorten([*layout.texts])}")
    if cells.left_out:
        notes.append(f"{cells.left_out:,} of {len(cells.numbers) + cells.left_out:,} rows have empty cells and are "
                     "left out")

    def find_line(row: int) -> int:
        return line_number(next(lines(content, cells.at[row])))

    columns.units = [cells.units.get(column, unit) for column, unit in enumerate(layout.units)]
    directions, values, channels, more = _measurements(columns, cells.numbers, reading, find_line)
    channels, values, of_channels = reflectance(channels, values, layout.line, reading)
    directions, values, deviation, repeated = average_repeats(directions, values)
    name = next((columns.said[key] for key in _NAMES if columns.said.get(key)), "")
    samples = Samples(*map_directions(np.asarray, directions.T), values, channels, name,
                      notes=(*notes, *more, *of_channels, *repeated), deviation=deviation)
    return decide_symmetry(unmeasured.remove_unmeasured(samples, reading), reading, symmetry)


def _on_its_side(content: bytes, line: int, reading: Reading) -> Samples:
    """As `read`, of a table whose names are on a line; errors count the columns of the table as it lies."""
    try:
        samples = read(content, reading)
    except DatasetError as error:
        column = f" (column {error.line - line + 1})" if error.line and error.line > line else ""
        raise type(error)(f"in a table that lies on its side{column}: {error}") from error
    return replace(samples, notes=("The table lies on its side: a line for each name", *samples.notes))


def _measurements(columns: Columns, numbers: FloatArray, reading: Reading,
                  find_line: Callable[[int], int]) -> tuple[FloatArray, FloatArray, Sequence[str], list[str]]:
    """Directions, (n, 4) radians, values of the BRDF, the names of their columns, and notes of how they are read."""
    unit = table_columns.unit_of_angles(columns, reading)
    what, note, said_cosine = table_columns.quantity(columns, reading)
    angles = columns.angles(numbers)
    in_degrees = _are_degrees(unit, angles, reading, columns.line)
    check_angles(angles, find_line, in_degrees, signed=True)
    notes = [angles_note(in_degrees, unit, reading)]
    values, channels = numbers[:, [*columns.values]], [value.channel for value in columns.values.values()]
    if (wavelength := columns.roles.get(WAVELENGTH)) is not None:
        in_microns = {"um": True, "nm": False}.get(columns.units[wavelength] or "")
        angles, values, channels, in_rows = _wavelengths_to_columns(
            angles, numbers[:, wavelength], values[:, 0], in_microns, columns.line)
        notes.append(in_rows)
    directions = np.radians(angles) if in_degrees else angles
    if columns.is_scan:
        side = table_columns.mirror_side(columns)
        directions, sides = plane.directions(directions[:, 0], directions[:, 2], values, side)
        notes.append(sides)
    elif (directions[:, [0, 2]] < 0).any():
        theta, phi = directions[:, [0, 2]], directions[:, [1, 3]]
        directions = np.stack([np.abs(theta), phi + np.pi * (theta < 0)], axis=2).reshape(-1, 4)
        notes.append("Polar angles below 0 are on the other side of the normal")
    if (standard := columns.roles.get(STANDARD)) is not None:
        reflected = parse_number(columns.said.get("standard", "1").encode())
        values = _divide_by_standard(values, numbers[:, standard], reflected, find_line)
        notes.append(f"Divided by a standard of reflectance {reflected:g}")
    notes += [note] if note else []
    contradicts = "; the file says otherwise" if said_cosine not in ("", what.cosine) else ""
    asked = "" if reading.quantity is None else f", as asked{contradicts}"
    directions, values, of_quantity = to_brdf(directions, values, what, asked, columns.line)
    return directions, values, channels, [*notes, *of_quantity]


def _wavelengths_to_columns(angles: FloatArray, wavelengths: FloatArray, values: FloatArray, in_microns: bool | None,
                           line: int) -> tuple[FloatArray, FloatArray, list[str], str]:
    """Of a table with a row for each wavelength, (n,), one for each pair of directions that has all of them, in the
    order in which they begin: angles, (m, 4), values, (m, bands), channels such as 550nm, and a note.

    What was measured more than once is averaged. Whether wavelengths are in micrometres their size says, where nothing
    else does. Raises DatasetError if the directions hardly share their wavelengths.
    """
    if in_microns or (in_microns is None and np.abs(wavelengths).max() < _MICRONS):
        wavelengths = wavelengths * 1000
    bands, band = np.unique(np.round(wavelengths, 6), return_inverse=True)
    _, first, pair = np.unique(np.round(angles / _SAME_WRITTEN), axis=0, return_index=True, return_inverse=True)
    pair = pair.ravel()
    cells = len(first) * len(bands)
    if len(bands) > _MOST_WAVELENGTHS or cells * _LEAST_SHARED > len(values):
        raise DatasetError(f"{len(bands):,} wavelengths at {len(first):,} pairs of directions in {len(values):,} rows "
                           "found, expected the same wavelengths at all", line=line)
    cell = pair * len(bands) + band
    count = np.bincount(cell, minlength=cells)
    mean = (np.bincount(cell, values, cells) / np.maximum(count, 1)).reshape(len(first), len(bands))
    whole = (count > 0).reshape(len(first), len(bands)).all(axis=1)
    if not whole.any():
        raise DatasetError("no pair of directions has all wavelengths, expected the same at all", line=line)
    kept = np.flatnonzero(whole)[np.argsort(first[whole])]
    lacking = f"; {np.count_nonzero(~whole):,} without some are left out" if not whole.all() else ""
    note = f"{len(bands)} wavelength{'s' * (len(bands) > 1)} at {len(kept):,} pairs of directions, in rows{lacking}"
    return angles[first[kept]], mean[kept], [f"{number:g}nm" for number in bands], note


def _symmetry(content: bytes, layout: Layout, reading: Reading) -> str:
    """The symmetry that a comment says, one of `SYMMETRIES`; of none, if `reading` says it."""
    comment = next((line for line in lines(content, end=layout.titles) if _SYMMETRY.match(line[0])), None)
    if comment is None or reading.symmetry is not None:
        return NO_SYMMETRY
    text = decode(_SYMMETRY.sub(b"", comment[0]))
    words = frozenset(re.findall(r"[^\W_]+", text.lower())) - _FILLERS
    if words in _SYMMETRIES:
        return _SYMMETRIES[words]
    raise line_error(comment, f"symmetry {text[:40]!r} found, expected 180 degrees, or mirror, or 180 degrees and "
                     "mirror, or none")


def _are_degrees(unit: str | None, angles: FloatArray, reading: Reading, line: int) -> bool:
    """Whether angles are degrees; `UnitsUnknownError` if that is not known."""
    if reading.angles is not None:
        return reading.angles == "degrees"
    if unit is None and not look_like_degrees(angles):
        raise UnitsUnknownError("the angles may be degrees or radians: choose which (the option angles of reading; in "
                                "Blender's import, Angles), or write theta_i[deg] or theta_i[rad], or before this "
                                "line '# angles: degrees'", line=line)
    return unit != "rad"


def _divide_by_standard(values: FloatArray, standard: FloatArray, reflected: float,
                        find_line: Callable[[int], int]) -> FloatArray:
    """The BRDF, from what the detector read of the sample and of a diffuse standard: a ratio times its BRDF."""
    if not 0 < reflected <= 2:
        raise DatasetError(f"a standard of reflectance {reflected:g} found, expected 0 to 1")
    dark = np.flatnonzero(standard <= 0)
    if len(dark):
        raise DatasetError(f"the standard reads {standard[dark[0]]:g}, expected more than 0", line=find_line(dark[0]))
    return np.asarray(values / standard[:, None] * (reflected / np.pi))


FORMAT = Format("Table", "table with column names (.csv, .tsv, .txt)", (".csv", ".tsv", ".txt"), recognises, read,
                ("angles", "quantity", "illuminant", "isotropic", "symmetry", "keep_unmeasured", "columns"),
                largest=8 << 20)

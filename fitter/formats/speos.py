"""Ansys Speos' anisotropic BSDF, text (.anisotropicbsdf): a line for each fact, then a table for each rotation of the
sample and each angle of incidence (docs/layouts.md, Speos).

Values have no unit: one factor for all makes what is reflected at the incidence of the spectrum the percentage of each
band. Values of 0 are not measurements; those at polar angle 0 are one direction, their mean.
"""

import re
from dataclasses import dataclass

import numpy as np

from ..arrays import FloatArray
from ..errors import DatasetError
from ..samples import RGB, Samples
from . import unmeasured
from .format import Format
from .isotropy import decide_symmetry
from .reading import BY_DEFAULT, Reading
from .scattered import weights
from .spectra import to_linear_srgb
from .text import check_thetas, line_error, line_number, parse_row

_HEAD = re.compile(rb"OPTIS - Anisotropic BSDF surface file v(\d+)[^\r\n]*", re.IGNORECASE)
_ANY_LINE = re.compile(rb"[^\r\n]*(?:\r\n?|\n|\Z)")
_OLDEST = 7
_TURNS = -1                 # phi_i over the rotation of the sample
_MOST = 10_000              # angles, bands or tables
_BANDS = np.arange(400.0, 701.0, 10.0)
_FLAT = 1e-6                # of a spectrum: below it, it has no colour
_LEAST_COSINE = 1e-3        # an intensity at the horizon tells no BSDF


@dataclass(frozen=True)
class _Table:
    """What is reflected at one angle of incidence: angles in radians, values, (polar angles, azimuths), proportional to
    the BSDF, and the line where they begin."""

    rotation: float
    theta_i: float
    theta: FloatArray
    phi: FloatArray
    values: FloatArray
    line: int


class _Lines:
    """The lines of a file, one after the other: some of them may be blank."""

    def __init__(self, content: bytes) -> None:
        self.content, self.at = content, 0
        self.last = next(_ANY_LINE.finditer(content))

    def next(self, what: str) -> re.Match[bytes]:
        """The next line, whatever is in it."""
        if self.at >= len(self.content):
            raise DatasetError(f"ends where {what} were expected")
        self.last = next(_ANY_LINE.finditer(self.content, self.at))
        self.at = self.last.end()
        return self.last

    def numbers(self, count: int, what: str) -> list[float]:
        """The numbers of the next line that is not blank."""
        while not (line := self.next(what))[0].strip():
            pass
        return parse_row(line, None, count, what)

    def whole(self, what: str) -> int:
        """A number of things."""
        number = self.numbers(1, what)[0]
        if not 1 <= number <= _MOST or number != int(number):
            raise self.error(f"{number:g} found, expected a whole number from 1 to {_MOST}: {what}")
        return int(number)

    def error(self, message: str) -> DatasetError:
        """An error in the last line."""
        return line_error(self.last, message)


def read(content: bytes, reading: Reading = BY_DEFAULT) -> Samples:
    """Read a Speos file; its spectrum becomes linear sRGB, or grey where it is flat."""
    lines = _Lines(content)
    is_intensity, has_transmission, angles = _head(lines)
    at, bands, shares = _spectrum(lines)
    if has_transmission:
        _spectrum(lines)
    tables = [_table(lines, rotation, theta_i, is_intensity) for rotation, theta_i in angles]
    reflected = _reflected_integral(tables, at)
    if not reflected > 0:
        raise DatasetError("the values are 0 at the incidence of the spectrum, expected a BSDF", line=tables[0].line)
    phi_i = [_TURNS * table.rotation * (len({table.rotation for table in tables}) > 1) for table in tables]
    parts = [_directions(table, turn) for table, turn in zip(tables, phi_i, strict=True)]
    theta_i, phi, theta_o, phi_o, relative = (np.concatenate(column) for column in zip(*parts, strict=True))
    if not len(relative):
        raise DatasetError("no values above 0, expected measurements")
    channels: tuple[str, ...] = ("grey",)
    colour = shares[:1]
    if np.ptp(shares) > _FLAT * abs(shares[0]):
        channels, colour = RGB, to_linear_srgb(_BANDS, np.interp(_BANDS, bands, shares)[None],
                                               illuminant=reading.illuminant)[0]
    values = relative[:, None] / reflected * colour
    note = f"Reflects {np.mean(shares):.4g} at {np.degrees(at[0]):g} degrees, as the file says"
    samples = Samples(theta_i, phi, theta_o, phi_o, values, channels, "",
                      notes=(note, *(reading.notes if len(channels) > 1 else ())))
    return decide_symmetry(unmeasured.remove_unmeasured(samples, reading), reading)


def _head(lines: _Lines) -> tuple[bool, bool, list[tuple[float, float]]]:
    """Whether values are intensities; whether there is transmission, too; and the rotation and the angle of incidence
    of each table of the reflection, radians."""
    version = _HEAD.match(lines.next("a version")[0])
    if version is None or int(version[1]) < _OLDEST:
        raise lines.error(f"an older version found, expected {_OLDEST} or later: save it again in Speos' BSDF viewer")
    if lines.numbers(1, "0 for text, or 1")[0] != 0:
        raise lines.error("a binary file of Speos, expected text: save it as text in Speos' BSDF viewer")
    lines.next("a comment")
    length = lines.numbers(1, "the number of characters of the description")[0]
    if not 0 <= length <= len(lines.content):
        raise lines.error(f"{length:g} characters of a description found, expected no more than there are")
    lines.at = min(lines.at + int(length), len(lines.content))
    lines.next("lines after the description")
    lines.numbers(3, "the anisotropy vector")
    has_reflection, has_transmission = lines.numbers(2, "whether there are reflection and transmission")
    if not has_reflection:
        raise lines.error("transmission alone found, expected reflection: transmitted light cannot be used")
    is_intensity = lines.numbers(1, "1 for values of the BSDF, or 0")[0] == 0
    angles = _angles(lines)
    if has_transmission:
        _angles(lines)
    return is_intensity, bool(has_transmission), angles


def _angles(lines: _Lines) -> list[tuple[float, float]]:
    """Each rotation with each of its angles of incidence, radians."""
    rotations = lines.numbers(lines.whole("rotations of the sample"), "a rotation for each, degrees")
    pairs = []
    for rotation in rotations:
        incidences = lines.numbers(lines.whole("angles of incidence"), "an angle of incidence for each, degrees")
        if min(incidences) < 0 or max(incidences) > 90:
            raise lines.error(f"angles of incidence from {min(incidences):g} to {max(incidences):g} found, expected 0 "
                              "to 90 degrees")
        pairs += [(np.radians(rotation), np.radians(theta)) for theta in incidences]
        if len(pairs) > _MOST:
            raise lines.error(f"more than {_MOST} angles of incidence found")
    return pairs


def _spectrum(lines: _Lines) -> tuple[tuple[float, float], FloatArray, FloatArray]:
    """theta_i and rotation at which it was measured, radians; the bands in nm; and the share of light of each."""
    theta_i, rotation = lines.numbers(2, "theta_i and rotation at which the spectrum was measured")
    lines.next("a comment on the spectrum")
    rows = np.array([lines.numbers(2, "a wavelength in nm and a percentage")
                     for _ in range(lines.whole("bands of the spectrum"))])
    order = np.argsort(rows[:, 0], kind="stable")
    if len({*rows[:, 0].tolist()}) != len(rows):
        raise lines.error("two bands of one wavelength found")
    return (np.radians(theta_i), np.radians(rotation)), rows[order, 0], rows[order, 1] / 100


def _table(lines: _Lines, rotation: float, theta_i: float, is_intensity: bool) -> _Table:
    shape = lines.numbers(2, "the numbers of polar angles and of azimuths")
    line = line_number(lines.last)
    if not all(1 <= number <= _MOST and number == int(number) for number in shape):
        raise lines.error(f"{shape[0]:g} x {shape[1]:g} values found, expected whole numbers from 1 to {_MOST}")
    polar, around = map(int, shape)
    phi = np.radians(lines.numbers(around, "an azimuth for each column"))
    if (np.diff(phi) <= 0).any() or np.ptp(phi) > 2 * np.pi + 1e-6:
        raise lines.error("azimuths found that do not rise, or over more than 360 degrees")
    rows = np.array([lines.numbers(around + 1, "a polar angle and a value for each azimuth") for _ in range(polar)])
    check_thetas(rows[:, :1], lambda row: line + 2 + row, in_degrees=True)
    theta, values = np.radians(rows[:, 0]), rows[:, 1:]
    if (np.diff(theta) <= 0).any():
        raise lines.error("polar angles found that do not rise")
    if is_intensity:
        cosine = np.cos(theta)[:, None]
        values = np.where(cosine > _LEAST_COSINE, values / np.maximum(cosine, _LEAST_COSINE), 0)
    return _Table(rotation, theta_i, theta, phi, values, line)


def _reflected_integral(tables: list[_Table], at: tuple[float, float]) -> float:
    """The integral of values times cos(theta_o) at the incidence of the spectrum, of two tables between which it is."""
    apart = [abs(np.angle(np.exp(1j * (table.rotation - at[1])))) for table in tables]
    nearest = sorted((table for table, turn in zip(tables, apart, strict=True) if turn <= min(apart) + 1e-9),
                     key=lambda table: table.theta_i)
    angles = [table.theta_i for table in nearest]
    above = int(np.clip(np.searchsorted(angles, at[0]), 1, max(len(angles) - 1, 1)))
    pair = nearest[above - 1:above + 1]
    totals = [np.sum(weights(table.phi, table.theta, 0.0) * table.values.T) for table in pair]
    return float(np.interp(at[0], [table.theta_i for table in pair], totals))


def _directions(table: _Table, phi_i: float) -> tuple[FloatArray, ...]:
    """Directions, radians, and values of a table that are not 0; the normal once, with the mean of its values."""
    values = table.values.copy()
    if table.theta[0] == 0:
        measured = values[0] != 0
        values[0, 0] = values[0].sum() / max(np.count_nonzero(measured), 1)
        values[0, 1:] = 0
    if np.ptp(table.phi) > 2 * np.pi - 1e-6:
        values[:, -1] = 0                   # the first once more
    row, column = np.nonzero(values)
    theta_o, phi_o = table.theta[row], table.phi[column] + np.pi + phi_i
    return (np.full(len(row), table.theta_i), np.full(len(row), phi_i), np.minimum(theta_o, np.pi / 2), phi_o,
            values[row, column])


FORMAT = Format("Speos", "Speos .anisotropicbsdf", (".anisotropicbsdf",), _HEAD.match, read,
                ("illuminant", "isotropic", "symmetry", "keep_unmeasured"))

"""Zemax's table of scattered light (.bsdf), about the direction of specular reflection, as Radiant's Imaging Sphere and
other scatterometers write it: reflection only (docs/layouts.md, Zemax, with the sign of the sample's rotation).

A value of 0 stands for a direction that was not measured. All lines at radial 0 are one direction, their mean.
"""

import re
from dataclasses import replace
from itertools import islice

import numpy as np

from ..arrays import BoolArray, Directions, FloatArray
from ..errors import DatasetError
from ..samples import HORIZON, RGB, Samples, subset
from .format import Format
from .isotropy import decide_symmetry
from .reading import BY_DEFAULT, Reading
from .scattered import weights
from .spectra import XYZ_TO_SRGB
from .text import decode, floats, line_error, lines, parse_number, parse_row, parse_rows

_WORD_KEYS = "Symmetry", "SpectralContent", "ScatterType"
_ANGLES = {"SampleRotation": (-360, 360), "AngleOfIncidence": (0, 90), "ScatterAzimuth": (-360, 360),
           "ScatterRadial": (0, 180)}            # and their range, degrees
_TABLE_KEYS = "AngleOfIncidence", "ScatterAzimuth", "ScatterRadial"
_TURNS = -1                 # phi_i over the rotation of the sample
_LINE_START = rb"(?:\A|(?<=[\r\n]))[ \t]*"
_MARK = re.compile(_LINE_START + rb"(?:ScatterAzimuth|ScatterRadial)[ \t]")
_ZEMAX_KEYWORD = re.compile(_LINE_START + rb"(%b)[ \t]+([^\s#]+)" % "|".join((*_WORD_KEYS, *_ANGLES)).encode())
_BEGIN = re.compile(_LINE_START + rb"DataBegin\b[^\r\n]*")
_LIGHTTOOLS = re.compile(rb"\s*(?:AOI|POI|Side)[ \t]")
_DATA_END = re.compile(_LINE_START + rb"DataEnd\b[^\r\n]*")
_TIS = re.compile(_LINE_START + rb"TIS\b([^\r\n]*)")
_LARGEST = 4 << 20          # bytes; a file of 37 rotations has a million
_Angles = dict[str, FloatArray]     # by keyword, degrees
_ONE_ROTATION = "Measured at 1 rotation: taken as isotropic"
_TOLD = 0.1                 # of the TIS, by which it and the integral differ where a note says so
_ZEMAX_HORIZON = 1e-9       # cosine below which a direction is on the horizon, but for rounding


def read(content: bytes, reading: Reading = BY_DEFAULT) -> Samples:
    """Read a Zemax file; XYZ becomes linear sRGB. Raises DatasetError if it is malformed, or of transmitted light."""
    words, angles = _header(content)
    tables, totals = zip(*(_table(begin, angles) for begin in islice(_BEGIN.finditer(content), 4)), strict=True)
    expected = 3 if words["SpectralContent"] == "XYZ" else 1
    if len(tables) != expected:
        raise DatasetError(f"{len(tables)} tables found, expected {expected} for the SpectralContent "
                           f"{words['SpectralContent']}")
    shape = [len(angles[name]) for name in _ANGLES]      # (rotation, incidence, azimuth, radial)
    values = (np.stack(tables, axis=-1) if expected > 1 else tables[0][..., None]).reshape(*shape, expected)
    notes = _totals_note(angles, values[..., expected // 2], totals[expected // 2].reshape(shape[:2]))      # Y of XYZ
    measured = _is_measured(values, angles["ScatterRadial"] == 0)
    directions = _directions(angles, measured)
    if not measured.any():
        raise DatasetError("no measurement above the horizon: all values are 0")
    values = values[measured]
    channels: tuple[str, ...] = ("grey",)
    if expected == 3:
        channels, values = RGB, values @ XYZ_TO_SRGB.T
    samples = decide_symmetry(Samples(*directions, values, channels, "", notes=notes), reading)
    symmetrical = words["Symmetry"].lower().startswith("planesymmetrical")
    if samples.isotropic:
        lacks = not symmetrical and not np.ptp(samples.phi_i)
        return replace(samples, notes=(*samples.notes, _ONE_ROTATION)) if lacks else samples
    return _both_sides(samples) if symmetrical else samples


def _is_measured(values: FloatArray, mirrored: BoolArray) -> BoolArray:
    """Which values are not 0: (rotation, incidence, azimuth, radial); of the mirrored ray only one, which gets their
    mean.
    """
    measured = np.asarray(values.any(axis=-1))
    for radial in np.flatnonzero(mirrored):
        here = measured[:, :, :, radial]
        count = np.maximum(here.sum(axis=2), 1)[..., None]
        values[:, :, 0, radial] = values[:, :, :, radial].sum(axis=2) / count
        here[:, :, 0] = here.any(axis=2)
        here[:, :, 1:] = False
    return measured


def _directions(angles: _Angles, measured: BoolArray) -> Directions:
    """Those of the values that were measured, radians; those below the horizon no longer count as measured."""
    theta, azimuth, radial = np.meshgrid(*(np.radians(angles[name]) for name in _TABLE_KEYS), indexing="ij",
                                         sparse=True)
    z = np.cos(theta) * np.cos(radial) + np.sin(theta) * (np.sin(radial) * np.cos(azimuth))
    measured &= z > _ZEMAX_HORIZON
    x = np.cos(theta) * (np.sin(radial) * np.cos(azimuth)) - np.sin(theta) * np.cos(radial)
    rotation = _TURNS * np.radians(angles["SampleRotation"])
    phi = rotation if len(rotation) > 1 else np.zeros(1)
    x, y, z, theta, phi = (np.broadcast_to(array, measured.shape)[measured] for array in (
        x, np.sin(radial) * np.sin(azimuth), z, np.minimum(theta, HORIZON), phi[:, None, None, None]))
    return theta, phi, np.arctan2(np.hypot(x, y), z), np.arctan2(y, x) + phi


def _both_sides(samples: Samples) -> Samples:
    """Samples on one side of the plane of incidence, and on the other as well."""
    sideways = np.flatnonzero(np.abs(np.sin(samples.phi_o - samples.phi_i)) > _ZEMAX_HORIZON)
    both = subset(samples, np.concatenate([np.arange(len(samples)), sideways]))
    phi_o = both.phi_o.copy()
    phi_o[len(samples):] = 2 * both.phi_i[len(samples):] - phi_o[len(samples):]
    note = f"Symmetrical about the plane of incidence: {len(samples):,} samples stand for {len(phi_o):,}"
    return replace(both, phi_o=phi_o, notes=(*samples.notes, note))


def _totals_note(angles: _Angles, values: FloatArray, totals: FloatArray) -> tuple[str, ...]:
    """A note where the TIS of the file, `totals`, (rotation, incidence), and the integral of its values, (rotation,
    incidence, azimuth, radial), differ, of the incidence that differs most. Totals that it does not say are no numbers.
    """
    theta_i, azimuth, radial = (np.radians(angles[name]) for name in _TABLE_KEYS)
    if (np.diff(azimuth) <= 0).any() or (np.diff(radial) <= 0).any():
        return ()
    weight = np.stack([weights(azimuth, radial, theta) for theta in theta_i])
    found = np.einsum("riap,iap->ri", values, weight)
    with np.errstate(invalid="ignore"):
        apart = np.where(np.isfinite(totals), np.abs(found - totals) / np.maximum(np.abs(totals), _ZEMAX_HORIZON), 0)
    if not (apart > _TOLD).any():
        return ()
    rotation, incidence = np.unravel_index(apart.argmax(), apart.shape)
    return (f"TIS: at {np.degrees(theta_i[incidence]):g} degrees of incidence the file says "
            f"{totals[rotation, incidence]:.4g}, its values integrate to {found[rotation, incidence]:.4g}; "
            f"{np.count_nonzero(apart > _TOLD):,} of {apart.size:,} differ by more than a tenth",)


def _header(content: bytes) -> tuple[dict[str, str], _Angles]:
    """Read what stands before the tables, words and angles by keyword, and refuse what is not a BRDF."""
    begin = _BEGIN.search(content)
    if begin is None:
        raise DatasetError("no line DataBegin")
    if _LIGHTTOOLS.match(content, begin.end()):
        raise line_error(begin, "a BSDF of LightTools, which is not read; export it as Zemax .bsdf, or write its "
                         "reflectance as a table with column names")
    words: dict[str, str] = {}
    angles: _Angles = {}
    for line in _ZEMAX_KEYWORD.finditer(content, 0, begin.start()):
        keyword = decode(line[1])
        if keyword in words or keyword in angles:
            raise line_error(line, f"{keyword} a second time")
        if keyword in _WORD_KEYS:
            words[keyword] = decode(line[2])
        else:
            angles[keyword] = _angles(line, begin.start(), _ANGLES[keyword])
    missing = [keyword for keyword in (*_WORD_KEYS, *_ANGLES) if keyword not in words and keyword not in angles]
    if missing:
        raise DatasetError(f"no line {', '.join(missing)} before DataBegin")
    symmetry, spectrum, scatter = (words[name] for name in _WORD_KEYS)
    if scatter.upper() != "BRDF":
        raise DatasetError(f"ScatterType {scatter} found, expected BRDF: transmitted light cannot be used")
    if symmetry.lower().removesuffix("4d") not in ("planesymmetrical", "asymmetrical"):
        raise DatasetError(f"Symmetry {symmetry} found, expected PlaneSymmetrical or Asymmetrical, or either with 4D")
    if spectrum not in ("Monochrome", "XYZ"):
        raise DatasetError(f"SpectralContent {spectrum} found, expected Monochrome or XYZ")
    return words, angles


def _angles(line: re.Match[bytes], end: int, limits: tuple[int, int]) -> FloatArray:
    """The angles in degrees on the line after a keyword and their number."""
    keyword = decode(line[1])
    count = parse_number(line[2], line)
    row = next(lines(line.string, line.end(), end), None)
    if not 1 <= count <= len(line.string) or count != int(count) or row is None:
        raise line_error(line, f"{keyword} {count:g} found, expected a number of angles, and these on the next line")
    numbers = np.array(parse_row(row, None, int(count), f"the angles of {keyword}"))
    if numbers.min() < limits[0] or numbers.max() > limits[1]:
        raise line_error(row, f"{keyword} from {numbers.min():g} to {numbers.max():g} found, expected {limits[0]} to "
                         f"{limits[1]} degrees")
    return numbers


def _table(begin: re.Match[bytes], angles: _Angles) -> tuple[FloatArray, FloatArray]:
    """The values between DataBegin and DataEnd, (rotation x incidence, azimuth, radial), and their TIS, (rotation x
    incidence)."""
    content, start = begin.string, begin.end()
    data_end = _DATA_END.search(content, start)
    if data_end is None:
        raise line_error(begin, "no line DataEnd after DataBegin")
    end = data_end.start()
    incidences, azimuths, radials = (angles[name] for name in _TABLE_KEYS)
    most = len(angles["SampleRotation"]) * len(incidences)
    totals = [*islice(_TIS.finditer(content, start, end), most + 1)]
    if len(totals) != most:
        shown = f"{len(totals)}" if len(totals) < most else f"more than {most}"
        raise line_error(begin, f"{shown} lines TIS found, expected {most}, one for each angle of incidence and sample "
                         f"rotation")
    if content[start:totals[0].start()].strip():
        raise line_error(begin, "expected a line TIS after DataBegin")
    blocks = []
    for total, last in zip(totals, [*(line.start() for line in totals[1:]), end], strict=True):
        block = parse_rows(content, total.end(), len(radials), "a value for each angle of ScatterRadial", None, last)
        if len(block) != len(azimuths):
            raise line_error(total, f"{len(block)} rows found, expected {len(azimuths)}, one for each angle of "
                             f"ScatterAzimuth")
        blocks.append(block)
    said = np.array([(floats(line[1], line[1].split()) or [np.nan])[0] for line in totals])
    return np.array(blocks) if len(blocks) > 1 else blocks[0][None], said


FORMAT = Format("Zemax", "Zemax .bsdf", (".bsdf",), _MARK.search, read, ("isotropic", "symmetry"), largest=_LARGEST)

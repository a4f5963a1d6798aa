"""Materials of EPFL's Realistic Graphics Lab (.bsdf): named arrays, which make a function, `RglTable`.

The samples are its values at the nodes of its grid and between (`direction_sampling`): there the angles of incidence
are up to 30 degrees apart, and the grid is wide where the density of half vectors is not even (docs/layouts.md, RGL).
"""

import math
import struct
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..arrays import FloatArray, concatenate_directions
from ..coordinates import direction_sampling
from ..errors import DatasetError
from ..samples import HALF_TURN, HALF_TURN_AND_MIRROR, HORIZON, LARGEST_VALUE, RGB, Samples, apply_symmetry
from . import rgl_warp
from .format import Format
from .isotropy import rotations_note
from .reading import BY_DEFAULT, Reading
from .rgl_table import FEWEST_AZIMUTHS, RglTable, reduction
from .spectra import to_linear_srgb
from .text import decode

LARGEST = 160 << 20         # bytes; a spectral file has up to 15 million, of an anisotropic material 17 times as many
_TENSOR_MAGIC = b"tensor_file\0"
_TENSOR_VERSION = b"\1\0"
_TYPES = dict(enumerate(("<u1", "<i1", "<u2", "<i2", "<u4", "<i4", "<u8", "<i8", "<f2", "<f4", "<f8"), 1))
_MOST_DIMENSIONS = 8
_NEEDED_FIELDS = ("phi_i", "theta_i", "sigma", "ndf", "vndf", "luminance", "jacobian")
_MOST_INCIDENCES = 10_000   # directions of incidence of an anisotropic material; real files have 136
_MOST_BETWEEN = 4           # samples between, for each node; published files have 3
_LONG, _PRODUCT = 40, 26        # characters of a name, and of the product in brackets that ends a description
_LAST_MEASURED = np.radians(89)     # at most; what is tabulated beyond is an extrapolation
_SYMMETRIES = {1: "none", 2: HALF_TURN, 4: HALF_TURN_AND_MIRROR}    # by how often the azimuths go into a turn


def read(content: bytes, reading: Reading = BY_DEFAULT) -> Samples:
    """Read a .bsdf file: its values at the nodes of its grid and between; spectra become linear sRGB."""
    table = read_table(content, reading)
    nodes = table.nodes()
    count = len(nodes[0])
    if not count:
        raise DatasetError("no measurement above the horizon")
    most = min(direction_sampling.SAMPLED_COUNT, _MOST_BETWEEN * count) if table.isotropic else count
    others = direction_sampling.sample_directions(most, table.isotropic)
    directions = concatenate_directions([nodes[:4], others])
    values = np.concatenate([nodes[4], table.evaluate(*others)])
    at = f"{len(table.theta_i)} angles of incidence" + ("" if table.isotropic else f" and {len(table.phi_i)} azimuths")
    note = f"{count:,} nodes at {at}, {len(values) - count:,} between by the interpolation that the file defines"
    if table.theta_i[-1] > _LAST_MEASURED:
        note += f"; beyond {np.degrees(table.theta_i[-2]):.0f} degrees it is the authors' extrapolation"
    notes = (note, *table.notes, *([] if table.isotropic else [rotations_note(nodes[0], nodes[1])]))
    samples = Samples(*directions, values, RGB, table.name, notes=notes, isotropic=table.isotropic)
    return apply_symmetry(samples, _SYMMETRIES[table.reduction])


def read_table(content: bytes, reading: Reading = BY_DEFAULT) -> RglTable:
    """Read a .bsdf file as the function that it defines; raises `DatasetError` as `read` does."""
    fields = read_arrays(content)
    colour = "spectra" if "spectra" in fields else "rgb"
    needed = (*_NEEDED_FIELDS, colour, *(["wavelengths"] if colour == "spectra" else []))
    missing = [name for name in needed if name not in fields]
    if missing:
        raise DatasetError(f"no array {', '.join(missing)}; expected those of an RGL material, {', '.join(needed)}")
    azimuths, angles = fields["phi_i"].size, fields["theta_i"].size
    for name, leading in (("phi_i", (azimuths,)), ("theta_i", (angles,)), ("sigma", (None, None)),
                          ("ndf", (None, None)), ("vndf", (azimuths, angles, None, None)),
                          ("luminance", (azimuths, angles, None, None)), ("jacobian", (1,)),
                          (colour, (azimuths, angles, None, None, None))):
        _check_shape(fields[name], name, leading)
    return _table(fields, colour, reading)


def _table(fields: dict[str, NDArray[Any]], colour: str, reading: Reading) -> RglTable:
    """The table of arrays whose shapes have been checked."""
    theta_i = _finite(fields["theta_i"], "theta_i")
    if len(theta_i) < 2 or (np.diff(theta_i) <= 0).any() or theta_i[0] < 0 or theta_i[-1] > HORIZON + 1e-5:
        raise DatasetError("theta_i must hold at least two rising angles from 0 to pi/2 radians")
    ndf, sigma, density = (_finite(fields[name], name) for name in ("ndf", "sigma", "vndf"))
    if ndf.min() < 0 or sigma.min() <= 0 or density.min() < 0 or not (density.sum(axis=(-2, -1)) > 0).all():
        raise DatasetError("ndf, sigma and vndf must not be negative, nor sigma or a slice of vndf zero")
    channels, size = fields[colour].shape[2:4]
    if size != fields[colour].shape[4]:
        raise DatasetError(f"{colour} has the shape {fields[colour].shape}, expected square tables")
    if colour == "rgb" and channels != len(RGB):
        raise DatasetError(f"rgb has {channels} channels, expected {len(RGB)}")
    azimuths = _azimuths(fields, colour)
    weights = (np.eye(len(RGB)) if colour == "rgb" else
               _weights(fields["wavelengths"], channels, reading.illuminant))
    values = np.zeros((len(azimuths), len(theta_i), size, size, len(RGB)))
    for band in range(channels):        # one at a time, to save memory
        values += _finite(fields[colour][:len(azimuths), :, band], colour)[..., None] * weights[:, band]
    density = density[:len(azimuths)]
    name = decode(fields["description"].tobytes()).strip() if "description" in fields else ""
    return RglTable(theta_i, ndf, sigma, rgl_warp.warp(density.reshape(-1, *density.shape[2:])),
                    values.reshape(-1, *values.shape[2:]), bool(fields["jacobian"][0]),
                    _short(name) if name and name.isprintable() else "",
                    ((name,) if name and name.isprintable() and name != _short(name) else ())
                    + tuple(reading.notes if colour == "spectra" else ()), azimuths)


def _short(description: str) -> str:
    """A name of a description of up to a hundred characters: the product that it ends with, or what stands before a
    remark; else its first words.

    Examples
    --------
    >>> _short("TeckWrap vinyl wrapping film (Mint CHM16E)"), _short("Green paint (on steel, with a primer, of 2016)")
    ('Mint CHM16E', 'Green paint')
    """
    head, _, remark = description.partition(" (")
    if len(description) <= _LONG or not head:
        return description
    if remark.endswith(")") and len(remark) <= _PRODUCT:
        return remark[:-1]
    return head if len(head) <= _LONG else head[:_LONG].rpartition(" ")[0] or head[:_LONG]


def _azimuths(fields: dict[str, NDArray[Any]], colour: str) -> FloatArray:
    """The azimuths of incidence, radians; one, 0, of an isotropic material."""
    phi_i = _finite(fields["phi_i"], "phi_i")
    if len(phi_i) < FEWEST_AZIMUTHS:
        for name in ("vndf", colour):
            if not np.array_equal(fields[name][0], fields[name][-1]):
                raise DatasetError(f"{name} differs between two azimuths phi_i, expected at least {FEWEST_AZIMUTHS} of "
                                   f"an anisotropic material")
        return np.zeros(1)
    if len(phi_i) * fields["theta_i"].size > _MOST_INCIDENCES:
        raise DatasetError(f"{len(phi_i):,} azimuths and {fields['theta_i'].size:,} angles of incidence found, "
                           f"expected at most {_MOST_INCIDENCES:,} pairs")
    if (np.diff(phi_i) <= 0).any() or np.abs(phi_i).max() > 4 * np.pi or reduction(phi_i) not in _SYMMETRIES:
        raise DatasetError(f"phi_i from {np.degrees(phi_i[0]):g} to {np.degrees(phi_i[-1]):g} degrees found, expected "
                           f"rising angles over a turn, a half or a quarter of it")
    return phi_i


def _check_shape(array: NDArray[Any], name: str, expected: tuple[int | None, ...]) -> None:
    """Raise `DatasetError` unless the array has these dimensions; None stands for any number from 2."""
    if array.ndim != len(expected) or not all(size >= 2 if wanted is None else size == wanted
                                              for size, wanted in zip(array.shape, expected, strict=True)):
        shown = ", ".join("2 or more" if wanted is None else str(wanted) for wanted in expected)
        raise DatasetError(f"{name} has the shape {array.shape}, expected ({shown})")


def _finite(array: NDArray[Any], name: str) -> FloatArray:
    numbers = array.astype(float)
    if not (np.abs(numbers) <= LARGEST_VALUE).all():
        raise DatasetError(f"{name} holds numbers that are not finite, or larger than {LARGEST_VALUE:g}")
    return numbers


def _weights(wavelengths: NDArray[Any], bands: int, illuminant: str) -> FloatArray:
    """The matrix from spectra to linear sRGB: (3, bands)."""
    _check_shape(wavelengths, "wavelengths", (bands,))
    return to_linear_srgb(_finite(wavelengths, "wavelengths"), np.eye(bands), illuminant=illuminant).T


def read_arrays(content: bytes) -> dict[str, NDArray[Any]]:
    """The arrays of the container, by name: read-only, of the file's types. They look into the content: no copies."""
    start = len(_TENSOR_MAGIC) + len(_TENSOR_VERSION)
    if content[:start] != _TENSOR_MAGIC + _TENSOR_VERSION:
        raise DatasetError(f"tensor file of version {tuple(content[len(_TENSOR_MAGIC):start])}, expected (1, 0)")
    arrays: dict[str, NDArray[Any]] = {}
    try:
        count, = struct.unpack_from("<I", content, start)
        at = start + 4
        for _ in range(count):
            size, = struct.unpack_from("<H", content, at)
            at += 2 + size
            name = decode(content[at - size:at])
            dimensions, kind, offset = struct.unpack_from("<HBQ", content, at)
            if dimensions > _MOST_DIMENSIONS:
                raise ValueError(f"{name!r:.40} has {dimensions} dimensions, expected at most {_MOST_DIMENSIONS}")
            shape = struct.unpack_from(f"<{dimensions}Q", content, at + 11)
            at += 11 + 8 * dimensions
            if name in arrays:
                raise ValueError(f"two arrays are named {name!r:.40}")
            arrays[name] = _array(content, name, kind, offset, shape)
    except struct.error as error:
        message = f"a damaged tensor file: {len(content):,} bytes end within the table of its arrays"
        raise DatasetError(message) from error
    except ValueError as error:
        raise DatasetError(f"a damaged tensor file: {error}") from error
    return arrays


def _array(content: bytes, name: str, kind: int, offset: int, shape: tuple[int, ...]) -> NDArray[Any]:
    if kind not in _TYPES:
        raise ValueError(f"{name!r:.40} is of the type {kind}, expected 1 to {len(_TYPES)}")
    size = math.prod(shape)
    end = offset + size * np.dtype(_TYPES[kind]).itemsize
    if end > len(content):
        raise ValueError(f"{name!r:.40} should end at byte {end:,}, and the file has {len(content):,}")
    return np.frombuffer(content, _TYPES[kind], size, offset).reshape(shape)


FORMAT = Format("RGL", "RGL .bsdf", (".bsdf",), lambda content: content.startswith(_TENSOR_MAGIC), read,
                ("illuminant",), is_text=False, largest=LARGEST)

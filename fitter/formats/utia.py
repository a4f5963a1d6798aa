"""UTIA's database of anisotropic reflectance (.bin): float64, whose encoding is not written down (docs/layouts.md,
UTIA). Where a direction is the normal, the sample is the mean of the 48 azimuths."""


import numpy as np

from ..arrays import FloatArray, map_directions
from ..colours import decode_srgb
from ..errors import DatasetError
from ..samples import LARGEST_VALUE, RGB, Samples
from .format import Format
from .isotropy import decide_symmetry
from .reading import BY_DEFAULT, Reading

THETAS, PHIS = 6, 48
GRID_STEPS = np.radians(15), np.radians(7.5)    # of theta, of phi
_DIRECTION_COUNT = THETAS * PHIS
SIZE = 3 * _DIRECTION_COUNT ** 2 * 8            # bytes
_SMALLEST, _LARGEST = 1e-8, 1e8                 # of the numbers that are not zero, their median
_MOST_NEGATIVE = 0.05                           # of all numbers: noise of dark directions
_NOTES = {"raw": "Values as they are stored; UTIA's files are also taken as encoded: choose the option encoding",
          "srgb": "Values decoded from sRGB, as asked", "srgb140": "Values / 140 decoded from sRGB, x 100, as asked"}


def recognises(content: bytes) -> bool:
    """Whether a file has the size, and numbers that can be reflectances."""
    if len(content) != SIZE:
        return False
    numbers = np.frombuffer(content, "<f8")
    if not np.isfinite(numbers).all() or np.count_nonzero(numbers < 0) > _MOST_NEGATIVE * len(numbers):
        return False
    sizes = np.abs(numbers[numbers != 0])
    return bool(len(sizes) and sizes.max() <= LARGEST_VALUE and _SMALLEST < np.median(sizes) < _LARGEST)


def read(content: bytes, reading: Reading = BY_DEFAULT) -> Samples:
    """Read a .bin file. Raises DatasetError if the size or the numbers are no such file's."""
    if not recognises(content):
        raise DatasetError(f"{len(content):,} bytes, expected {SIZE:,} of reflectances")
    stored = np.frombuffer(content, "<f8").reshape(3, THETAS, PHIS, THETAS, PHIS)
    values = np.moveaxis(_decode(stored, reading.encoding), 0, -1).copy()       # (theta_i, phi_i, theta_o, phi_o, 3)
    values[0, 0] = values[0].mean(axis=0)
    values[:, :, 0, 0] = values[:, :, 0].mean(axis=2)
    distinct = np.ones(values.shape[:-1], dtype=bool)
    distinct[0, 1:] = distinct[:, :, 0, 1:] = False
    theta, phi = np.arange(THETAS) * GRID_STEPS[0], np.arange(PHIS) * GRID_STEPS[1]
    axes = np.meshgrid(theta, phi, theta, phi, indexing="ij", sparse=True)
    directions = map_directions(lambda axis: np.broadcast_to(axis, distinct.shape)[distinct], axes)
    values = values[distinct]
    samples = Samples(*directions, values, RGB, "", notes=(_NOTES[reading.encoding],))
    return decide_symmetry(samples, reading)


def _decode(stored: FloatArray, encoding: str) -> FloatArray:
    """The BRDF of what is stored, with one of `_NOTES`; of any shape."""
    if encoding == "raw":
        return stored
    if encoding == "srgb":
        return decode_srgb(stored)
    return 100 * decode_srgb(np.maximum(stored, 0) / 140, 0.0375)       # the reader has this threshold


FORMAT = Format("UTIA", "UTIA .bin", (".bin",), recognises, read, ("isotropic", "encoding"), is_text=False,
                largest=SIZE)

"""NVIDIA's measured materials of the Material Definition Language (.mbsdf), isotropic: a table of float32 by theta_in,
theta_out and phi, of which the reflection is read (docs/layouts.md, MBSDF).

Where theta_in or theta_out is 0 all phi are one direction: the sample is their mean.
"""

import math
import struct

import numpy as np

from ..arrays import map_directions
from ..errors import DatasetError
from ..samples import HORIZON, RGB, Samples
from . import unmeasured
from .format import Format
from .reading import BY_DEFAULT, Reading

MBSDF_MAGIC = b"NVIDIA ARC MBSDF V"
_BLOCKS = b"\nMBSDF_DATA=\n", b"\nMBSDF_DATA_REFLECTION=\n"
_TRANSMISSION = b"MBSDF_DATA_TRANSMISSION=\n"
_MBSDF_HEADER = struct.Struct("<3I")
_LARGEST = 32 << 20


def read(content: bytes, reading: Reading = BY_DEFAULT) -> Samples:
    """Read the reflection of an .mbsdf file."""
    starts = [content.find(block) + len(block) for block in _BLOCKS if block in content]
    if not starts:
        what = "transmitted light only" if _TRANSMISSION in content else "no line MBSDF_DATA= or MBSDF_DATA_REFLECTION="
        raise DatasetError(f"{what}, expected reflection")
    start = min(starts)
    if len(content) < start + _MBSDF_HEADER.size:
        raise DatasetError("it ends before the table")
    kind, thetas, phis = _MBSDF_HEADER.unpack_from(content, start)
    if kind not in (0, 1) or thetas < 2 or phis < 2:
        raise DatasetError(f"type {kind}, {thetas} x {thetas} x {phis} values found, expected type 0 or 1 and at least "
                           f"2 values along each axis")
    shape = thetas, thetas, phis, 3 if kind else 1
    start += _MBSDF_HEADER.size
    end = start + 4 * math.prod(shape)
    if end > len(content) or (end < len(content) and not content.startswith(_TRANSMISSION, end)):
        raise DatasetError(f"{len(content) - start:,} bytes of values found, expected {end - start:,} for "
                           f"{' x '.join(map(str, shape))} float32")
    values = np.frombuffer(content, "<f4", math.prod(shape), start).reshape(shape).astype(float)
    if not np.isfinite(values).all():
        raise DatasetError("holds numbers that are not finite")
    distinct = np.ones(shape[:3], dtype=bool)
    distinct[0, :, 1:] = distinct[:, 0, 1:] = False
    for at_normal in (values[0], values[:, 0]):
        at_normal[:] = at_normal.mean(axis=1, keepdims=True)
    values[0, 0] = values[0, 0].mean(axis=0)
    theta = np.arange(thetas) / thetas * HORIZON
    phi = np.arange(phis) / (phis - 1) * np.pi
    directions = map_directions(lambda axis: np.broadcast_to(axis, distinct.shape)[distinct],
                                (theta[:, None, None], 0.0, theta[:, None], phi))
    values = values[distinct]
    samples = Samples(*directions, values, RGB if kind else ("grey",), "")
    return unmeasured.remove_unmeasured(samples, reading)


FORMAT = Format("NVIDIA", "NVIDIA .mbsdf", (".mbsdf",), lambda content: content.startswith(MBSDF_MAGIC), read,
                ("keep_unmeasured",), is_text=False, largest=_LARGEST)

"""Fits as files: NumPy .npz, versioned, without pickled objects, and checked on reading.

Entries: `header` (JSON text: format, version, coordinates, transform, levels, compression, channels, columns, changes,
name, source), `diffuse`, for a bi-level fit `coefficients`, `keys`, `displacement`, and for a log-relative one
`prior_kd`, `prior_ks`, `prior_alpha`, `prior_gamma`, `prior_f0`, `prior_ceiling`.
"""

import io
import json

import numpy as np

from .. import files
from ..coordinates.half_difference import HalfDifference
from ..coordinates.nusselt import Nusselt
from ..errors import DatasetError
from ..lattice import dense, perfect_hash
from ..lattice.sparse import SparseLattice
from ..samples import LARGEST_VALUE
from . import microfacet, npz
from .transform import IDENTITY, LEAST_OFFSET, LogRelative

FORMAT = "measured-brdf-fit"
VERSION = 4
_READ = (2, 3, 4)           # 2 had no softening; 2 and 3 did not name coordinates and transform
LARGEST = 100 * LARGEST_VALUE   # of any number: single precision has room for what the shader makes of it
_LEAST_CEILING = float(np.finfo(np.float32).tiny)
_PRIOR = ("kd", "ks", "alpha", "gamma", "f0")


def write(fit, path):
    """Write a `Fit` to `path`."""
    coordinates, transform = fit.coordinates, fit.transform
    header = {"format": FORMAT, "version": VERSION, "coordinates": coordinates.name, "transform": transform.name,
              "diffuse_level": int(fit.diffuse_level),
              "specular_level": fit.specular_level, "compression": fit.compression,
              "channels": list(fit.channels), "columns": list(fit.columns), "changes": list(fit.changes),
              "name": str(fit.name), "source": str(fit.source)}
    arrays = {"diffuse": fit.diffuse.control_points}
    if fit.specular is not None:
        index = fit.specular.index
        header["multiplier"] = index.multiplier
        arrays |= {"coefficients": fit.specular.coefficients, "keys": index.keys, "displacement": index.displacement}
    if isinstance(coordinates, HalfDifference):
        header["softening"] = float(coordinates.softening)
    if isinstance(transform, LogRelative):
        header |= {"offset": transform.offset, "plausible": bool(transform.floor == 0)}
        arrays |= {f"prior_{name}": getattr(transform.prior, name) for name in _PRIOR}
        arrays["prior_ceiling"] = transform.ceiling
    content = io.BytesIO()      # not straight to the file: on a full disk an unfinished ZipFile complains on its own
    np.savez_compressed(content, header=np.array(json.dumps(header)), **arrays)
    with files.replacing(path) as stream:
        stream.write(content.getbuffer())


def read(path):
    """Read what `write` wrote: the keyword arguments of a `Fit`.

    Raises
    ------
    DatasetError
        If it is not there, or not a fit of this version, or its parts contradict each other.
    """
    content = files.read_bytes(path, npz.LARGEST)
    try:
        entries = npz.read(content)
        header = json.loads(str(entries.pop("header")))
        if not isinstance(header, dict) or header.get("format") != FORMAT:
            raise ValueError("no header of a fit")
    except (ValueError, KeyError, RecursionError) as error:
        raise DatasetError("not a fit saved by Measured BRDF", path) from error
    if header.get("version") not in _READ:
        raise DatasetError(f"a fit of version {header.get('version')!r}, expected {VERSION}; fit the data again", path)
    try:
        return _assemble(header, entries)
    except (KeyError, TypeError, ValueError, OverflowError) as error:
        raise DatasetError(f"a damaged fit: {error}", path) from error


def _assemble(header, entries):
    channels = tuple(header["channels"])
    _check(channels and all(isinstance(name, str) for name in channels), "its channels are not names")
    columns, changes = tuple(header["columns"]), tuple(header["changes"])
    _check(len(columns) == len(channels) and all(type(i) is int and 0 <= i < len(columns) for i in columns)
           and set(columns) == set(range(max(columns) + 1)), "its channels read columns that are not there")
    _check(all(isinstance(change, str) for change in changes), "its changes are not text")
    parts = {"channels": channels, "columns": columns, "changes": changes,
             "name": str(header["name"]), "source": str(header["source"])}
    stored = max(columns) + 1
    level = _level(header["diffuse_level"])
    diffuse = _array(entries, "diffuse", (*dense.shape(level), stored), np.float32)
    parts |= {"diffuse": dense.DenseLattice(level, diffuse), "coordinates": _coordinates(header, entries),
              "transform": _transform(header, entries, stored)}
    if header["specular_level"] is None:
        return parts

    level = _level(header["specular_level"])
    compression = float(header["compression"])
    _check(0 <= compression <= 100, "its compression is not a percentage")
    keys = entries["keys"]
    n = len(keys)
    _check(n <= np.prod(dense.shape(level)), "more keys than its lattice has control points")
    keys = _array(entries, "keys", (n,), np.uint32)
    displacement = entries["displacement"]
    _check(displacement.ndim == 1 and len(displacement) and displacement.dtype in (np.uint16, np.uint32),
           "its hash table is not a table")
    _check(displacement.max() < max(n, 1), "its hash table points outside")
    multiplier = header["multiplier"]
    _check(type(multiplier) is int and 0 < multiplier < perfect_hash.MULTIPLIERS, "its hash function is unknown")
    _check(not n or keys.max() < np.prod(dense.shape(level)), "a key lies outside its lattice")
    index = perfect_hash.PerfectHash(keys, displacement, multiplier)
    _check((index.slots(keys) == np.arange(n)).all(), "its hash table does not find its keys")
    coefficients = _array(entries, "coefficients", (n, stored), np.float32)
    return parts | {"specular": SparseLattice(level, index, coefficients), "compression": compression}


def _coordinates(header, entries):
    name = _named(header, "coordinates", Nusselt.name, HalfDifference.name, entries)
    if name == Nusselt.name:
        return Nusselt()
    softening = 0.0 if header["version"] == 2 else header["softening"]
    _check(isinstance(softening, float) and 0 <= softening < 1, "its softening radius is not one")
    return HalfDifference(softening)


def _transform(header, entries, stored):
    name = _named(header, "transform", IDENTITY.name, LogRelative.name, entries)
    return IDENTITY if name == IDENTITY.name else _log_relative(header, entries, stored)


def _named(header, part, plain, other, entries):
    """Which of two a part is; before version 4, that of fits with or without a prior."""
    if header["version"] < 4:
        return other if "prior_kd" in entries else plain
    _check(header[part] in (plain, other), f"its {part} are unknown")
    return header[part]


def _log_relative(header, entries, stored):
    ks = entries["prior_ks"]
    lobes = len(ks) if ks.ndim else 0
    _check(lobes <= microfacet.MAX_LOBES, "its prior has too many lobes")
    shapes = {"kd": (stored,), "ks": (lobes, stored), "alpha": (lobes,), "gamma": (lobes,), "f0": (lobes,)}
    prior = microfacet.Microfacet(**{name: _array(entries, f"prior_{name}", shapes[name], np.float64)
                                     for name in _PRIOR})
    for name, (low, high) in microfacet.RANGES.items():
        _check_range(f"prior_{name}", getattr(prior, name), low, high)
    ceiling = _array(entries, "prior_ceiling", (stored,), np.float64)
    offset = header["offset"]
    _check(type(offset) in (int, float), "its offset is not a number")
    for name, numbers, low in (("kd", prior.kd, 0), ("ks", prior.ks, 0), ("ceiling", ceiling, _LEAST_CEILING),
                               ("offset", np.array([offset], dtype=float), LEAST_OFFSET)):
        _check_range(f"prior_{name}", numbers, low, LARGEST)
    plausible = header["plausible"]
    _check(isinstance(plausible, bool), "it does not say whether it is plausible")
    return LogRelative(prior, float(offset), ceiling, 0.0 if plausible else -np.inf)


def _level(level):
    _check(type(level) is int and 0 <= level <= dense.MAX_LEVEL, f"level {level!r} does not exist")
    return level


def _array(entries, name, shape, dtype):
    array = entries[name]
    _check(array.shape == shape and array.dtype == dtype,
           f"{name} is {array.dtype} {array.shape}, expected {np.dtype(dtype)} {shape}")
    _check_range(name, array, -LARGEST, LARGEST)
    return array


def _check_range(name, numbers, low, high):
    """Neither NaN nor infinite, nor outside; without a copy of what may be a large array."""
    _check(not numbers.size or (low <= numbers.min() and numbers.max() <= high),
           f"{name} holds numbers that are not within {low:g} to {high:g}")


def _check(condition, message):
    if not condition:
        raise ValueError(message)

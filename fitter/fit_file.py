"""Fits as files: NumPy .npz, versioned, without pickled objects, and checked on reading.

Entries: `header` (JSON text: format, version, levels, compression, channels, name, source), `diffuse`, and for a
bi-level fit `coefficients`, `keys`, `displacement`.
"""

import io
import json

import numpy as np

from . import archive, files, lattice, perfect_hash
from .errors import DatasetError
from .sparse_lattice import SparseLattice

FORMAT = "measured-brdf-fit"
VERSION = 1


def write(fit, path):
    """Write a `Fit` to `path`."""
    header = {"format": FORMAT, "version": VERSION, "diffuse_level": int(fit.diffuse_level),
              "specular_level": fit.specular_level, "compression": fit.compression,
              "channels": list(fit.channels), "name": str(fit.name), "source": str(fit.source)}
    arrays = {"diffuse": fit.diffuse}
    if fit.specular is not None:
        index = fit.specular.index
        header["multiplier"] = index.multiplier
        arrays |= {"coefficients": fit.specular.coefficients, "keys": index.keys, "displacement": index.displacement}
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
    content = files.read_bytes(path, archive.LARGEST)
    try:
        entries = archive.read(content)
        header = json.loads(str(entries.pop("header")))
        if not isinstance(header, dict) or header.get("format") != FORMAT:
            raise ValueError("no header of a fit")
    except (ValueError, KeyError, RecursionError) as error:
        raise DatasetError("not a fit saved by Measured BRDF", path) from error
    if header.get("version") != VERSION:
        raise DatasetError(f"a fit of version {header.get('version')!r}, expected {VERSION}; fit the data again", path)
    try:
        return _assemble(header, entries)
    except (KeyError, TypeError, ValueError) as error:
        raise DatasetError(f"a damaged fit: {error}", path) from error


def _assemble(header, entries):
    channels = tuple(header["channels"])
    _check(channels and all(isinstance(name, str) for name in channels), "its channels are not names")
    parts = {"channels": channels, "name": str(header["name"]), "source": str(header["source"])}
    level = _level(header["diffuse_level"])
    diffuse = _array(entries, "diffuse", (*lattice.shape(level), len(channels)), np.float32)
    parts |= {"diffuse_level": level, "diffuse": diffuse}
    if header["specular_level"] is None:
        return parts

    level = _level(header["specular_level"])
    compression = float(header["compression"])
    _check(0 <= compression <= 100, "its compression is not a percentage")
    keys = entries["keys"]
    n = len(keys)
    keys = _array(entries, "keys", (n,), np.uint32)
    displacement = entries["displacement"]
    _check(displacement.ndim == 1 and len(displacement) and displacement.dtype in (np.uint16, np.uint32),
           "its hash table is not a table")
    _check(displacement.max() < max(n, 1), "its hash table points outside")
    multiplier = header["multiplier"]
    _check(type(multiplier) is int and 0 < multiplier < perfect_hash.MULTIPLIERS, "its hash function is unknown")
    _check(not n or keys.max() < np.prod(lattice.shape(level)), "a key lies outside its lattice")
    index = perfect_hash.PerfectHash(keys, displacement, multiplier)
    _check((index.slots(keys) == np.arange(n)).all(), "its hash table does not find its keys")
    coefficients = _array(entries, "coefficients", (n, len(channels)), np.float32)
    return parts | {"specular": SparseLattice(level, index, coefficients), "compression": compression}


def _level(level):
    _check(type(level) is int and 0 <= level <= lattice.MAX_LEVEL, f"level {level!r} does not exist")
    return level


def _array(entries, name, shape, dtype):
    array = entries[name]
    _check(array.shape == shape and array.dtype == dtype,
           f"{name} is {array.dtype} {array.shape}, expected {np.dtype(dtype)} {shape}")
    _check(np.isfinite(array).all(), f"{name} holds numbers that are not finite")
    return array


def _check(condition, message):
    if not condition:
        raise ValueError(message)

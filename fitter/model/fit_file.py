"""Fits as files or bytes: NumPy .npz archives with a version, without pickled objects; every entry is checked on
reading.

The entries are arrays, and `header`, a JSON text. Those that all fits have are in `to_bytes`; besides there are the
arrays `coefficients`, `keys` and `displacement` of a bi-level fit; `prior_*` and `damping` of a log-relative one;
`edit_*` of an edited one; and in the header the parameters of the coordinates, `edit` and `subsurface`.
"""

import json
import math
from dataclasses import fields
from pathlib import Path
from typing import Any, cast

import numpy as np
from numpy.typing import DTypeLike, NDArray

from ..coordinates import COORDINATES, ISOTROPIC_AXES, Coordinates
from ..coordinates.rusinkiewicz import LEAST_SOFTENING
from ..coordinates.stretch import LARGEST_STRETCH, LEAST_STRETCH, NO_STRETCH
from ..errors import DatasetError
from ..lattice import dense, perfect_hash
from ..lattice.sparse import SparseLattice
from ..optics import subsurface
from ..samples import LARGEST_VALUE, RGB
from ..shader_constants import DAMPING_KNOTS
from ..storage import files, npz
from . import microfacet
from .edit import COAT_WIDTHS, WIDTH_BOUNDS, Edit
from .transform import LEAST_OFFSET, LogRelative

FIT_FORMAT = "measured-brdf-fit"
VERSION = 8
_IDENTITY = "identity"      # what files call no transform
_MOST_DESATURATED = 0.9
LARGEST_STORED = 100 * LARGEST_VALUE    # number: the shader's intermediate results stay finite in single precision
_LEAST_CEILING = float(np.finfo(np.float32).tiny)
_STRETCH, _AXIS_STRETCH = ((least, LARGEST_STRETCH) for least in (LEAST_STRETCH, LEAST_STRETCH / 10))
# parameters of coordinates, and their bounds; a stretch may be 0, too
_OF_COORDINATES = {"softening": (LEAST_SOFTENING, 0.9), "stretch": _STRETCH, "back_stretch": _STRETCH,
                   "along": _AXIS_STRETCH, "across": _AXIS_STRETCH, "turn": (-np.pi, np.pi)}
_PRIOR = ("kd", "ks", "alpha", "gamma", "f0")
_ANISOTROPIC_PRIOR = ("across", "turn")
_EDIT = ("diffuse", "highlight", "level", "balance", "through")
_EDIT_NUMBERS = {"width": WIDTH_BOUNDS, "coat": (0.0, 1.0), "coat_width": COAT_WIDTHS}
_Arrays = dict[str, NDArray[Any]]


def to_bytes(parts: dict[str, Any]) -> bytes:
    """A fit's keyword arguments as an .npz file, without the folders of its source; equal fits have equal bytes."""
    coordinates, transform, edit = parts["coordinates"], parts["transform"], parts["edit"]
    diffuse, specular, below = parts["diffuse"], parts["specular"], parts["subsurface"]
    # what every fit has
    header: dict[str, Any] = {
        "format": FIT_FORMAT, "version": VERSION, "coordinates": coordinates.name,
        "transform": _IDENTITY if transform is None else transform.name,
        "diffuse_level": int(diffuse.level), "specular_level": None if specular is None else specular.level,
        "compression": parts["compression"], "channels": list(parts["channels"]), "columns": list(parts["columns"]),
        "changes": list(parts["changes"]), "name": str(parts["name"]),
        "source": files.strip_folders(str(parts["source"]))}
    arrays: _Arrays = {"diffuse": diffuse.control_points}
    # the sparse lattice
    if specular is not None:
        index = specular.index
        header["multiplier"] = index.multiplier
        arrays |= {"coefficients": specular.coefficients, "keys": index.keys, "displacement": index.displacement}
    header |= {name: float(number) for name, number in vars(coordinates).items()}
    # the transform and its prior
    if transform is not None:
        header |= {"offset": transform.offset, "plausible": bool(transform.floor == 0), "grey": transform.desaturation,
                   "lobes": list(transform.prior.kinds)}
        names = _PRIOR if transform.prior.isotropic else (*_PRIOR, *_ANISOTROPIC_PRIOR)
        arrays |= {f"prior_{name}": getattr(transform.prior, name) for name in names}
        arrays |= {"prior_ceiling": transform.ceiling, "damping": transform.damping}
    # edit and subsurface, where there are any
    if edit is not None:
        header["edit"] = {name: float(getattr(edit, name)) for name in _EDIT_NUMBERS}
        arrays |= {f"edit_{name}": getattr(edit, name) for name in _EDIT}
    if below is not None:
        header["subsurface"] = {name: np.asarray(value).tolist() for name, value in vars(below).items()}
    return npz.to_bytes({"header": np.array(json.dumps(header)), **arrays})


def read(path: str | Path) -> dict[str, Any]:
    """The keyword arguments of a `Fit` in a file. Raises DatasetError where it is absent or holds no fit of this
    version."""
    return from_bytes(files.read_bytes(path, npz.LARGEST_ARCHIVE), path)


def from_bytes(content: bytes, path: str | Path | None = None) -> dict[str, Any]:
    """As `read`, of what `to_bytes` returned; errors name the path."""
    try:
        entries = npz.read(content)
        header = json.loads(str(entries.pop("header")))
        if not isinstance(header, dict) or header.get("format") != FIT_FORMAT:
            raise ValueError("no header of a fit")
    except (ValueError, KeyError, RecursionError) as error:
        raise DatasetError("not a fit saved by Measured BRDF", path) from error
    if header.get("version") != VERSION:
        raise DatasetError(f"a fit of version {header.get('version')!r}, expected {VERSION}; fit the data again", path)
    try:
        return _assemble(header, entries)
    except (KeyError, TypeError, ValueError, OverflowError) as error:
        raise DatasetError(f"a damaged fit: {error}", path) from error


def _assemble(header: dict[str, Any], entries: _Arrays) -> dict[str, Any]:
    channels = tuple(header["channels"])
    _check(channels and all(isinstance(name, str) for name in channels), "its channels are not names")
    # columns are numbered from 0 without gaps
    columns, changes = tuple(header["columns"]), tuple(header["changes"])
    _check(len(columns) == len(channels) and all(type(i) is int and 0 <= i < len(columns) for i in columns)
           and set(columns) == set(range(max(columns) + 1)), "its channels refer to columns that do not exist")
    _check(all(isinstance(change, str) for change in changes), "its changes are not text")
    parts: dict[str, Any] = {"channels": channels, "columns": columns, "changes": changes,
                             "name": str(header["name"]), "source": str(header["source"])}
    stored = max(columns) + 1
    # the dense lattice, over its coordinates
    level = _level(header["diffuse_level"])
    coordinates = _coordinates(header)
    axes = len(coordinates.axes)
    diffuse = _array(entries, "diffuse", (*dense.shape(level, axes), stored), np.float32)
    parts |= {"diffuse": dense.DenseLattice(level, diffuse), "coordinates": coordinates,
              "transform": _transform(header, entries, stored), "edit": _edit(header, entries, len(columns), stored)}
    # light below the surface
    if "subsurface" in header:
        below = header["subsurface"]
        albedo, path = (np.array(below[name], dtype=float) for name in ("albedo", "mean_free_path"))
        _check(albedo.shape == path.shape == (len(RGB),) == (len(channels),), "what is below it has not three channels")
        subsurface.check(albedo, path, float(below["index"]))
        parts["subsurface"] = subsurface.Subsurface(albedo, path, float(below["index"]))
    if header["specular_level"] is None:
        return parts

    # the sparse lattice: keys and hash table must agree
    level = _level(header["specular_level"])
    compression = _number(header, "compression", 0, 100)
    n = len(entries["keys"])
    _check(axes == ISOTROPIC_AXES or level <= dense.MAX_LEVEL_OF_FOUR_AXES, "its sparse lattice is too large")
    size = math.prod(dense.shape(level, axes))
    _check(n <= size, "more keys than its lattice has control points")
    keys = _array(entries, "keys", (n,), np.uint32, 0, size - 1)
    displacement = entries["displacement"]
    _check(displacement.ndim == 1 and len(displacement) and displacement.dtype in (np.uint16, np.uint32),
           "its hash table is not a table")
    _check(displacement.max() < max(n, 1), "a displacement of its hash table is too large")
    multiplier = header["multiplier"]
    _check(type(multiplier) is int and 0 < multiplier < perfect_hash.MULTIPLIERS, "its hash function is unknown")
    index = perfect_hash.PerfectHash(keys, displacement, multiplier)
    _check((index.slots(keys) == np.arange(n)).all(), "its hash table does not find its keys")
    coefficients = _array(entries, "coefficients", (n, stored), np.float32)
    return parts | {"specular": SparseLattice(level, index, coefficients, axes), "compression": compression}


def _coordinates(header: dict[str, Any]) -> Coordinates:
    _check(header["coordinates"] in COORDINATES, "its coordinates are unknown")
    system: type[Any] = COORDINATES[header["coordinates"]]
    numbers = {}
    for name in (field.name for field in fields(system)):
        unstretched = name in ("stretch", "back_stretch") and header[name] == NO_STRETCH
        numbers[name] = NO_STRETCH if unstretched else _number(header, name, *_OF_COORDINATES[name])
    return cast(Coordinates, system(**numbers))


def _transform(header: dict[str, Any], entries: _Arrays, stored: int) -> LogRelative | None:
    _check(header["transform"] in (_IDENTITY, LogRelative.name), "its transform is unknown")
    if header["transform"] == _IDENTITY:
        return None
    ks = entries["prior_ks"]
    lobes = len(ks) if ks.ndim else 0
    _check(lobes <= microfacet.MAX_PRIOR_LOBES, "its prior has too many lobes")
    kinds = tuple(header["lobes"])
    _check(len(kinds) == lobes and set(kinds) <= set(microfacet.KINDS), "the lobes of its prior are unknown")
    ranges = {"kd": (0.0, LARGEST_STORED), "ks": (0.0, LARGEST_STORED)} | microfacet.RANGES
    shapes: dict[str, tuple[int, ...]] = {"kd": (stored,), "ks": (lobes, stored)}
    names = _PRIOR if "prior_across" not in entries else (*_PRIOR, *_ANISOTROPIC_PRIOR)
    prior = microfacet.Microfacet(**{
        name: _array(entries, f"prior_{name}", shapes.get(name, (lobes,)), np.float64, *ranges[name])
        for name in names}, kinds=kinds)
    # the transform
    plausible, grey = header["plausible"], _number(header, "grey", 0, _MOST_DESATURATED)
    _check(isinstance(plausible, bool), "it does not say whether it is plausible")
    _check(not grey or stored == len(RGB), "its share of grey is not 0, and its channels are not three")
    damping = entries["damping"]
    return LogRelative(
        prior, _number(header, "offset", LEAST_OFFSET, LARGEST_STORED),
        _array(entries, "prior_ceiling", (stored,), np.float64, _LEAST_CEILING, LARGEST_STORED),
        0.0 if plausible else -np.inf,
        _array(entries, "damping", (DAMPING_KNOTS, stored), np.float64, 0, 1) if len(damping) else np.zeros((0, 1)),
        grey)


def _edit(header: dict[str, Any], entries: _Arrays, channels: int, stored: int) -> Edit | None:
    if "edit" not in header:
        return None
    numbers = {name: _number(header["edit"], name, *bounds, "edit's ") for name, bounds in _EDIT_NUMBERS.items()}
    shapes: dict[str, tuple[int, ...]] = {
        "diffuse": (channels,), "highlight": (channels,), "level": (stored,),
        "balance": (DAMPING_KNOTS if numbers["width"] != 1 else 0, stored),
        "through": (DAMPING_KNOTS if numbers["coat"] else 0, 1)}
    arrays: dict[str, Any] = {
        name: _array(entries, f"edit_{name}", shape, np.float64, _LEAST_CEILING if name == "level" else 0)
        for name, shape in shapes.items()}
    return Edit(**arrays | numbers)


def _level(level: Any) -> int:
    _check(type(level) is int and 0 <= level <= dense.MAX_LEVEL, f"level {level!r} does not exist")
    return int(level)


def _number(header: dict[str, Any], name: str, low: float, high: float, whose: str = "") -> float:
    number = header[name]
    _check(type(number) in (int, float) and low <= number <= high,
           f"its {whose}{name} is not a number from {low:g} to {high:g}")
    return float(number)


def _array(entries: _Arrays, name: str, shape: tuple[int, ...], dtype: DTypeLike, low: float = -LARGEST_STORED,
           high: float = LARGEST_STORED) -> NDArray[Any]:
    """An entry of this shape and type, not copied, whose numbers are within bounds; NaN is not."""
    array = entries[name]
    _check(array.shape == shape and array.dtype == dtype,
           f"{name} is {array.dtype} {array.shape}, expected {np.dtype(dtype)} {shape}")
    _check(not array.size or (low <= array.min() and array.max() <= high),
           f"{name} holds numbers that are not within {low:g} to {high:g}")
    return array


def _check(condition: object, message: str) -> None:
    if not condition:
        raise ValueError(message)

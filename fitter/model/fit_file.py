"""Fits as files or bytes: NumPy .npz archives with a version, without pickled objects; every entry is checked on
reading.

The entries are `header`, a JSON text with format, version, coordinates, transform, levels, compression, channels,
columns, changes, name and source; `diffuse`; for a bi-level fit `coefficients`, `keys` and `displacement`; and for a
log-relative fit `prior_kd`, `prior_ks`, `prior_alpha`, `prior_gamma`, `prior_f0`, `prior_ceiling` and `damping`, and if
its lobes are anisotropic `prior_across` and `prior_turn`. The header of a fit in half and difference coordinates has
`softening` and `stretch`, of half angles `stretch` and `back_stretch`, or of an anisotropic one `along`, `across` and
`turn`; that of a log-relative one `offset`, `plausible`, `grey` and `lobes`, the kinds of the prior's lobes. An edited
fit has the entries `edit_diffuse`, `edit_highlight`, `edit_level`, `edit_balance` and `edit_through`, and `edit` in the
header: width, coat and coat_width. Of what has light below its surface the header has `subsurface`: albedo,
mean_free_path and index.
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
_EDIT, _EDIT_NUMBERS = ("diffuse", "highlight", "level", "balance", "through"), ("width", "coat", "coat_width")
_Arrays = dict[str, NDArray[Any]]


def to_bytes(parts: dict[str, Any]) -> bytes:
    """A fit, given as the keyword arguments of a `Fit`, as an .npz file has it: without the folders of its source.

    Equal fits have equal bytes.
    """
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
    """Read a file of a fit: the keyword arguments of a `Fit`.

    Raises DatasetError if the file is not there, is not a fit of a known version, or is damaged.
    """
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
    compression = float(header["compression"])
    _check(0 <= compression <= 100, "its compression is not a percentage")
    keys = entries["keys"]
    n = len(keys)
    _check(axes == ISOTROPIC_AXES or level <= dense.MAX_LEVEL_OF_FOUR_AXES, "its sparse lattice is too large")
    size = math.prod(dense.shape(level, axes))
    _check(n <= size, "more keys than its lattice has control points")
    keys = _array(entries, "keys", (n,), np.uint32)
    displacement = entries["displacement"]
    _check(displacement.ndim == 1 and len(displacement) and displacement.dtype in (np.uint16, np.uint32),
           "its hash table is not a table")
    _check(displacement.max() < max(n, 1), "a displacement of its hash table is too large")
    multiplier = header["multiplier"]
    _check(type(multiplier) is int and 0 < multiplier < perfect_hash.MULTIPLIERS, "its hash function is unknown")
    _check(not n or keys.max() < size, "a key lies outside its lattice")
    index = perfect_hash.PerfectHash(keys, displacement, multiplier)
    _check((index.slots(keys) == np.arange(n)).all(), "its hash table does not find its keys")
    coefficients = _array(entries, "coefficients", (n, stored), np.float32)
    return parts | {"specular": SparseLattice(level, index, coefficients, axes), "compression": compression}


def _coordinates(header: dict[str, Any]) -> Coordinates:
    _check(header["coordinates"] in COORDINATES, "its coordinates are unknown")
    system: type[Any] = COORDINATES[header["coordinates"]]
    numbers = {field.name: header[field.name] for field in fields(system)}
    for name, number in numbers.items():
        low, high = _OF_COORDINATES[name]
        without = name in ("stretch", "back_stretch") and number == NO_STRETCH
        _check(isinstance(number, float) and (without or low <= number <= high),
               f"its {name} is not a number from {low:g} to {high:g}")
    return cast(Coordinates, system(**numbers))


def _transform(header: dict[str, Any], entries: _Arrays, stored: int) -> LogRelative | None:
    _check(header["transform"] in (_IDENTITY, LogRelative.name), "its transform is unknown")
    if header["transform"] == _IDENTITY:
        return None
    ks = entries["prior_ks"]
    lobes = len(ks) if ks.ndim else 0
    _check(lobes <= microfacet.MAX_PRIOR_LOBES, "its prior has too many lobes")
    shapes: dict[str, tuple[int, ...]] = {
        "kd": (stored,), "ks": (lobes, stored), "alpha": (lobes,), "gamma": (lobes,), "f0": (lobes,),
        "across": (lobes,), "turn": (lobes,)}
    names = _PRIOR if "prior_across" not in entries else (*_PRIOR, *_ANISOTROPIC_PRIOR)
    # the prior
    kinds = tuple(header["lobes"])
    _check(len(kinds) == lobes and set(kinds) <= set(microfacet.KINDS), "the lobes of its prior are unknown")
    prior = microfacet.Microfacet(**{name: _array(entries, f"prior_{name}", shapes[name], np.float64)
                                     for name in names}, kinds=kinds)
    for name, (low, high) in microfacet.RANGES.items():
        _check_range(f"prior_{name}", getattr(prior, name), low, high)
    ceiling = _array(entries, "prior_ceiling", (stored,), np.float64)
    # the transform
    offset = header["offset"]
    _check(type(offset) in (int, float), "its offset is not a number")
    for name, numbers, low in (("kd", prior.kd, 0), ("ks", prior.ks, 0), ("ceiling", ceiling, _LEAST_CEILING),
                               ("offset", np.array([offset], dtype=float), LEAST_OFFSET)):
        _check_range(f"prior_{name}", numbers, low, LARGEST_STORED)
    plausible = header["plausible"]
    _check(isinstance(plausible, bool), "it does not say whether it is plausible")
    grey = header["grey"]
    _check(type(grey) in (int, float) and 0 <= grey <= _MOST_DESATURATED and (not grey or stored == len(RGB)),
           f"its share of grey is not within 0 to {_MOST_DESATURATED}, or its channels are not three")
    # damping, where energy was conserved
    damping = np.zeros((0, 1))
    if len(entries["damping"]):
        damping = _array(entries, "damping", (DAMPING_KNOTS, stored), np.float64)
        _check_range("damping", damping, 0, 1)
    return LogRelative(prior, float(offset), ceiling, 0.0 if plausible else -np.inf, damping, float(grey))


def _edit(header: dict[str, Any], entries: _Arrays, channels: int, stored: int) -> Edit | None:
    if "edit" not in header:
        return None
    width, coat, coat_width = (header["edit"][name] for name in _EDIT_NUMBERS)
    for name, number, (low, high) in (("width", width, WIDTH_BOUNDS), ("coat", coat, (0, 1)),
                                      ("coat_width", coat_width, COAT_WIDTHS)):
        _check(isinstance(number, float) and low <= number <= high,
               f"the {name} of its edit is not a number from {low:g} to {high:g}")
    shapes: dict[str, tuple[int, ...]] = {
        "diffuse": (channels,), "highlight": (channels,), "level": (stored,),
        "balance": (DAMPING_KNOTS if len(np.atleast_1d(entries["edit_balance"])) else 0, stored),
        "through": (DAMPING_KNOTS if coat else 0, 1)}
    arrays = {name: _array(entries, f"edit_{name}", shape, np.float64) for name, shape in shapes.items()}
    for name, array in arrays.items():
        _check_range(f"edit_{name}", array, _LEAST_CEILING if name == "level" else 0, LARGEST_STORED)
    _check((width != 1) == (len(arrays["balance"]) > 0), "its edit has a balance without a width, or the reverse")
    return Edit(**arrays, width=width, coat=coat, coat_width=coat_width)


def _level(level: Any) -> int:
    _check(type(level) is int and 0 <= level <= dense.MAX_LEVEL, f"level {level!r} does not exist")
    return int(level)


def _array(entries: _Arrays, name: str, shape: tuple[int, ...], dtype: DTypeLike) -> NDArray[Any]:
    array = entries[name]
    _check(array.shape == shape and array.dtype == dtype,
           f"{name} is {array.dtype} {array.shape}, expected {np.dtype(dtype)} {shape}")
    _check_range(name, array, -LARGEST_STORED, LARGEST_STORED)
    return array


def _check_range(name: str, numbers: NDArray[Any], low: float, high: float) -> None:
    """Refuse numbers outside a range, NaN among them. Makes no copy: the array may be large."""
    _check(not numbers.size or (low <= numbers.min() and numbers.max() <= high),
           f"{name} holds numbers that are not within {low:g} to {high:g}")


def _check(condition: object, message: str) -> None:
    if not condition:
        raise ValueError(message)

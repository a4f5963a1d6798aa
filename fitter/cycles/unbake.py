"""Reading the fit of a baked shader back from its OSL source.

A .blend of a version before 0.3.0 keeps the source of each shader, and no fit: by the source its materials get the
shader of a newer version without their measurements. `bake` writes nine digits of every number, enough to give each
back in single precision.
"""

import math
import re
from dataclasses import replace
from typing import Any

import numpy as np
from numpy.typing import DTypeLike, NDArray

from ..coordinates import Coordinates
from ..coordinates.anisotropic_nusselt import AnisotropicNusselt
from ..coordinates.anisotropic_rusinkiewicz import AnisotropicRusinkiewicz
from ..coordinates.half_angle import HalfAngle
from ..coordinates.half_difference import HalfDifference
from ..coordinates.nusselt import Nusselt
from ..coordinates.rusinkiewicz import Rusinkiewicz
from ..lattice import dense, perfect_hash
from ..lattice.sparse import SparseLattice
from ..model import microfacet
from ..model.edit import Edit
from ..model.fit import Fit
from ..model.transform import LogRelative
from ..samples import RGB
from ..shader_constants import DAMPING_KNOTS, OCCUPANCY_SHIFT
from .bake import shader_version

_CONSTANT = re.compile(r"^#define (\w+) (.*)$", re.MULTILINE)
_TABLE = r"^  (?:int|float) {}\[(\d+)\] = \{{\n([^}}]*)\}};$"
_NUMBER = r"[-+.\deE]+"
_KINDS: dict[str, microfacet.Kind] = {"LOBE": "mirror", "ANISOTROPIC_LOBE": "mirror", "RETRO": "retro",
                                      "SHEEN": "sheen", "FIBRE": "fibre"}


def unbake(source: str, name: str = "untitled", compression: float = 0.0) -> Fit:
    """Read a fit from the OSL source that `bake.bake` made of it, by any version since 0.1.0.

    Raises ValueError if the source is not a baked shader, or its tables contradict each other.

    Parameters
    ----------
    name : str
        The fit's name, which the source does not hold.
    compression : float
        Percent of the sparse lattice that the fit dropped, which the source does not hold either.

    Returns
    -------
    Fit
        It evaluates to what the baked fit does, to nine digits.
    """
    constants = dict(_CONSTANT.findall(source))
    try:
        return _fit(source, constants, name, compression)
    except (KeyError, IndexError, ZeroDivisionError, OverflowError) as error:
        raise ValueError(f"not a shader of Measured BRDF: {error} is missing or wrong") from error


def _fit(source: str, constants: dict[str, str], name: str, compression: float) -> Fit:
    stored = int(constants["STORED"])
    columns = tuple(int(constants[f"CHANNEL_{i}"]) for i in range(3))
    channels = RGB if int(constants["CHANNELS"]) == len(RGB) else ("grey",)
    columns = columns[:len(channels)]
    if stored < 1 or set(columns) != set(range(stored)):
        raise ValueError("the channels of the shader read columns that are not there")
    level = _level(constants["DIFFUSE_CELLS"])
    coordinates = _coordinates(constants)
    axes = len(coordinates.axes)
    diffuse = dense.DenseLattice(level, _table(source, "DIFFUSE", np.float32, (*dense.shape(level, axes), stored)))
    specular = _specular(source, constants, stored, axes) if int(constants["SPARSE"]) else None
    transform = None
    if int(constants["LOG_RELATIVE"] if "LOG_RELATIVE" in constants else constants["PRIOR"]):
        transform = _log_relative(constants, stored, columns)
        if int(constants.get("DAMPED", 0)):
            transform = replace(transform, damping=_table(source, "DAMPING", np.float64, (DAMPING_KNOTS, stored)))
    return Fit(coordinates, diffuse, specular, transform, float(compression) if specular is not None else 0.0,
               channels, columns, name=name, source="a baked shader", edit=_edit(source, constants, stored, columns))


def _coordinates(constants: dict[str, str]) -> Coordinates:
    # before 0.2.0 one constant told coordinates and transform; 0.1.0 did not soften
    if int(constants["HALF_DIFFERENCE"] if "HALF_DIFFERENCE" in constants else constants["PRIOR"]):
        return HalfDifference(float(constants.get("SOFTENING_2", 0)) ** 0.5, float(constants.get("STRETCH", 0)))
    if int(constants.get("RUSINKIEWICZ", 0)):
        return Rusinkiewicz(float(constants["SOFTENING_2"]) ** 0.5, float(constants.get("STRETCH", 0)))
    if int(constants.get("HALF_ANGLE", 0)):
        return HalfAngle(float(constants.get("STRETCH", 0)))
    if int(constants.get("ANISOTROPIC_RUSINKIEWICZ", 0)):
        numbers = {name: float(constants[name]) for name in ("STRETCH_ALONG", "STRETCH_ACROSS", "TURN_SINE",
                                                             "TURN_COSINE")}
        return AnisotropicRusinkiewicz(numbers["STRETCH_ALONG"], numbers["STRETCH_ACROSS"],
                                       math.atan2(numbers["TURN_SINE"], numbers["TURN_COSINE"]))
    return AnisotropicNusselt() if int(constants.get("ANISOTROPIC_NUSSELT", 0)) else Nusselt()


def _specular(source: str, constants: dict[str, str], stored: int, axes: int) -> SparseLattice:
    level, count = _level(constants["SPECULAR_CELLS"]), int(constants["KEY_COUNT"])
    displacement = _table(source, "DISPLACEMENT", np.uint32, (int(constants["BUCKET_COUNT"]),))
    if displacement.max(initial=0) < 1 << 16:
        displacement = displacement.astype(np.uint16)
    if shader_version(source) < 3:      # stored the keys themselves
        keys = _table(source, "KEYS", np.int64, (count,))
    else:
        words = -(-math.prod(dense.shape(level, axes)) >> OCCUPANCY_SHIFT)
        keys = perfect_hash.keys_of(_table(source, "OCCUPANCY", np.int32, (words,)))
    if len(keys) != count or keys.max(initial=0) >= math.prod(dense.shape(level, axes)):
        raise ValueError("the hash table of the shader does not have the keys that it counts")
    try:
        index = perfect_hash.restored(keys, displacement, int(constants["MULTIPLIER"]))
    except ValueError as error:
        raise ValueError(f"the hash table of the shader does not find its keys: {error}") from error
    return SparseLattice(level, index, _table(source, "SPECULAR", np.float32, (count, stored)), axes)


def _log_relative(constants: dict[str, str], stored: int, columns: tuple[int, ...]) -> LogRelative:
    def values(text: str) -> NDArray[np.float64]:
        numbers = _numbers(text, len(columns))
        return np.array([numbers[columns.index(column)] for column in range(stored)])

    lobes = re.findall(rf"({'|'.join(_KINDS)})\(((?:color)?\([^)]*\)), ([^)]*)\)", constants["PRIOR_LOBES"])
    if len(lobes) != len(re.findall(r"[A-Z_]+\(", constants["PRIOR_LOBES"])):
        raise ValueError("the shader has lobes of an unknown kind")
    numbers = [[float(number) for number in lobe[2].split(", ")] for lobe in lobes]
    kinds: tuple[microfacet.Kind, ...] = tuple(_KINDS[lobe[0]] for lobe in lobes)
    shapes = np.array([_shape(macro, each) for (macro, _, _), each in zip(lobes, numbers, strict=True)]
                      ).reshape(len(lobes), 5)
    ks = np.array([values(lobe[1]) for lobe in lobes]).reshape(len(lobes), stored)
    alpha, gamma, f0, across, turn = shapes.T
    prior = microfacet.Microfacet(values(constants["PRIOR_KD"]), ks, alpha, gamma, f0, kinds)
    if int(constants.get("PRIOR_ANISOTROPIC", 0)):
        prior = replace(prior, across=across, turn=turn)
    # the shader clips at 0, whether or not the fit does
    grey = float(constants.get("GREY", 0))
    return LogRelative(prior, float(constants["PRIOR_OFFSET"]), values(constants["PRIOR_CEILING"]), 0.0,
                       grey=grey / (1 + grey))


def _edit(source: str, constants: dict[str, str], stored: int, columns: tuple[int, ...]) -> Edit | None:
    if not int(constants.get("EDITED", 0)):         # before 0.2.0 nothing was edited
        return None
    diffuse, highlight, levels = (np.array(_numbers(constants[f"EDIT_{name}"], len(columns)))
                                  for name in ("DIFFUSE", "HIGHLIGHT", "LEVEL"))
    level = np.array([levels[columns.index(column)] for column in range(stored)])
    balance = np.zeros((0, stored))
    if int(constants["WIDENED"]):
        balance = _table(source, "BALANCE", np.float64, (DAMPING_KNOTS, stored))
    through = np.zeros((0, 1))
    if int(constants["COATED"]):
        through = _table(source, "THROUGH", np.float64, (DAMPING_KNOTS, stored))[:, :1]
    return Edit(diffuse, highlight, level, float(constants["EDIT_WIDTH"]), balance, float(constants["COAT"]),
                math.sqrt(float(constants["COAT_ALPHA_2"])), through)


def _numbers(text: str, channels: int) -> list[float]:
    """The numbers of a constant that has one for each channel, or one for all."""
    numbers = [float(number) for number in re.findall(_NUMBER, text.replace("color", ""))]
    if len(numbers) not in (1, channels):
        raise ValueError(f"{text} does not have a number for each channel")
    return numbers * channels if len(numbers) == 1 else numbers


def _shape(macro: str, n: list[float]) -> tuple[float, float, float, float, float]:
    """alpha, gamma, f0, across and turn of the numbers of a lobe's macro."""
    if macro == "ANISOTROPIC_LOBE":
        cosine, sine, along, across, gamma, f0 = n[:6]
        return 1 / along, gamma, f0, 1 / across, math.atan2(sine, cosine)
    if macro == "FIBRE":
        cosine, sine, inverse, dip, gamma, f0 = n
        return 1 / inverse, gamma, f0, dip, math.atan2(sine, cosine)
    alpha = n[0] ** -0.5
    # a sheen lobe has no gamma
    gamma, f0 = (microfacet.NO_GAMMA, n[1]) if macro == "SHEEN" else n[1:3]
    return alpha, gamma, f0, alpha, 0.0


def _level(cells: str) -> int:
    level = int(cells).bit_length() - 1
    if not 0 <= level <= dense.MAX_LEVEL or dense.cells(level) != int(cells):
        raise ValueError(f"a lattice of {cells} cells in the shader, expected a power of two")
    return level


def _table(source: str, name: str, dtype: DTypeLike, shape: tuple[int, ...]) -> NDArray[Any]:
    declaration = re.search(_TABLE.format(name), source, re.MULTILINE)
    if declaration is None:
        raise ValueError(f"the shader has no table {name}")
    values = np.array(declaration[2].split(","), dtype=np.float64) if declaration[2].strip() else np.empty(0)
    if len(values) != int(declaration[1]) or values.size != np.prod(shape) or not np.isfinite(values).all():
        raise ValueError(f"the table {name} of the shader has {len(values)} numbers, expected {np.prod(shape)}")
    return values.astype(dtype).reshape(shape)

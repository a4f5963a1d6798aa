"""Coordinates of a pair of directions: the arguments of the functions that the lattices store.

A system maps four angles to a point of the unit cube, and back; docs/fitting.md has the formulas. Those of isotropic
reflectance have three coordinates and two symmetries, ``x_3 -> 1 - x_3`` and ``(x_1, x_2) -> (1 - x_1, 1 - x_2)``;
those of anisotropic reflectance four and one, ``(x_3, x_4) -> (1 - x_3, 1 - x_4)``, the exchange of both directions.
`lattice.dense` relies on them.
"""

from typing import ClassVar, Protocol

from ..arrays import ArrayLike, Directions, FloatArray
from .anisotropic_nusselt import AnisotropicNusselt
from .anisotropic_rusinkiewicz import AnisotropicRusinkiewicz
from .half_angle import HalfAngle
from .half_difference import HalfDifference
from .nusselt import Nusselt
from .rusinkiewicz import Rusinkiewicz

ISOTROPIC_AXES = 3          # coordinates of a pair of directions that only turning about the normal tells from another


class Coordinates(Protocol):
    """A coordinate system: a frozen dataclass, in a module of its own, whose fields are the system's parameters."""

    name: ClassVar[str]                 # in files and shaders
    axes: ClassVar[tuple[str, ...]]     # names of the coordinates; their number is the dimension of the lattices

    def encode(self, theta_i: ArrayLike, phi_i: ArrayLike, theta_o: ArrayLike, phi_o: ArrayLike) -> FloatArray:
        """Map directions to coordinates: angles broadcast to (...), radians, to (..., dimension) in [0, 1]."""
        ...

    def decode(self, x: ArrayLike) -> Directions:
        """Map coordinates (..., dimension) to a pair of directions that has them: four (...) arrays, radians."""
        ...


COORDINATES: dict[str, type[Coordinates]] = {system.name: system for system in (
    Nusselt, HalfDifference, Rusinkiewicz, HalfAngle, AnisotropicNusselt, AnisotropicRusinkiewicz)}
"""All coordinate systems, by name. Their parameters have defaults."""

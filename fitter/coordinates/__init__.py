"""Coordinates of a pair of directions: the arguments of the functions that the lattices store.

A coordinate system maps four angles to a point of the unit cube, and a point back to angles. Those of isotropic
reflectance have three coordinates and two symmetries, which `lattice.dense` relies on: the function does not change
under ``x_3 -> 1 - x_3``, nor under ``(x_1, x_2) -> (1 - x_1, 1 - x_2)``. The part of the cube with ``x_1 >= 1/2`` and
``x_3 >= 1/2`` therefore represents all of it. Those of anisotropic reflectance have four coordinates, and one symmetry:
``(x_3, x_4) -> (1 - x_3, 1 - x_4)``, which is the exchange of both directions.
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

    name: ClassVar[str]
    """The system's name in files and shaders."""
    axes: ClassVar[tuple[str, ...]]
    """The names of the coordinates; their number is the dimension of the lattices."""

    def encode(self, theta_i: ArrayLike, phi_i: ArrayLike, theta_o: ArrayLike, phi_o: ArrayLike) -> FloatArray:
        """Map directions to coordinates: angles broadcast to (...), radians, to (..., dimension) in [0, 1]."""
        ...

    def decode(self, x: ArrayLike) -> Directions:
        """Map coordinates (..., dimension) to a pair of directions that has them: four (...) arrays, radians."""
        ...


COORDINATES: dict[str, type[Coordinates]] = {system.name: system for system in (
    Nusselt, HalfDifference, Rusinkiewicz, HalfAngle, AnisotropicNusselt, AnisotropicRusinkiewicz)}
"""All coordinate systems, by name. Their parameters have defaults."""

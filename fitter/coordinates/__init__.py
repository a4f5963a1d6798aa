"""Coordinates of a pair of directions: the arguments of the functions that the lattices hold.

Every coordinate system maps four angles to a point of the unit cube, and a point back to angles. All systems so far
have three coordinates, since the reflectance is isotropic, and share two symmetries, which `lattice.dense` relies on:
the function is unchanged by ``x_3 -> 1 - x_3`` and by ``(x_1, x_2) -> (1 - x_1, 1 - x_2)``, so that ``x_1 >= 1/2`` and
``x_3 >= 1/2`` cover everything.
"""

from typing import ClassVar, Protocol

from ..arrays import ArrayLike, Directions, FloatArray


class Coordinates(Protocol):
    """What a coordinate system offers. Systems are frozen dataclasses, one a module; their fields are parameters."""

    name: ClassVar[str]
    """How files and shaders call the system."""
    axes: ClassVar[tuple[str, ...]]
    """The names of the coordinates; their number is the dimension of the lattices."""

    def encode(self, theta_i: ArrayLike, phi_i: ArrayLike, theta_o: ArrayLike, phi_o: ArrayLike) -> FloatArray:
        """Directions, radians, broadcast to (...), to coordinates (..., dimension) in [0, 1]."""
        ...

    def decode(self, x: ArrayLike) -> Directions:
        """Coordinates (..., dimension) to a pair of directions that has them: four (...) arrays, radians."""
        ...

"""Names for the types of arrays, and what is done with those of pairs of directions.

Functions take `ArrayLike` and return arrays of one type.
"""

from collections.abc import Callable, Iterable
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

__all__ = ["ArrayLike", "BoolArray", "ComplexArray", "Directions", "FloatArray", "IntArray", "RealArray", "SingleArray",
           "broadcast_directions", "concatenate_directions", "map_directions", "select_directions", "unit_vectors"]

FloatArray = NDArray[np.float64]
SingleArray = NDArray[np.float32]
RealArray = NDArray[np.floating[Any]]       # of either precision
IntArray = NDArray[np.integer[Any]]
BoolArray = NDArray[np.bool_]
ComplexArray = NDArray[np.complex128]
Directions = tuple[FloatArray, FloatArray, FloatArray, FloatArray]
"""theta_i, phi_i, theta_o, phi_o, radians."""


def map_directions(function: Callable[[Any], FloatArray], directions: Iterable[Any]) -> Directions:
    """A function of each of four arrays."""
    theta_i, phi_i, theta_o, phi_o = map(function, directions)
    return theta_i, phi_i, theta_o, phi_o


def select_directions(directions: Iterable[FloatArray], which: Any) -> Directions:
    """Some of pairs of directions, by a slice, by indices or by a mask."""
    return map_directions(lambda angle: angle[which], directions)


def concatenate_directions(parts: Iterable[Directions]) -> Directions:
    """Several arrays of pairs of directions as one."""
    return map_directions(np.concatenate, zip(*parts, strict=True))


def broadcast_directions(*directions: ArrayLike) -> list[FloatArray]:
    """Angles of pairs of directions, four arrays that broadcast to (...), as arrays of that shape."""
    return list(np.broadcast_arrays(*(np.asarray(angle, dtype=float) for angle in directions)))


def unit_vectors(theta: ArrayLike, phi: ArrayLike) -> FloatArray:
    """Unit vectors of polar angles and azimuths, radians, which broadcast to (...): (..., 3)."""
    theta, phi = np.broadcast_arrays(theta, phi)
    return np.stack([np.sin(theta) * np.cos(phi), np.sin(theta) * np.sin(phi), np.cos(theta)], axis=-1)

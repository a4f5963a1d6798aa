"""Names for the types of arrays. Functions take `ArrayLike` and return arrays of one type."""

from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

__all__ = ["ArrayLike", "BoolArray", "ComplexArray", "Directions", "FloatArray", "IntArray", "SingleArray"]

FloatArray = NDArray[np.float64]
SingleArray = NDArray[np.float32]
IntArray = NDArray[np.integer[Any]]
BoolArray = NDArray[np.bool_]
ComplexArray = NDArray[np.complex128]
Directions = tuple[FloatArray, FloatArray, FloatArray, FloatArray]
"""theta_i, phi_i, theta_o, phi_o, radians."""

"""Inverses of positive definite matrices by their Cholesky factors, which cost less than those of any matrix."""

import numpy as np

from ..arrays import FloatArray

_SMALL_TRIANGLE = 96  # rows of a triangle that is inverted at once


def inverse_root(matrix: FloatArray) -> FloatArray:
    """The lower triangle R of R^T R = matrix^-1, (n, n). Raises LinAlgError where there is none."""
    root: FloatArray = np.asarray(np.linalg.cholesky(matrix), dtype=float)
    _invert(root)
    return root


def _invert(triangle: FloatArray) -> None:
    """Invert a lower triangle in place, by the inverses of two smaller ones and a product."""
    half = len(triangle) // 2
    if len(triangle) <= _SMALL_TRIANGLE:
        triangle[:] = np.tril(np.linalg.inv(triangle))
        return
    first, below, second = triangle[:half, :half], triangle[half:, :half], triangle[half:, half:]
    _invert(first)
    _invert(second)
    below[:] = -(second @ (below @ first))

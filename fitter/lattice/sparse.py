"""A control lattice that stores only its largest control points (Kameya and Lewis 2002, section 4.2)."""

import math
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from ..arrays import FloatArray, IntArray, SingleArray
from . import dense, perfect_hash

MOST_DENSE = 1 << 21        # control points of a lattice that is evaluated with its zeros
_SPARSE_POINTS = 4096       # points evaluated at a time otherwise


@dataclass(frozen=True)
class SparseLattice:
    """A lattice whose control points are in the slots of a minimal perfect hash; all others are 0."""

    level: int
    index: perfect_hash.PerfectHash     # of positions in the flattened box of `dense.shape(level, axes)`
    coefficients: SingleArray           # (n, channels), in the order of the slots
    axes: int = 3

    @property
    def nbytes(self) -> int:
        """Bytes of coefficients, keys and hash table."""
        return self.coefficients.nbytes + self.index.nbytes

    @property
    def count(self) -> int:
        """Control points stored, counted once whatever the number of channels."""
        return len(self.coefficients)

    def evaluate(self, x: FloatArray) -> FloatArray:
        """The spline at coordinates (n, axes): (n, channels)."""
        if math.prod(dense.shape(self.level, self.axes)) <= MOST_DENSE:
            return dense.evaluate(self.dense, self.level, x)
        result = np.empty((len(x), self.coefficients.shape[1]))
        stored = np.concatenate([self.coefficients, np.zeros((1, self.coefficients.shape[1]))])     # slot -1
        for start in range(0, len(x), _SPARSE_POINTS):
            grid = dense.Grid(x[start:start + _SPARSE_POINTS], self.level)
            rows = np.arange(len(grid.first))
            slots = self.index.slots(grid.taps(rows[:, None]))
            result[start:start + _SPARSE_POINTS] = np.einsum("nt,ntc->nc", grid.basis(rows), stored[slots])
        return result

    @cached_property
    def dense(self) -> SingleArray:
        """All control points, zeros included: dense.shape(level, axes) + (channels,) float32."""
        box = dense.shape(self.level, self.axes)
        full = np.zeros((math.prod(box), self.coefficients.shape[1]), dtype=np.float32)
        full[self.index.keys] = self.coefficients
        return full.reshape(*box, -1)


def total(diffuse: dense.DenseLattice, sparse: SparseLattice) -> tuple[int, FloatArray] | None:
    """The level and the control points of the sum of two splines; None where these would be more than `MOST_DENSE`."""
    finest = max(diffuse.level, sparse.level)
    if math.prod(dense.shape(finest, sparse.axes)) > MOST_DENSE:
        return None
    return finest, sum((dense.refine_to_level(box, level, finest) for box, level in (
        (diffuse.control_points, diffuse.level), (sparse.dense, sparse.level))), np.zeros(1))


def keep_largest(control_points: FloatArray, level: int, count: int) -> SparseLattice:
    """Keep the control points of largest magnitude over all channels, of those that directions can reach: of
    dense.shape(level, axes) + (channels,), at most `count`, and fewer if fewer are reachable and not 0."""
    flat, axes = control_points.reshape(-1, control_points.shape[-1]), control_points.ndim - 1
    magnitude = np.einsum("nc,nc->n", flat, flat) * dense.reachable(level, axes).ravel()
    count = min(count, int(np.count_nonzero(magnitude)))
    largest = np.argpartition(-magnitude, min(count, len(magnitude) - 1))[:count]
    return keep(control_points, level, largest)


def keep(control_points: FloatArray, level: int, keys: IntArray) -> SparseLattice:
    """The control points at some positions of the flattened box, of dense.shape(level, axes) + (channels,)."""
    index = perfect_hash.build(keys)
    flat = control_points.reshape(-1, control_points.shape[-1])
    return SparseLattice(level, index, flat[index.keys].astype(np.float32), control_points.ndim - 1)

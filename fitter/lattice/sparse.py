"""A control lattice of which only the control points that matter are kept (Kameya and Lewis 2002, section 4.2)."""

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from ..arrays import FloatArray, SingleArray
from . import dense, perfect_hash


@dataclass(frozen=True)
class SparseLattice:
    """Control points in the slots of a minimal perfect hash; all others are 0.

    Attributes
    ----------
    level : int
    index : perfect_hash.PerfectHash
        Its keys are positions in the flattened box of `dense.shape(level)`.
    coefficients : (n, channels) float32
        In the order of the slots.
    """

    level: int
    index: perfect_hash.PerfectHash
    coefficients: SingleArray

    def __len__(self) -> int:
        return len(self.coefficients)

    @property
    def nbytes(self) -> int:
        """Bytes of coefficients, keys and hash table."""
        return self.coefficients.nbytes + self.index.nbytes

    @property
    def count(self) -> int:
        """Control points stored, counted once whatever the number of channels."""
        return len(self)

    def evaluate(self, x: FloatArray) -> FloatArray:
        """The spline at coordinates (n, 3): (n, channels)."""
        return dense.evaluate(self.dense, self.level, x)

    @cached_property
    def dense(self) -> SingleArray:
        """The same lattice with its zeros: lattice.shape(level) + (channels,) float32."""
        box = dense.shape(self.level)
        full = np.zeros((np.prod(box), self.coefficients.shape[1]), dtype=np.float32)
        full[self.index.keys] = self.coefficients
        return full.reshape(*box, -1)


def keep_largest(control_points: FloatArray, level: int, count: int) -> SparseLattice:
    """The `count` reachable control points of largest magnitude over all channels.

    Parameters
    ----------
    control_points : lattice.shape(level) + (channels,) float64
    level : int
    count : int
        At most this many; fewer where fewer are reachable and not 0.

    Returns
    -------
    SparseLattice
    """
    flat = control_points.reshape(-1, control_points.shape[-1])
    magnitude = np.einsum("nc,nc->n", flat, flat) * dense.reachable(level).ravel()
    count = min(count, np.count_nonzero(magnitude))
    kept = np.argpartition(-magnitude, min(count, len(magnitude) - 1))[:count]
    index = perfect_hash.build(kept)
    return SparseLattice(level, index, flat[index.keys].astype(np.float32))

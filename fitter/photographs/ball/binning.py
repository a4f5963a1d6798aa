"""Many measurements as fewer samples: the mean in each cell of half and difference coordinates.

The cells are even in `half_angle.HalfAngle`, stretched: about the normal they are narrow along the half angle, and
further out as wide as a share of it, so that highlights of every width change little over a cell. A sample lies at the
mean of its cell's coordinates, and has the mean of its values. Their weights are known before the values are, so that
noise, however large, does not bias the mean.
"""

import numpy as np

from ...arrays import Directions, FloatArray, IntArray
from ...coordinates.half_angle import HalfAngle

SYSTEM = HalfAngle(100.0)
_CELLS = 1600, 300, 300      # along h, x and y from -1 to 1, where there is room for as many
_COARSER = 0.95             # times as many along each axis, or fewer, until no more are occupied than there may be
_PRIOR_COUNT = 3            # pixels with the scatter that was expected, which those of a cell are added to


def bin_samples(directions: Directions, values: FloatArray, deviation: FloatArray,
                most: int) -> tuple[Directions, FloatArray, FloatArray]:
    """Weighted means of values (n, channels) in so many cells of their directions at most, and their relative standard
    deviations, which are estimated from the scatter in a cell and the `deviation` expected of each value, (n,)."""
    mu = 2 * SYSTEM.encode(*directions) - 1
    cell = _cells(mu, most)
    count = int(cell.max()) + 1
    # a little noise everywhere, so that no weight is infinite
    weight = 1 / (deviation ** 2 + (1e-3 + np.median(deviation)) ** 2)
    total = np.bincount(cell, weight, count)

    def mean(column: FloatArray) -> FloatArray:
        return np.asarray(np.bincount(cell, weight * column, count) / total)

    middle, means = (np.stack([mean(column) for column in columns.T], axis=1) for columns in (mu, values))
    scatter = _deviation(cell, weight / total[cell], values, means, deviation)
    return SYSTEM.decode((middle + 1) / 2), means, scatter


def _cells(mu: FloatArray, most: int) -> IntArray:
    """The number of each point's cell, from 0 and without gaps: (n, 3) in [-1, 1] to (n,)."""
    counts = np.array(_CELLS)
    while True:
        index = np.minimum((0.5 * (mu + 1) * counts).astype(np.int64), counts - 1)
        packed = (index[:, 0] * counts[1] + index[:, 1]) * counts[2] + index[:, 2]
        _, cell = np.unique(packed, return_inverse=True)
        occupied = int(cell.max()) + 1
        if occupied <= most or counts.max() == 1:
            return np.asarray(cell.ravel())
        # photographs of one difference angle each are surfaces in these coordinates
        counts = np.maximum((min(_COARSER, (most / occupied) ** 0.5) * counts).astype(int), 1)


def _deviation(cell: IntArray, share: FloatArray, values: FloatArray, mean: FloatArray, deviation: FloatArray,
               ) -> FloatArray:
    """The relative standard deviation of the weighted means: (cells,)."""
    count = len(mean)
    size = np.maximum(np.sqrt((mean ** 2).mean(axis=1)), np.finfo(float).tiny)
    number = np.bincount(cell, minlength=count)
    off = ((values - mean[cell]) ** 2).mean(axis=1) / size[cell] ** 2
    expected = np.bincount(cell, deviation ** 2, count) / number
    variance = (np.bincount(cell, off, count) + _PRIOR_COUNT * expected) / (np.maximum(number - 1, 0) + _PRIOR_COUNT)
    return np.asarray(np.sqrt(variance * np.bincount(cell, share ** 2, count)))

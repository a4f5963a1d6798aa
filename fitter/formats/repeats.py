"""Measurements of one pair of directions, averaged, and how much they scatter."""

import numpy as np

from ..arrays import FloatArray, IntArray
from .names import ANGLES

_SAME = 1e-6                    # radians between directions that count as one
_PRIOR_COUNT = 3                # further measurements of each pair of directions, with the scatter of those as bright
_ALIKE_PAIRS, _MOST_BINS = 10, 10  # pairs in a bin of brightness, and bins
_DARK_MEAN = 1e-3               # of the mean: scatter is relative to no less
_FACTOR_APART = 3.0             # times the least of one pair that its largest is, which is no noise any more
_MOST_SCATTER = 0.3             # relative standard deviation of half of the bright pairs, which is none either


def average_repeats(directions: FloatArray, values: FloatArray,
             ) -> tuple[FloatArray, FloatArray, FloatArray | None, tuple[str, ...]]:
    """One sample for each pair of directions: directions, values, their relative standard deviations, and notes.

    A few measurements hardly tell how much they scatter: each pair's variance is drawn to that of others as bright.
    """
    keys = [np.round((np.mod(column, 2 * np.pi) if name.startswith("phi") else column) / _SAME)
            for name, column in zip(ANGLES, directions.T, strict=True)]
    _, first, group, count = np.unique(np.stack(keys[::-1], axis=1), axis=0, return_index=True, return_inverse=True,
                                       return_counts=True)
    if len(first) == len(values):
        return directions, values, None, ()
    group = group.ravel()
    mean = np.stack([np.bincount(group, column) / count for column in values.T], axis=1)
    size = np.sqrt((mean ** 2).mean(axis=1))
    relative = (values - mean[group]) / np.maximum(size, _DARK_MEAN * size.mean() + np.finfo(float).tiny)[group, None]
    squares, several = np.bincount(group, (relative ** 2).mean(axis=1)).astype(float), count > 1
    like_it = _scatter(size, squares, count - 1)
    deviation = np.sqrt((squares + _PRIOR_COUNT * like_it) / (count - 1 + _PRIOR_COUNT) / count)
    scatter = 100 * np.sqrt(np.median(squares[several] / (count[several] - 1)))
    pairs = f"{several.sum():,} pair{'s' if several.sum() > 1 else ''} of directions"
    note = f"{pairs} measured more than once: averaged, with a scatter of {scatter:.2g} %"
    as_written = np.argsort(first)
    bright = several & (size >= np.median(size[several]))
    usual = float(np.sqrt(np.median(squares[bright] / (count[bright] - 1))))
    questions = _differing(values, group)
    if not questions and usual > _MOST_SCATTER:
        questions = (f"Half of the bright ones scatter by {usual:.0%} or more: are several samples in one table?",)
    return directions[first[as_written]], mean[as_written], deviation[as_written], (note, *questions)


def _differing(values: FloatArray, group: IntArray) -> tuple[str, ...]:
    """A note of pairs of directions whose measurements, of `group` (n,), differ by more than noise makes: of the bright
    half, since an instrument's noise is any factor of what is dark."""
    grey = values.mean(axis=1)
    lowest, highest = np.full(group.max() + 1, np.inf), np.full(group.max() + 1, -np.inf)
    np.minimum.at(lowest, group, grey)
    np.maximum.at(highest, group, grey)
    bright = highest >= np.median(highest)
    apart = bright & (highest > 0) & (highest >= _FACTOR_APART * lowest)
    if not apart.any():
        return ()
    times = highest[apart] / np.maximum(lowest[apart], _DARK_MEAN * highest[apart])
    count = int(apart.sum())
    return (f"The values of {count:,} pair{'s' * (count > 1)} of directions differ by a factor of up to "
            f"{times.max():,.3g}: is one of another sample, or in another unit?",)


def _scatter(size: FloatArray, squares: FloatArray, freedom: IntArray) -> FloatArray:
    """The relative variance of measurements as bright as each pair of directions: (n,), of the `size` of each, the sum
    of squares of its relative deviations, and how many measurements more than one it has.

    It is that of all pairs, or where many were measured again the median of those of similar brightness: what an
    instrument adds to dark directions is no noise of bright ones.
    """
    again = np.flatnonzero(freedom)
    order = again[np.argsort(size[again], kind="stable")]
    bins = np.array_split(order, min(max(len(order) // _ALIKE_PAIRS, 1), _MOST_BINS))
    if len(bins) == 1:
        variances = [squares.sum() / freedom.sum()]
    else:       # the median of chi squared over its degrees of freedom (E. B. Wilson, M. M. Hilferty 1931)
        variances = [np.median(squares[part] / freedom[part] / (1 - 2 / (9 * freedom[part])) ** 3) for part in bins]
    return np.asarray(np.array(variances)[np.searchsorted([size[part[0]] for part in bins[1:]], size, side="right")])

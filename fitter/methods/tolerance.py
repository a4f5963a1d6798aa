"""The smallest fit whose error is within a tolerance."""

import math
from collections.abc import Callable
from functools import partial
from typing import Any

import numpy as np

from .. import progress
from ..arrays import select_directions
from ..lattice import dense
from ..model.fit import Fit, notation
from ..quality import cross_validation
from ..quality.metrics import error_metrics
from ..samples import Samples, distinct_channels, subset
from . import MethodName, fit, prepare
from .levels import KEPT_OF_FOUR, Levels

METHOD: MethodName = "kriging"
SPECULAR_LEVEL = 6
DIFFUSE_LEVELS = (1, 2, 3, 4, 5)
KEPT = (0, 47, 94, 188, 376, 752, 1504, 3008, 6016)     # control points of the specular lattice


def fit_within(samples: Samples, tolerance: float, held_out: bool = False) -> Fit:
    """Find the fit of fewest bytes whose error is within a tolerance, by bisection of the compression for each diffuse
    level: of fits by "kriging" with a specular lattice of level 6, or of anisotropic samples 4
    (`Levels.four_axis_levels`).

    Parameters
    ----------
    tolerance
        Root mean square error over all samples and channels, 1/sr.
    held_out
        Measure the error at samples that were held out of the fit, in five folds (`cross_validation.cross_validate`),
        instead of at the fitted samples.

    Raises
    ------
    ValueError
        If the tolerance is not positive, or no candidate reaches it; the message gives the best candidate's error.

    Examples
    --------
    >>> theta = np.radians([0, 20, 40, 60, 80.0])
    >>> grey = Samples(theta, 0 * theta, theta, 0 * theta, np.full((5, 1), 0.2))
    >>> found = fit_within(grey, 0.01)
    >>> found.notation, error_metrics(grey.values, found.evaluate(*grey.directions)).rmse < 0.01
    ('(1,6,100)', True)
    """
    if not tolerance > 0:
        raise ValueError(f"tolerance is {tolerance!r}, expected a positive number of 1/sr")
    if held_out and len(samples) == 1:
        raise ValueError("one sample cannot be predicted from the others")
    every = np.arange(len(samples))
    parts = cross_validation.folds(len(samples)) if held_out else [every]
    stored = len(distinct_channels(samples)[0].channels)         # equal channels are stored, and counted, once
    with progress.part(0.0, 0.3):
        folds = [(part, _prepared_fit(subset(samples, np.setdiff1d(every, part) if held_out else part)))
                 for part in progress.each(parts)]
    fit_whole = _prepared_fit(samples) if held_out else folds[0][1]

    # bisection over the compression, for each diffuse level
    counts = [count for count in KEPT if count <= 8 * len(samples)]
    smallest: Fit | None = None
    best = np.inf, ""
    steps = len(counts).bit_length()
    for number, diffuse_level in enumerate(DIFFUSE_LEVELS):
        if smallest is not None and 4 * _dense_size(samples, diffuse_level) * stored >= smallest.nbytes:
            break
        low, high, step = 0, len(counts), 0               # kept[high] suffices, if it exists
        while low < high:
            middle = (low + high) // 2
            compression = _compression(counts[middle])
            begin, found = 0.3 + 0.7 * (number + step / steps) / len(DIFFUSE_LEVELS), np.empty(samples.values.shape)
            with progress.part(begin, begin + 0.7 / steps / len(DIFFUSE_LEVELS)):
                for part, fit_fold in progress.each(folds):
                    fitted = fit_fold(diffuse_level=diffuse_level, compression=compression)
                    found[part] = fitted.evaluate(*select_directions(samples.directions, part))
            error = error_metrics(samples.values, found).rmse
            step += 1
            best = min(best, (error, notation(diffuse_level, SPECULAR_LEVEL, compression)))
            low, high = (low, middle) if error <= tolerance else (middle + 1, high)
        if high < len(counts):
            end = 0.3 + 0.7 * (number + 1) / len(DIFFUSE_LEVELS)
            with progress.part(end, end):
                fitted = fit_whole(diffuse_level=diffuse_level, compression=_compression(counts[high]))
            smallest = min(smallest or fitted, fitted, key=lambda fit: fit.nbytes)
    if smallest is None:
        raise ValueError(f"no fit is within {tolerance:g} 1/sr: the best, {best[1]}, has an error of {best[0]:.3g}; "
                         f"expected a larger tolerance")
    return smallest


def _prepared_fit(samples: Samples) -> Callable[..., Fit]:
    """`fit` of samples, for which the estimate is made once."""
    return partial(fit, samples, specular_level=SPECULAR_LEVEL, method=METHOD, **prepare(samples, METHOD))


def fit_arguments(fit: Fit) -> dict[str, Any]:
    """The keyword arguments with which `fit` makes the fit that `fit_within` found, of the same samples."""
    diffuse_level, compression = fit.diffuse_level, fit.compression
    if not fit.isotropic:     # the levels whose `Levels.four_axis_levels` the fit has
        count = Levels(fit.diffuse_level, fit.specular_level, compression).kept_count(4)
        diffuse_level, compression = diffuse_level + 1, _compression(round(count / KEPT_OF_FOUR))
    return {"diffuse_level": diffuse_level, "specular_level": SPECULAR_LEVEL, "compression": compression,
            "method": METHOD}


def _dense_size(samples: Samples, diffuse_level: int) -> int:
    """Control points of a dense lattice."""
    if samples.isotropic:
        return math.prod(dense.shape(diffuse_level))
    return math.prod(dense.shape(Levels(diffuse_level, None, 0.0).four_axis_levels().diffuse, 4))


def _compression(count: int) -> float:
    return 100 * (1 - count / dense.full_size(SPECULAR_LEVEL))

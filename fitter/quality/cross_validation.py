"""Cross-validation: the error of a fit at samples that were held out of it."""

from collections.abc import Callable
from typing import NamedTuple

import numpy as np

from ..arrays import FloatArray, IntArray, select_directions
from ..model import Reflectance
from ..samples import Samples, subset

FOLD_COUNT = 5
SEED = 2002


class HeldOutErrors(NamedTuple):
    """Errors at samples that were held out."""

    rmse: float
    """Root mean square error, 1/sr."""
    cube_root_rmse: float
    """Root mean square error of `cube_root`, which gives dark directions more weight; 1/sr to the power 1/3."""


def cube_root(theta_o: FloatArray, values: FloatArray) -> FloatArray:
    """The cube root of cosine-weighted reflectance: (n,) radians and (n, c) 1/sr to (n, c).

    The metric that agreed best with observers in A. Fores, J. Ferwerda, J. Gu: Toward a Perceptually Based Metric for
    BRDF Modeling, 2012.
    """
    return np.cbrt(values * np.cos(theta_o)[:, None])


def folds(count: int, parts: int = FOLD_COUNT, seed: int = SEED) -> list[IntArray]:
    """Divide `count` samples at random into at most `parts` folds: arrays of indices, none empty.

    Examples
    --------
    >>> sorted(np.concatenate(folds(7, 3)).tolist())
    [0, 1, 2, 3, 4, 5, 6]
    """
    shuffled = np.random.default_rng(seed).permutation(count)
    return [part for part in np.array_split(shuffled, parts) if len(part)]


def cross_validate(samples: Samples, fit: Callable[[Samples], Reflectance], parts: int = FOLD_COUNT,
                   seed: int = SEED) -> HeldOutErrors:
    """Errors of a fit by cross-validation: each sample is predicted by a fit to the other folds. Raises ValueError if
    there is only one sample."""
    if len(samples) < 2:
        raise ValueError("one sample cannot be predicted from the others")
    predicted = np.empty(samples.values.shape)
    for part in folds(len(samples), parts, seed):
        predicted[part] = predict_part(samples, part, fit)
    return errors(samples, predicted)


def predict_part(samples: Samples, part: IntArray, fit: Callable[[Samples], Reflectance]) -> FloatArray:
    """Predictions of a part of samples, indices (k,), by a fit to all others: (k, channels), 1/sr."""
    others = np.ones(len(samples), dtype=bool)
    others[part] = False
    return fit(subset(samples, others)).evaluate(*select_directions(samples.directions, part))


def errors(samples: Samples, predicted: FloatArray) -> HeldOutErrors:
    """Errors of predictions (n, channels), over all samples and channels."""
    error = predicted - samples.values
    cubes = cube_root(samples.theta_o, predicted) - cube_root(samples.theta_o, samples.values)
    return HeldOutErrors(float(np.sqrt(np.mean(error ** 2))), float(np.sqrt(np.mean(cubes ** 2))))

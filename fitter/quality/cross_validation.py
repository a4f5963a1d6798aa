"""How true a fit is between the samples: its error at samples that it has not seen."""

from typing import NamedTuple

import numpy as np

from ..samples import subset

FOLDS = 5
SEED = 2002


class HeldOutErrors(NamedTuple):
    """Errors at samples that were held out."""

    rmse: float
    """Root mean square error, 1/sr."""
    cube_root_rmse: float
    """That of `cube_root`, which weighs dark and bright directions alike; 1/sr to the power 1/3."""


def cube_root(theta_o, values):
    """The cube root of cosine-weighted reflectance (Fores, Ferwerda and Gu 2012): (n,) and (n, c) to (n, c)."""
    return np.cbrt(values * np.cos(theta_o)[:, None])


def folds(count, parts=FOLDS, seed=SEED):
    """A random division of `count` samples: a list of at most `parts` (n,) int arrays, none of them empty."""
    shuffled = np.random.default_rng(seed).permutation(count)
    return [part for part in np.array_split(shuffled, parts) if len(part)]


def held_out_values(samples, fit, parts=FOLDS, seed=SEED):
    """What `fit` predicts for each sample from the samples of the other folds.

    Parameters
    ----------
    samples : Samples
        Two at least.
    fit : callable
        Takes `Samples`, returns anything with the `evaluate` of `Fit`.
    parts, seed : int
        How many folds, and which.

    Returns
    -------
    (n, channels) float64
    """
    if len(samples) < 2:
        raise ValueError("one sample cannot be predicted from the others")
    predicted = np.empty(samples.values.shape)
    for part in folds(len(samples), parts, seed):
        seen = np.ones(len(samples), dtype=bool)
        seen[part] = False
        model = fit(subset(samples, seen))
        predicted[part] = model.evaluate(*(angle[part] for angle in samples.directions))
    return predicted


def held_out(samples, fit, parts=FOLDS, seed=SEED):
    """Errors of `held_out_values` over all samples and channels: HeldOutErrors."""
    return errors(samples, held_out_values(samples, fit, parts, seed))


def errors(samples, predicted):
    """Errors of predictions (n, channels) of the samples, over all of them and all channels: HeldOutErrors."""
    error = predicted - samples.values
    cubes = cube_root(samples.theta_o, predicted) - cube_root(samples.theta_o, samples.values)
    return HeldOutErrors(float(np.sqrt(np.mean(error ** 2))), float(np.sqrt(np.mean(cubes ** 2))))

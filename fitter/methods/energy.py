"""Fits that reflect no more than they receive."""

from dataclasses import replace
from functools import partial

import numpy as np

from ..quality.physics import directional_albedo

_VIEWS = np.radians(np.append(np.arange(0, 80, 10), np.arange(80, 91, 2.0)))
_CELLS = 56
_ROUNDS = 8
_TOLERANCE = 2e-3


def conserve(approximation, offset, channels):
    """Lower a field where its fit reflects more than it receives, equally for incident and outgoing directions.

    Parameters
    ----------
    approximation : callable
        Makes a `Fit` of what to take from the field: a function of polar angles, (n,) radians to (n, channels), whose
        values at both directions are to be taken.
    offset : float
        1/sr: a field is a logarithm of f + offset.
    channels : int

    Returns
    -------
    Fit
        Its `changes` say what was lowered.
    """
    lower = np.zeros((len(_VIEWS), channels))
    first = None
    for _ in range(_ROUNDS):
        fit = approximation(partial(_at, lower))
        albedo = directional_albedo(fit, _VIEWS, _CELLS)
        first = albedo if first is None else first
        if albedo.max() <= 1 + _TOLERANCE:
            break
        # half of it, since both directions give: exact for a constant, whose albedo is pi f
        excess = np.maximum(albedo - 1, 0)
        lower = lower - 0.5 * np.log1p(-excess / (albedo + np.pi * offset))
    if first.max() <= 1 + _TOLERANCE:
        return fit
    if albedo.max() > 1 + _TOLERANCE:
        fit, albedo = _flattened(fit)
    worst = np.degrees(_VIEWS[first.max(axis=1).argmax()])
    return replace(fit, changes=(
        f"directional albedo of {first.max():.3g} at {worst:.0f} degrees lowered to {albedo.max():.3g}",))


def _flattened(fit):
    """The fit under the highest ceiling that makes its albedo 1, where nothing gentler did; and its albedo."""
    high = fit.prior.ceiling
    low = np.minimum(high, 1 / np.pi)                   # of this ceiling no albedo is above 1
    for _ in range(_ROUNDS):
        ceiling = np.sqrt(low * high)
        albedo = directional_albedo(replace(fit, prior=replace(fit.prior, ceiling=ceiling)), _VIEWS, _CELLS)
        within = albedo.max(axis=0) <= 1
        low, high = np.where(within, ceiling, low), np.where(within, high, ceiling)
    fit = replace(fit, prior=replace(fit.prior, ceiling=low))
    return fit, directional_albedo(fit, _VIEWS, _CELLS)


def _at(lower, theta):
    return np.stack([np.interp(theta, _VIEWS, column) for column in lower.T], axis=-1)

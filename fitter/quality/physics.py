"""What a reflectance must be to be physical: reciprocal, nowhere negative, and reflecting no more than it receives.

A model here is anything with the `evaluate` of `Fit`.
"""

from typing import NamedTuple

import numpy as np

PAIRS = 20_000
SEED = 2002
_CELLS = 96                 # along the radius and along half a turn


class Physics(NamedTuple):
    """Departures of a model from physics, over pairs of directions that are uniform in projected solid angle."""

    reciprocity_error: float
    """Mean of |f(i, o) - f(o, i)| over the mean of |f|."""
    negative_fraction: float
    """Share of the values that are negative; a renderer takes them for 0."""
    negative_energy: float
    """The mean of what is negative over the mean of what is not: the energy that taking them for 0 adds."""


def direction_pairs(count=PAIRS, seed=SEED):
    """Random pairs of directions, uniform in projected solid angle: theta_i, phi_i, theta_o, phi_o, each (count,)."""
    u = np.random.default_rng(seed).random((3, count))
    theta_i, theta_o = np.arcsin(np.sqrt(u[:2]))
    return theta_i, np.zeros(count), theta_o, np.pi * u[2]


def measure(model, pairs=None):
    """How far a model is from being reciprocal and non-negative: Physics."""
    theta_i, phi_i, theta_o, phi_o = direction_pairs() if pairs is None else pairs
    value = model.evaluate(theta_i, phi_i, theta_o, phi_o)
    swapped = model.evaluate(theta_o, phi_o, theta_i, phi_i)
    size, above = np.abs(value).mean(), np.maximum(value, 0).mean()
    return Physics(float(np.abs(value - swapped).mean() / size) if size else 0.0, float((value < 0).mean()),
                   float(np.maximum(-value, 0).mean() / above) if above else 0.0)


def directional_albedo(model, theta_o, cells=_CELLS):
    """The share of the light from all sides that leaves toward each view angle, negative values taken for 0.

    The integral of f cos(theta_i) over the incident hemisphere, by the midpoint rule over the disk onto which that
    projects. By reciprocity it is also the share of the light from theta_o that is reflected, at most 1.

    Parameters
    ----------
    theta_o : (n,) array_like
        Radians.
    cells : int
        Steps along the radius and along half a turn.

    Returns
    -------
    (n, channels) float64
    """
    steps = (np.arange(cells) + 0.5) / cells
    theta_i, delta_phi = (grid.ravel() for grid in np.meshgrid(np.arcsin(steps), np.pi * steps))
    area = 2 * np.pi * np.sin(theta_i) / cells ** 2         # of a cell and its mirror image
    return np.stack([area @ np.maximum(model.evaluate(theta_i, 0, np.full_like(theta_i, angle), delta_phi), 0)
                     for angle in np.atleast_1d(theta_o)])

"""Physical plausibility of a model: reciprocity, non-negative values, and conservation of energy."""

from typing import NamedTuple

import numpy as np

from ..arrays import ArrayLike, Directions, FloatArray
from ..model import Reflectance, is_isotropic

PAIRS = 20_000
SEED = 2002
_INTEGRAL_CELLS = 96        # of the integral, along radius and azimuth


class Physics(NamedTuple):
    """Departures of a model from physics, over pairs of directions with uniform density in projected solid angle."""

    reciprocity_error: float
    """Mean of |f(i, o) - f(o, i)| over the mean of |f|."""
    negative_fraction: float
    """Share of the values that are negative; a renderer clips them to 0."""
    negative_energy: float
    """Sum of the negative values over that of the positive ones: the relative energy that clipping adds."""


def direction_pairs(count: int = PAIRS) -> Directions:
    """Random pairs of directions with uniform density in projected solid angle, the light at the azimuth 0: four
    (count,) arrays, radians."""
    u = np.random.default_rng(SEED).random((3, count))
    theta_i, theta_o = np.arcsin(np.sqrt(u[:2]))
    return theta_i, np.zeros(count), theta_o, np.pi * u[2]


def measure(model: Reflectance, pairs: Directions | None = None) -> Physics:
    """Measure a model's departures from reciprocity and from non-negative values, at pairs of directions, four (n,)
    arrays, radians: by default `direction_pairs()`, turned for an anisotropic model at random."""
    if pairs is None:
        theta_i, phi_i, theta_o, phi_o = direction_pairs()
        if not is_isotropic(model):
            phi_i = 2 * np.pi * np.random.default_rng(SEED).random(PAIRS)
            phi_o = phi_i + np.where(np.arange(PAIRS) % 2, phi_o, -phi_o)
    else:
        theta_i, phi_i, theta_o, phi_o = pairs
    value = model.evaluate(theta_i, phi_i, theta_o, phi_o)
    swapped = model.evaluate(theta_o, phi_o, theta_i, phi_i)
    size, above = np.abs(value).mean(), np.maximum(value, 0).mean()
    return Physics(float(np.abs(value - swapped).mean() / size) if size else 0.0, float((value < 0).mean()),
                   float(np.maximum(-value, 0).mean() / above) if above else 0.0)


def directional_albedo(model: Reflectance, theta_o: ArrayLike, phi_o: float = 0.0) -> FloatArray:
    """The directional albedo of a model, (n, channels): the share of light from each of some directions, (n,) radians,
    that is reflected.

    The integral of f cos(theta_i) over the incident hemisphere, by the midpoint rule over the disk to which that
    projects; negative values count as 0. By reciprocity, it is the albedo for light from theta_o.
    """
    steps = (np.arange(_INTEGRAL_CELLS) + 0.5) / _INTEGRAL_CELLS
    turns = np.pi * steps if is_isotropic(model) else np.concatenate([np.pi * steps, -np.pi * steps])
    theta_i, delta_phi = (grid.ravel() for grid in np.meshgrid(np.arcsin(steps), turns))
    # with the mirror images where there is half a turn
    area = 2 * np.pi * np.sin(theta_i) / (_INTEGRAL_CELLS * len(turns))
    phi_i = phi_o + delta_phi
    return np.stack([area @ np.maximum(model.evaluate(theta_i, phi_i, np.full_like(theta_i, angle), phi_o), 0)
                     for angle in np.atleast_1d(theta_o)])

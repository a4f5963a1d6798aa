"""Half and difference coordinates are smooth functions of both directions: d, x and y^2 (the field is even in y).

The truth is that the second differences of a smooth function from both sides of a point agree but for what falls as the
step; a jump makes a difference that grows as its inverse square, a kink one that grows as its inverse.
"""

import numpy as np
import pytest

from fitter.arrays import unit_vectors as unit
from fitter.coordinates.half_angle import HalfAngle
from fitter.coordinates.half_difference import HalfDifference
from fitter.coordinates.rusinkiewicz import Rusinkiewicz

SYSTEMS = [HalfDifference(), Rusinkiewicz(), HalfDifference(stretch=33.0), Rusinkiewicz(stretch=33.0), HalfAngle(),
           HalfAngle(33.0), HalfAngle(12.0, 33.0)]
ANGLES = np.radians([0, 3, 20, 45, 70, 85])
SEAMS = {
    "retro-reflection": [(a, 0.3, a, 0.3) for a in ANGLES],
    "normal incidence": [(0, 0, a, 0.4) for a in ANGLES],
    "normal exitance": [(a, 0.4, 0, 0) for a in ANGLES],
    "mirror reflection": [(a, 0.3, a, 0.3 + np.pi) for a in ANGLES],
    "the plane of incidence": [(a, 0.3, b, 0.3) for a in ANGLES for b in ANGLES],
}


def through(pair, step, t):
    """Pairs of directions on a line through one: step (2, 2) in the tangents of both; t (n,) to (n, 2, 3)."""
    theta, phi = np.array(pair[::2]), np.array(pair[1::2])
    tangent = step[:, :1] * unit(theta + np.pi / 2, phi) + step[:, 1:] * unit(np.pi / 2 + 0 * theta, phi + np.pi / 2)
    size = np.linalg.norm(tangent, axis=-1, keepdims=True)
    t = t[:, None, None]
    return np.cos(t * size) * unit(theta, phi) + np.sin(t * size) * tangent / np.where(size, size, 1)


def smooth_part(system, w):
    theta, phi = np.arctan2(np.hypot(w[..., 0], w[..., 1]), w[..., 2]), np.arctan2(w[..., 1], w[..., 0])
    mu = 2 * system.encode(theta[:, 0], phi[:, 0], theta[:, 1], phi[:, 1]) - 1
    if isinstance(system, HalfAngle):      # the functions with the symmetries of a lattice are those of these
        h, x, y = np.moveaxis(mu, -1, 0)
        return np.stack([h * h, h * x, x * x, y * y], axis=-1)
    return mu ** [1, 1, 2]


def jump(system, pair, step, length):
    """By how much the second differences from both sides of a pair disagree: (3,)."""
    f = smooth_part(system, through(pair, step, length * np.arange(-2, 3)))
    return np.abs((f[4] - 2 * f[3] + f[2]) - (f[2] - 2 * f[1] + f[0]))


@pytest.mark.parametrize("seam", SEAMS)
@pytest.mark.parametrize("system", SYSTEMS, ids=str)
def test_no_seam_has_a_jump_a_kink_or_a_bend(system, seam, random):
    for pair in SEAMS[seam]:
        steps = random.standard_normal((20, 2, 2))
        steps /= np.linalg.norm(steps, axis=(1, 2), keepdims=True)
        large, small = (np.max([jump(system, pair, step, length) for step in steps], axis=0) for length in (1e-4, 1e-5))
        assert (small <= 3e-3 * large + 3e-13).all(), pair          # of the third order: a thousandth

import numpy as np
import pytest

from fitter.coordinates.half_difference import HALF_DIFFERENCE_SOFTENING, HalfDifference, project
from fitter.coordinates.rusinkiewicz import LEAST_SOFTENING

softened = pytest.mark.parametrize("softening", [LEAST_SOFTENING, HALF_DIFFERENCE_SOFTENING, 0.3])


@softened
def test_the_coordinates_are_their_definition(pairs, softening):
    """The sum of squares that gives y, against |H|^2 - x^2."""
    theta_i, phi_i, theta_o, phi_o = pairs
    q_i, q_o = (project(theta) * np.array([np.cos(phi), np.sin(phi)])
                for theta, phi in ((theta_i, phi_i), (theta_o, phi_o)))
    half, difference = (q_i + q_o) / 2, (q_i - q_o) / 2
    d = (softening ** 4 + (1 - softening ** 4) * (difference ** 2).sum(axis=0) ** 2) ** 0.25
    x = (half * difference).sum(axis=0) / d
    y = np.sqrt(np.maximum((half ** 2).sum(axis=0) - x * x, 0))
    found = 2 * HalfDifference(softening).encode(*pairs) - 1
    np.testing.assert_allclose(found[:, :2], np.stack([d, x], axis=1), atol=1e-12)
    np.testing.assert_allclose(found[:, 2] ** 2, y ** 2, atol=1e-12)


@softened
def test_coordinates_that_no_directions_have_are_taken_for_some_that_are_near(softening, random):
    mu = random.random((500, 3)) * [1, 2, 1] - [0, 1, 0]
    back = 2 * HalfDifference(softening).encode(*HalfDifference(softening).decode((mu + 1) / 2)) - 1
    assert np.isfinite(back).all()
    inside = (np.hypot(mu[:, 1], mu[:, 2]) + mu[:, 0] < 1) & (mu[:, 0] > 1.5 * softening)
    kept = np.hypot(mu[:, 1], mu[:, 2]) - np.hypot(back[:, 1], back[:, 2])
    np.testing.assert_allclose(kept[inside], 0, atol=1e-9)
    np.testing.assert_allclose(back[inside, 0], mu[inside, 0], atol=1e-9)

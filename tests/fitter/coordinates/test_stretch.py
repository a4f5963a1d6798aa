import numpy as np
import pytest

from fitter.coordinates.half_difference import HalfDifference
from fitter.coordinates.rusinkiewicz import Rusinkiewicz
from fitter.coordinates.stretch import (
    LARGEST_STRETCH,
    LEAST_STRETCH,
    NO_STRETCH,
    stretch_half_vector,
    unstretch_half_vector,
)

STRETCHES = LEAST_STRETCH, 5.0, 33.0, LARGEST_STRETCH
systems = pytest.mark.parametrize("system", [HalfDifference, Rusinkiewicz])


@pytest.fixture
def disk(random):
    """Half vectors: anywhere in the unit disk, on its rim, and ever nearer to 0."""
    radius = np.concatenate([random.random(300), np.ones(50), 10 ** (-12 * random.random(300)), [0.0, 1e-300]])
    angle = 2 * np.pi * random.random(len(radius))
    return radius * np.cos(angle), radius * np.sin(angle)


@pytest.mark.parametrize("k", STRETCHES)
def test_the_length_is_the_inverse_hyperbolic_sine_and_the_direction_stays(disk, k):
    x, y = stretch_half_vector(*disk, k)
    radius = np.hypot(*disk)
    # by its definition as a logarithm; log1p(u + u^2 / (1 + sqrt(1 + u^2))) keeps small numbers
    def asinh(u):
        return np.log1p(u + u * u / (1 + np.sqrt(1 + u * u)))

    np.testing.assert_allclose(np.hypot(x, y), asinh(k * radius) / asinh(k), rtol=1e-8, atol=1e-300)
    np.testing.assert_allclose(x * disk[1], y * disk[0], atol=1e-15)
    assert (x * disk[0] >= 0).all()


@pytest.mark.parametrize("k", STRETCHES)
def test_unstretched_is_the_inverse(disk, k):
    for back in (unstretch_half_vector(*stretch_half_vector(*disk, k), k),
                 stretch_half_vector(*unstretch_half_vector(*disk, k), k)):
        np.testing.assert_allclose(back, disk, rtol=1e-8, atol=1e-300)


def test_nothing_is_stretched_by_default(disk):
    np.testing.assert_array_equal(stretch_half_vector(*disk, NO_STRETCH), disk)
    np.testing.assert_array_equal(unstretch_half_vector(*disk, NO_STRETCH), disk)


@systems
@pytest.mark.parametrize("k", STRETCHES)
def test_a_system_stretches_its_half_vector_alone(random, system, k):
    theta_i, theta_o = np.arccos(random.random((2, 500)))
    phi = 2 * np.pi * random.random(500)
    plain, found = (2 * each.encode(theta_i, 0, theta_o, phi) - 1 for each in (system(), system(stretch=k)))
    np.testing.assert_array_equal(found[:, 0], plain[:, 0])
    radius, new = (np.hypot(mu[:, 1], mu[:, 2]) for mu in (plain, found))
    np.testing.assert_allclose(np.sinh(new * np.arcsinh(k)), k * radius, atol=1e-9 * k)
    np.testing.assert_allclose(found[:, 1] * plain[:, 2], found[:, 2] * plain[:, 1], atol=1e-12)
    back = system(stretch=k).decode((found + 1) / 2)
    np.testing.assert_allclose(back[0], theta_i, atol=1e-6)
    np.testing.assert_allclose(back[2], theta_o, atol=1e-6)

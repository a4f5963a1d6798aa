"""Both systems whose first coordinate is softened at retro-reflection, with any softening radius."""

import numpy as np
import pytest

from fitter.coordinates.half_difference import HALF_DIFFERENCE_SOFTENING, HalfDifference, project
from fitter.coordinates.rusinkiewicz import LEAST_SOFTENING, RUSINKIEWICZ_SOFTENING, Rusinkiewicz

every_system = pytest.mark.parametrize("system", [
    *map(HalfDifference, (LEAST_SOFTENING, HALF_DIFFERENCE_SOFTENING, 0.3)),
    *map(Rusinkiewicz, (LEAST_SOFTENING, RUSINKIEWICZ_SOFTENING, 0.3))], ids=str)


def first_of_mirror_pairs(system, theta):
    """The first coordinate of pairs of directions that mirror each other, theta from the normal."""
    length = project(theta) if isinstance(system, HalfDifference) else np.sin(theta)
    softened = (system.softening ** 4 + (1 - system.softening ** 4) * length ** 4) ** 0.25
    return softened if isinstance(system, HalfDifference) else project(np.arcsin(softened))


@every_system
def test_decode_is_the_inverse_but_for_a_turn_about_the_normal(pairs, system):
    theta_i, phi_i, theta_o, phi_o = system.decode(system.encode(*pairs))
    np.testing.assert_allclose(theta_i, pairs[0], atol=1e-9)
    np.testing.assert_allclose(theta_o, pairs[2], atol=1e-9)
    np.testing.assert_allclose(np.cos(phi_o - phi_i), np.cos(pairs[3] - pairs[1]), atol=1e-9)


@every_system
def test_the_mirror_direction_has_no_half_vector_and_exchange_turns_it(pairs, system):
    theta_i, phi_i, theta_o, phi_o = pairs
    mirror = 2 * system.encode(theta_i, phi_i, theta_i, phi_i + np.pi) - 1
    np.testing.assert_allclose(mirror[:, 0], first_of_mirror_pairs(system, theta_i),
                               atol=1e-12 if isinstance(system, HalfDifference) else 1e-7)
    np.testing.assert_allclose(mirror[:, 1:], 0, atol=1e-12)
    np.testing.assert_allclose(2 * system.encode(theta_o, phi_o, theta_i, phi_i) - 1,
                               (2 * system.encode(*pairs) - 1) * [1, -1, 1], atol=1e-12)


@every_system
@pytest.mark.parametrize("theta", [0, 0.4, 1.5, np.pi / 2])
def test_the_same_direction_twice_is_a_point_of_its_own(theta, system):
    found = 2 * system.encode(theta, 0.3, theta, 0.3) - 1
    np.testing.assert_allclose(found, [first_of_mirror_pairs(system, 0.0), 0, project(theta)], atol=1e-12)

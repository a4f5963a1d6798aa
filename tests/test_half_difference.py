import numpy as np
import pytest

from fitter.half_difference import directions, half_difference, project


@pytest.fixture
def pairs(random):
    theta_i, theta_o = np.arccos(random.random((2, 500)))
    phi_i, phi_o = random.random((2, 500)) * 2 * np.pi
    return theta_i, phi_i, theta_o, phi_o


def test_directions_is_the_inverse_but_for_a_turn_about_the_normal(pairs):
    theta_i, phi_i, theta_o, phi_o = pairs
    back = directions(half_difference(*pairs))
    np.testing.assert_allclose(back[0], theta_i, atol=1e-9)
    np.testing.assert_allclose(back[2], theta_o, atol=1e-9)
    np.testing.assert_allclose(np.cos(back[3] - back[1]), np.cos(phi_o - phi_i), atol=1e-9)


def test_the_mirror_direction_has_no_half_vector_and_exchange_turns_it(pairs):
    theta_i, phi_i, theta_o, phi_o = pairs
    mirror = 2 * half_difference(theta_i, phi_i, theta_i, phi_i + np.pi) - 1
    np.testing.assert_allclose(mirror[:, 0], project(theta_i), atol=1e-12)
    np.testing.assert_allclose(mirror[:, 1:], 0, atol=1e-12)
    np.testing.assert_allclose(2 * half_difference(theta_o, phi_o, theta_i, phi_i) - 1,
                               (2 * half_difference(*pairs) - 1) * [1, -1, 1], atol=1e-12)


def test_turning_and_mirroring_both_directions_change_nothing(pairs):
    theta_i, phi_i, theta_o, phi_o = pairs
    expected = half_difference(*pairs)
    np.testing.assert_allclose(half_difference(theta_i, phi_i + 1, theta_o, phi_o + 1), expected, atol=1e-12)
    np.testing.assert_allclose(half_difference(theta_i, -phi_i, theta_o, -phi_o), expected, atol=1e-12)


@pytest.mark.parametrize("theta", [0, 0.4, 1.5, np.pi / 2])
def test_the_same_direction_twice_is_a_point_of_its_own(theta):
    np.testing.assert_allclose(2 * half_difference(theta, 0.3, theta, 0.3) - 1, [0, project(theta), 0], atol=1e-12)

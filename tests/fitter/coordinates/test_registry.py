"""What every coordinate system must do. A system that is entered in COORDINATES is tested here by itself."""

import numpy as np
import pytest

from fitter.coordinates import COORDINATES
from fitter.coordinates.half_difference import HalfDifference
from fitter.coordinates.rusinkiewicz import Rusinkiewicz

STRETCHED = HalfDifference(stretch=33.0), Rusinkiewicz(stretch=33.0)
every_system = pytest.mark.parametrize("system", [*(make() for make in COORDINATES.values()), *STRETCHED], ids=str)


@pytest.fixture
def pairs(random):
    """Pairs of directions, among them the normal, grazing directions, mirror and retro-reflective pairs."""
    special = np.array([(theta_i, theta_o, delta_phi) for theta_i in (0, 1e-9, 0.7, np.pi / 2)
                        for theta_o in (0, 1e-9, 0.7, np.pi / 2) for delta_phi in (0, 1e-9, 2, np.pi)]).T
    theta_i, theta_o, delta_phi = np.concatenate([special, random.random((3, 500)) * [[1.57], [1.57], [6.28]]], axis=1)
    phi_i = random.random(len(theta_i)) * 6.28
    return theta_i, phi_i, theta_o, phi_i + delta_phi


def vectors(theta, phi):
    return np.stack([np.sin(theta) * np.cos(phi), np.sin(theta) * np.sin(phi), np.cos(theta)], axis=-1)


def test_systems_are_entered_under_their_names():
    assert {name: make.name for name, make in COORDINATES.items()} == {name: name for name in COORDINATES}


@every_system
def test_the_image_lies_in_the_quarter_of_the_cube_that_lattices_store(system, pairs):
    x = system.encode(*pairs)
    assert x.shape == (len(pairs[0]), len(system.axes))
    assert x.dtype == np.float64
    assert ((x >= -1e-12) & (x <= 1 + 1e-12)).all()
    assert (x[:, [0, -1]] >= 0.5 - 1e-12).all()


@every_system
def test_encode_broadcasts(system):
    x = system.encode(np.zeros((2, 1)), 0.1, np.linspace(0, 1, 3), 0.2)
    assert x.shape == (2, 3, len(system.axes))
    assert system.decode(x)[0].shape == (2, 3)


@every_system
def test_a_rotation_about_the_normal_and_a_mirror_image_have_the_same_coordinates(system, pairs):
    theta_i, phi_i, theta_o, phi_o = pairs
    x = system.encode(*pairs)
    np.testing.assert_allclose(system.encode(theta_i, phi_i + 1, theta_o, phi_o + 1), x, atol=1e-9)
    np.testing.assert_allclose(system.encode(theta_i, -phi_i, theta_o, -phi_o), x, atol=1e-9)


@every_system
def test_decode_gives_the_pair_up_to_rotation_and_mirror_image(system, pairs):
    theta_i, phi_i, theta_o, phi_o = system.decode(system.encode(*pairs))
    # an angle is as accurate as a root of rounding: where a projection is flat, and with softening at retro-reflection
    np.testing.assert_allclose(theta_i, pairs[0], atol=2e-5)
    np.testing.assert_allclose(theta_o, pairs[2], atol=2e-5)
    found = (vectors(theta_i, phi_i) * vectors(theta_o, phi_o)).sum(axis=1)
    expected = (vectors(pairs[0], pairs[1]) * vectors(pairs[2], pairs[3])).sum(axis=1)
    np.testing.assert_allclose(found, expected, atol=2e-5)

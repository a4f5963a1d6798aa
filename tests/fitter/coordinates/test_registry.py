"""What every coordinate system must do. A system that is entered in COORDINATES is tested here by itself."""

import numpy as np
import pytest

from fitter.arrays import unit_vectors
from fitter.coordinates import COORDINATES, ISOTROPIC_AXES
from fitter.coordinates.anisotropic_rusinkiewicz import AnisotropicRusinkiewicz
from fitter.coordinates.half_angle import HalfAngle
from fitter.coordinates.half_difference import HalfDifference
from fitter.coordinates.rusinkiewicz import LEAST_SOFTENING, Rusinkiewicz

STRETCHED = (HalfDifference(stretch=33.0), Rusinkiewicz(stretch=33.0), HalfAngle(33.0), HalfAngle(1000.0),
             HalfAngle(5.0, 33.0), AnisotropicRusinkiewicz(33.0, 5.0, 0.7))
SOFTENED = [make(softening) for make in (HalfDifference, Rusinkiewicz) for softening in (LEAST_SOFTENING, 0.3)]
SYSTEMS = [*(make() for make in COORDINATES.values()), *STRETCHED, *SOFTENED]
every_system = pytest.mark.parametrize("system", SYSTEMS, ids=str)
every_isotropic_system, every_anisotropic_system = (
    pytest.mark.parametrize("system", [system for system in SYSTEMS if (len(system.axes) == ISOTROPIC_AXES) is wanted],
                            ids=str) for wanted in (True, False))


@pytest.fixture
def pairs(random):
    """Pairs of directions, among them the normal, grazing directions, mirror and retro-reflective pairs."""
    special = np.array([(theta_i, theta_o, delta_phi) for theta_i in (0, 1e-9, 0.7, np.pi / 2)
                        for theta_o in (0, 1e-9, 0.7, np.pi / 2) for delta_phi in (0, 1e-9, 2, np.pi)]).T
    theta_i, theta_o, delta_phi = np.concatenate([special, random.random((3, 500)) * [[1.57], [1.57], [6.28]]], axis=1)
    phi_i = random.random(len(theta_i)) * 6.28
    return theta_i, phi_i, theta_o, phi_i + delta_phi


def test_systems_are_entered_under_their_names():
    assert {name: make.name for name, make in COORDINATES.items()} == {name: name for name in COORDINATES}


@every_system
def test_the_image_lies_in_the_part_of_the_cube_that_lattices_store(system, pairs):
    x = system.encode(*pairs)
    assert x.shape == (len(pairs[0]), len(system.axes))
    assert x.dtype == np.float64
    assert ((x >= -1e-12) & (x <= 1 + 1e-12)).all()
    halved = [0, -1] if len(system.axes) == ISOTROPIC_AXES else [-1]
    assert (x[:, halved] >= 0.5 - 1e-12).all()


@every_system
def test_encode_broadcasts(system):
    x = system.encode(np.zeros((2, 1)), 0.1, np.linspace(0, 1, 3), 0.2)
    assert x.shape == (2, 3, len(system.axes))
    assert system.decode(x)[0].shape == (2, 3)


@every_isotropic_system
def test_a_rotation_about_the_normal_and_a_mirror_image_have_the_same_coordinates(system, pairs):
    theta_i, phi_i, theta_o, phi_o = pairs
    x = system.encode(*pairs)
    np.testing.assert_allclose(system.encode(theta_i, phi_i + 1, theta_o, phi_o + 1), x, atol=1e-9)
    np.testing.assert_allclose(system.encode(theta_i, -phi_i, theta_o, -phi_o), x, atol=1e-9)


@every_isotropic_system
def test_decode_gives_the_pair_up_to_rotation_and_mirror_image(system, pairs):
    theta_i, phi_i, theta_o, phi_o = system.decode(system.encode(*pairs))
    # an angle is as accurate as a root of rounding where a projection is flat, and at retro-reflection as its fourth
    # root times the softening radius
    accuracy = max(2e-5, 1e-3 * getattr(system, "softening", 0) * (system.axes[0] == "d"))
    np.testing.assert_allclose(theta_i, pairs[0], atol=accuracy)
    np.testing.assert_allclose(theta_o, pairs[2], atol=accuracy)
    found = (unit_vectors(theta_i, phi_i) * unit_vectors(theta_o, phi_o)).sum(axis=1)
    expected = (unit_vectors(pairs[0], pairs[1]) * unit_vectors(pairs[2], pairs[3])).sum(axis=1)
    np.testing.assert_allclose(found, expected, atol=2e-5)


@every_anisotropic_system
def test_exchanged_directions_have_the_same_coordinates_and_turned_ones_do_not(system, pairs):
    theta_i, phi_i, theta_o, phi_o = pairs
    x = system.encode(*pairs)
    back = system.encode(theta_o, phi_o, theta_i, phi_i)
    seam = np.abs(x[:, 3] - 0.5) < 1e-6                 # where the two halves meet, either may be given
    np.testing.assert_allclose(back[~seam], x[~seam], atol=1e-9)
    np.testing.assert_allclose(np.abs(back[seam] - 0.5), np.abs(x[seam] - 0.5), atol=1e-6)
    apart = np.abs(x - system.encode(theta_i, phi_i + 1, theta_o, phi_o + 1)).max(axis=1)
    assert (apart[np.maximum(theta_i, theta_o) > 0.5] > 1e-3).all()


@every_anisotropic_system
def test_decode_gives_the_pair_in_one_of_its_orders(system, pairs):
    theta_i, phi_i, theta_o, phi_o = system.decode(system.encode(*pairs))
    found = unit_vectors(theta_i, phi_i), unit_vectors(theta_o, phi_o)
    expected = unit_vectors(*pairs[:2]), unit_vectors(*pairs[2:])
    apart = [np.maximum(np.abs(found[0] - first).max(axis=1), np.abs(found[1] - second).max(axis=1))
             for first, second in (expected, expected[::-1])]
    # where both directions graze and mirror each other there is no half vector
    mirrored = np.abs(expected[0] + expected[1]).max(axis=1) < 1e-6
    assert (np.minimum(*apart)[~mirrored] < 2e-5).all()

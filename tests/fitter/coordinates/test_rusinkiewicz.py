import numpy as np
import pytest

from fitter.arrays import unit_vectors
from fitter.coordinates.half_difference import project, unproject
from fitter.coordinates.rusinkiewicz import LEAST_SOFTENING, RUSINKIEWICZ_SOFTENING, Rusinkiewicz

softened = pytest.mark.parametrize("softening", [LEAST_SOFTENING, RUSINKIEWICZ_SOFTENING, 0.3])


def rotation(axis, angle):
    """The matrix of a rotation about the y or the z axis: (3, 3)."""
    c, s = np.cos(angle), np.sin(angle)
    return np.array([[c, 0, s], [0, 1, 0], [-s, 0, c]] if axis == "y" else [[c, -s, 0], [s, c, 0], [0, 0, 1]])


def papers_angles(theta_i, phi_i, theta_o, phi_o):
    """theta_h, theta_d and phi_d as the paper defines them, by rotation matrices: the incident direction after the half
    vector has been turned to the normal."""
    i, o = unit_vectors(theta_i, phi_i), unit_vectors(theta_o, phi_o)
    h = (i + o) / np.linalg.norm(i + o)
    theta_h, phi_h = np.arccos(h[2]), np.arctan2(h[1], h[0])
    turned = rotation("y", -theta_h) @ rotation("z", -phi_h)
    np.testing.assert_allclose(turned @ h, [0, 0, 1], atol=1e-12)
    d = turned @ i
    return theta_h, np.arccos(np.clip(d[2], -1, 1)), np.arctan2(d[1], d[0])


@softened
def test_the_coordinates_are_the_papers_angles(pairs, softening):
    theta_h, theta_d, phi_d = np.array([papers_angles(*pair) for pair in zip(*pairs, strict=True)]).T
    d, x, y = (2 * Rusinkiewicz(softening).encode(*pairs) - 1).T
    s = (softening ** 4 + (1 - softening ** 4) * np.sin(theta_d) ** 4) ** 0.25
    np.testing.assert_allclose(d, project(np.arcsin(s)), atol=1e-10)
    np.testing.assert_allclose(x, project(theta_h) * np.cos(phi_d) * np.sin(theta_d) / s, atol=1e-10)
    np.testing.assert_allclose(x ** 2 + y ** 2, project(theta_h) ** 2, atol=1e-10)
    far = np.sin(theta_d) > 30 * softening              # without regard to the softening
    assert np.count_nonzero(far) > (400 if 30 * softening < 1 else -1)
    radius = project(theta_h)
    unsoftened = np.stack([project(theta_d), radius * np.cos(phi_d), radius ** 2 * np.sin(phi_d) ** 2])
    np.testing.assert_allclose(np.stack([d, x, y ** 2])[:, far], unsoftened[:, far], atol=1e-5)


@softened
def test_coordinates_that_no_directions_have_are_taken_for_some_that_are_near(softening, random):
    """All of the part of the cube that lattices store is decoded, for the nodes of a lattice are."""
    mu = random.random((20_000, 3)) * [1, 2, 1] - [0, 1, 0]
    system = Rusinkiewicz(softening)
    theta_i, phi_i, theta_o, phi_o = system.decode((mu + 1) / 2)
    for theta in (theta_i, theta_o):
        assert ((theta >= 0) & (theta <= np.pi / 2 + 1e-12)).all()
    assert np.isfinite(phi_o - phi_i).all()
    back = 2 * system.encode(theta_i, phi_i, theta_o, phi_o) - 1
    # both directions are above the horizon, whatever the azimuth of the difference, where theta_h + theta_d is at most
    # a right angle
    half = np.hypot(mu[:, 1], mu[:, 2])
    above = (half < 1) & (unproject(half) + unproject(mu[:, 0]) < np.pi / 2) & (mu[:, 0] > 0.5 * softening)
    assert np.count_nonzero(above) > 20
    np.testing.assert_allclose(np.hypot(back[above, 1], back[above, 2]), half[above], atol=1e-9)
    np.testing.assert_allclose(back[above, 0], mu[above, 0], atol=1e-9)


def test_grazing_pairs_that_mirror_each_other_are_finite():
    for gap in (0, 1e-12, 1e-6, 1e-3):
        coordinates = Rusinkiewicz(stretch=33.0).encode(np.pi / 2, 0, np.pi / 2, np.pi - gap)
        assert ((coordinates >= 0) & (coordinates <= 1 + 1e-9)).all()

"""The half angle and the difference vector, against Rusinkiewicz's angles found by rotations."""

import numpy as np
import pytest

from fitter.arrays import unit_vectors
from fitter.coordinates.half_angle import HalfAngle
from fitter.coordinates.half_difference import project


def rotated(w, axis, angle):
    """Rodrigues' rotation: (n, 3) about (n, 3) or (3,), by (n,)."""
    axis = np.broadcast_to(axis, w.shape)
    c, s = np.cos(angle)[:, None], np.sin(angle)[:, None]
    return w * c + np.cross(axis, w) * s + axis * (w * axis).sum(axis=1, keepdims=True) * (1 - c)


@pytest.mark.parametrize(("stretch", "back"), [(0.0, 0.0), (5.0, 0.0), (300.0, 0.0), (5.0, 33.0)])
def test_the_coordinates_are_those_of_rusinkiewiczs_angles(random, stretch, back):
    theta_i, theta_o = np.arccos(random.random((2, 400)))
    phi = 2 * np.pi * random.random(400)
    i, o = unit_vectors(theta_i, 0.0), unit_vectors(theta_o, phi)
    half = i + o
    half /= np.linalg.norm(half, axis=1)[:, None]
    theta_h, phi_h = np.arccos(half[:, 2]), np.arctan2(half[:, 1], half[:, 0])
    difference = rotated(rotated(i, [0, 0, 1], -phi_h), [0, 1, 0], -theta_h)
    theta_d, phi_d = np.arccos(difference[:, 2]), np.arctan2(difference[:, 1], difference[:, 0])
    system = HalfAngle(stretch, back)
    h, x, y = (2 * system.encode(theta_i, 0, theta_o, phi) - 1).T
    r, delta = project(theta_h), 0.3 / max(stretch, 1)
    np.testing.assert_allclose(h, np.arcsinh(stretch * r) / np.arcsinh(stretch) if stretch else r, atol=1e-9)
    d = np.arcsinh(back * project(theta_d)) / np.arcsinh(back) if back else project(theta_d)
    np.testing.assert_allclose(np.hypot(x, y), d, atol=1e-9)
    # the incident direction is lowered where it lies on the far side of the half vector
    np.testing.assert_allclose(x, d * np.cos(phi_d) * r ** 2 / (r ** 2 + delta ** 2), atol=1e-9)

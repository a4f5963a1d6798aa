import itertools

import numpy as np
import pytest

from fitter.arrays import unit_vectors
from fitter.coordinates.nusselt import Nusselt


def test_coordinates_are_those_of_the_projected_vectors(random):
    theta_i, theta_o = random.random((2, 500)) * np.pi / 2
    phi_i, phi_o = random.random((2, 500)) * 20 - 10
    incident, outgoing = unit_vectors(theta_i, phi_i), unit_vectors(theta_o, phi_o)
    along = incident[:, :2] / np.linalg.norm(incident[:, :2], axis=1, keepdims=True)
    mu_x = (outgoing[:, :2] * along).sum(axis=1)
    mu_y = np.abs(outgoing[:, 0] * along[:, 1] - outgoing[:, 1] * along[:, 0])
    expected = (np.stack([np.hypot(incident[:, 0], incident[:, 1]), mu_x, mu_y], axis=1) + 1) / 2
    np.testing.assert_allclose(Nusselt().encode(theta_i, phi_i, theta_o, phi_o), expected, atol=1e-14)


def test_directions_invert_nusselt_at_the_edges_too():
    for theta_i, theta_o, delta_phi in itertools.product(
            [0, 1e-9, 0.3, np.pi / 2 - 1e-9, np.pi / 2], [0, 1e-9, 1.2, np.pi / 2],
            [0, 1e-9, 2.0, np.pi - 1e-9, np.pi]):
        back = Nusselt().decode(Nusselt().encode(theta_i, 0.7, theta_o, 0.7 + delta_phi))
        # near the horizon the projection is flat: an angle comes back to the square root of rounding
        assert [back[0], back[2]] == pytest.approx([theta_i, theta_o], abs=1e-7)
        assert back[1] == 0
        at, expected = (np.sin(theta_o) * np.exp(1j * phi) for phi in (back[3], delta_phi))
        assert at == pytest.approx(expected, abs=1e-7), (theta_i, theta_o, delta_phi)


def test_directions_refuses_what_no_direction_projects_to():
    with pytest.raises(ValueError, match="outside"):
        Nusselt().decode([0.5, 1.0, 1.0])

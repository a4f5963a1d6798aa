"""Directions between nodes: even, and about the mirror direction by the logarithm of the angle from it."""

import numpy as np
import pytest

from fitter.arrays import unit_vectors
from fitter.coordinates import direction_sampling


@pytest.mark.parametrize("isotropic", [True, False])
def test_a_third_is_even_and_the_rest_is_about_the_mirror_direction(isotropic):
    theta_i, phi_i, theta_o, phi_o = direction_sampling.sample_directions(30_000, isotropic)
    incident, outgoing = unit_vectors(theta_i, phi_i), unit_vectors(theta_o, phi_o)
    mirrored = incident * (-1, -1, 1)
    away = np.degrees(np.arccos(np.clip((mirrored * outgoing).sum(axis=1), -1, 1)))
    decades = [np.count_nonzero((away >= low) & (away < high)) / 30_000
               for low, high in ((0, 0.0999), (0.1, 0.5), (0.5, 2.5), (2.5, 12.5), (20.001, 180))]
    # two thirds over log(200), of which some are below the horizon, and a few of those that are evenly spread
    share = 2 / 3 * np.log(5) / np.log(200)
    assert decades[0] < 0.001
    assert 0.9 * share < decades[1] < 1.02 * share
    assert 0.9 * share < decades[2] < 1.05 * share
    assert 0.85 * share < decades[3] < 1.15 * share
    assert decades[4] == pytest.approx(1 / 3, abs=0.03)
    even = (away > 21) & (np.cos(phi_o - phi_i) > 0) & (np.minimum(theta_i, theta_o) > np.radians(22))
    counts = np.histogram2d(theta_i[even], theta_o[even], bins=4)[0]
    assert counts.min() > 0.7 * counts.max()


def test_isotropic_ones_lie_on_one_side_and_others_all_around():
    _, phi_i, theta_o, phi_o = direction_sampling.sample_directions(5_000)
    assert not phi_i.any()
    assert phi_o.min() >= 0
    assert phi_o.max() <= np.pi
    assert np.degrees(theta_o.max()) < 89.91
    _, phi_i, _, phi_o = direction_sampling.sample_directions(5_000, isotropic=False)
    for turn in (phi_i, phi_o - phi_i):
        assert (np.histogram(np.mod(turn, 2 * np.pi), bins=8, range=(0, 2 * np.pi))[0] > 150).all()

"""Anisotropic lobes: against the published model, one direction at a time."""

import numpy as np
import pytest

from fitter.model.microfacet import KINDS, geometry, lobe, lobe_with_slopes, surface_components
from fitter.quality.physics import direction_pairs
from support.anisotropic import brushed_fit, ggx_lobe, turned, vectors


def pairs(count=400, seed=0):
    random = np.random.default_rng(seed)
    theta_i, _, theta_o, _ = direction_pairs(count)
    return theta_i, *2 * np.pi * random.random((1, count)), theta_o, *2 * np.pi * random.random((1, count))


def test_a_lobe_is_the_published_distribution_and_masking():
    along, across, turn = 0.12, 0.45, np.radians(20)
    directions = pairs()
    wi, wo = (turned(w, turn) for w in vectors(*directions))
    h = (wi + wo) / np.linalg.norm(wi + wo, axis=1)[:, None]
    fresnel = 0.9 + 0.1 * (1 - np.sum(wi * h, axis=1)) ** 5
    expected = ggx_lobe(wi, wo, along, across) * np.pi * along * across * fresnel      # a lobe's D is 1 at the normal
    found = (brushed_fit(along, across, turn).evaluate(*directions)[:, 0] - 0.02) / 0.8
    steep = np.maximum(directions[0], directions[2]) < np.radians(80)
    np.testing.assert_allclose(found[steep], expected[steep], rtol=0.01)


def test_of_equal_widths_it_does_not_change_when_both_directions_turn():
    theta_i, phi_i, theta_o, phi_o = directions = pairs()
    nearly = brushed_fit(0.2, 0.2 * (1 + 1e-9))
    assert brushed_fit(0.2, 0.2).isotropic
    assert not nearly.isotropic
    np.testing.assert_allclose(nearly.evaluate(theta_i, phi_i + 1, theta_o, phi_o + 1), nearly.evaluate(*directions),
                               rtol=1e-6)


def test_a_quarter_turn_exchanges_the_widths():
    theta_i, phi_i, theta_o, phi_o = pairs()
    quarter = np.pi / 2
    np.testing.assert_allclose(brushed_fit(0.1, 0.4, 0.3).evaluate(theta_i, phi_i, theta_o, phi_o),
                               brushed_fit(0.4, 0.1, 0.3).evaluate(theta_i, phi_i + quarter, theta_o, phi_o + quarter))


@pytest.mark.parametrize("kind", KINDS)
@pytest.mark.parametrize("numbers", [(0.3, 2.5, 0.2, 0.5, 0.4), (0.2, 1.6, 0.8, 0.2, 0.0), (1.4, 3.0, 0.5, 0.6, -1.0),
                                     (0.5, 2.0, 0.1)], ids=str)
def test_slopes_of_a_lobe_are_those_of_small_steps(random, kind, numbers):
    if kind == "fibre" and len(numbers) == 3:
        pytest.skip("fibres have a direction")
    theta_i, theta_o = np.arccos(random.uniform(0.02, 1, (2, 500)))
    directions = theta_i, random.uniform(0, 7, 500), theta_o, random.uniform(0, 7, 500)
    at, along = geometry(*directions), surface_components(*directions) if len(numbers) > 3 else None
    value, derivatives = lobe_with_slopes(kind, at, along, *numbers)
    slopes = derivatives()
    np.testing.assert_array_equal(value, lobe(kind, at, along, *numbers))
    assert len(slopes) == len(numbers)
    for axis, slope in enumerate(slopes):
        sides = []
        for step in (-1e-5, 1e-5):
            moved = list(numbers)
            moved[axis] = moved[axis] * np.exp(step) if axis in (0, 3) else moved[axis] + step
            sides.append(lobe(kind, at, along, *moved))
        expected = (sides[1] - sides[0]) / 2e-5
        np.testing.assert_allclose(slope, expected, rtol=1e-5, atol=1e-7 * np.abs(slope).max() + 1e-9)

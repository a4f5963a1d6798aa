"""Directions as users give them: any angle, below the horizon too."""

import numpy as np
import pytest

import fitter
from fitter.arrays import unit_vectors
from support import truths


@pytest.fixture(scope="module", params=["Paper", "Standard"])
def fit(request):
    return fitter.fit(truths.TRUTHS["retro a"].measured("Cornell"), **fitter.PRESETS[request.param])


def test_values_belong_to_directions_not_to_the_angles_that_name_them(fit):
    random = np.random.default_rng(1)
    given = random.uniform(-3 * np.pi, 3 * np.pi, (4, 500))
    given[::2] = np.where(random.random((2, 500)) < 0.5, given[::2] / 6, given[::2])    # half of them above the horizon
    x, y, z = np.moveaxis(unit_vectors(given[::2], given[1::2]), -1, 0)
    theta, phi = np.arccos(np.clip(z, -1, 1)), np.arctan2(y, x)
    below = (z < 0).any(axis=0)
    found = fit.evaluate(*given)
    assert 100 < np.count_nonzero(below) < 400
    np.testing.assert_array_equal(found[below], 0)
    expected = fit.evaluate(theta[0], phi[0], theta[1], phi[1])
    np.testing.assert_allclose(found[~below], expected[~below], rtol=1e-6, atol=1e-9)
    assert np.abs(expected[~below]).min() > 0

"""Averages of many pixels, beside a reflectance that is known everywhere."""

import numpy as np
import pytest

from fitter.photographs.ball import measuring
from fitter.photographs.ball.binning import bin_samples
from support import ball_scene
from tests.fitter.photographs.test_ball import photographed


@pytest.fixture(scope="module")
def slices():
    """Half a million pairs of directions with the difference angles of four photographs."""
    random = np.random.default_rng(3)
    parts = []
    for phase in np.radians((20, 60, 100, 140)):
        theta_i, turn = np.arccos(1 - random.random((2, 400_000)) * [[0.83], [2]])
        normal = np.stack([np.sin(theta_i) * np.cos(2 * turn), np.sin(theta_i) * np.sin(2 * turn), np.cos(theta_i)], 1)
        view = np.array([np.sin(phase), 0, np.cos(phase)])
        theta_o = np.arccos(normal @ view)
        along = view - np.cos(theta_o)[:, None] * normal
        light = np.array([0, 0, 1]) - np.cos(theta_i)[:, None] * normal
        delta = np.arctan2(np.sum(np.cross(light, along) * normal, axis=1), np.sum(light * along, axis=1))
        kept = theta_o < 1.39
        parts.append(np.stack([theta_i, 0 * theta_i, theta_o, delta])[:, kept])
    return tuple(np.concatenate(parts, axis=1))


@pytest.mark.parametrize("make", [ball_scene.matte, ball_scene.glossy, ball_scene.velvet],
                         ids=lambda make: make.__name__)
def test_means_are_those_of_the_reflectance_however_noisy_the_pixels_are(slices, make):
    truth, random = make(), np.random.default_rng(5)
    values = truth.evaluate(*slices)
    noisy = values * (1 + 0.2 * random.standard_normal(values.shape))
    directions, means, deviation = bin_samples(slices, noisy, np.full(len(values), 0.2), 5000)
    assert 3000 < len(means) <= 5000
    exact = truth.evaluate(*directions)
    off = (means / exact - 1).mean(axis=1)
    # a bias would be the same everywhere; what is left is noise
    assert abs(np.average(off, weights=1 / deviation ** 2)) < 0.003
    highlight = exact.mean(axis=1) > np.quantile(exact.mean(axis=1), 0.95)
    assert abs(np.average(off[highlight], weights=1 / deviation[highlight] ** 2)) < 0.01


def test_the_deviation_is_that_of_the_means(slices):
    truth, random = ball_scene.matte(), np.random.default_rng(6)
    values = truth.evaluate(*slices)[:, :1]
    directions, means, deviation = bin_samples(slices, values * (1 + 0.2 * random.standard_normal(values.shape)),
                                               np.full(len(values), 0.2), 20_000)
    off = (means / truth.evaluate(*directions)[:, :1] - 1)[:, 0] / deviation
    assert np.sqrt(np.mean(off ** 2)) == pytest.approx(1, abs=0.15)


def test_directions_that_scatter_more_than_their_pixels_say_count_less():
    directions = tuple(np.repeat([[a, b]], 50, axis=0).T.ravel() for a, b in ((0.3, 0.9), (0, 0), (0.4, 0.8), (2, 1)))
    values = np.ones((100, 1))
    values[:50] += 0.3 * np.random.default_rng(1).standard_normal((50, 1))
    found, _, deviation = bin_samples(directions, values, np.full(100, 0.01), 10)
    order = np.argsort(found[0])
    assert deviation[order][0] > 10 * deviation[order][1]


def test_many_pixels_become_at_most_so_many_samples(monkeypatch):
    monkeypatch.setattr(measuring, "MOST_SAMPLES", 5000)
    truth = ball_scene.glossy()
    found = measuring.samples_from_ball([photographed(scene, truth) for scene in ball_scene.scenes((20, 60))])
    assert 3000 < len(found) <= 5000
    assert found.notes[-1] == f"Averaged to {len(found):,} samples"
    assert np.median(np.abs(found.values / truth.evaluate(*found.directions) - 1)) < 0.02

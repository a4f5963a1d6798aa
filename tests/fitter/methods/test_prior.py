"""Priors by forward selection, against the models that made the samples."""

import itertools

import numpy as np
import pytest

from fitter import Samples
from fitter.methods import prior
from fitter.model.microfacet import MAX_PRIOR_LOBES, NO_GAMMA, RANGES, Microfacet
from fitter.model.transform import bounded_log

MIRROR, COAT, RETRO, SHEEN = ("mirror", 0.3, 2.5, 0.2), ("mirror", 0.04, 2.0, 0.05), ("retro", 0.1, 3.0, 0.8), (
    "sheen", 1.2, NO_GAMMA, 0.7)


@pytest.fixture
def directions(random):
    """Pairs of directions, a third of them about the mirror direction and a third about the light."""
    count = 900
    theta_i, theta_o = np.arcsin(np.sqrt(random.random((2, count)) * 0.97))
    phi = random.random(count) * 2 * np.pi
    near = np.arange(count) % 3 > 0
    theta_o = np.where(near, np.clip(theta_i + 0.1 * random.standard_normal(count), 0, 1.45), theta_o)
    phi = np.where(near, np.pi * (np.arange(count) % 3 == 1) + 0.1 * random.standard_normal(count), phi)
    return theta_i, np.zeros(count), theta_o, phi


def model(*lobes, ks=(2.0, 1.5, 1.0), kd=(0.05, 0.1, 0.15)):
    kinds, alpha, gamma, f0 = zip(*lobes, strict=True)
    strengths = np.array([np.array(ks) * factor for factor in (1.0, 0.6, 0.4)[:len(lobes)]])
    return Microfacet(np.array(kd), strengths, np.array(alpha), np.array(gamma), np.array(f0), kinds)


def models_of(truth, directions):
    """The models that are fitted to a truth, its values, and the offset."""
    values = truth.evaluate(*directions)
    offset = float(np.median(values))
    samples = Samples(*directions, values, ("R", "G", "B"))
    return prior.candidates(samples, values, offset), values, offset


def error(fitted, directions, values, offset):
    """RMSE of the logarithm."""
    residual = bounded_log(fitted.evaluate(*directions), offset) - bounded_log(values, offset)
    return np.sqrt(np.mean(residual ** 2))


@pytest.mark.parametrize("lobe", [MIRROR, COAT, RETRO, SHEEN])
def test_one_lobe_of_each_kind_is_found(directions, lobe):
    (_, fitted, *_), values, offset = models_of(model(lobe), directions)
    assert fitted.kinds == (lobe[0],)
    assert error(fitted, directions, values, offset) < 0.01
    np.testing.assert_allclose(fitted.kd, [0.05, 0.1, 0.15], rtol=0.1)


@pytest.mark.parametrize("lobes", [(MIRROR, COAT), (COAT, RETRO), (MIRROR, RETRO)])
def test_two_lobes_are_found_one_after_the_other(directions, lobes):
    (_, _, fitted, *_), values, offset = models_of(model(*lobes), directions)
    assert sorted(fitted.kinds) == sorted(kind for kind, *_ in lobes)
    assert error(fitted, directions, values, offset) < 0.03


def test_each_candidate_has_one_lobe_more_and_is_closer(directions):
    models, values, offset = models_of(model(MIRROR, COAT, RETRO), directions)
    assert [len(each.kinds) for each in models] == list(range(MAX_PRIOR_LOBES + 1))
    errors = [error(each, directions, values, offset) for each in models]
    assert all(after < 0.9 * before for before, after in itertools.pairwise(errors))
    np.testing.assert_array_equal(models[0].kd, np.median(values, axis=0))
    for each in models:                          # what a file may hold
        for name, (low, high) in RANGES.items():
            numbers = getattr(each, name)
            assert ((low <= numbers) & (numbers <= high)).all()
        assert (each.ks >= 0).all()


def test_no_model_has_more_parameters_than_a_quarter_of_the_values(directions):
    truth = model(MIRROR, COAT, RETRO)
    for count, lobes in ((2, 0), (11, 0), (12, 1), (19, 1), (20, 2), (28, 3), (900, 3)):
        some = tuple(angle[:count] for angle in directions)
        models, _, _ = models_of(truth, some)
        assert len(models) == 1 + lobes, count
        # of one channel: 3 numbers of a lobe's shape, its strength and kd
        assert all(prior.parameter_count(each) <= 3 * count / 4 for each in models[1:])


def test_equal_values_have_no_lobes(directions):
    values = np.full((900, 2), 0.3)
    models = prior.candidates(Samples(*directions, values, ("a", "b")), values, 0.3)
    assert len(models) == 1
    np.testing.assert_array_equal(models[0].evaluate(*directions), 0.3)


def test_models_scale_with_their_samples(directions):
    values = model(MIRROR, COAT).evaluate(*directions)
    small, large = (prior.candidates(Samples(*directions, values * scale, ("R", "G", "B")), values * scale,
                                     scale * float(np.median(values))) for scale in (1e-12, 1e12))
    assert len(small) == len(large) == MAX_PRIOR_LOBES + 1
    for one, other in zip(small, large, strict=True):
        np.testing.assert_allclose(one.evaluate(*directions) * 1e24, other.evaluate(*directions), rtol=1e-5)


def test_a_coat_that_few_samples_show_is_as_white_as_they_are(random):
    """A blue paint under a white coat, of which one sample in a hundred shows the peak: no channel loses its lobe."""
    theta_i = np.radians(np.repeat(np.arange(10, 81, 10), 60))
    theta_o, phi = np.arcsin(np.sqrt(random.random(480) * 0.97)), 2 * np.pi * random.random(480)
    theta_o[::60], phi[::60] = theta_i[::60] + 0.02, np.pi
    directions = theta_i, 0 * theta_i, theta_o, phi
    coated = Microfacet(np.array([0.005, 0.03, 0.2]), np.array([[20.0, 20, 20]]), np.array([0.04]), np.array([2.0]),
                        np.array([0.05]))
    models, _, _ = models_of(coated, directions)
    coat = min(range(len(models[-1].alpha)), key=lambda k: models[-1].alpha[k])
    strengths = models[-1].ks[coat]
    assert strengths.max() < 1.5 * strengths.min()


def test_samples_below_zero_are_fitted_to_what_is_not():
    random = np.random.default_rng(3)
    directions = tuple(random.random((4, 300)) * [[1.4], [0], [1.4], [6.28]])
    values = random.standard_normal((300, 2))
    for each in prior.candidates(Samples(*directions, values, ("a", "b")), values, 1.0):
        assert np.isfinite(each.evaluate(*directions)).all()
        assert (each.evaluate(*directions) >= 0).all()

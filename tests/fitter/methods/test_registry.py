"""What every fitting method must do. A method that is entered in METHODS is tested here by itself."""

from typing import get_args

import numpy as np
import pytest

import fitter
from fitter import Fit, Samples
from fitter.methods import METHODS, MethodName, levels

SIZE = {"diffuse_level": 2, "specular_level": 4, "compression": 80.0}
every_method = pytest.mark.parametrize("method", METHODS)


def directions(random, count):
    theta_i, theta_o = np.arccos(random.random((2, count)))
    return theta_i, np.zeros(count), theta_o, random.random(count) * 2 * np.pi


@pytest.fixture
def samples(random):
    """A made highlight over a Lambertian, in three channels."""
    theta_i, phi_i, theta_o, phi_o = directions(random, 120)
    peak = np.exp(-8 * ((theta_i - theta_o) ** 2 + (1 + np.cos(phi_o)) ** 2))
    values = np.array([0.05, 0.1, 0.15]) + peak[:, None] * np.array([0.5, 0.4, 0.25])
    return Samples(theta_i, phi_i, theta_o, phi_o, values, ("R", "G", "B"), "made paint", "made by a test")


def test_the_names_are_those_of_the_type():
    assert set(METHODS) == set(get_args(MethodName))


@every_method
def test_a_fit_says_what_it_was_fitted_to(samples, method):
    fit = METHODS[method](samples, levels.Levels(*SIZE.values()), plausible=True)
    assert isinstance(fit, Fit)
    assert (fit.channels, fit.name, fit.source) == (samples.channels, samples.name, samples.source)
    assert (fit.diffuse_level, fit.specular_level, fit.compression) == tuple(SIZE.values())
    assert fit.evaluate(*samples.directions).shape == samples.values.shape


@every_method
@pytest.mark.parametrize("specular_level", [4, None])
def test_a_fit_is_finite_on_the_whole_hemisphere(samples, random, method, specular_level):
    fit = fitter.fit(samples, **SIZE | {"specular_level": specular_level}, method=method)
    theta, delta_phi = np.linspace(0, np.pi / 2, 10), np.linspace(0, 2 * np.pi, 13)
    edges = np.meshgrid(theta, [0.0], theta, delta_phi, indexing="ij")
    for pairs in ([angle.ravel() for angle in edges], directions(random, 2000)):
        assert np.isfinite(fit.evaluate(*pairs)).all()


@every_method
def test_a_constant_is_fitted_at_its_samples(random, method):
    white = Samples(*directions(random, 200), np.full((200, 1), 0.25))
    fit = fitter.fit(white, 3, 5, 80.0, method)
    np.testing.assert_allclose(fit.evaluate(*white.directions), 0.25, rtol=0.02)


@every_method
def test_the_fit_follows_its_samples(samples, method):
    """The made highlight varies by a factor of 11: the mean of the samples has an error of more than 0.1."""
    assert fitter.error_metrics(samples.values, samples.values.mean(axis=0) + 0 * samples.values).rmse > 0.1
    fit = fitter.fit(samples, 4, 6, 90.0, method)
    assert fitter.error_metrics(samples.values, fit.evaluate(*samples.directions)).rmse < 0.01


@every_method
def test_an_unknown_option_is_refused(samples, method):
    with pytest.raises(TypeError, match="softning"):
        fitter.fit(samples, **SIZE, method=method, softning=0.1)


def test_a_fit_that_memory_does_not_hold_is_refused(monkeypatch, glossy):
    def too_large(*_arguments, **_options):
        return np.ones(1 << 50)         # 9 petabytes

    monkeypatch.setitem(METHODS, "mba", too_large)
    with pytest.raises(ValueError, match="not enough memory for a fit of these levels"):
        fitter.fit(glossy)

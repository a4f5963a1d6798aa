"""What workers draw and count of two materials, against pictures and integrals of the fits themselves."""

import numpy as np
import pytest
from measured_brdf.addon.compare import curves
from measured_brdf.addon.core.storage.outcomes import EmbeddedFit
from measured_brdf.addon.work import tasks

import fitter
from fitter.imaging import pictures, plane_plot
from fitter.imaging.plane_plot import Plotted
from tests.addon.answers import answer_all


@pytest.fixture(scope="module")
def fits(glossy):
    dull = fitter.Samples(*glossy.directions, 0.3 / np.pi + 0.1 * glossy.values, glossy.channels, "dull")
    return [fitter.fit(samples, 3, 4, 80.0, method="mba") for samples in (glossy, dull)]


@pytest.fixture(scope="module")
def kept(extension, fits):
    return [EmbeddedFit(tasks.kept_bytes(fit), fit.name, "Rec.709") for fit in fits]


def test_a_split_sphere_has_both_fits_each_on_its_side(extension, kept, fits, monkeypatch):
    drawn = []
    monkeypatch.setattr(curves.icons, "draw_at_once", lambda key, draw: drawn.append((key, draw())) or 1)
    assert curves._split_sphere(*kept, 0.25)[0] == 0
    answer_all()
    assert curves._split_sphere(*kept, 0.25)[0] == curves._split_sphere(*kept, 0.5)[0] == 1
    (first, picture), (second, _) = drawn
    assert first != second
    for part, fit in ((slice(0, 64), fits[0]), (slice(66, 256), fits[1])):
        np.testing.assert_allclose(picture[:, part], pictures.lit_sphere(fit)[:, part], atol=1e-4)


def test_the_polar_plot_is_that_of_the_fits(kept, fits):
    two, _ = tasks.polar_plot([(each, ()) for each in kept], None, 0.6)
    expected, _ = plane_plot.polar_plot([Plotted(fit) for fit in fits], None, 0.6)
    np.testing.assert_allclose(two, expected, atol=0.02)
    assert np.abs(two - plane_plot.polar_plot([Plotted(fits[0])], None, 0.6)[0]).max() > 0.3


def test_the_albedo_is_integrated(kept, fits, random):
    n = 400_000
    theta, phi = np.arcsin(np.sqrt(random.random(n))), random.random(n) * 2 * np.pi     # cosine-weighted
    for each, fit in zip(kept, fits, strict=True):
        brute = np.pi * np.maximum(fit.evaluate(theta, phi, np.zeros(n), np.zeros(n)), 0).mean(axis=0)
        np.testing.assert_allclose(tasks.normal_albedo(each), brute, rtol=0.01)


def test_a_grey_fit_has_one_albedo_three_times(glossy):
    grey = fitter.Samples(*glossy.directions, glossy.values[:, :1], ("grey",), "grey")
    kept = EmbeddedFit(tasks.kept_bytes(fitter.fit(grey, 2, None, method="mba")), "grey", "Rec.709")
    albedo = tasks.normal_albedo(kept)
    assert albedo.shape == (3,)
    assert np.ptp(albedo) == 0 < albedo[0]


def test_a_damaged_fit_is_an_error(kept):
    with pytest.raises(ValueError, match="not a fit"):
        tasks.normal_albedo(kept[0]._replace(fit=b"void"))

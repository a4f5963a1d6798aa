"""Koenderink and Lafortune: analytic cases, and the errors of an independent implementation."""

from dataclasses import replace

import numpy as np
import pytest

import fitter
from fitter.report.baselines import koenderink, lafortune


def directions(random, count=600):
    theta_i, theta_o, phi_o = random.random((3, count)) * np.array([[1.5], [1.5], [np.pi]])
    return theta_i, np.zeros(count), theta_o, phi_o


def grey(samples, values):
    return replace(samples, values=values, channels=("grey",))


def rmse(model, samples):
    return fitter.error_metrics(samples.values, model.evaluate(*samples.directions)).rmse


def test_order_8_has_55_parameters_and_order_2_has_5():
    assert [len(koenderink.modes(order)) for order in (2, 8)] == [5, 55]


def test_zernike_radial_polynomials_are_orthogonal():
    nodes, weights = np.polynomial.legendre.leggauss(20)
    r, weights = (nodes + 1) / 2, weights / 2
    for l in range(9):
        degrees = range(l, 9, 2)
        values = np.array([koenderink.zernike_radial(n, l, r) for n in degrees])
        gram = (values * weights * r) @ values.T
        np.testing.assert_allclose(gram, np.diag([1 / (2 * n + 2) for n in degrees]), atol=1e-13)


def test_zernike_radial_polynomials_are_those_of_the_books():
    r = np.linspace(0, 1, 9)
    np.testing.assert_allclose(koenderink.zernike_radial(4, 0, r), 6 * r**4 - 6 * r**2 + 1, atol=1e-12)
    np.testing.assert_allclose(koenderink.zernike_radial(5, 1, r), 10 * r**5 - 12 * r**3 + 3 * r, atol=1e-12)


def test_koenderinks_functions_are_orthogonal_over_both_hemispheres():
    """By quadrature that is exact for them: r dr = sin(theta) dtheta / 2, and even steps of delta_phi."""
    nodes, weights = np.polynomial.legendre.leggauss(12)
    theta, weights = 2 * np.arcsin((nodes + 1) / 2 / np.sqrt(2)), weights * (nodes + 1) / 4
    phi = np.arange(20) * 2 * np.pi / 20
    theta_i, theta_o, delta_phi = (grid.ravel() for grid in np.meshgrid(theta, theta, phi, indexing="ij"))
    values = koenderink.design_matrix(8, theta_i, 0, theta_o, delta_phi)
    gram = (values * np.einsum("i,j,k->ijk", weights, weights, np.full(20, 1 / 20)).ravel()[:, None]).T @ values
    squares = [(4 if n == m else 2) / ((2 * n + 2) * (2 * m + 2)) * (0.5 if l else 1)
               for n, m, l in koenderink.modes(8)]
    np.testing.assert_allclose(gram, np.diag(squares), atol=1e-13)


def test_koenderink_holds_a_lambertian_in_its_first_parameter(random):
    samples = fitter.Samples(*directions(random), np.full((600, 1), 0.3 / np.pi))
    model = koenderink.fit(samples)
    assert model.coefficients[0, 0] == pytest.approx(0.15 / np.pi, abs=1e-9)
    np.testing.assert_allclose(model.coefficients[1:], 0, atol=1e-9)


def test_koenderink_is_reciprocal(curet):
    model = koenderink.fit(curet("leather"))
    np.testing.assert_allclose(model.evaluate(0.4, 0.1, 1.2, 2.0), model.evaluate(1.2, 2.0, 0.4, 0.1), rtol=1e-12)


@pytest.mark.parametrize("lobe", [(-1.03, 0.71, 67.0), (-0.9, 0.9, 12.0), (0.87, 0.8, 21.8)])
def test_one_lafortune_lobe_over_a_lambertian_is_recovered(random, lobe):
    truth = lafortune.Lafortune(np.array([0.3]), np.array(lobe)[None, :, None])
    at = directions(random)
    samples = fitter.Samples(*at, truth.evaluate(*at))
    found = lafortune.fit(samples, lobes=1)
    np.testing.assert_allclose(found.rho, truth.rho, atol=1e-6)
    np.testing.assert_allclose(found.lobes, truth.lobes, rtol=1e-6)


def test_lafortune_holds_a_lambertian(random):
    samples = fitter.Samples(*directions(random), np.full((600, 1), 0.3 / np.pi))
    np.testing.assert_allclose(lafortune.fit(samples).evaluate(*samples.directions), samples.values, atol=1e-9)


def test_lafortune_evaluates_the_formula_with_vectors(random):
    model = lafortune.Lafortune(np.array([0.3, 0.6]), random.random((3, 3, 2)) * [[[2], [2], [9]]] - [[[1], [1], [0]]])
    theta_i, phi_i, theta_o, phi_o = 0.7, 0.3, 1.1, 2.5
    i, o = (np.array([np.sin(t) * np.cos(p), np.sin(t) * np.sin(p), np.cos(t)])
            for t, p in ((theta_i, phi_i), (theta_o, phi_o)))
    expected = [model.rho[c] / np.pi + sum(max(xy * (i[0] * o[0] + i[1] * o[1]) + z * i[2] * o[2], 0) ** n
                                           for xy, z, n in model.lobes[:, :, c]) for c in range(2)]
    np.testing.assert_allclose(model.evaluate(theta_i, phi_i, theta_o, phi_o), expected, rtol=1e-12)


def test_a_lobe_that_explodes_away_from_the_samples_stays_a_number():
    model = lafortune.Lafortune(np.array([0.3]), np.array([-3.0, 3.0, 900.0])[None, :, None])
    assert model.evaluate(1.4, 0, 1.4, np.pi) == pytest.approx(1e30)


def test_counts_are_the_papers():
    assert lafortune.Lafortune(np.zeros(1), np.zeros((3, 3, 1))).coefficient_count == 10
    assert koenderink.Koenderink(8, np.zeros((55, 3))).nbytes == 4 * 55 * 3


# design.md, section 5; a baseline may be better, and must not be made worse than it is
@pytest.mark.parametrize(("sample", "koenderink_8", "lafortune_3"), [(1, 0.0112, 0.0191), (5, 0.0395, 0.0475),
                                                                     (15, 0.0361, 0.0809)])
def test_errors_on_curet_are_those_of_the_reference_or_better(curet, sample, koenderink_8, lafortune_3):
    samples = curet(sample)
    assert rmse(koenderink.fit(samples), samples) == pytest.approx(koenderink_8, rel=0.01)
    assert rmse(lafortune.fit(samples), samples) < 1.01 * lafortune_3


@pytest.mark.parametrize(("stem", "channel", "koenderink_8", "lafortune_3"),
                         [("krylon_blue_RGB", 2, 0.444, 0.0674), ("garnet_red_RGB", 0, 0.213, 0.0732)])
def test_errors_on_cornell_are_those_of_the_reference_or_better(cornell, stem, channel, koenderink_8, lafortune_3):
    samples = cornell(stem)
    samples = grey(samples, samples.values[:, [channel]])
    assert rmse(koenderink.fit(samples), samples) == pytest.approx(koenderink_8, rel=0.01)
    assert rmse(lafortune.fit(samples), samples) < 1.01 * lafortune_3


def test_three_lobes_fit_cayman_at_least_as_well_as_the_reference(data, cornell):
    from fitter.formats import astm
    from fitter.formats.text import read_bytes

    path = data / "cornell" / "cayman.astm"
    _, bands = astm.read_spectrum(path, read_bytes(path))
    samples = grey(cornell("cayman"), bands.mean(axis=1, keepdims=True))
    assert rmse(koenderink.fit(samples), samples) == pytest.approx(11.5, rel=0.01)
    assert rmse(lafortune.fit(samples), samples) < 0.103


def test_without_scipy_lafortune_says_what_is_missing(curet, monkeypatch):
    import sys

    monkeypatch.setitem(sys.modules, "scipy.optimize", None)
    with pytest.raises(ImportError, match="needs SciPy"):
        lafortune.fit(curet("felt"))

from dataclasses import replace

import numpy as np
import pytest
from scipy import interpolate

from fitter.coordinates.half_difference import project
from fitter.model.microfacet import Microfacet
from fitter.model.transform import LogRelative, bounded_log
from fitter.shader_constants import DAMPING_KNOTS

GREY = Microfacet(np.array([0.2, 0.4]), np.zeros((0, 2)), np.zeros(0), np.zeros(0), np.zeros(0))


@pytest.fixture
def directions(random):
    """Polar angles up to both ends, and where knots of a damping are."""
    theta_i, theta_o = np.pi / 2 * random.random((2, 300))
    theta_i[:3], theta_o[:3] = (0, np.pi / 2, 0), (np.pi / 2, np.pi / 2, 0)
    return theta_i, 0 * theta_i, theta_o, 2 * np.pi * random.random(300)


def test_field_and_reflectance_are_inverse(directions, random):
    values = 0.01 + random.random((300, 2))
    transform = LogRelative(GREY, 0.05, np.array([np.inf, np.inf]))
    np.testing.assert_allclose(transform.reflectance(transform.field(values, *directions), *directions), values,
                               rtol=1e-12)


def test_a_reflectance_is_the_field_of_the_formula_within_its_bounds(directions, random):
    field = 2 * random.standard_normal((300, 2))
    transform = LogRelative(GREY, 0.05, np.array([0.7, 0.9]), 0.0)
    raw = (GREY.kd + 0.05) * np.exp(field) - 0.05
    expected = []
    for one, other in raw:
        scale = (1 + max(one / 0.7, other / 0.9) ** 16) ** (-1 / 16)
        expected.append([max(scale * one, 0), max(scale * other, 0)])
    np.testing.assert_allclose(transform.reflectance(field, *directions), expected, rtol=1e-12)
    assert np.isfinite(transform.reflectance(np.full((300, 2), 1e4), *directions)).all()


def test_with_grey_negative_components_of_a_colour_have_a_logarithm(directions, random):
    prior = Microfacet(np.array([0.1, 0.2, 0.3]), np.zeros((0, 3)), np.zeros(0), np.zeros(0), np.zeros(0))
    values = np.outer(0.1 + random.random(300), [-0.2, 1.0, 1.3])
    transform = LogRelative(prior, 0.05, np.full(3, np.inf), desaturation=0.5)
    field = transform.field(values, *directions)
    mixed = 0.5 * values + 0.5 * values.mean(axis=1)[:, None]
    assert mixed.min() > 0
    np.testing.assert_allclose(field, np.log(mixed + 0.05) - np.log(prior.kd + 0.05), rtol=1e-12)
    np.testing.assert_allclose(transform.reflectance(field, *directions), values, rtol=1e-9)
    clipped = replace(transform, floor=0.0).reflectance(field, *directions)
    np.testing.assert_allclose(clipped, np.maximum(values, 0), rtol=1e-9)


def test_damping_multiplies_the_reflectance_by_a_factor_of_each_angle(directions, random):
    """SciPy's uniform cubic B-spline in the projected radius, even about the normal, the last point repeated."""
    damping = random.random((DAMPING_KNOTS, 2))
    plain = LogRelative(GREY, 0.05, np.array([9.0, 9.0]), 0.0)
    damped = LogRelative(GREY, 0.05, np.array([9.0, 9.0]), 0.0, damping)
    field = random.standard_normal((300, 2))
    around = np.concatenate([damping[-1:], damping[:0:-1], damping, damping[-1:]])
    knots = (np.arange(len(around) + 4) - 2 - DAMPING_KNOTS) / (DAMPING_KNOTS - 1)
    spline = interpolate.BSpline(knots, around, 3)
    factors = [spline(project(theta)) for theta in (directions[0], directions[2])]
    np.testing.assert_allclose(damped.reflectance(field, *directions),
                               plain.reflectance(field, *directions) * factors[0] * factors[1], rtol=1e-12)
    np.testing.assert_allclose(spline(-project(directions[0])), factors[0], rtol=1e-12)
    assert damped.nbytes == plain.nbytes + 4 * 2 * DAMPING_KNOTS


def test_the_logarithm_is_bounded_below_minus_the_offset():
    values = np.array([-1.0, -0.05, 0.0, 1.0])
    np.testing.assert_allclose(np.exp(bounded_log(values, 0.05)), [0.0025, 0.0025, 0.05, 1.05])

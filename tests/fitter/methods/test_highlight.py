"""A highlight between samples: no brighter and of no other colour than these say."""

from dataclasses import replace

import numpy as np
import pytest

import fitter
from fitter.arrays import select_directions
from fitter.coordinates.half_difference import HalfDifference
from fitter.methods import highlight
from fitter.model.microfacet import Microfacet, geometry
from fitter.model.transform import LogRelative
from fitter.samples import RGB, Samples
from support.truths import cornell

STANDARD = fitter.PRESETS["Standard"]
COAT = Microfacet(np.zeros(3), np.full((1, 3), 400.0), np.array([0.014]), np.array([2.5]), np.array([0.03]))


def mirror(degrees):
    theta = np.radians(degrees)
    return theta, 0 * theta, theta, np.full(len(theta), np.pi)


def coated_interference(*directions):
    """Flakes whose colour turns with the difference angle, more saturated than red, green and blue, under a coat that
    reflects all colours alike: the mirror direction is grey, and none of the colours two degrees from it is."""
    at = geometry(*directions)
    inside = np.sqrt(1 - (1 - at.cos_d ** 2) / 1.5 ** 2)
    phase = 4 * np.pi * 480.0 * inside[:, None] / np.array([610.0, 540.0, 460.0])
    film = 0.5 + 0.5 * np.cos(phase)
    film += 0.5 * (film - film.mean(axis=1, keepdims=True))
    flakes = 0.12 * np.exp(-at.tan2_h / 0.2 ** 2) + 0.004
    return flakes[:, None] * film + COAT.evaluate_geometry(at)


@pytest.fixture(scope="module")
def coated():
    """It, measured on Cornell's rings about the normal alone: a sample for each incidence is within two degrees of the
    mirror direction."""
    rings = np.arccos(1 - (np.arange(10) / 10) ** 2)
    theta_i, phi_i, theta_o, phi_o = select_directions(at := cornell(), np.isin(at[2], rings))
    random = np.random.default_rng(4)
    values = coated_interference(theta_i, phi_i, theta_o, phi_o)
    values = values * (1 + 0.005 * random.standard_normal(values.shape)) + 1e-4 * random.standard_normal(values.shape)
    assert (values < 0).any()
    return Samples(theta_i, phi_i, theta_o, phi_o, values, RGB, "coated interference", "synthetic")


def test_the_colour_of_a_highlight_between_samples_is_theirs(coated):
    """Without it the coat, which is grey, had .56 of its red at 20 degrees."""
    at = mirror(np.arange(12.5, 78, 2.5))
    found, wanted = fitter.fit(coated, **STANDARD).evaluate(*at), coated_interference(*at)
    hue = (found / found.mean(axis=1, keepdims=True)) / (wanted / wanted.mean(axis=1, keepdims=True))
    assert np.abs(np.log(hue)).max() < np.log(1.3)


def a_highlight(random):
    """Fields at random, one of them of a sample that failed, over a prior with a narrow lobe."""
    prior = Microfacet(np.full(3, 0.01), np.full((1, 3), 50.0), np.array([0.02]), np.array([2.0]), np.array([0.1]))
    theta = np.radians(np.linspace(6, 80, 60))
    directions = theta, 0 * theta, np.abs(theta + np.radians(random.normal(0, 0.5, 60))), np.full(60, np.pi)
    transform = LogRelative(prior, 0.01, np.full(3, np.inf))
    field = 0.3 * random.standard_normal((60, 3))
    field[7] = 6, 0, -6
    samples = Samples(*directions, transform.reflectance(field, *directions), RGB)
    known = np.where(np.arange(60) == 7, 10.0, 0.0)
    wrong = field + [3.0, 0.0, -3.0]            # another colour, as bright
    wrong += np.log(np.exp(field).sum(axis=1, keepdims=True) / np.exp(wrong).sum(axis=1, keepdims=True))
    found, _ = highlight.find(samples, transform, HalfDifference(0.03, 33.0), known, wrong)
    return found, samples, field


def apart(field):
    return field - field.mean(axis=1, keepdims=True)


def test_no_direction_has_a_colour_that_no_sample_has_and_each_its_brightness(random):
    found, _, field = a_highlight(random)
    at, continued = mirror(np.linspace(0, 89, 200)), random.standard_normal((200, 3))
    blended = found.blend(at, continued)
    good, share = apart(np.delete(field, 7, axis=0)), highlight.highlight_share(found.transform, at)[:, None]
    assert share.min() > 0.95                   # of the rest it is what the process says
    assert (apart(blended) <= share * good.max(axis=0) + (1 - share) * apart(continued) + 1e-9).all()
    assert (apart(blended) >= share * good.min(axis=0) + (1 - share) * apart(continued) - 1e-9).all()
    bright, wanted = (found.transform.reflectance(each, *at).sum(axis=1) for each in (blended, continued))
    np.testing.assert_allclose(bright, wanted, rtol=1e-9)


def test_at_its_own_direction_a_sample_keeps_its_colour_and_beside_the_highlight_nothing_changes(random):
    found, samples, field = a_highlight(random)
    share = highlight.highlight_share(found.transform, samples.directions)
    inside = (share > 0.9) & (np.arange(60) != 7)
    assert inside.sum() > 5
    np.testing.assert_allclose(found.blend(samples.directions, field)[inside], field[inside], atol=0.02)
    outside = np.radians([40.0, 30.0]), np.zeros(2), np.radians([10.0, 80.0]), np.array([np.pi, 0.0])
    continued = random.standard_normal((2, 3))
    np.testing.assert_array_equal(found.blend(outside, continued), continued)


def test_a_sample_that_is_left_out_does_not_know_itself(random):
    found, samples, field = a_highlight(random)
    number = int(np.argmax(highlight.highlight_share(found.transform, samples.directions) * (np.arange(60) != 7)))
    told = replace(found, colours=found.colours + 9 * (np.arange(60) == number)[:, None] * np.array([1.0, 0.0, -1.0]))
    one, other = (each.blend(samples.directions, field, left_out=True) for each in (found, told))
    np.testing.assert_array_equal(one[number], other[number])
    assert np.abs(one - other).max() > 0.1


def test_a_black_channel_does_not_darken_or_brighten_the_others(random):
    """Of a teal paint that has no red the red one, whatever it is, once moved green and blue to keep the mean."""
    found = a_highlight(random)[0]
    at, black = mirror(np.linspace(10, 70, 30)), np.array([-9.0, 0.0, 0.0])
    found = replace(found, colours=apart(np.tile([-6.0, 0.2, -0.2], (60, 1))))
    values = found.transform.reflectance(found.blend(at, np.tile(black, (30, 1))), *at)
    wanted = found.transform.reflectance(np.tile(black, (30, 1)), *at)
    np.testing.assert_allclose(values[:, 1:].sum(axis=1), wanted[:, 1:].sum(axis=1), rtol=0.01)


def test_one_bright_sample_does_not_decide_against_most_of_the_others(random):
    found, samples, field = a_highlight(random)
    share = highlight.highlight_share(found.transform, samples.directions)
    known = np.where(np.arange(60) == 7, 10.0, 0.0)
    number = int(np.argmax(share * (np.arange(60) != 7)))
    wrong = field + 0.5 * (found.blend(samples.directions, field, left_out=True) - field)   # nearer than the others are
    wrong[number] += [5.0, 0.0, -5.0]
    assert highlight.find(samples, found.transform, found.coordinates, known, wrong)[0] is None


def test_where_the_process_predicts_samples_better_the_colours_stay_its_own(random):
    found, samples, field = a_highlight(random)
    known = np.zeros(60)
    assert highlight.find(samples, found.transform, found.coordinates, known, field)[0] is None
    broad = replace(found.transform, prior=replace(found.transform.prior, alpha=np.array([0.06])))
    assert highlight.find(samples, broad, found.coordinates, known, field + [3.0, 0.0, -3.0])[0] is None

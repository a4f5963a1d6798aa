"""Scale, chrome balls and coverage."""

import re
from dataclasses import replace

import numpy as np
import pytest

import fitter
from benchmarks.harness.judging import directions
from benchmarks.photographs import difference
from fitter.photographs.ball import coverage
from fitter.photographs.ball.measuring import intensity_of_ball, reflected_light, scale_samples
from fitter.photographs.rig.lamps import MeasuredPlace, find_highlight, implausible_light, intensity_of_card
from fitter.quality.physics import direction_pairs
from support import ball_scene
from support.truths import Truth
from tests.fitter.photographs.test_ball import photographed

WHITE = Truth("white", "", lambda *directions: np.full((len(directions[0]), 3), 0.8 / np.pi))


def measured_under(phases, paint, noise=0.0, size=(60, 60)):
    """The samples of a ball under lamps at these phase angles."""
    return fitter.samples_from_ball([photographed(scene, paint, noise)
                                     for scene in ball_scene.scenes(phases, size=size)])


@pytest.fixture(scope="module")
def white():
    return measured_under((30, 80, 130), WHITE, 0.01)


def test_a_white_ball_tells_the_intensity_and_the_colour_of_the_lamp():
    scene = ball_scene.at_phase(50, 20, intensity=(3.0, 2.0, 1.0), size=(60, 60))
    shot = replace(photographed(scene, WHITE, noise=0.02), intensity=np.ones(3))
    np.testing.assert_allclose(intensity_of_ball(shot, 0.8), [3, 2, 1], rtol=3e-3)


def test_a_card_tells_it_too():
    """At 2 m, turned by 60 degrees from the lamp: a quarter of a half."""
    normal = (0, -np.sin(np.pi / 3), np.cos(np.pi / 3))
    radiance = np.full((7, 3), 0.18 / np.pi * 0.5 / 4) * [4, 2, 1]
    np.testing.assert_allclose(intensity_of_card(radiance, (0, 0, 0), normal, (0, 0, 2), 0.18, "card"), [4, 2, 1])
    with pytest.raises(fitter.DatasetError, match=r"^card: the card does not face the lamp"):
        intensity_of_card(radiance, (0, 0, 0), (0, 0, -1), (0, 0, 2), 0.18, "card")


def test_an_albedo_that_is_given_scales_the_samples_and_a_note_says_that_it_is_a_guess(white):
    np.testing.assert_allclose(reflected_light(white), 0.8, rtol=0.01)
    guessed, factor, _ = scale_samples(replace(white, values=white.values * 7), 0.4)
    assert factor == pytest.approx(1 / 14, rel=0.01)
    assert np.median(guessed.values) == pytest.approx(0.4 / np.pi, rel=0.01)
    assert guessed.notes[-1] == "The scale is a guess: an albedo of 0.4 was given"


@pytest.mark.parametrize(("times", "note"), [
    (1.2, ""), (1.5, r"More light leaves than arrives, 1\.\d+ of it at .* degrees: the lamp's intensity, a card's .*"),
    (1e-4, r"Only 8(\.\d)?e-05 of the light leaves, less than of the blackest paints: the lamp's intensity, .*")])
def test_a_lamp_that_makes_a_paint_reflect_more_than_arrives_or_nothing_is_told(white, times, note):
    assert re.fullmatch(note, "".join(implausible_light(reflected_light(replace(white, values=white.values * times)))))


@pytest.mark.parametrize("albedo", [0.8, 0.9])
def test_an_albedo_that_no_paint_of_this_kind_can_have_is_told_and_the_largest_that_it_can(albedo):
    """Of cos i + cos o the share of light from theta is cos theta + 2 / 3, which is 4 / 3 in the mean, and 1.62 at 17
    degrees, where no more than all may leave."""
    paint = Truth("", "", lambda *at: np.repeat((np.cos(at[0]) + np.cos(at[2]))[:, None] / 4 / np.pi, 3, axis=1))
    notes = scale_samples(measured_under((30, 80, 130), paint, 0.01), albedo)[0].notes
    told = re.search(r"More light leaves than arrives, 1\.\d+ of it at 17 degrees: an albedo of (.*) is the largest",
                     notes[-1])
    assert (told is None) == (albedo == 0.8)
    assert told is None or float(told[1]) == pytest.approx(4 / 3 / (np.sqrt(11 / 12) + 2 / 3), abs=0.03)


def test_a_chrome_ball_shows_where_the_lamp_is():
    chrome = Truth("chrome", "", ball_scene.truths._lobe(3000.0, 0.01, f0=0.9).evaluate)
    for phase, turn in ((25, 0), (70, 130), (110, 250)):
        scene = ball_scene.at_phase(phase, turn)
        picture = np.minimum(ball_scene.photograph(chrome, scene, points=3), 5.0)
        highlight = find_highlight(picture, scene.rays(), scene.camera, scene.centre, scene.radius)
        ball = MeasuredPlace(np.asarray(scene.centre), scene.radius)
        lamp, _ = highlight.lamp(ball, 1.2)
        angle = np.degrees(np.arccos(lamp @ scene.lamp / 1.2 ** 2))
        assert angle < 1.0
        with pytest.raises(fitter.DatasetError, match="more than its radius"):
            highlight.lamp(ball, 0.04)
        # a grain of dust on the other side of the ball
        dusty, (row, column) = picture.copy(), np.argwhere(picture.max(axis=2) == picture.max())[0]
        dusty[picture.shape[0] - row, picture.shape[1] - column] = 0.6 * picture.max()
        found = find_highlight(dusty, scene.rays(), scene.camera, scene.centre, scene.radius)
        np.testing.assert_allclose(found.direction, highlight.direction)
    both = picture + ball_scene.photograph(chrome, ball_scene.at_phase(30, 0))
    with pytest.raises(fitter.DatasetError, match="no highlight"):
        find_highlight(0 * picture, scene.rays(), scene.camera, scene.centre, scene.radius)
    with pytest.raises(fitter.DatasetError, match="more than one highlight"):
        find_highlight(np.minimum(both, 1e-3), scene.rays(), scene.camera, scene.centre, scene.radius)


@pytest.fixture(scope="module")
def two_lamps():
    return measured_under((40, 100), ball_scene.matte(), size=(50, 50))


def test_coverage_is_that_of_a_search_over_all_pairs(two_lamps, monkeypatch):
    pairs = direction_pairs(300)

    def vectors(theta, phi):
        return np.stack([np.sin(theta) * np.cos(phi), np.sin(theta) * np.sin(phi), np.cos(theta)], axis=1)

    def angles(first, second):
        return np.arccos(np.clip(first @ second.T, -1, 1))

    near = np.full(300, np.inf)
    for theta_i, theta_o in ((two_lamps.theta_i, two_lamps.theta_o), (two_lamps.theta_o, two_lamps.theta_i)):
        for sign in (1, -1):
            turn = sign * (two_lamps.phi_o - two_lamps.phi_i)
            off = np.maximum(angles(vectors(pairs[0], 0 * pairs[0]), vectors(theta_i, 0 * theta_i)),
                             angles(vectors(pairs[2], pairs[3]), vectors(theta_o, turn)))
            near = np.minimum(near, off.min(axis=1))
    for reach in np.radians((3, 5, 10)):
        monkeypatch.setattr(coverage, "REACH", reach)
        np.testing.assert_array_equal(coverage.are_covered(two_lamps, pairs), near < reach)


def test_the_next_lamp_is_where_the_only_gap_is_or_nowhere(two_lamps):
    one = measured_under((20, 40, 60, 80), ball_scene.matte(), size=(50, 50))
    covered = coverage.coverage(one)
    assert covered.difference == (pytest.approx(10, abs=2.5), pytest.approx(40, abs=2.5))
    assert [round(low / 10) for low, _ in covered.gaps] == [4]
    assert coverage.next_phase_angle(one, covered) == pytest.approx(115, abs=3)
    more = fitter.samples_from_ball([photographed(scene, ball_scene.matte()) for scene in ball_scene.scenes()])
    fewer = coverage.coverage(two_lamps)
    assert fewer.difference == (pytest.approx(20, abs=2.5), pytest.approx(50, abs=2.5))
    # from 50 to 75, from 20 to 50, and from 5 to 20 degrees
    assert [round(low / 10) for low, _ in fewer.gaps] == [2, 5, 0]
    assert coverage.coverage(more).share > 1.5 * fewer.share
    assert not any("next lamp" in line for line in coverage.advice(more))


def test_the_next_lamp_is_where_a_photograph_helps_most():
    """Beside a fit to each photograph that might be next: not where the gap is the widest."""
    lamps, paint, at = (40, 110), ball_scene.glossy(), directions()
    samples, truth = measured_under(lamps, paint, 0.01), paint.evaluate(*at)
    gaps = coverage.coverage(samples).gaps
    fits = [fitter.fit(measured_under((*lamps, sum(gap)), paint, 0.01), **fitter.PRESETS["Standard"]) for gap in gaps]
    errors = [difference(at[2], truth, fit.evaluate(*at)) for fit in fits]
    print(gaps, errors)
    best = gaps[int(np.argmin(errors))]
    assert best != gaps[0]
    assert coverage.advice(samples)[-1] == \
        f"Put the next lamp at {sum(best):.0f}° from the camera, seen from the ball"

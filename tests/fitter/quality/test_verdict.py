"""The verdict on a fit: errors as the eye sees them, grades, and words."""

import numpy as np
import pytest

import fitter
from fitter.methods import prior, regression_kriging
from fitter.quality import verdict
from fitter.quality.verdict import UNKNOWN, Verdict
from fitter.samples import Samples


def white(values, theta_o=0.3):
    """Samples of a white surface, of these values relative to it after the cosine of the outgoing angle."""
    values = np.asarray(values, dtype=float)
    angles = [np.full(len(values), angle) for angle in (0.2, 0.0, theta_o, 2.0)]
    return Samples(*angles, (values / np.pi / np.cos(theta_o))[:, None])


@pytest.mark.parametrize(("measured", "predicted", "expected"), [
    (0.125, 0.216, 10.0), (1.0, 1.0, 0.0), (0.0, 0.001, 10.0), (0.0, -0.5, 0.0), (27.0, 1000.0, 0.0),
    (1.0, 1000.0, 100.0)])
def test_steps_are_those_of_cube_roots_as_far_as_screens_show_them(measured, predicted, expected):
    samples = white([measured])
    assert verdict.lightness_error(samples, white([predicted]).values) == pytest.approx(expected)


def test_steps_do_not_depend_on_how_many_samples_agree_in_kind():
    assert verdict.lightness_error(white([0.125] * 7), white([0.216] * 7).values) == pytest.approx(10.0)
    assert verdict.lightness_error(white([0.125, 1]), white([0.216, 1]).values) == pytest.approx(10 / np.sqrt(2))


def test_a_step_is_about_that_of_lightness():
    """Of CIELAB, L* = 116 Y^(1/3) - 16."""
    grey, lighter = 0.18, 0.20
    expected = 116 * (np.cbrt(lighter) - np.cbrt(grey))
    assert verdict.lightness_error(white([grey]), white([lighter]).values) == pytest.approx(expected, rel=0.2)


def test_a_fit_of_what_it_can_hold_is_excellent_everywhere(random):
    theta_i, theta_o = 1.5 * np.sqrt(random.random((2, 300)))
    samples = Samples(theta_i, 0 * theta_i, theta_o, np.pi * random.random(300), np.full((300, 1), 0.1))
    made = prior.lambertian(np.array([[0.1]]))
    judged = verdict.judge(samples, made, verdict.unseen_error(samples, lambda part: prior.lambertian(part.values)))
    assert (judged.match, judged.between) == pytest.approx((0, 0), abs=1e-9)
    assert judged.farthest == pytest.approx(np.degrees(max(theta_i.max(), theta_o.max())))
    assert verdict.is_well(judged)


def test_what_a_fit_has_not_seen_is_predicted_not_repeated(random):
    """A model that knows its samples by heart, and is black elsewhere."""
    class ByHeart:
        def __init__(self, seen):
            self.seen = dict(zip(seen.theta_o.tolist(), seen.values[:, 0].tolist(), strict=True))

        def evaluate(self, theta_i, phi_i, theta_o, phi_o):
            return np.array([[self.seen.get(angle, 0.0)] for angle in np.asarray(theta_o).tolist()])

    theta_o = random.random(50)
    samples = Samples(0 * theta_o, 0 * theta_o, theta_o, 0 * theta_o, (1 / np.pi / np.cos(theta_o))[:, None])
    assert verdict.lightness_error(samples, ByHeart(samples).evaluate(*samples.directions)) == 0
    assert verdict.unseen_error(samples, ByHeart) == pytest.approx(100)


def test_one_sample_says_nothing_of_others():
    assert verdict.unseen_error(white([0.5]), lambda part: prior.lambertian(part.values)) == UNKNOWN


def test_no_fit_is_better_between_its_samples_than_at_them():
    judged = verdict.judge(white([0.125, 0.125]), prior.lambertian(np.array([[1.0]])), 0.1)
    assert judged.between == judged.match > 1


def test_kriging_predicts_a_sample_from_the_others_alone(glossy, random):
    some = fitter.Samples(*(angle[:150] for angle in glossy.directions), glossy.values[:150, :1])
    spoiled = some.values.copy()
    spoiled[7] *= 3
    plain, other = (regression_kriging.estimate(fitter.Samples(*some.directions, values))
                    for values in (some.values, spoiled))
    assert plain.left_out.shape == some.values.shape
    # its own value enters the prior alone, which all samples have
    assert abs(other.left_out[7] / plain.left_out[7] - 1) < 0.5
    assert verdict.lightness_error(some, plain.left_out) < 10


@pytest.mark.parametrize(("found", "text"), [
    (Verdict(1.0, 2.0, 90.0, 5.0), "Matches the measurements: excellent. Between measured angles: excellent"),
    (Verdict(1.01, 2.01, 90.0, 5.0), "Matches the measurements: good. Between measured angles: good"),
    (Verdict(3.01, 4.01, 90.0, 25.0), "Matches the measurements: fair. Between measured angles: fair"),
    (Verdict(6.01, 8.01, 70.4, 30.0), "Matches the measurements: poor. Between measured angles: poor, uncertain beyond "
                                      "70 degrees and in gaps of up to 30 degrees"),
    (Verdict(0.1, UNKNOWN, 70, 5.0), "Matches the measurements: excellent. Not tested between measured angles "
     "(Error at Unseen Angles does that), "
                                     "uncertain beyond 70 degrees"),
    (Verdict(0.1, UNKNOWN, 90.0, 5.0), "Matches the measurements: excellent. Not tested between measured angles "
     "(Error at Unseen Angles does that)")])
def test_the_verdict_in_words(found, text):
    assert verdict.sentence(found) == text


@pytest.mark.parametrize(("found", "text"), [
    (Verdict(1.0, 4.0, 70.0, 30.0), "Matches the measurements: excellent"),
    (Verdict(3.0, UNKNOWN, 70.0, 30.0), "Matches the measurements: good"),
    (Verdict(1.0, 4.01, 70.0, 5.0), "Matches the measurements: excellent. Between measured angles: fair")])
def test_the_line_of_a_verdict_says_what_lies_between_measured_angles_only_where_that_is_worse_than_good(found, text):
    assert verdict.line(found) == text


@pytest.mark.parametrize(("match", "between", "well"), [
    (0.5, 0.5, True), (3.0, 4.0, True), (0.5, UNKNOWN, True), (3.1, 3.1, False), (0.5, 4.1, False)])
def test_well_is_at_least_good(match, between, well):
    assert verdict.is_well(Verdict(match, between, 90.0, 5.0)) is well


def test_the_share_of_a_ball_that_is_a_guess_is_counted_on_a_ball(random):
    """Random points of a white ball's picture, and for each the light of an even sky that reaches it."""
    x, y = random.uniform(-1, 1, (2, 400_000))
    seen = x * x + y * y < 1
    view = np.arccos(np.sqrt(1 - (x * x + y * y)[seen]))
    light = np.arcsin(np.sqrt(random.random(len(view))))        # as the cosine weighs it
    beyond = (np.degrees(view) > 75) | (np.degrees(light) > 60)
    judged = Verdict(0.1, UNKNOWN, 75.0, 5.0, 60.0)
    assert verdict.extrapolated_share(judged) == pytest.approx(beyond.mean(), abs=0.004)
    assert verdict.line(judged).endswith("the rim is a guess (30 % of a ball)")
    assert not verdict.is_well(judged)
    assert verdict.is_well(Verdict(0.1, UNKNOWN, 85.0, 5.0, 85.0))


@pytest.mark.parametrize("value", [0.0, -0.1, 1e3])
def test_what_shows_nothing_is_not_judged(value):
    """Any fit matches values of which no screen shows that they differ."""
    samples = white(np.full(40, value))
    judged = verdict.judge(samples, prior.lambertian(samples.values), 0.1)
    assert (judged.match, judged.between) == (UNKNOWN, UNKNOWN)
    assert verdict.unseen_error(samples, lambda part: prior.lambertian(part.values)) == UNKNOWN
    assert not verdict.is_well(judged)
    assert verdict.match_message(judged).is_bad
    assert not any(grade in verdict.sentence(judged) + verdict.line(judged) for grade in verdict.GRADES)


def test_a_black_channel_is_judged_with_the_others():
    samples = white([0.125, 0.2])
    two = Samples(*samples.directions, np.column_stack([0 * samples.values, samples.values]), ("R", "G"))
    assert verdict.judge(two, prior.lambertian(np.array([[0.0, 1 / np.pi]]))).match > 10
    assert verdict.judge(two, prior.lambertian(two.values[:1])).match >= 0


def test_a_fold_that_shows_nothing_says_nothing_of_what_lies_between():
    values = np.full(50, -0.01)
    values[next(k for k in range(50) if k not in verdict.folds(50)[0])] = 0.5
    assert verdict.unseen_error(white(values), lambda part: prior.lambertian(part.values)) == UNKNOWN


@pytest.mark.parametrize("error", [UNKNOWN, float("nan")])
@pytest.mark.parametrize("limits", [verdict.MATCH_LIMITS, verdict.BETWEEN_LIMITS, verdict.PREDICTED_LIMITS])
def test_no_error_has_no_grade(error, limits):
    assert verdict.grade(error, limits) == verdict.UNJUDGED
    assert verdict.grade_message("It", error, limits).is_bad


@pytest.mark.parametrize(("missed", "text", "bad"), [
    (0.02, "predicted within 2.0%: excellent", False), (0.1, "10.0%: good", False), (0.2, "20.0%: fair", False),
    (3.83, "predicted within 383.0%: poor. So the photographs are not predicted", True),
    (float("nan"), "a.exr shows is dark: not judged", True)])
def test_a_predicted_photograph_in_words(missed, text, bad):
    found = verdict.prediction_message("a.exr", missed)
    assert text in found.words
    assert found.is_bad is bad

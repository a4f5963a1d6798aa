"""A judgement of a fit in plain words: how closely it matches the measurements, and what it is worth between them
(docs/fitting.md). `grade_message` makes words of all errors: of fits, of photographs that are predicted from others,
and of renders beside them.

Errors are in steps of lightness: 100 times the difference of the cube roots of cosine-weighted reflectance, white being
a Lambertian surface of albedo 1. Differences above twice the cube root of white do not count: no screen shows them.
"""

import math
from collections.abc import Callable
from typing import NamedTuple

import numpy as np

from ..arrays import FloatArray
from ..model import Reflectance
from ..samples import Samples, subset
from ..shader_constants import GRAZING
from .coverage import widest_gap
from .cross_validation import cube_root, folds, predict_part
from .describe import WIDE_GAP

GRADES = ("excellent", "good", "fair", "poor")
UNJUDGED = "not judged, for there is nothing to compare"    # the words where there is no error
MATCH_LIMITS = (1.0, 3.0, 6.0)         # steps at the samples: the most that is excellent, good, fair
BETWEEN_LIMITS = (2.0, 4.0, 8.0)       # steps at samples that the fit had not seen
PREDICTED_LIMITS = (0.05, 0.1, 0.2)     # of a photograph's root mean square: rightly described ones miss .01 to .1,
                        # balls with lamps 5 degrees beside their places .15, 10 degrees .3, flat samples .2 to .3 with
                        # 5 degrees and .5 to 4 with shuffled lamps (tests/fitter/photographs/test_judged.py)
LITTLE_GUESSED = 0.05       # of a ball, which is not worth a word
UNKNOWN = -1.0              # in the place of an error that has not been worked out
BRIGHTEST = 2.0            # cube root, relative to white
_NOT_PREDICTED = (". So the photographs are not predicted: lamps, places or the order of the files are wrong, or the "
                  "surface is another")
_UNTESTED = "Not tested between measured angles (Error at Unseen Angles does that)"


class Verdict(NamedTuple):
    """What is known of a fit's worth; errors in steps of lightness, `UNKNOWN` where nothing tells them, angles in
    degrees."""

    match: float        # the error at the samples,
    between: float      # and at samples that the fit had not seen
    farthest: float     # the largest measured polar angle
    hole: float         # the widest hole between samples (see `coverage`)
    # the largest measured polar angle of the other direction, light or viewer; 0 where it is not known
    least: float = 0.0


class Judgement(NamedTuple):
    """Words for an error, and whether nothing of the result is to be trusted."""

    words: str
    is_bad: bool


UNPREDICTED = Judgement("Whether the photographs are described rightly is not judged: two others are needed to predict "
                        "one", False)


def lightness_error(samples: Samples, predicted: FloatArray) -> float:
    """The root mean square error of predictions (n, channels), 1/sr, in delta L*, the steps of lightness."""
    measured, fitted = (_lightness(samples, values) for values in (samples.values, predicted))
    return 100 * float(np.sqrt(np.mean((fitted - measured) ** 2)))


def judge(samples: Samples, fit: Reflectance, unseen: float = UNKNOWN) -> Verdict:
    """Judge a fit by its samples, and by `lightness_error` at samples that it had not seen, if they are known.

    No fit counts as better between its samples than at them, and none is judged by samples that show nothing.
    """
    if _shows_something(samples):
        match = lightness_error(samples, fit.evaluate(*samples.directions))
        unseen = max(match, unseen) if unseen != UNKNOWN else UNKNOWN
    else:
        match = unseen = UNKNOWN
    least, farthest = sorted(float(np.degrees(theta.max())) for theta in (samples.theta_i, samples.theta_o))
    return Verdict(match, unseen, farthest, widest_gap(samples)[0], least)


def unseen_error(samples: Samples, fit: Callable[[Samples], Reflectance]) -> float:
    """`lightness_error` at one fold of the samples, of a fit to the others: a fifth of the work of cross-validation.

    `UNKNOWN` for a single sample, and where the fold shows nothing.
    """
    if len(samples) < 2:
        return UNKNOWN
    part = folds(len(samples))[0]
    held_out = subset(samples, part)
    return lightness_error(held_out, predict_part(samples, part, fit)) if _shows_something(held_out) else UNKNOWN


def _shows_something(samples: Samples) -> bool:
    """Whether a value is neither black nor brighter than counts: whatever is predicted of others has no error."""
    shown = _lightness(samples, samples.values)
    return bool(((shown > 0) & (shown < BRIGHTEST)).any())


def _lightness(samples: Samples, values: FloatArray) -> FloatArray:
    """Values (n, channels), 1/sr, of samples as cube roots relative to that of white, as far as they count."""
    return np.clip(np.cbrt(np.pi) * cube_root(samples.theta_o, values), 0, BRIGHTEST)


def grade(error: float, limits: tuple[float, ...]) -> str:
    """One of `GRADES`; `UNJUDGED` of what is no error: `UNKNOWN`, or not a number."""
    return GRADES[sum(error > limit for limit in limits)] if error >= 0 else UNJUDGED


def grade_message(what: str, error: float, limits: tuple[float, ...]) -> Judgement:
    """What has an error, in words with its grade. It is bad where the grade is the worst, or there is none."""
    found = grade(error, limits)
    return Judgement(f"{what}: {found}", found in (GRADES[-1], UNJUDGED))


def extrapolated_share(verdict: Verdict) -> float:
    """The extrapolated share of the picture of a white ball under an even sky: of its pairs of directions outside the
    measured domain; 0 where that is not known.

    Of the light that a Lambertian ball sends to a far camera, sin^2 t comes from where the viewer is up to t from the
    normal, and of that sin^2 t from light up to t.
    """
    if not verdict.least:
        return 0.0
    return 1 - math.prod(math.sin(math.radians(angle)) ** 2 for angle in (verdict.least, verdict.farthest))


def is_well(verdict: Verdict) -> bool:
    """Whether a fit matches its measurements at least well, is not known to be worse between them, and little of what
    one sees is beyond them."""
    return (0 <= verdict.match <= MATCH_LIMITS[1] and verdict.between <= BETWEEN_LIMITS[1]
            and extrapolated_share(verdict) <= LITTLE_GUESSED)


def sentence(verdict: Verdict) -> str:
    """The verdict in plain words."""
    between = _line_between_angles(verdict) if verdict.between >= 0 else _UNTESTED
    doubts = [] if verdict.farthest >= math.degrees(GRAZING) else [f"beyond {verdict.farthest:.0f} degrees"]
    if verdict.hole > WIDE_GAP:
        doubts.append(f"in gaps of up to {verdict.hole:.0f} degrees")
    uncertain = f", uncertain {' and '.join(doubts)}" if doubts else ""
    return f"{match_message(verdict).words}. {between}{uncertain}{_extrapolation_message(verdict)}"


def line(verdict: Verdict) -> str:
    """As `sentence`, in a line: of what lies between the measured angles, only that it is worse than good; and how much
    of what one sees lies beyond them."""
    between = f". {_line_between_angles(verdict)}" if verdict.between > BETWEEN_LIMITS[1] else ""
    return f"{match_message(verdict).words}{between}{_extrapolation_message(verdict)}"


def prediction_message(name: str, missed: float) -> Judgement:
    """How far a photograph of this name is from what the others say of it, as a share of its root mean square."""
    found = grade_message(f"Without {name}, that photograph is predicted within {missed:.1%}" if missed >= 0
                          else f"What {name} shows is dark", missed, PREDICTED_LIMITS)
    return found._replace(words=found.words + _NOT_PREDICTED * found.is_bad)


def match_message(verdict: Verdict) -> Judgement:
    """How closely a fit matches its measurements."""
    return grade_message("Matches the measurements", verdict.match, MATCH_LIMITS)


def _extrapolation_message(verdict: Verdict) -> str:
    share = extrapolated_share(verdict)
    measured = f"Measured to {verdict.least:.0f} and {verdict.farthest:.0f} degrees"
    return "" if share <= LITTLE_GUESSED else f". {measured}, the rim is a guess ({100 * share:.0f} % of a ball)"


def _line_between_angles(verdict: Verdict) -> str:
    return grade_message("Between measured angles", verdict.between, BETWEEN_LIMITS).words

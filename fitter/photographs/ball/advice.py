"""What photographs of a ball have measured, in words, and where to put the next lamp.

It should stand in the middle of a gap that the difference angles leave; where there are several, in that of which fits
know least: photographs with difference angles between two gaps are left out in turn, and the fits to the others
disagree where nobody measured. The measure is the variance of cube roots of cosine-weighted values over their mean
square.
"""

from collections.abc import Sequence

import numpy as np

from ... import progress
from ...arrays import FloatArray, select_directions
from ...methods import fit
from ...methods.presets import PRESETS
from ...quality.cross_validation import cube_root
from ...quality.physics import direction_pairs
from ...samples import Samples, subsample, subset
from ..rig.photograph import STEEPEST
from ..rig.report import MeasurementReport, judge_left_out
from .coverage import REACH, Coverage, coverage, difference_angle
from .measuring import BallMeasurement
from .photograph import BallPhotograph, measure_pixels
from .samples import gather_samples

_SAMPLES = 8000             # to which each part is fitted
_JUDGED = 1000              # samples by which a photograph is predicted
_PAIRS = 20_000             # of directions, of which those in a gap are looked at


def report_ball(measured: BallMeasurement) -> MeasurementReport:
    """What is to be said of photographs of a ball. They are judged by that with the middle phase angle, because nothing
    tells of angles beyond all others."""
    angles = [each.phase_angle for each in measured.photographs]
    middle = int(np.argsort(angles, kind="stable")[len(angles) // 2])
    judged = judge_left_out(measured.photographs, middle, _left_out_error)
    return MeasurementReport((*measured.samples.notes, judged.words, *advice(measured.samples)),
                             (*measured.doubts, *([judged.words] if judged.is_bad else [])))


def advice(samples: Samples) -> tuple[str, ...]:
    """What samples of a ball cover, and where to put the next lamp."""
    covered = coverage(samples)
    lines = ["Incidence {:.0f}° to {:.0f}°, exitance {:.0f}° to {:.0f}°, difference angle {:.0f}° to {:.0f}°".format(
        *covered.incidence, *covered.exitance, *covered.difference),
        f"{covered.share:.0%} of all pairs of directions are within {np.degrees(REACH):.0f}° of a measured one; the "
        f"rest is a guess"]
    lines += [f"No photograph has a difference angle between {low:.0f}° and {high:.0f}°" for low, high in covered.gaps]
    angle = next_phase_angle(samples, covered)
    if angle is not None:
        lines.append(f"Put the next lamp at {angle:.0f}° from the camera, seen from the ball")
    return tuple(lines)


def _left_out_error(others: Sequence[BallPhotograph], shot: BallPhotograph) -> float:
    """How far a photograph is from what a fit to others says of it. They are placed by `place_photographs`."""
    made = fit(subsample(gather_samples(others, shot.name, shot.name), _JUDGED), **PRESETS["Standard"])
    there = measure_pixels(shot)
    light = there.seen.irradiance[:, None]
    missed = light * (made.evaluate(*there.seen.directions) - there.reflectance)
    return float(np.linalg.norm(missed) / np.linalg.norm(light * there.reflectance))


def next_phase_angle(samples: Samples, covered: Coverage) -> float | None:
    """The phase angle of the photograph that would help most, degrees; None if none would."""
    if not covered.gaps:
        return None
    middles = [sum(gap) / 2 for gap in covered.gaps]
    angles = np.degrees(difference_angle(samples.directions))
    between = np.digitize(angles, sorted(middles))
    parts = np.unique(between)
    if len(middles) == 1 or len(parts) == 1:
        return 2 * middles[0]
    fits = [fit(subsample(subset(samples, between != part), _SAMPLES), **PRESETS["Standard"])
            for part in progress.each(parts.tolist())]
    pairs = direction_pairs(_PAIRS)
    at = np.degrees(difference_angle(pairs))

    def disagreement(gap: tuple[float, float]) -> float:
        inside = select_directions(pairs, (gap[0] < at) & (at < gap[1]) & (np.maximum(pairs[0], pairs[2]) < STEEPEST))
        found: FloatArray = np.stack([cube_root(inside[2], each.evaluate(*inside)) for each in fits])
        return float(found.var(axis=0).mean() / (found ** 2).mean())

    return 2 * middles[int(np.argmax([disagreement(gap) for gap in covered.gaps]))]

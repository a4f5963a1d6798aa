"""What is to be said of photographs that were measured. They are judged by one that is predicted from the others."""

from collections.abc import Callable, Sequence
from functools import partial
from typing import NamedTuple, TypeVar

import numpy as np

from ..arrays import FloatArray
from ..methods import fit
from ..methods.presets import PRESETS
from ..quality.physics import directional_albedo
from ..quality.verdict import UNPREDICTED, Judgement, prediction_message
from ..samples import subsample
from .ball.coverage import advice
from .ball.measuring import BallMeasurement, gather_samples
from .ball.photograph import BallPhotograph, measure_pixels
from .flat.advice import next_lamp
from .flat.judging import contradictions, turned_lamps
from .flat.maps import Maps, evenly, maps_from_flat, sample_frame, texel_points
from .flat.photograph import FlatPhotograph, observe
from .rig.lamps import SHARE_ANGLES, implausible_light
from .rig.photograph import Photograph

_FITTED = 1000              # samples of a ball by which a photograph is predicted
_UNSURE = 0.1               # standard deviation of a weight, of the largest, that is uncertain
_LEFT_OUT = 48              # texels along a side, of maps without one of the photographs
_WEIGHED = 4000             # texels whose reflectance is looked at
_JUDGED = 120               # texels by which photographs are judged
_Photograph = TypeVar("_Photograph", bound=Photograph)


class MeasurementReport(NamedTuple):
    """What is to be said of what was measured: lines, and those of them that say that something is wrong."""

    lines: tuple[str, ...]
    doubts: tuple[str, ...]


def _judge_left_out(photographs: Sequence[_Photograph], number: int,
                    error: Callable[[list[_Photograph], _Photograph], float]) -> Judgement:
    """How far one of photographs is from what the others say of it, of its root mean square, in words."""
    others, shot = [*photographs[:number], *photographs[number + 1:]], photographs[number]
    return UNPREDICTED if len(others) < 2 else prediction_message(shot.name, error(others, shot))


def report_ball(measured: BallMeasurement) -> MeasurementReport:
    """What is to be said of photographs of a ball. That with the middle phase angle is predicted: nothing tells of
    angles beyond all others."""
    angles = [each.phase_angle for each in measured.photographs]
    middle = int(np.argsort(angles, kind="stable")[len(angles) // 2])
    judged = _judge_left_out(measured.photographs, middle, _ball_error)
    return MeasurementReport((*measured.samples.notes, judged.words, *advice(measured.samples)),
                             (*measured.doubts, *([judged.words] if judged.is_bad else [])))


def _ball_error(others: Sequence[BallPhotograph], shot: BallPhotograph) -> float:
    """How far a photograph is from what a fit to others says of it. They are placed by `place_photographs`."""
    made = fit(subsample(gather_samples(others, shot.name, shot.name), _FITTED), **PRESETS["Standard"])
    there = measure_pixels(shot)
    light = there.seen.irradiance[:, None]
    missed = light * (made.evaluate(*there.seen.directions) - there.reflectance)
    return float(np.linalg.norm(missed) / np.linalg.norm(light * there.reflectance))


def report_sample(maps: Maps, photographs: Sequence[FlatPhotograph],
                  albedo: float | None = None) -> MeasurementReport:
    """What is to be said of maps. The albedo is that which was guessed, if it was."""
    height, width, count = maps.weights.shape
    most = float(maps.weights.max()) or 1.0
    unsure = (maps.deviation.max(axis=2) > _UNSURE * most).mean()
    told = _judge_left_out(photographs, len(photographs) // 2, partial(_sample_error, maps))
    lines = [f"{width} x {height} texels of {count} material{'s' * (count > 1)}, {len(photographs)} photographs, of "
             f"which {maps.used.mean():.1f} tell of a texel in the mean",
             f"{(maps.used == 0).mean():.1%} of the texels are in none; the weights of {unsure:.1%} are uncertain by "
             f"more than {_UNSURE:.0%} of the largest", told.words]
    bright = implausible_light(_reflected_light(maps), albedo)
    frame, points = sample_frame(maps.corners, photographs), texel_points(maps.corners, (height, width))
    some = points.reshape(height, width, 3)[evenly(height, width, _JUDGED)].reshape(-1, 3)
    size = np.linalg.norm(np.diff(maps.corners[:3], axis=0), axis=1)
    judged = (*contradictions(maps.fits, observe(photographs, some, frame[2]), frame,
                              [each.name for each in photographs]),
              *turned_lamps(maps.normals, frame, maps.used > 0, size))
    return MeasurementReport((*lines, *maps.notes, *bright, *judged, next_lamp(maps, photographs).advice),
                             (*bright, *[told.words] * told.is_bad, *judged))


def _reflected_light(maps: Maps) -> FloatArray:
    """The share of light from each of `SHARE_ANGLES` that a sample reflects, the median of its texels: (angles,
    channels)."""
    height, width, count = maps.weights.shape
    weights = maps.weights[evenly(height, width, _WEIGHED)].reshape(-1, count)
    shares = np.stack(np.broadcast_arrays(*(directional_albedo(fit, SHARE_ANGLES) for fit in maps.fits)))
    return np.asarray(np.median(np.einsum("nm,mac->nac", weights, shares), axis=0))


def _sample_error(maps: Maps, others: Sequence[FlatPhotograph], shot: FlatPhotograph) -> float:
    """How far a photograph is from what coarse maps of the same materials by others say of it; not a number where it
    shows nothing of the sample."""
    height, width = (min(each, _LEFT_OUT) for each in maps.weights.shape[:2])
    coarse = maps_from_flat(others, maps.corners, (height, width), maps.fits)
    seen = observe([shot], texel_points(maps.corners, (height, width)), sample_frame(maps.corners, [shot])[2])
    counts = seen.good[:, 0] & (coarse.used.ravel() > 0)
    there = seen.radiance[counts, 0]
    expected = coarse.radiance(shot.camera, shot.lamp, shot.intensity).reshape(len(counts), -1)[counts]
    size = float(np.linalg.norm(there))
    return float(np.linalg.norm(expected - there)) / size if size else float("nan")

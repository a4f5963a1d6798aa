"""Photographs of a ball as samples, also of a description."""

from collections.abc import Sequence
from dataclasses import replace
from typing import NamedTuple

import numpy as np

from ...arrays import ArrayLike, FloatArray, concatenate_directions
from ...errors import DatasetError
from ...methods.prior import candidates
from ...quality.physics import directional_albedo
from ...samples import LARGEST_VALUE, RGB, Samples, choice, subset
from ..description.capture_setup import CaptureSetup
from ..pictures import Light, Pictures, read_mask, same_pictures
from ..rig import lamps
from ..rig.ball_finding import brightest, find_ball
from ..rig.camera import CameraView, field_of_view, orientation
from ..rig.photograph import STEEPEST, check_alike
from .binning import bin_samples
from .photograph import BallPhotograph, measure_pixels
from .placing import check_outline, place_ball

MOST_SAMPLES = 200_000
RADIUS = 0.025              # m, of a ball whose size does not matter
_FITTED = 4000              # samples from which an albedo is found


class BallMeasurement(NamedTuple):
    """What photographs measure."""

    samples: Samples
    photographs: list[BallPhotograph]   # with the ball at its outline, and the intensity that belongs to the samples
    doubts: tuple[str, ...]             # those of the samples' notes which say that something is wrong


def measure_ball(setup: CaptureSetup) -> BallMeasurement:
    """The samples that the photographs of a description make.

    Raises DatasetError if the description or a file is wrong, with file and key; ImportError without OpenImageIO.
    """
    photographs, notes = read_photographs(setup)
    photographs = place_photographs(photographs, setup.title)
    samples = gather_samples(photographs, setup.title, str(setup.path))
    same = same_pictures([each.radiance for each in photographs], [each.name for each in photographs])
    samples = replace(samples, notes=(*samples.notes, *notes, *same))
    samples, factor, bright = scale_samples(samples, setup.scale.albedo)
    # what is a guess of the samples' scale is one of the lamp's intensity
    return BallMeasurement(samples, [replace(each, intensity=each.intensity / factor) for each in photographs],
                           (*same, *bright))


def read_photographs(setup: CaptureSetup) -> tuple[list[BallPhotograph], tuple[str, ...]]:
    """The photographs of a description as they are: nothing is checked of what they show; and notes of how they were
    read. Raises as `measure_ball`."""
    pictures = Pictures(setup)
    lights, scene = pictures.photographs, locate_ball(setup, pictures)
    rays, mask = scene.view.rays(), read_mask(setup.need_ball(), scene.view.size)

    def photograph(light: Light, lamp: FloatArray, intensity: FloatArray, name: str) -> BallPhotograph:
        known = light.known if mask is None else mask & light.known
        return BallPhotograph(light.radiance, rays, scene.view.position, *scene.what, lamp, intensity,
                              setup.lamp.radius, light.noise, known, name)

    intensity, note = lamps.lamp_intensity(scene, pictures, lights[0].radiance.shape[2])
    white = scene.setup.scale.ball
    if white is not None and white.lamp is not None:
        shown = photograph(pictures.lamp_light(white, "file"), white.lamp, intensity, white.file[0].name)
        intensity, note = intensity_of_ball(shown, white.albedo), ("Scale and colour by a ball of known albedo",)
    photographs = [photograph(light, lamp, intensity, shot.name)
                   for light, lamp, shot in zip(lights, scene.lamps, setup.photographs, strict=True)]
    return photographs, (*pictures.notes, *setup.notes, *scene.notes, *note)


def locate_ball(setup: CaptureSetup, pictures: Pictures) -> lamps.Scene:
    """The scene of a ball: by its outline in the photographs if nobody says where ball or camera is."""
    ball, size = setup.need_ball(), pictures.size
    centre, radius = np.zeros(3) if ball.place is None else ball.place, ball.radius or RADIUS
    position, notes = setup.camera.position, tuple[str, ...]()
    view = CameraView(np.zeros(3), orientation(setup.camera, centre), size,
                      field_of_view(setup.camera, pictures.infos))
    if setup.camera.is_far or isinstance(ball.centre, str):
        seen = brightest([light.radiance for light in pictures.photographs], read_mask(ball, size))
        outline = find_ball(seen, view.rays(), str(setup.path))
        if position is None or isinstance(position, str):
            position = centre - outline.centre(np.zeros(3), radius)
            notes = f"The camera is {np.linalg.norm(position - centre):.4g} m away by the ball's outline",
        else:
            centre = outline.centre(position, radius)
            notes = "The ball's centre by its outline: {:.4g}, {:.4g}, {:.4g} m".format(*centre),
    what = lamps.MeasuredPlace(centre, radius)
    view = view._replace(position=np.asarray(position))
    return lamps.place_scene(setup, view, what, lamps.find_lamps(setup, pictures, view, what), what, notes)


def intensity_of_ball(photograph: BallPhotograph, albedo: ArrayLike) -> FloatArray:
    """The intensity of a lamp, (channels,), in a photograph of a matte ball of known albedo, whatever that says of it;
    what each pixel shows is weighed by the light that falls there."""
    ball = measure_pixels(photograph)
    upright = (ball.seen.directions[0] < lamps.NEAR_NORMAL) & (ball.seen.directions[2] < lamps.NEAR_NORMAL)
    if not upright.any():
        raise DatasetError("the lamp lights the ball of known albedo at grazing angles only", photograph.name)
    weight = ball.seen.irradiance[upright] / ball.seen.irradiance[upright].sum()
    seen = photograph.intensity * (weight @ ball.reflectance[upright])
    return lamps.check_intensity(np.pi / np.asarray(albedo) * seen, "ball", photograph.name)


def reflected_light(samples: Samples) -> FloatArray:
    """The share of light from each of `SHARE_ANGLES` that is reflected, (angles, channels), by a model of lobes fitted
    to samples."""
    some = subset(samples, choice(len(samples), _FITTED))
    offset = float(np.median(np.abs(some.values)))
    return directional_albedo(candidates(some, some.values, max(offset, 1e-12))[-1], lamps.SHARE_ANGLES)


def scale_samples(samples: Samples, albedo: float | None) -> tuple[Samples, float, tuple[str, ...]]:
    """Samples of unknown scale with a given albedo, of even light from everywhere and in the mean over channels; what
    they were multiplied with, 1 where no albedo is given; and what is implausible of it, which is in the notes too."""
    light = reflected_light(samples)
    factor = 1.0 if albedo is None else albedo / float(light.mean())
    guess = () if albedo is None else (lamps.GUESSED.format(f"{albedo:g}"),)
    bright = lamps.implausible_light(light * factor, albedo)
    return replace(samples, values=samples.values * factor, notes=(*samples.notes, *guess, *bright)), factor, bright


def samples_from_ball(photographs: Sequence[BallPhotograph], name: str = "ball", source: str = "photographs of a ball",
                      ) -> Samples:
    """The reflectance that photographs of a ball measure, each under another lamp or from elsewhere: isotropic samples.

    The ball is moved to its outline, which the photographs show more precisely than it can be measured (`place_ball`).
    There are at most `MOST_SAMPLES`; where more pixels can be used, means over cells (`binning`). The deviation is that
    of the pixels' noise, and what small errors of the places do. The notes say how many pixels were used.

    Raises DatasetError if there are no photographs, they have several sizes or numbers of channels, one shows nothing
    of the ball that is lit, or its outline is not where the ball is said to be.
    """
    return gather_samples(place_photographs(photographs, source), name, source)


def place_photographs(photographs: Sequence[BallPhotograph], source: str) -> list[BallPhotograph]:
    """Photographs with the ball at its outline; raises as `samples_from_ball` does."""
    if not photographs:
        raise DatasetError("no photographs found, expected one or more", source)
    check_alike(photographs)
    for each in photographs:
        check_outline(each)
    return place_ball(photographs)


def gather_samples(photographs: Sequence[BallPhotograph], name: str, source: str) -> Samples:
    """The samples of photographs that are placed by `place_photographs`; raises as `samples_from_ball` does."""
    parts = [measure_pixels(each) for each in photographs]
    directions = concatenate_directions(part.seen.directions for part in parts)
    values = np.concatenate([part.reflectance for part in parts])
    deviation = np.concatenate([part.deviation for part in parts])
    if np.abs(values).max() > LARGEST_VALUE:
        raise DatasetError(f"a reflectance of {np.abs(values).max():g} / sr found: the intensity of the lamp is far "
                           f"too small", source)
    angles = " ".join(f"{np.degrees(each.phase_angle):.0f}" for each in photographs)
    left_out = sum(part.left_out for part in parts)
    without = f"; {left_out:,} saturated, dark or masked ones are left out" if left_out else ""
    notes = [f"{len(parts)} photograph{'s' * (len(parts) > 1)} of a ball, the lamp at {angles} degrees from the camera",
             f"{len(values):,} pixels to {np.degrees(STEEPEST):.0f} degrees from the normal{without}"]
    if len(values) > MOST_SAMPLES:
        directions, values, deviation = bin_samples(directions, values, deviation, MOST_SAMPLES)
        notes.append(f"Averaged to {len(values):,} samples")
    return Samples(*directions, values, RGB if values.shape[1] == 3 else ("grey",), name, source, tuple(notes),
                   deviation=deviation)

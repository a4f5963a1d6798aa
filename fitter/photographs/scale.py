"""The scale of photographs: a lamp's radiant intensity in the units of the pictures, or an albedo that is given.

A Lambertian of the albedo rho that faces a lamp at the distance d has the radiance rho I / (pi d^2). So a card or a
painted ball of known albedo tells I in each channel, and with it the colour of the lamp and of the camera.
"""

from dataclasses import replace

import numpy as np

from ..arrays import ArrayLike, FloatArray
from ..errors import DatasetError
from ..methods.prior import candidates
from ..quality.albedo import DARKEST_SURFACE
from ..quality.physics import directional_albedo
from ..samples import Samples, choice, subset
from .ball import BallPhotograph, measured

GUESSED = "The scale is a guess: an albedo of {} was given"
_UPRIGHT = np.radians(60)   # polar angle up to which real paints are Lambertian enough
_FITTED = 4000              # samples from which an albedo is found
ANGLES = np.arcsin(np.sqrt((np.arange(6) + 0.5) / 6))       # of equal shares of the light that leaves a Lambertian
_BRIGHTEST = 1.02           # share of the light that a white paint may seem to reflect, by its noise


def intensity_of_card(radiance: ArrayLike, point: ArrayLike, normal: ArrayLike, lamp: ArrayLike,
                      albedo: ArrayLike) -> FloatArray:
    """The intensity of a lamp of which a card shows the light.

    Raises DatasetError if the lamp does not light the card, or the card is dark.

    Parameters
    ----------
    radiance : (..., channels) array_like
        Of pixels that see the card.
    point, normal, lamp : (3,) array_like
        Where the card is, where it faces, and where the lamp is, metres.
    albedo : float, or (channels,) array_like
        Of the card: .18 for a grey one.

    Returns
    -------
    (channels,) float64
        W/sr in the units of the radiance.

    Examples
    --------
    >>> intensity_of_card([0.18 / np.pi], (0, 0, 0), (0, 0, 1), (0, 0, 2), 0.18).round(6).tolist()
    [4.0]
    """
    away = np.asarray(lamp, dtype=float) - np.asarray(point, dtype=float)
    distance = float(np.linalg.norm(away))
    length = float(np.linalg.norm(np.asarray(normal, dtype=float)))
    cosine = float(away @ np.asarray(normal, dtype=float)) / (distance * length) if distance * length else 0.0
    if cosine <= 0:
        raise DatasetError("the card does not face the lamp")
    values = np.asarray(radiance, dtype=float)
    return _bright(np.pi * values.reshape(-1, values.shape[-1]).mean(axis=0) * distance ** 2
                   / (_albedo(albedo) * cosine), "card")


def intensity_of_ball(photograph: BallPhotograph, albedo: ArrayLike) -> FloatArray:
    """The intensity of a lamp in a photograph of a matte ball of known albedo, whatever that says of it: (channels,).

    What each pixel shows is weighed by the light that falls there.
    """
    ball = measured(photograph)
    upright = (ball.seen.directions[0] < _UPRIGHT) & (ball.seen.directions[2] < _UPRIGHT)
    if not upright.any():
        raise DatasetError("the lamp lights the ball of known albedo at grazing angles only", photograph.name)
    weight = ball.seen.irradiance[upright] / ball.seen.irradiance[upright].sum()
    return _bright(np.pi / _albedo(albedo) * photograph.intensity * (weight @ ball.reflectance[upright]), "ball")


def _albedo(albedo: ArrayLike) -> FloatArray:
    albedo = np.asarray(albedo, dtype=float)
    if not ((albedo > 0) & (albedo <= 1)).all():
        raise DatasetError(f"an albedo of {albedo.tolist()} found, expected more than 0 and at most 1")
    return albedo


def _bright(intensity: FloatArray, what: str) -> FloatArray:
    if not (intensity > 0).all():
        raise DatasetError(f"the {what} of known albedo is dark in a channel")
    return np.asarray(intensity)


def reflected(samples: Samples) -> FloatArray:
    """The share of light from each of `ANGLES` that is reflected, (angles, channels), by a model of lobes fitted to
    samples."""
    some = subset(samples, choice(len(samples), _FITTED))
    offset = float(np.median(np.abs(some.values)))
    return directional_albedo(candidates(some, some.values, max(offset, 1e-12))[-1], ANGLES)


def scaled(samples: Samples, albedo: float) -> Samples:
    """Samples of unknown scale with a given albedo, of even light from everywhere and in the mean over channels; notes
    say that it is a guess, and what is implausible of it."""
    light = reflected(samples)
    factor = float(_albedo(albedo)) / float(light.mean())
    notes = (*samples.notes, GUESSED.format(f"{albedo:g}"), *implausible_light(light * factor, albedo))
    return replace(samples, values=samples.values * factor, notes=notes)


def implausible_light(light: FloatArray, albedo: float | None = None) -> tuple[str, ...]:
    """A note where more is `reflected` than arrives, (angles, channels), or next to nothing; `albedo` is the one that
    was given."""
    upright = ANGLES < _UPRIGHT         # what grazes is a guess
    most = light[upright].max()
    if DARKEST_SURFACE <= most <= _BRIGHTEST:
        return ()
    why = "the lamp's intensity, a card's albedo or a distance is wrong"
    if most < DARKEST_SURFACE:
        why = why if albedo is None else "was the albedo meant that was given?"
        return f"Only {most:.2g} of the light leaves, less than of the blackest paints: {why}",
    angle = np.degrees(ANGLES[upright][light[upright].max(axis=1).argmax()])
    why = why if albedo is None else f"an albedo of {albedo / most:.2g} is the largest that it can have"
    return f"More light leaves than arrives, {most:.3g} of it at {angle:.0f} degrees: {why}",

"""Samples of photographs of a ball."""

from collections.abc import Sequence

import numpy as np

from ...arrays import concatenate_directions
from ...errors import DatasetError
from ...samples import LARGEST_VALUE, RGB, Samples
from ..rig.photograph import STEEPEST, check_alike
from .binning import bin_samples
from .photograph import BallPhotograph, measure_pixels
from .placing import check_outline, place_ball

MOST_SAMPLES = 200_000


def samples_from_ball(photographs: Sequence[BallPhotograph], name: str = "ball", source: str = "photographs of a ball",
                      ) -> Samples:
    """The reflectance that photographs of a ball measure.

    Parameters
    ----------
    photographs : sequence of BallPhotograph
        Of one ball and size, each under another lamp or from elsewhere.
    name, source : str
        Of the samples.

    The ball is moved to its outline, which the photographs show more precisely than it can be measured (`place_ball`).

    Returns
    -------
    Samples
        Isotropic, at most `MOST_SAMPLES`; where more pixels can be used, means over cells (`binning`). The deviation is
        that of the pixels' noise, and what small errors of the places do. The notes say how many pixels were used.

    Raises
    ------
    DatasetError
        If there are no photographs, they have several sizes or numbers of channels, one shows nothing of the ball that
        is lit, or its outline is not where the ball is said to be.
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
    lamps = " ".join(f"{np.degrees(each.phase_angle):.0f}" for each in photographs)
    left_out = sum(part.left_out for part in parts)
    without = f"; {left_out:,} saturated, dark or masked ones are left out" if left_out else ""
    notes = [f"{len(parts)} photograph{'s' * (len(parts) > 1)} of a ball, the lamp at {lamps} degrees from the camera",
             f"{len(values):,} pixels to {np.degrees(STEEPEST):.0f} degrees from the normal{without}"]
    if len(values) > MOST_SAMPLES:
        directions, values, deviation = bin_samples(directions, values, deviation, MOST_SAMPLES)
        notes.append(f"Averaged to {len(values):,} samples")
    return Samples(*directions, values, RGB if values.shape[1] == 3 else ("grey",), name, source, tuple(notes),
                   deviation=deviation)

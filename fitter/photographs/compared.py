"""A photograph beside a render of the same: the part of the picture that ball or sample take, and what differs."""

from typing import NamedTuple

import numpy as np

from ..arrays import BoolArray, FloatArray, RealArray
from ..errors import DatasetError
from .ball import BallPhotograph
from .camera import pixel_angle
from .description.capture_setup import CaptureSetup
from .flat_setup import places_of
from .pictures import Pictures, mask_of, within
from .setup import photographed

_MARGIN = 1.12              # side of the part over the ball's diameter


class Part(NamedTuple):
    """A square part of a picture, in pixels from its left and its top; it may reach beyond the picture."""

    left: int
    top: int
    side: int


class Compared(NamedTuple):
    """The only photograph of a description, which is compared."""

    radiance: RealArray
    """(h, w, channels)."""
    counted: BoolArray
    """(h, w)."""
    part: Part


def photograph_of(setup: CaptureSetup) -> Compared:
    """The only photograph of a description, and the part of it that the ball or the sample takes."""
    if setup.ball is not None:
        shot, = photographed(setup)
        return Compared(shot.radiance, np.ones(shot.rays.shape[:2], bool) if shot.mask is None else shot.mask,
                        part_of_ball(shot))
    light = Pictures(setup.camera, setup.lamp).of_lamp(setup.photographs[0], "files")
    size = light.radiance.shape[0], light.radiance.shape[1]
    corners, mask = places_of(setup.need_sample(), size), mask_of(setup.need_sample(), size)
    side = int(np.ceil(_MARGIN * np.ptp(corners, axis=0).max()))
    left, top = np.round((corners.min(axis=0) + corners.max(axis=0) - side) / 2).astype(int).tolist()
    return Compared(light.radiance, light.known & within(corners, size) & (mask is None or mask), Part(left, top, side))


def part_of_ball(photograph: BallPhotograph) -> Part:
    """The part of a photograph that the ball takes. DatasetError if it is not in the picture."""
    axis, _, limb = photograph.sight
    rows, columns = np.nonzero(photograph.rays @ axis > np.cos(limb))
    if not len(rows):
        raise DatasetError("no pixel sees the ball: it is not in the picture", photograph.name)
    across = 2 * limb / pixel_angle(photograph.rays)
    side = int(np.ceil(_MARGIN * max(float(np.ptp(rows)) + 1, float(np.ptp(columns)) + 1, across)))
    middle = (rows.min() + rows.max() + 1) / 2, (columns.min() + columns.max() + 1) / 2
    return Part(round(middle[1] - side / 2), round(middle[0] - side / 2), side)


def reduced(picture: RealArray, part: Part, size: int) -> FloatArray:
    """A part of a picture in fewer pixels, each the mean of its area: (h, w, channels) to (size, size, channels).

    What is beyond the picture is 0.

    Examples
    --------
    >>> reduced(np.arange(4.0).reshape(2, 2, 1), Part(0, 0, 2), 1).ravel().tolist()
    [1.5]
    """
    rows, columns = (_shares(first, part.side, size, length)
                     for first, length in zip((part.top, part.left), picture.shape[:2], strict=True))
    return np.asarray(np.einsum("ij,jkc,lk->ilc", rows, picture, columns, optimize=True))


def _shares(first: int, side: int, size: int, length: int) -> FloatArray:
    """The share of each of `length` pixels in the mean of each of `size` pixels: (size, length)."""
    edges = first + side * np.arange(size + 1) / size
    place = np.arange(length)
    overlap = np.minimum(edges[1:, None], place + 1) - np.maximum(edges[:-1, None], place)
    return np.asarray(np.maximum(overlap, 0) * size / side)


def relative_difference(photograph: FloatArray, rendered: FloatArray, counted: BoolArray) -> float:
    """The mean difference of a render from a photograph, both (h, w, channels), as a share of the photograph's mean,
    over the pixels that count, (h, w).

    Examples
    --------
    >>> relative_difference(np.array([[[3.0], [1.0]]]), np.array([[[2.0], [1.0]]]), np.ones((1, 2), bool))
    0.25
    """
    total = float(photograph[counted].sum())
    return float(np.abs(rendered - photograph)[counted].sum()) / total if total > 0 else float("nan")

"""The scene of a description, and a photograph of it beside a render: the part of the picture that ball or sample take,
and what differs."""

from typing import NamedTuple

import numpy as np

from ..arrays import BoolArray, FloatArray, RealArray
from ..errors import DatasetError
from .ball.measuring import locate_ball, read_photographs
from .description.capture_setup import CaptureSetup
from .flat.reading import corner_places, locate_sample
from .pictures import Pictures, polygon_mask, read_mask
from .rig.camera import pixel_angle
from .rig.lamps import Scene

_MARGIN = 1.12              # side of the part over the ball's diameter


def resolve(setup: CaptureSetup) -> Scene:
    """The scene in which a description is measured.

    Raises DatasetError if the description or a file is wrong, with file and key; ImportError without OpenImageIO.
    """
    pictures = Pictures(setup)
    return locate_sample(setup, pictures) if setup.ball is None else locate_ball(setup, pictures)


class Part(NamedTuple):
    """A square part of a picture, in pixels from its left and its top; it may reach beyond the picture."""

    left: int
    top: int
    side: int


def read_compared(setup: CaptureSetup) -> tuple[RealArray, BoolArray, Part]:
    """The only photograph of a description, (h, w, channels), which of its pixels count, (h, w), and the part that the
    ball or the sample takes."""
    if setup.ball is not None:
        (shot,), _ = read_photographs(setup)
        axis, _, limb = shot.sight
        places = np.argwhere(shot.rays @ axis > np.cos(limb))[:, ::-1]
        if not len(places):
            raise DatasetError("no pixel sees the ball: it is not in the picture", shot.name)
        counted = np.ones(shot.rays.shape[:2], bool) if shot.mask is None else shot.mask
        return (shot.radiance, counted,
                _part_around(np.concatenate([places, places + 1]), 2 * limb / pixel_angle(shot.rays)))
    light = Pictures(setup).lamp_light(setup.photographs[0], "files")
    size = light.radiance.shape[0], light.radiance.shape[1]
    corners, mask = corner_places(setup.need_sample(), size), read_mask(setup.need_sample(), size)
    counted = light.known & polygon_mask(corners, size) & (mask is None or mask)
    return light.radiance, counted, _part_around(corners)


def _part_around(places: FloatArray, across: float = 0.0) -> Part:
    """The part, so many pixels wide or more, with a margin around places in a picture (n, 2)."""
    low, high = places.min(axis=0), places.max(axis=0)
    side = int(np.ceil(_MARGIN * max((high - low).max(), across)))
    left, top = np.round((low + high - side) / 2).astype(int).tolist()
    return Part(left, top, side)


def area_means(picture: RealArray, part: Part, size: int) -> FloatArray:
    """A part of a picture in fewer pixels, each the mean of its area: (h, w, channels) to (size, size, channels).

    What is beyond the picture is 0.

    Examples
    --------
    >>> area_means(np.arange(4.0).reshape(2, 2, 1), Part(0, 0, 2), 1).ravel().tolist()
    [1.5]
    """
    def overlaps(first: int, count: int) -> FloatArray:
        edges, place = first + part.side * np.arange(size + 1) / size, np.arange(count)
        overlap = np.minimum(edges[1:, None], place + 1) - np.maximum(edges[:-1, None], place)
        return np.asarray(np.maximum(overlap, 0) * size / part.side)

    return np.asarray(np.einsum("ij,jkc,lk->ilc", overlaps(part.top, picture.shape[0]), picture,
                                overlaps(part.left, picture.shape[1]), optimize=True))


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

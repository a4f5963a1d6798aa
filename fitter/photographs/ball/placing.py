"""Photographs with the ball where its outline is, if that is near where it is said to be.

Of a picture only the outline is judged. What is beside it, a stand, or a dim room, does not count; a mask may be that
of the ball itself.
"""

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from ...arrays import BoolArray, FloatArray
from ...errors import DatasetError
from ..rig import ball_finding as finding
from ..rig.ball_finding import Outline, Profile, angle_beyond, edge_profile, fit_cone, scatter
from ..rig.camera import pixel_angle
from ..rig.photograph import mean_of_neighbours
from .photograph import BallPhotograph, visible_pixels

MOVED = 2.0                 # pixels by which an outline may be off
_ENOUGH = 1 / 2             # of the outline, that must be seen to move a ball
_SHARP = 0.8                # least share of the brightness that is missing beyond an edge that places a ball
_WITHIN, _LIT = 3.0, 0.2    # where the cosine of incidence so many pixels within the outline is larger, it has an edge
_FITTING = 2 / 3            # share of its edges that must be where they are expected
_WHOLE = 0.3                # share of the pixels that should be lit, of which as many are bright where the ball is
_WRONG = "the ball's outline is not where it is said to be"
_OF_BALL = 0.5              # a mask with a smaller share of the pixels around an outline is that of the ball


def place_ball(photographs: Sequence[BallPhotograph]) -> list[BallPhotograph]:
    """Photographs with the ball where its outline is, seen from each place in all photographs of it together.

    A pixel is a degree of its normals or several, and a tape measure does not place a ball as well. Where less than
    half of the outline is seen, the ball stays where it was said to be.
    """
    moved = list(photographs)
    together: dict[tuple[object, ...], list[int]] = {}
    for number, each in enumerate(moved):
        place = (*each.camera.tolist(), *each.centre.tolist(), each.radius, each.rays.shape, each.rays.tobytes())
        together.setdefault(place, []).append(number)
    for numbers in together.values():
        first = moved[numbers[0]]
        axis, _, gamma = first.sight
        v = axis / np.cos(gamma)
        touching = np.concatenate([_touching(v, moved[number]) for number in numbers])
        v, arc, _ = fit_cone(touching, v, pixel_angle(first.rays))
        if arc >= _ENOUGH and np.linalg.norm(v) > 1:
            for number in numbers:
                moved[number] = replace(moved[number], centre=Outline.from_vector(v).centre(first.camera, first.radius))
    return moved


def _touching(v: FloatArray, photograph: BallPhotograph) -> FloatArray:
    """Rays through the clear edges near the outline v: (n, 3)."""
    profile, grey = _profile(v, photograph), photograph.radiance.mean(axis=2)
    level = finding.BALL_BRIGHTNESS * float(np.percentile(grey, 99.5))
    with np.errstate(invalid="ignore"):
        clear = ((profile.beyond < (1 - _SHARP) * profile.within) & (profile.within > level)
                 & (np.abs(profile.edge) < MOVED + 0.5))
    return np.asarray(profile.rays[clear])


def _profile(v: FloatArray, photograph: BallPhotograph) -> Profile:
    """The edges of the ball across the outline v, of pixels that count."""
    size, grey, mask = pixel_angle(photograph.rays), photograph.radiance.mean(axis=2), photograph.mask
    if mask is not None:
        off = angle_beyond(photograph.rays, v) / size
        around = (off > finding.WINDOW / 2) & (off < finding.WINDOW)
        if mask[around].mean() < _OF_BALL if around.any() else True:
            grey, mask = grey * mask, None          # beside the ball it is black
    return edge_profile(v, grey, photograph.rays, size, mask)


def check_outline(photograph: BallPhotograph) -> None:
    """Raise DatasetError if much of the outline in a photograph, where the ball is lit there, is more than `MOVED`
    pixels from where the ball is said to be."""
    axis, _, gamma = photograph.sight
    size, grey = pixel_angle(photograph.rays), photograph.radiance.mean(axis=2)
    v = axis / np.cos(gamma)
    off = angle_beyond(photograph.rays, v) / size
    if not (off < 0).any():
        raise DatasetError("no pixel sees the ball: it is not in the picture", photograph.name)
    residual = grey - mean_of_neighbours(photograph.radiance).mean(axis=2)
    around = residual[off > finding.WINDOW]
    noise = scatter(around) / np.sqrt(1.25) if len(around) else 0.0
    is_bright = grey > max(finding.BALL_BRIGHTNESS * float(np.percentile(grey, 99.5)), finding.ABOVE_NOISE * noise)
    if photograph.mask is not None:
        is_bright &= photograph.mask
    of_ball = np.count_nonzero(is_bright & (off < 0))
    if is_bright.any() and not of_ball:
        raise DatasetError(f"{_WRONG}: nothing is bright there", photograph.name)
    # where only a highlight is bright, the edge of a dark and glossy ball need not be seen
    is_whole = of_ball > _WHOLE * len(visible_pixels(photograph).pixel)
    profile = _profile(v, photograph)
    with np.errstate(invalid="ignore"):
        brighter = np.fmax(profile.within, profile.beyond)
        is_seen = brighter > finding.ABOVE_NOISE * noise
        judged = _is_lit(photograph, profile, gamma / size) & (is_whole | is_seen)
        # a dark ball before a room has an edge as well
        clear = is_seen & (np.abs(profile.within - profile.beyond) > finding.CLEAR * brighter)
        fits = clear & (np.abs(profile.edge) < MOVED)
    wanted, fitting = np.count_nonzero(judged), np.count_nonzero(judged & fits)
    if fitting < _FITTING * wanted:
        others = np.abs(profile.edge[judged & clear & ~fits])
        distance = f"; {len(others)} have it {np.median(others):.1f} pixels off, in the median" * bool(len(others))
        raise DatasetError(
            f"{_WRONG}: of {wanted} of its {len(judged)} sectors, those that are lit, {fitting} have their edge within "
            f"{MOVED:g} pixels, expected two thirds{distance}, and {np.count_nonzero(judged & ~clear)} show none. The "
            f"camera or the ball was moved, or their places are wrong", photograph.name)


def _is_lit(photograph: BallPhotograph, profile: Profile, pixels: float) -> BoolArray:
    """In which sectors of its outline a ball, of a radius of so many pixels, is lit: (sectors,)."""
    axis = photograph.sight[0]
    # the normal a few pixels within the outline, and the light that falls there
    rise = np.sqrt(min(2 * _WITHIN / pixels, 1.0))
    normal = np.sqrt(1 - rise ** 2) * profile.around - rise * axis
    away = photograph.lamp - photograph.centre - photograph.radius * normal
    return np.asarray(np.sum(normal * away, axis=1) > _LIT * np.linalg.norm(away, axis=1))

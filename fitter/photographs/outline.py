"""The outline of a ball in a picture, and where the ball is.

Rays r that touch a ball make the same angle with the direction a to its centre, in whatever part of the picture: ::

    r . a = cos gamma,    sin gamma = radius / distance

With v = a / cos gamma that is r . v = 1, which is linear: least squares find v from rays through the outline, where a
circle in the picture would be wrong, for perspective makes it an ellipse. Which parts of a region's edge are the ball's
outline, and not where its lit part ends, is decided by random samples (M. A. Fischler, R. C. Bolles: Random Sample
Consensus, Communications of the ACM 24(6), 1981).
"""

from collections.abc import Sequence
from dataclasses import replace
from typing import NamedTuple

import numpy as np

from ..arrays import ArrayLike, BoolArray, FloatArray, IntArray
from ..errors import DatasetError
from .ball import TO_SIGMA, BallPhotograph, seen
from .camera import pixel_angle

MOVED = 2.0                 # pixels by which an outline may be off
_BRIGHT = 0.02              # a ball is brighter than this share of what its picture has beside the background
_ABOVE_NOISE = 6.0          # standard deviations of the background by which a ball is brighter than it
_LEAST = 5.0                # pixels, of a ball's radius
_SECOND = 0.1               # of the largest region's pixels, that another must have to count as a ball
_COARSE = 200               # pixels along a picture in which regions are told apart
_TRIALS, _NEAR = 400, 1.5   # random samples; pixels from an outline within which an edge is a part of it
_FITS = 0.5                 # pixels, of the median edge from the outline of a ball
_LEAST_ARC, _ENOUGH = 1 / 3, 1 / 2      # of the outline, that must be seen to find a ball, and to move it
_ROUNDS = 3                 # of least squares without what is far off
_SHARP = 0.8                # least share of the brightness that is missing beyond an edge that places a ball
_SECTORS = 48               # of the outline
_WINDOW = 6.0               # pixels to both sides of the outline where its edge is looked for
_STEP = 0.1                 # pixels between the places that are tried
_WITHIN, _LIT = 3.0, 0.2    # where the cosine of incidence so many pixels within the outline is larger, it has an edge
_FITTING = 2 / 3            # share of its edges that must be where they are expected
_STRAY = 0.2                # share of the bright pixels that may be beside the ball
_WHOLE = 0.3                # share of the pixels that should be lit, of which as many are bright where the ball is
_CLEAR = 0.5                # least share of the brightness within that is missing beyond an edge


class Outline(NamedTuple):
    """A cone of rays that touch a ball."""

    axis: FloatArray
    """Toward its centre, a unit vector: (3,)."""
    half_angle: float
    """gamma, radians."""
    residual: float
    """The median distance of the edges that were found from it, pixels."""

    def centre(self, camera: ArrayLike, radius: float) -> FloatArray:
        """The centre of the ball of this radius, (3,), seen from a camera at (3,)."""
        return np.asarray(camera + self.axis * radius / np.sin(self.half_angle))


def find_ball(picture: FloatArray, rays: FloatArray, name: str = "picture") -> Outline:
    """Find the one ball in a picture, bright before a dark background.

    Raises DatasetError if there is no ball, a part of it is beyond the frame, or there are two bright things.

    Parameters
    ----------
    picture : (height, width, channels) float64
        Linear; of several photographs from one place the brightest of each pixel (`brightest`).
    rays : (height, width, 3) float64
        Directions through the pixels' centres.
    name : str
        For messages.
    """
    grey, size = picture.mean(axis=2), pixel_angle(rays)
    border = np.concatenate([grey[0], grey[-1], grey[:, 0], grey[:, -1]])
    dark = float(np.median(border))
    noise = _scatter(border)
    level = dark + max(_BRIGHT * (float(np.percentile(grey, 99.5)) - dark), _ABOVE_NOISE * noise)
    region = _only_region(grey > level, name)
    edges = _edges(region, grey, level, rays)
    if len(edges) < 2 * _LEAST:
        raise DatasetError("no ball found: nothing in the picture is large and brighter than its border", name)
    v = _consensus(edges, size)
    for _ in range(3):
        v, residual, arc = _refined(v, grey, rays, size, name)
    outline = Outline(v / np.linalg.norm(v), float(np.arccos(1 / np.linalg.norm(v))), residual)
    if outline.half_angle < _LEAST * size or residual > _FITS or arc < _LEAST_ARC:
        raise DatasetError(f"no outline of a ball found: what is bright is no disc (edges {residual:.1f} pixels off, "
                           f"over {arc:.0%} of its outline)", name)
    return outline


def brightest(pictures: list[FloatArray]) -> FloatArray:
    """Of several pictures of one size, each relative to its own brightness, the largest of each pixel."""
    return np.asarray(np.max([each / max(float(np.percentile(each, 99.5)), np.finfo(float).tiny) for each in pictures],
                             axis=0))


def _only_region(bright: BoolArray, name: str) -> BoolArray:
    """The largest connected region, (h, w) bool, if it is the only large one and within the frame."""
    step = -(-max(bright.shape) // _COARSE)
    height, width = (-(-side // step) for side in bright.shape)
    blocks = np.zeros((height * step, width * step), bool)
    blocks[:bright.shape[0], :bright.shape[1]] = bright
    # a block is bright where at least half of it is, so that noise joins nothing
    coarse = blocks.reshape(height, step, width, step).mean(axis=(1, 3)) >= 0.5
    regions = sorted(_regions(coarse), key=lambda region: int(region.sum()), reverse=True)
    if not regions or np.count_nonzero(regions[0]) * step ** 2 < _LEAST ** 2:
        raise DatasetError("no ball found: nothing in the picture is large and brighter than its border", name)
    largest = regions[0]
    if largest[0].any() or largest[-1].any() or largest[:, 0].any() or largest[:, -1].any():
        raise DatasetError("the ball is cut by the frame, or the background is as bright as it is", name)
    second = max((np.count_nonzero(each) for each in regions[1:]), default=0)
    if second > _SECOND * np.count_nonzero(largest):
        raise DatasetError("two bright things found, expected one ball: mask the other one", name)
    whole = np.kron(_grown(largest), np.ones((step, step), bool))
    return np.asarray(whole[:bright.shape[0], :bright.shape[1]] & bright)


def _regions(bright: BoolArray) -> list[BoolArray]:
    """The connected regions of a small picture, those of a single pixel left out."""
    left, regions = bright.copy(), []
    while left.any():
        region = np.zeros_like(left)
        region[np.unravel_index(int(np.argmax(left)), left.shape)] = True
        count = 0
        while (now := int(np.count_nonzero(region))) != count:
            count, region = now, _grown(region) & left
        left &= ~region
        if count > 1:
            regions.append(region)
    return regions


def _grown(region: BoolArray) -> BoolArray:
    """A region and the pixels that touch it."""
    padded = np.pad(region, 1)
    return np.asarray(padded[1:-1, 1:-1] | padded[:-2, 1:-1] | padded[2:, 1:-1] | padded[1:-1, :-2] | padded[1:-1, 2:])


def _edges(region: BoolArray, grey: FloatArray, level: float, rays: FloatArray) -> FloatArray:
    """Rays where the brightness crosses a level, at the edge of a region: (n, 3)."""
    crossings = []
    for axis in (0, 1):
        here = [slice(None)] * 2
        there = [slice(None)] * 2
        here[axis], there[axis] = slice(None, -1), slice(1, None)
        first, second = tuple(here), tuple(there)
        crossed = region[first] != region[second]
        a, b = grey[first][crossed], grey[second][crossed]
        share = np.clip((level - a) / np.where(a == b, 1, b - a), 0, 1)[:, None]
        crossings.append((1 - share) * rays[first][crossed] + share * rays[second][crossed])
    edges = np.concatenate(crossings)
    return np.asarray(edges / np.linalg.norm(edges, axis=1, keepdims=True))


def _consensus(edges: FloatArray, size: float) -> FloatArray:
    """The v that most edges agree with."""
    random = np.random.default_rng(0)
    best: FloatArray = np.zeros(3)
    most = -1
    for _ in range(_TRIALS):
        three = edges[random.choice(len(edges), 3, replace=False)]
        if abs(np.linalg.det(three)) < 1e-12:
            continue
        v = np.asarray(np.linalg.solve(three, np.ones(3)), dtype=float)
        if np.linalg.norm(v) <= 1:
            continue
        agree = int(np.count_nonzero(np.abs(_off(edges, v)) < _NEAR * size))
        if agree > most:
            best, most = v, agree
    near = edges[np.abs(_off(edges, best)) < _NEAR * size] if most > 0 else edges
    return np.asarray(np.linalg.lstsq(near, np.ones(len(near)), rcond=None)[0])


def _off(rays: FloatArray, v: FloatArray) -> FloatArray:
    """The angles of rays beyond the cone of v, radians: (..., 3) to (...)."""
    length = float(np.linalg.norm(v))
    axis = v / length
    return np.asarray(np.arctan2(np.linalg.norm(np.cross(rays, axis), axis=-1), rays @ axis)
                      - np.arccos(min(1 / length, 1.0)))


class _Profile(NamedTuple):
    """The edges across an outline, in sectors of it: (sectors,) each, NaN where there are too few pixels."""

    within: FloatArray
    """The brightness just within the edge."""
    beyond: FloatArray
    """And beyond it."""
    edge: FloatArray
    """Where it is, pixels from the outline outward."""
    around: FloatArray
    """The directions of the sectors' middles, about the axis: (sectors, 3)."""


def _profile(v: FloatArray, grey: FloatArray, rays: FloatArray, size: float, mask: BoolArray | None = None) -> _Profile:
    axis = v / np.linalg.norm(v)
    gamma = float(np.arccos(min(1 / float(np.linalg.norm(v)), 1.0)))
    window = int(max(min(_WINDOW, gamma / size / 2), 3))
    off = _off(rays, v) / size
    near = np.abs(off) < window if mask is None else (np.abs(off) < window) & mask
    x, y = _across(axis)
    sector = _sector(rays[near], x, y)
    off, value = off[near], grey[near]
    edge = _steps(sector, off, value, np.arange(1 - window, window - 1 + _STEP / 2, _STEP))
    within, beyond = (_means(sector[part], value[part]) for part in (
        (off > edge[sector] - 3) & (off < edge[sector] - 0.5), off > edge[sector] + 1))
    turn = 2 * np.pi * (np.arange(_SECTORS) + 0.5) / _SECTORS
    return _Profile(within, beyond, edge, np.cos(turn)[:, None] * x + np.sin(turn)[:, None] * y)


def _steps(sector: IntArray, off: FloatArray, value: FloatArray, places: FloatArray) -> FloatArray:
    """Of some places, in each sector that of the edge by least squares: (sectors,).

    Within an edge at e the brightness is taken to be a + b sqrt(e - off), as a sphere's is, whose normal turns with the
    root of the distance from its outline; and beyond it that of the outermost pixels.
    """
    value = value - np.nan_to_num(_means(sector[off > places[-1]], value[off > places[-1]]))[sector]
    best, edge = np.full(_SECTORS, -np.inf), np.zeros(_SECTORS)
    for place in places:
        inner, outer = np.maximum(place - off + 0.5, 0), np.maximum(place - off - 0.5, 0)
        columns = inner - outer, (inner ** 1.5 - outer ** 1.5) * 2 / 3       # means over the width of a pixel
        aa, ab, bb, av, bv = (np.bincount(sector, part, _SECTORS) for part in (
            columns[0] ** 2, columns[0] * columns[1], columns[1] ** 2, columns[0] * value, columns[1] * value))
        with np.errstate(invalid="ignore", divide="ignore"):
            explained = np.nan_to_num((bb * av ** 2 - 2 * ab * av * bv + aa * bv ** 2) / (aa * bb - ab ** 2))
        better = explained > best
        best, edge = np.where(better, explained, best), np.where(better, place, edge)
    return edge


def _means(sector: IntArray, value: FloatArray) -> FloatArray:
    """The mean of the values in each sector; NaN where there is none."""
    with np.errstate(invalid="ignore"):
        return np.asarray(np.bincount(sector, value, _SECTORS) / np.bincount(sector, minlength=_SECTORS))


def _refined(v: FloatArray, grey: FloatArray, rays: FloatArray, size: float, name: str,
             ) -> tuple[FloatArray, float, float]:
    """A better v from profiles across the outline; the residual, pixels; and the share of it that has an edge."""
    if np.linalg.norm(v) <= 1 or not np.isfinite(v).all():
        raise DatasetError("no outline of a ball found: what is bright is no disc", name)
    profile = _profile(v, grey, rays, size)
    with np.errstate(invalid="ignore"):
        clear = (profile.beyond < (1 - _CLEAR) * profile.within) & (np.abs(profile.edge) < _WINDOW / 2)
    if np.count_nonzero(clear) < _LEAST_ARC * _SECTORS:
        return v, np.inf, np.count_nonzero(clear) / _SECTORS
    axis, gamma = v / np.linalg.norm(v), np.arccos(1 / np.linalg.norm(v))
    at = gamma + profile.edge[clear] * size
    touching = np.cos(at)[:, None] * axis + np.sin(at)[:, None] * profile.around[clear]
    v, arc = _robust(touching, v, size)
    return v, float(np.median(np.abs(_off(touching, v)))) / size, arc


def placed(photographs: Sequence[BallPhotograph]) -> list[BallPhotograph]:
    """Photographs with the ball where its outline is, seen from each place in all photographs of it together.

    A pixel is a degree of its normals, or several where they graze, and a tape measure or a hand in the window does not
    place a ball as well as its outline does. Where less than half of that is seen, the ball stays where it was said to
    be; where it is farther away than `MOVED` pixels, `check_outline` has refused it.
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
        v, arc = _robust(touching, v, pixel_angle(first.rays))
        if arc >= _ENOUGH and np.linalg.norm(v) > 1:
            outline = Outline(v / np.linalg.norm(v), float(np.arccos(1 / np.linalg.norm(v))), 0.0)
            for number in numbers:
                moved[number] = replace(moved[number], centre=outline.centre(first.camera, first.radius))
    return moved


def _touching(v: FloatArray, photograph: BallPhotograph) -> FloatArray:
    """Rays through the clear edges near the outline v: (n, 3)."""
    size, grey = pixel_angle(photograph.rays), photograph.radiance.mean(axis=2)
    profile = _profile(v, grey, photograph.rays, size, photograph.mask)
    level = _BRIGHT * float(np.percentile(grey, 99.5))
    with np.errstate(invalid="ignore"):
        clear = ((profile.beyond < (1 - _SHARP) * profile.within) & (profile.within > level)
                 & (np.abs(profile.edge) < MOVED + 0.5))
    axis, at = v / np.linalg.norm(v), np.arccos(1 / np.linalg.norm(v)) + profile.edge[clear] * size
    return np.asarray(np.cos(at)[:, None] * axis + np.sin(at)[:, None] * profile.around[clear])


def _robust(touching: FloatArray, v: FloatArray, size: float) -> tuple[FloatArray, float]:
    """The v of rays of which some are wrong, and the share of the circle about it where rays agree; v without any."""
    if len(touching) < 3:
        return v, 0.0
    near = touching
    for _ in range(_ROUNDS):
        if len(near) < 3:
            return v, 0.0
        v = np.asarray(np.linalg.lstsq(near, np.ones(len(near)), rcond=None)[0], dtype=float)
        off = np.abs(_off(touching, v)) / size
        near = touching[off <= 3 * TO_SIGMA * np.median(off) + 0.05]       # not a stand, nor where the lit part ends
    x, y = _across(v / np.linalg.norm(v))
    return np.asarray(v), len(np.unique(_sector(near, x, y))) / _SECTORS


def _sector(rays: FloatArray, x: FloatArray, y: FloatArray) -> IntArray:
    """In which sector of an outline rays are, (n, 3) to (n,); x and y are at right angles to its axis."""
    return ((np.arctan2(rays @ y, rays @ x) / (2 * np.pi) + 1) * _SECTORS).astype(int) % _SECTORS


def _across(axis: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Two unit vectors at right angles to an axis and to each other."""
    x = np.cross(axis, np.eye(3)[int(np.argmin(np.abs(axis)))])
    x /= np.linalg.norm(x)
    return x, np.cross(axis, x)


def check_outline(photograph: BallPhotograph) -> None:
    """Compare the outline in a photograph, where the ball is lit there, with where the ball is said to be.

    Raises DatasetError if much of it is more than `MOVED` pixels off, or much that is bright is beside it.
    """
    axis, _, gamma = photograph.sight
    size, grey = pixel_angle(photograph.rays), photograph.radiance.mean(axis=2)
    v = axis / np.cos(gamma)
    off = _off(photograph.rays, v) / size
    if not (off < 0).any():
        raise DatasetError("no pixel sees the ball: it is not in the picture", photograph.name)
    profile = _profile(v, grey, photograph.rays, size, photograph.mask)
    dark = grey[off > _WINDOW]
    noise = _scatter(dark) if len(dark) else 0.0
    counted = np.ones(grey.shape, bool) if photograph.mask is None else photograph.mask
    bright = counted & (grey > max(_BRIGHT * float(np.percentile(grey, 99.5)), _ABOVE_NOISE * noise))
    # the normal a few pixels within the outline, and the light that falls there
    rise = np.sqrt(min(2 * _WITHIN * size / gamma, 1.0))
    normal = np.sqrt(1 - rise ** 2) * profile.around - rise * axis
    away = photograph.lamp - photograph.centre - photograph.radius * normal
    lit = np.sum(normal * away, axis=1) > _LIT * np.linalg.norm(away, axis=1)
    # where only a highlight is bright, the edge of a dark and glossy ball need not be seen
    is_whole = np.count_nonzero(bright) > _WHOLE * len(seen(photograph).pixel)
    with np.errstate(invalid="ignore"):
        judged = lit & (is_whole | (np.fmax(profile.within, profile.beyond) > _ABOVE_NOISE * noise))
        fits = ((profile.within > _ABOVE_NOISE * noise) & (profile.beyond < (1 - _CLEAR) * profile.within)
                & (np.abs(profile.edge) < MOVED))
    stray = np.count_nonzero(bright & (off > MOVED)) > _STRAY * np.count_nonzero(bright)
    if stray or np.count_nonzero(judged & fits) < _FITTING * np.count_nonzero(judged):
        raise DatasetError("the ball's outline is not where it is said to be: the camera or the ball was moved, their "
                           "places are wrong, or the background is bright", photograph.name)


def _scatter(values: FloatArray) -> float:
    """The standard deviation of values (n,) of which some are far off."""
    return TO_SIGMA * float(np.median(np.abs(values - np.median(values))))

"""A ball in a picture, found by its outline, whatever else is there.

Rays r that touch a ball make the same angle gamma with the direction a to its centre, where perspective makes its
picture an ellipse. With v = a / cos gamma that is r . v = 1, which is linear: least squares find v. What is brighter
than a level is regions, of which one is the ball, with or without its stand or the room: so several levels are tried.
Which edges are the ball's outline, and not where its lit part ends, is decided by random samples (M. A. Fischler, R. C.
Bolles: Random Sample Consensus, Communications of the ACM 24(6), 1981).
"""

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from ...arrays import ArrayLike, BoolArray, FloatArray, IntArray, RealArray
from ...errors import DatasetError
from .camera import pixel_angle
from .photograph import TO_SIGMA

SECTORS = 48                # of the outline
WINDOW = 6.0                # pixels to both sides of the outline where its edge is looked for
BALL_BRIGHTNESS = 0.02               # a ball is brighter than this share of what its picture has beside the background
ABOVE_NOISE = 6.0           # standard deviations of the background by which a ball is brighter than it
CLEAR = 0.5                 # least share of the brightness within that is missing beyond an edge
_EDGE_STEP = 0.1                 # pixels between the places that are tried
_ROUNDS = 3                 # of least squares without what is far off

_LEVELS = BALL_BRIGHTNESS, 0.05, 0.1, 0.2, 0.4       # of a ball above its background, of the brightest of the picture
_LEAST = 5.0                # pixels, of a ball's radius
_SECOND = 0.1               # of the largest region's pixels, that another must have to count as a ball
_COARSE = 200               # pixels along a picture in which regions are told apart
_TRIALS, _NEAR = 400, 1.5   # random samples; pixels from an outline within which an edge is a part of it
_FITS = 0.5                 # pixels, of the median edge from the outline of a ball
_LEAST_ARC = 1 / 3          # of the outline, that must be seen
_BRIGHTEST = 99.5           # percentile of a picture that stands for its largest value
_NO_DISC = "no outline of a ball found: what is bright is no disc"


class Outline(NamedTuple):
    """A cone of rays that touch a ball."""

    axis: FloatArray    # toward its centre, a unit vector: (3,)
    half_angle: float   # gamma, radians
    residual: float     # the median distance of the edges that were found from it, pixels

    @classmethod
    def from_vector(cls, v: FloatArray, residual: float = 0.0) -> "Outline":
        """That of v."""
        return cls(v / np.linalg.norm(v), float(np.arccos(1 / np.linalg.norm(v))), residual)

    def centre(self, camera: ArrayLike, radius: float) -> FloatArray:
        """The centre of the ball of this radius, (3,), seen from a camera at (3,)."""
        return np.asarray(camera + self.axis * radius / np.sin(self.half_angle))


class Profile(NamedTuple):
    """The edges across an outline, in sectors of it: (sectors,) each, NaN where there are too few pixels."""

    within: FloatArray  # the brightness just within the edge
    beyond: FloatArray  # and beyond it
    edge: FloatArray    # where it is, pixels from the outline outward
    around: FloatArray  # the directions of the sectors' middles, about the axis: (sectors, 3)
    rays: FloatArray    # through the edges: (sectors, 3)


def find_ball(picture: FloatArray, rays: FloatArray, name: str = "picture") -> Outline:
    """Find the one ball in a picture, brighter than its background, most of it.

    The picture, (height, width, channels), is linear; of several photographs from one place it is the `brightest` of
    each pixel. Raises DatasetError if there is no ball, a part of it is beyond the frame, or there are two.
    """
    grey = picture.mean(axis=2)
    border = _border(grey)
    dark, noise = float(np.median(border)), scatter(border)
    above = float(np.percentile(grey, _BRIGHTEST)) - dark
    first: DatasetError | None = None
    for share in _LEVELS:
        try:
            return _outline_above(dark + max(share * above, ABOVE_NOISE * noise), grey, rays, name)
        except DatasetError as error:
            first = first or error
    raise first or DatasetError(_NO_DISC, name)


def _border(grey: FloatArray) -> FloatArray:
    return np.concatenate([grey[0], grey[-1], grey[:, 0], grey[:, -1]])


def _outline_above(level: float, grey: FloatArray, rays: FloatArray, name: str) -> Outline:
    """The outline of the only ball among the regions that are brighter than a level."""
    found: list[Outline] = []
    others: list[BoolArray] = []
    first: DatasetError | None = None
    regions = _large_regions(grey > level, name)
    for region in regions:
        try:
            found.append(_fit_outline(region, level, grey, rays, name))
        except DatasetError as error:
            others.append(region)
            first = first or error
    # what reaches the border is the room, or a stand
    whole = [each for each in others if not _border(each.astype(float)).any()]
    beside = [each for ball in found for each in whole      # which are no part of it
              if (rays[each] @ ball.axis < np.cos(ball.half_angle)).mean() > 0.5]
    if len(found) > 1 or beside or (not found and len(regions) > 1):
        raise DatasetError("two bright things found, expected one ball: mask the other one", name)
    if first is not None and not found:
        raise first
    return found[0]


def _fit_outline(region: BoolArray, level: float, grey: FloatArray, rays: FloatArray, name: str) -> Outline:
    """The outline of a region, if it is that of a ball."""
    size = pixel_angle(rays)
    v = _consensus(_edges(region, grey, level, rays), size, name)
    for _ in range(3):
        v, arc, residual = _refine(v, grey, rays, size, name)
    outline = Outline.from_vector(v, residual)
    is_cut = bool((_border(angle_beyond(rays, v)) < 0).any())
    if is_cut or (residual > _FITS and _border(region.astype(float)).any()):
        raise DatasetError("the ball is cut by the frame, or the background is as bright as it is", name)
    return _check_outline(outline, arc, size, name)


def disc_outline(mask: BoolArray, rays: FloatArray, name: str = "mask") -> Outline:
    """The outline of the ball that a mask, (h, w), is; raises DatasetError if it is no disc."""
    size, edges = pixel_angle(rays), _edges(mask, mask.astype(float), 0.5, rays)
    v, arc, residual = fit_cone(edges, _consensus(edges, size, name), size)
    return _check_outline(Outline.from_vector(v, residual), arc, size, name)


def _check_outline(outline: Outline, arc: float, size: float, name: str) -> Outline:
    """An outline, if it is that of a ball, and so much of it has an edge."""
    if outline.half_angle < _LEAST * size or outline.residual > _FITS or arc < _LEAST_ARC:
        raise DatasetError(f"{_NO_DISC} (edges {outline.residual:.1f} pixels off, over {arc:.0%} of its outline)", name)
    return outline


def brightest(pictures: Sequence[RealArray], mask: BoolArray | None = None) -> FloatArray:
    """Of several pictures of one size, each relative to its own brightness, the largest of each pixel; 0 where a mask,
    (h, w), is False."""
    largest = np.max([each / max(float(np.percentile(each, _BRIGHTEST)), np.finfo(float).tiny) for each in pictures],
                     axis=0)
    return np.asarray(largest if mask is None else largest * mask[..., None])


def _large_regions(bright: BoolArray, name: str) -> list[BoolArray]:
    """The largest connected region, (h, w) bool, and those that are not much smaller."""
    step = -(-max(bright.shape) // _COARSE)
    height, width = (-(-side // step) for side in bright.shape)
    blocks = np.zeros((height * step, width * step), bool)
    blocks[:bright.shape[0], :bright.shape[1]] = bright
    # a block is bright where at least half of it is, so that noise joins nothing
    coarse = blocks.reshape(height, step, width, step).mean(axis=(1, 3)) >= 0.5
    found = sorted((each for each in regions(coarse) if np.count_nonzero(each) > 1), key=np.count_nonzero, reverse=True)
    if not found or np.count_nonzero(found[0]) * step ** 2 < _LEAST ** 2:
        raise DatasetError("no ball found: nothing in the picture is large and brighter than its border", name)
    large = [each for each in found if np.count_nonzero(each) > _SECOND * np.count_nonzero(found[0])]
    whole = [np.kron(_grow(each), np.ones((step, step), bool))[:bright.shape[0], :bright.shape[1]] for each in large]
    return [np.asarray(each & bright) for each in whole]


def regions(bright: BoolArray) -> list[BoolArray]:
    """The connected regions of a small picture."""
    left, found = bright.copy(), []
    while left.any():
        region = np.zeros_like(left)
        region[np.unravel_index(int(np.argmax(left)), left.shape)] = True
        count = 0
        while (now := int(np.count_nonzero(region))) != count:
            count, region = now, _grow(region) & left
        left &= ~region
        found.append(region)
    return found


def _grow(region: BoolArray) -> BoolArray:
    padded = np.pad(region, 1)
    return np.asarray(padded[1:-1, 1:-1] | padded[:-2, 1:-1] | padded[2:, 1:-1] | padded[1:-1, :-2] | padded[1:-1, 2:])


def _edges(region: BoolArray, grey: FloatArray, level: float, rays: FloatArray) -> FloatArray:
    """Rays where the brightness crosses a level, at the edge of a region: (n, 3)."""
    crossings = []
    for first, second in ((np.s_[:-1], np.s_[1:]), (np.s_[:, :-1], np.s_[:, 1:])):
        crossed = region[first] != region[second]
        a, b = grey[first][crossed], grey[second][crossed]
        share = np.clip((level - a) / np.where(a == b, 1, b - a), 0, 1)[:, None]
        crossings.append((1 - share) * rays[first][crossed] + share * rays[second][crossed])
    edges = np.concatenate(crossings)
    return np.asarray(edges / np.linalg.norm(edges, axis=1, keepdims=True))


def _consensus(edges: FloatArray, size: float, name: str) -> FloatArray:
    """The v that most edges agree with."""
    if len(edges) < 2 * _LEAST:
        raise DatasetError(_NO_DISC, name)
    random, best, most = np.random.default_rng(0), np.zeros(3), -1
    for _ in range(_TRIALS):
        three = edges[random.choice(len(edges), 3, replace=False)]
        if abs(np.linalg.det(three)) < 1e-12:
            continue
        v = np.asarray(np.linalg.solve(three, np.ones(3)), dtype=float)
        if np.linalg.norm(v) <= 1:
            continue
        agree = int(np.count_nonzero(np.abs(angle_beyond(edges, v)) < _NEAR * size))
        if agree > most:
            best, most = v, agree
    near = edges[np.abs(angle_beyond(edges, best)) < _NEAR * size] if most > 0 else edges
    return np.asarray(np.linalg.lstsq(near, np.ones(len(near)), rcond=None)[0])


def _refine(v: FloatArray, grey: FloatArray, rays: FloatArray, size: float, name: str,
             ) -> tuple[FloatArray, float, float]:
    """A better v from profiles across the outline, the share of it that has an edge, and the residual, pixels."""
    if np.linalg.norm(v) <= 1 or not np.isfinite(v).all():
        raise DatasetError(_NO_DISC, name)
    profile = edge_profile(v, grey, rays, size)
    with np.errstate(invalid="ignore"):
        clear = (profile.beyond < (1 - CLEAR) * profile.within) & (np.abs(profile.edge) < WINDOW / 2)
    if np.count_nonzero(clear) < _LEAST_ARC * SECTORS:
        return v, np.count_nonzero(clear) / SECTORS, np.inf
    return fit_cone(profile.rays[clear], v, size)


def angle_beyond(rays: FloatArray, v: FloatArray) -> FloatArray:
    """The angles of rays beyond the cone of v, radians: (..., 3) to (...)."""
    length = float(np.linalg.norm(v))
    axis = v / length
    return np.asarray(np.arctan2(np.linalg.norm(np.cross(rays, axis), axis=-1), rays @ axis)
                      - np.arccos(min(1 / length, 1.0)))


def edge_profile(v: FloatArray, grey: FloatArray, rays: FloatArray, size: float, mask: BoolArray | None = None,
               ) -> Profile:
    """The edges across the outline v of a picture, (h, w); `size` is the angle of a pixel, radians."""
    axis = v / np.linalg.norm(v)
    gamma = float(np.arccos(min(1 / float(np.linalg.norm(v)), 1.0)))
    window = int(max(min(WINDOW, gamma / size / 2), 3))
    off = angle_beyond(rays, v) / size
    near = np.abs(off) < window if mask is None else (np.abs(off) < window) & mask
    x, y = _perpendicular_axes(axis)
    sector = _sector(rays[near], x, y)
    off, value = off[near], grey[near]
    edge = _steps(sector, off, value, np.arange(1 - window, window - 1 + _EDGE_STEP / 2, _EDGE_STEP))
    within, beyond = (_means(sector[part], value[part]) for part in (
        (off > edge[sector] - 3) & (off < edge[sector] - 0.5), off > edge[sector] + 1))
    turn = 2 * np.pi * (np.arange(SECTORS) + 0.5) / SECTORS
    around = np.cos(turn)[:, None] * x + np.sin(turn)[:, None] * y
    angle = (gamma + edge * size)[:, None]
    return Profile(within, beyond, edge, around, np.cos(angle) * axis + np.sin(angle) * around)


def _steps(sector: IntArray, off: FloatArray, value: FloatArray, places: FloatArray) -> FloatArray:
    """Of some places, in each sector that of the edge by least squares: (sectors,).

    Within an edge at e the brightness is taken to be a + b sqrt(e - off), as a sphere's is, whose normal turns with the
    root of the distance from its outline; and beyond it that of the outermost pixels.
    """
    value = value - np.nan_to_num(_means(sector[off > places[-1]], value[off > places[-1]]))[sector]
    best, edge = np.full(SECTORS, -np.inf), np.zeros(SECTORS)
    for place in places:
        inner, outer = np.maximum(place - off + 0.5, 0), np.maximum(place - off - 0.5, 0)
        columns = inner - outer, (inner ** 1.5 - outer ** 1.5) * 2 / 3       # means over the width of a pixel
        aa, ab, bb, av, bv = (np.bincount(sector, part, SECTORS) for part in (
            columns[0] ** 2, columns[0] * columns[1], columns[1] ** 2, columns[0] * value, columns[1] * value))
        with np.errstate(invalid="ignore", divide="ignore"):
            explained = np.nan_to_num((bb * av ** 2 - 2 * ab * av * bv + aa * bv ** 2) / (aa * bb - ab ** 2))
        better = explained > best
        best, edge = np.where(better, explained, best), np.where(better, place, edge)
    return edge


def _means(sector: IntArray, value: FloatArray) -> FloatArray:
    with np.errstate(invalid="ignore"):
        return np.asarray(np.bincount(sector, value, SECTORS) / np.bincount(sector, minlength=SECTORS))


def fit_cone(touching: FloatArray, v: FloatArray, size: float) -> tuple[FloatArray, float, float]:
    """The v of rays of which some are wrong, the share of the circle about it where rays agree, and the median distance
    of all from it, pixels; v, 0 and infinity without any."""
    near, off = touching, np.full(1, np.inf)
    for _ in range(_ROUNDS):
        if len(near) < 3:
            return v, 0.0, np.inf
        v = np.asarray(np.linalg.lstsq(near, np.ones(len(near)), rcond=None)[0], dtype=float)
        off = np.abs(angle_beyond(touching, v)) / size
        near = touching[off <= 3 * TO_SIGMA * np.median(off) + 0.05]       # not a stand, nor where the lit part ends
    x, y = _perpendicular_axes(v / np.linalg.norm(v))
    return v, len(np.unique(_sector(near, x, y))) / SECTORS, float(np.median(off))


def _sector(rays: FloatArray, x: FloatArray, y: FloatArray) -> IntArray:
    """In which sector of an outline rays are, (n, 3) to (n,); x and y are at right angles to its axis."""
    return ((np.arctan2(rays @ y, rays @ x) / (2 * np.pi) + 1) * SECTORS).astype(int) % SECTORS


def _perpendicular_axes(axis: FloatArray) -> tuple[FloatArray, FloatArray]:
    x = np.cross(axis, np.eye(3)[int(np.argmin(np.abs(axis)))])
    x /= np.linalg.norm(x)
    return x, np.cross(axis, x)


def scatter(values: FloatArray) -> float:
    """The standard deviation of values (n,) of which some are far off."""
    return TO_SIGMA * float(np.median(np.abs(values - np.median(values))))

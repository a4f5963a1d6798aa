"""A ball in a picture, found by its outline, whatever else is there.

What is brighter than a level is regions, of which one is the ball, with or without its stand, or the room before which
it stands: so several levels are tried. Which parts of a region's edge are the ball's outline, and not where its lit
part ends, is decided by random samples (M. A. Fischler, R. C. Bolles: Random Sample Consensus, Communications of the
ACM 24(6), 1981).
"""

from collections.abc import Sequence

import numpy as np

from ...arrays import BoolArray, FloatArray, RealArray
from ...errors import DatasetError
from .camera import pixel_angle
from .outline import (
    ABOVE_NOISE,
    BALL_BRIGHTNESS,
    CLEAR,
    SECTORS,
    WINDOW,
    Outline,
    angle_beyond,
    edge_profile,
    fit_cone,
    scatter,
)

_LEVELS = BALL_BRIGHTNESS, 0.05, 0.1, 0.2, 0.4       # of a ball above its background, of the brightest of the picture
_LEAST = 5.0                # pixels, of a ball's radius
_SECOND = 0.1               # of the largest region's pixels, that another must have to count as a ball
_COARSE = 200               # pixels along a picture in which regions are told apart
_TRIALS, _NEAR = 400, 1.5   # random samples; pixels from an outline within which an edge is a part of it
_FITS = 0.5                 # pixels, of the median edge from the outline of a ball
_LEAST_ARC = 1 / 3          # of the outline, that must be seen
_BRIGHTEST = 99.5           # percentile of a picture that stands for its largest value
_NO_DISC = "no outline of a ball found: what is bright is no disc"


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
        v, residual, arc = _refine(v, grey, rays, size, name)
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
    """A better v from profiles across the outline; the residual, pixels; and the share of it that has an edge."""
    if np.linalg.norm(v) <= 1 or not np.isfinite(v).all():
        raise DatasetError(_NO_DISC, name)
    profile = edge_profile(v, grey, rays, size)
    with np.errstate(invalid="ignore"):
        clear = (profile.beyond < (1 - CLEAR) * profile.within) & (np.abs(profile.edge) < WINDOW / 2)
    if np.count_nonzero(clear) < _LEAST_ARC * SECTORS:
        return v, np.inf, np.count_nonzero(clear) / SECTORS
    v, arc, residual = fit_cone(profile.rays[clear], v, size)
    return v, residual, arc

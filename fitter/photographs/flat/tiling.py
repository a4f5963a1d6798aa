"""A tile of a flat sample: a part of its maps that can be repeated, and whose edges nobody sees.

Along each axis two strips of the sample, a period apart, are laid upon one another, and pass into one another beside
the path along which they differ least, seen from above under a few lamps (A. A. Efros, W. T. Freeman: Image Quilting
for Texture Synthesis and Transfer, SIGGRAPH 2001). That of the second axis is closed, since the tile goes on there. The
period is the one, of half the sample or more, whose strips are most alike.
"""

from dataclasses import replace
from typing import NamedTuple

import numpy as np

from ... import progress
from ...arrays import FloatArray, IntArray
from .maps import Maps

LEAST_TEXELS = 16           # along both axes
_STRIP = 8                  # of how many the sample has room
_BLENDED = 5                # of how many parts of a strip one, on each side of the path, passes into the other
_LAMPS = (0, 0), (45, 0), (45, 90), (45, 180), (45, 270)       # degrees from the normal, and around it
_FAR = 100.0                # times the sample's size: camera and lamps are the same for all texels


class _Seam(NamedTuple):
    """Where two strips of a sample, along its rows, become one: their first columns, and the share of the second in
    each texel, (h, strip)."""

    begin: int
    end: int
    share: FloatArray


def cut_tile(maps: Maps) -> Maps:
    """The part of maps that can be repeated, with corners where it was cut. ValueError if they have fewer than
    `LEAST_TEXELS` along an axis."""
    height, width = maps.used.shape
    if min(height, width) < LEAST_TEXELS:
        raise ValueError(f"{width} x {height} texels, a tile is cut from {LEAST_TEXELS} or more along both sides")
    with progress.part(0.0, 0.8, "Looking from above"):
        blended = [_lightness_from_above(maps), maps.weights, maps.normals]
    progress.report(0.8, "Cutting a tile")
    taken: list[FloatArray] = [maps.deviation, maps.used[..., None].astype(float)]
    cut = []
    for is_closed in (False, True):
        seam = _seam(blended[0], is_closed)
        sharp = seam._replace(share=seam.share.round())
        cut.append([seam.begin, seam.end])
        blended, taken = ([np.swapaxes(_cut(each, where), 0, 1) for each in layers]
                          for layers, where in ((blended, seam), (taken, sharp)))
    _, weights, normals = blended
    deviation, used = taken
    u, v = np.array(cut) / [[width], [height]]
    along, up = maps.corners[[1, 3]] - maps.corners[0]
    normals /= np.linalg.norm(normals, axis=2)[..., None]
    return replace(maps, weights=weights, normals=normals, deviation=deviation, used=used[..., 0].astype(int),
                   corners=maps.corners[0] + np.outer(u[[0, 1, 1, 0]], along) + np.outer(v[[0, 0, 1, 1]], up))


def tile_size(maps: Maps) -> str:
    """How large a tile is, in words."""
    height, width = maps.used.shape
    return "The tile has {} x {} texels and is {:.4g} x {:.4g} m large".format(
        width, height, *(maps.corners[2] - maps.corners[0]))


def _lightness_from_above(maps: Maps) -> FloatArray:
    """The cube roots of what each texel shows from above, under each lamp: (h, w, lamps * channels)."""
    middle, (along, up) = maps.corners.mean(axis=0), maps.corners[[1, 3]] - maps.corners[0]
    size = float(np.linalg.norm(along + up))
    axes = np.stack([along / np.linalg.norm(along), up / np.linalg.norm(up)])
    axes = _FAR * size * np.vstack([axes, np.cross(*axes)])
    white, found = np.full(max(len(fit.channels) for fit in maps.fits), (_FAR * size) ** 2), []
    for theta, phi in progress.each(np.radians(_LAMPS).tolist()):
        toward = np.array([np.sin(theta) * np.cos(phi), np.sin(theta) * np.sin(phi), np.cos(theta)])
        shown = maps.radiance(middle + axes[2], middle + toward @ axes, white)
        found.append(np.cbrt(shown))
    return np.concatenate(found, axis=2)


def _seam(seen: FloatArray, is_closed: bool) -> _Seam:
    """The least visible seam of what is seen, (h, w, n), between strips that lie half of its width apart or more."""
    width = seen.shape[1]
    strip = max(width // _STRIP, 4)
    half = max(strip // _BLENDED, 1)

    def differences(period: int) -> FloatArray:
        begin = (width - period - strip) // 2
        apart = seen[:, begin:begin + strip] - seen[:, begin + period:begin + period + strip]
        return np.asarray((apart ** 2).sum(axis=2))

    period = min(range(-(-width // 2), width - strip + 1), key=lambda each: float(differences(each).mean()))
    off, begin = differences(period), (width - period - strip) // 2
    path = half + 1 + cheapest_path((off[:, :-1] + off[:, 1:])[:, half:-half], is_closed)
    return _Seam(begin, begin + period, np.clip(0.5 + (path[:, None] - np.arange(strip) - 0.5) / (2 * half), 0, 1))


def _cut(values: FloatArray, seam: _Seam) -> FloatArray:
    """What is between the strips of a seam, (h, period, n), of (h, w, n)."""
    begin, end, share = seam.begin, seam.end, seam.share[..., None]
    strip = share.shape[1]
    one, other = values[:, begin:begin + strip], values[:, end:end + strip]
    # what is infinite is not to be multiplied with 0
    mixed = np.where(share == 0, one, np.where(share == 1, other, (1 - share) * one + share * other))
    return np.concatenate([mixed, values[:, begin + strip:end]], axis=1)


def cheapest_path(cost: FloatArray, is_closed: bool) -> IntArray:
    """The column in each row of a path down costs (h, w) whose sum is least. From row to row it goes at most one column
    aside; a closed one does so from the last row to the first too."""
    columns = np.arange(cost.shape[1])
    first = last = np.ones(len(columns), dtype=bool)
    if is_closed:           # from each column of the first row in turn
        near = np.abs(columns - columns[:, None]) <= 1
        sums = np.where(columns == columns[:, None], cost[0], np.inf)
        for row in cost[1:]:
            sums = _least(sums) + row
        start = int(np.where(near, sums, np.inf).min(axis=1).argmin())
        first, last = columns == start, near[start]
    found = [np.where(first, cost[0], np.inf)]
    for row in cost[1:]:
        found.append(_least(found[-1]) + row)
    path = [int(np.where(last, found[-1], np.inf).argmin())]
    for each in found[-2::-1]:
        low = max(path[-1] - 1, 0)
        path.append(low + int(each[low:path[-1] + 2].argmin()))
    return np.array(path[::-1])


def _least(sums: FloatArray) -> FloatArray:
    """The least of each number of rows (..., w) and its neighbours."""
    wide = np.pad(sums, [(0, 0)] * (sums.ndim - 1) + [(1, 1)], constant_values=np.inf)
    return np.asarray(np.minimum(np.minimum(wide[..., :-2], wide[..., 2:]), sums))

"""Photographs of a flat sample as maps: at each texel a mix of a few materials, and a normal.

The reflectance of a texel is a non-negative mix of a few measured ones, turned by the texel's own normal: H. Lensch,
J. Kautz, M. Goesele, W. Heidrich, H.-P. Seidel: Image-Based Reconstruction of Spatial Appearance and Geometric Detail,
ACM Transactions on Graphics 22(2), 2003; P. Ren, J. Wang, J. Snyder, X. Tong, B. Guo: Pocket Reflectometry, SIGGRAPH
2011.
"""

import os
from collections.abc import Callable, Iterator, Sequence
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass
from typing import TypeVar

import numpy as np

from ... import progress
from ...arrays import ArrayLike, BoolArray, FloatArray, IntArray
from ...errors import DatasetError
from ...model.fit import Fit
from ...samples import Samples
from ..description.capture_setup import MOST_MATERIALS
from ..pictures import check_bright
from ..rig.photograph import check_alike, mean_of_neighbours
from . import solving
from .materials import MOST_TEXELS, materials_found
from .photograph import FlatPhotograph, find_pixels, interpolate_bilinear, observe, pixel_corners, shading_geometry
from .solving import Texels, radiances, slopes_to_normals

_BLOCK = 4096               # texels at a time: 50 MB with 16 photographs and 4 materials
_COARSER, _COARSEST = 4, 4096   # of how many texels along both axes one is solved first; the fewest that follow others
_EVEN = 0.01                # of the longest side, by which corners may be out of a plane
_LEAST_RELIEF = 1e-3        # slope from texel to texel, .06 degrees, below which nobody sees it
_MANY = 8                   # pixels of a texel along both axes, from where photographs are made coarser
_EXACT = 1e-3               # of the pixels that a texel has, by which places may be wrong
_SMOOTHED = 100             # rounds, each of which carries a normal by one texel
_Result = TypeVar("_Result")


@dataclass(frozen=True, eq=False)
class Maps:
    """A flat sample as a mix of materials with a normal at each texel.

    Row 0 lies along the edge from the first corner to the second, and column 0 along that from the first to the last;
    a texel's place is its centre.

    Attributes
    ----------
    fits : tuple of Fit
        The materials that are mixed; `notes` say how they were found.
    weights, deviation : (h, w, materials) float64
        At least 0, and their standard deviation; 0 and infinite where no photograph tells.
    normals : (h, w, 3) float64
        Unit vectors in the coordinates of the corners.
    corners : (4, 3) float64
        Metres.
    used : (h, w) int
        How many photographs tell of a texel.
    """

    fits: tuple[Fit, ...]
    weights: FloatArray
    normals: FloatArray
    corners: FloatArray
    deviation: FloatArray
    used: IntArray
    notes: tuple[str, ...] = ()

    def radiance(self, camera: ArrayLike, lamp: ArrayLike, intensity: ArrayLike) -> FloatArray:
        """What each texel sends to a camera at this place, under a lamp at that of this intensity: (h, w, channels).

        Shadows of texels on one another are not in it. Places are (3,), metres; the intensity is (channels,), W/sr.
        """
        points, weights = texel_points(self.corners, self.weights.shape[:2]), self.weights.reshape(-1, len(self.fits))
        normals = self.normals.reshape(-1, 3)
        eye, light = (np.asarray(each, dtype=float)[None] for each in (camera, lamp))
        found = []
        for part in _blocks(len(points)):
            seen = shading_geometry(points[part], eye, light, np.atleast_1d(np.asarray(intensity, dtype=float))[None])
            found.append(np.einsum("npcm,nm->nc", radiances(self.fits, seen, normals[part]), weights[part]))
        return np.concatenate(found).reshape(*self.weights.shape[:2], -1)


def maps_from_flat(photographs: Sequence[FlatPhotograph], corners: ArrayLike, shape: tuple[int, int],
                   fits: Sequence[Fit] | int | None = None) -> Maps:
    """The maps of a flat sample that photographs show.

    Parameters
    ----------
    photographs : sequence of FlatPhotograph
        Two or more.
    corners : (4, 3) array_like
        Metres, counter-clockwise as the camera sees the sample, from that at texel (0, 0) along its row.
    shape : (h, w)
        Texels.
    fits : sequence of Fit, or int
        One to four isotropic materials that are mixed; by default, or of so many, they are found in the photographs
        (`materials`), which then say nothing of the scale of each one's weights: its purest texels have about 1.

    Returns
    -------
    Maps
        Normals are smooth as far as the photographs leave them open; where they tell nothing, the surface is flat. A
        texel that has eight pixels or more along both axes is their mean.

    Raises
    ------
    DatasetError
        If there are fewer than two photographs, their sizes differ, one is black, corners are crossed, clockwise or not
        in a plane, a lamp is behind the sample, no texel is seen in two photographs, or too few for materials to be
        found in them.
    ValueError
        If the materials are too many or anisotropic, or their channels are not those of the photographs.
    """
    if len(photographs) < 2:
        raise DatasetError(f"{len(photographs)} photograph{'s' * (not photographs)} found, expected two or more under "
                           f"lamps in several places", photographs[0].name if photographs else None)
    check_alike(photographs)
    for each in photographs:
        check_bright(each.radiance, each.name)
    corners = np.array(corners, dtype=float)
    height, width = (int(each) for each in shape)
    if min(height, width) < 1:
        raise ValueError(f"{width} x {height} texels, expected one or more along both sides")
    frame = sample_frame(corners, photographs)
    photographs = coarse(photographs, corners, (height, width))
    points = texel_points(corners, (height, width))
    grid = points.reshape(height, width, 3)
    notes: tuple[str, ...] = ()
    some = observe(photographs, grid[evenly(height, width, MOST_TEXELS)].reshape(-1, 3), frame[2])
    if fits is None or isinstance(fits, int):
        with progress.part(0.0, 0.4, "Finding materials"):
            fits, notes = materials_found(some, frame, photographs[0].name, fits)
    fits = tuple(fits)
    check_materials(fits, photographs[0].radiance.shape[2])
    with progress.part(0.4, 0.9, "Finding weights and normals"):
        few = solving.solve_texels(fits, some, frame)
        prior = solving.estimate_prior(few)
        texels = _solve_grid(fits, photographs, grid, frame, prior,
                             few.slopes if len(few.slopes) == len(points) else None)
    if not (texels.used.sum(axis=1) > 1).any():
        raise DatasetError("no texel is seen and lit in two photographs or more: the corners are not where the sample "
                           "is in the pictures, or lamps and camera graze it", photographs[0].name)
    with progress.part(0.9, 1.0, "Smoothing normals"):
        slopes = smooth_slopes(texels.slopes.reshape(height, width, 2), texels.precision.reshape(height, width, 2, 2),
                               texels.used.any(axis=1).reshape(height, width))
        slopes = slopes.reshape(-1, 2)
        weights, far = solving.turned_weights(texels, slopes)
        if len(far):
            weights[far] = np.concatenate(_map_blocks(lambda part: solving.given_normals(
                fits, observe(photographs, points[far[part]], frame[2]), frame, texels.part(far[part]),
                slopes[far[part]], prior), len(far)))
        progress.report(1.0)
    normals = slopes_to_normals(slopes, frame).reshape(height, width, 3)
    return Maps(fits, weights.reshape(height, width, -1), normals, corners,
                texels.deviation.reshape(height, width, -1), texels.used.sum(axis=1).reshape(height, width), notes)


def _solve_grid(fits: Sequence[Fit], photographs: Sequence[FlatPhotograph], grid: FloatArray, frame: FloatArray,
                prior: solving.Prior, first: FloatArray | None = None) -> Texels:
    """The texels of a grid of points (h, w, 3), row by row: from slopes to begin with, (n, 2), else from many starts of
    few of them, and then from these slopes."""
    height, width = grid.shape[:2]
    points = grid.reshape(-1, 3)
    if first is None and min(height, width) >= 2 * _COARSER and len(points) > _COARSEST:
        middle = slice(_COARSER // 2, None, _COARSER)
        with progress.part(0.0, 2 / _COARSER ** 2):
            few = grid[middle, middle]
            coarse = _solve_grid(fits, photographs, few, frame, prior).slopes.reshape(*few.shape[:2], 2)
        place = (np.indices((height, width)).reshape(2, -1).T - _COARSER // 2) / _COARSER
        first = interpolate_bilinear(coarse, *pixel_corners(place, few.shape[:2])[:2])
    with progress.part(0.0 if first is None else 2 / _COARSER ** 2, 1.0):
        parts = _map_blocks(lambda part: solving.solve_texels(fits, observe(photographs, points[part], frame[2]), frame,
                                                      None if first is None else first[part], prior), len(points))
    return Texels(*(np.concatenate(arrays) for arrays in zip(*parts, strict=True)))


def _map_blocks(work: Callable[[slice], _Result], count: int) -> list[_Result]:
    """What work returns of so many things, in blocks of which several are worked on at once."""
    blocks, results = list(_blocks(count)), []
    with ThreadPoolExecutor(os.cpu_count()) as threads:
        try:
            for number, result in enumerate(threads.map(work, blocks)):
                results.append(result)
                progress.report((number + 1) / len(blocks))
        except BaseException:
            threads.shutdown(cancel_futures=True)       # who listens may cancel
            raise
    return results


def _blocks(count: int) -> Iterator[slice]:
    return (slice(start, start + _BLOCK) for start in range(0, count, _BLOCK))


def evenly(height: int, width: int, most: int) -> tuple[slice, slice]:
    """As many rows and columns as have so many texels at most."""
    step = int(np.ceil(np.sqrt(height * width / most)))
    return slice(step // 2, None, step), slice(step // 2, None, step)


def check_materials(materials: Sequence[Fit | Samples], channels: int) -> None:
    """Raise ValueError if photographs of so many channels cannot show a mix of these materials."""
    if not 1 <= len(materials) <= MOST_MATERIALS:
        raise ValueError(f"{len(materials)} materials found, expected 1 to {MOST_MATERIALS}")
    for each in materials:
        if not each.isotropic:
            raise ValueError(f"{each.name}: anisotropic, expected materials that are isotropic")
        if len(each.channels) not in (1, channels):
            raise ValueError(f"{each.name}: {len(each.channels)} channels found, expected {channels} as in the "
                             f"photographs, or 1")


def sample_frame(corners: FloatArray, photographs: Sequence[FlatPhotograph]) -> FloatArray:
    """The axes of a sample: along its rows, along its columns nearly, and its normal toward the camera; rows of (3, 3).
    Raises DatasetError as `maps_from_flat` does."""
    name = photographs[0].name
    if corners.shape != (4, 3) or not np.isfinite(corners).all():
        raise DatasetError(f"corners of the shape {corners.shape} found, expected four points (4, 3)", name)
    sides = np.roll(corners, -1, axis=0) - corners
    turns = np.cross(np.roll(sides, 1, axis=0), sides)
    size = np.linalg.norm(sides, axis=1).max()
    normal = np.cross(corners[2] - corners[0], corners[3] - corners[1])
    if not np.linalg.norm(normal) > 1e-6 * size ** 2:
        raise DatasetError("the corners lie on a line, or their order is crossed: expected them one after the other "
                           "around the sample", name)
    normal /= np.linalg.norm(normal)
    out = np.abs((corners - corners.mean(axis=0)) @ normal).max()
    if out > _EVEN * size:
        raise DatasetError(f"the corners are not in a plane: they are {out:.3g} m out of it", name)
    if not (turns @ normal > 0).all():
        raise DatasetError("the corners are crossed: expected them one after the other around the sample", name)
    for each in photographs:
        if not (each.camera - corners.mean(axis=0)) @ normal > 0:
            raise DatasetError("the corners run clockwise as the camera sees them, or it is behind the sample: "
                               "expected them counter-clockwise", each.name)
        if not ((each.lamp - corners) @ normal > 0).any():
            raise DatasetError("the lamp is behind the sample", each.name)
    along = sides[0] - sides[0] @ normal * normal
    along /= np.linalg.norm(along)
    return np.stack([along, np.cross(normal, along), normal])


def coarse(photographs: Sequence[FlatPhotograph], corners: FloatArray,
           shape: tuple[int, int]) -> list[FlatPhotograph]:
    """Photographs with a pixel for each texel, where that has many: a texel is the mean of its pixels. Few are left as
    they are, for what they show of a bump's highlight is not what one normal in their middle does."""
    found = []
    for each in photographs:
        count = pixels_per_texel(find_pixels(each.rays, corners - each.camera), shape)
        found.append(each if count < _MANY else each.average_texels(texel_corners(corners, shape), count))
    return found


def pixels_per_texel(places: FloatArray, shape: tuple[int, int]) -> int:
    """How many pixels a texel has along both axes, of a sample whose corners are at these places, (4, 2)."""
    sides = np.linalg.norm(np.roll(places, -1, axis=0) - places, axis=1) * (1 + _EXACT)
    height, width = shape
    return max(int(min(sides[[0, 2]].min() / width, sides[[1, 3]].min() / height)), 1)


def texel_corners(corners: FloatArray, shape: tuple[int, int], *rim: float) -> FloatArray:
    """The corners of texels, (h + 1, w + 1, 3), without a rim of these shares of the sample's height and width."""
    ends = rim or (0.0, 0.0)
    return _points_in_sample(corners, *(np.clip(np.linspace(0, 1, count + 1), end, 1 - end)
                                        for count, end in zip(shape, ends, strict=True)))


def texel_points(corners: FloatArray, shape: tuple[int, int]) -> FloatArray:
    """The centres of texels, row by row: (h w, 3)."""
    return _points_in_sample(corners, *((np.arange(count) + 0.5) / count for count in shape)).reshape(-1, 3)


def _points_in_sample(corners: FloatArray, v: FloatArray, u: FloatArray) -> FloatArray:
    """Points at these shares of a sample's height and width, (m,) and (n,): (m, n, 3)."""
    v, u = v[:, None, None], u[:, None]
    return np.asarray((1 - v) * ((1 - u) * corners[0] + u * corners[1])
                      + v * ((1 - u) * corners[3] + u * corners[2]))


def smooth_slopes(slopes: FloatArray, precision: FloatArray, known: BoolArray) -> FloatArray:
    """The most probable slopes (h, w, 2), where those of neighbours differ by as much as they do beyond what their
    uncertainty makes: they are their neighbours' as far as they are not known themselves.

    The precision (h, w, 2, 2) is the inverse of their covariance; `known` is where photographs tell of them, (h, w).
    """
    pairs_known = np.concatenate([(known[1:] & known[:-1]).ravel(), (known[:, 1:] & known[:, :-1]).ravel()])
    if not pairs_known.any():
        return slopes
    squared = np.concatenate([(np.diff(slopes, axis=axis) ** 2).sum(axis=2).ravel() for axis in (0, 1)])
    variance = np.trace(np.linalg.inv(precision), axis1=2, axis2=3)
    doubt = np.concatenate([(variance[1:] + variance[:-1]).ravel(), (variance[:, 1:] + variance[:, :-1]).ravel()])
    sure = pairs_known & (doubt <= np.median(doubt[pairs_known]))
    relief = max(float((squared - doubt)[sure].mean()) / 2, _LEAST_RELIEF ** 2)
    beside = 4 * mean_of_neighbours(np.ones((*known.shape, 1)), "constant")
    inverse = np.linalg.inv(precision + beside[..., None] / relief * np.eye(2))
    own = np.einsum("hwij,hwj->hwi", precision, slopes)
    found = slopes
    for _ in range(_SMOOTHED):
        found = np.einsum("hwij,hwj->hwi", inverse, own + 4 * mean_of_neighbours(found, "constant") / relief)
    return np.asarray(found)

"""Control lattices of uniform cubic B-splines in the unit cube: indexing, evaluation and refinement.

At level h there are M = 2^h cells along each axis, and control points numbered -1 to M + 1; cell i reads the points i -
1 to i + 2 (Kameya and Lewis 2002, equation 7). A lattice that has the symmetries of `coordinates` is C2 across the
plane of incidence and through normal incidence, and stores a part of its control points: of three axes those that cells
with ``x_1 >= 1/2`` and ``x_3 >= 1/2`` read, a box of (M/2 + 3) (M + 3) (M/2 + 3); of four those that cells with ``x_4
>= 1/2`` read. `osl/lattice.h` reads the same boxes.
"""

import itertools
from collections.abc import Sequence
from dataclasses import dataclass
from functools import lru_cache

import numpy as np

from ..arrays import BoolArray, FloatArray, IntArray, SingleArray

MAX_LEVEL = 8
MAX_LEVEL_OF_FOUR_AXES = 6  # of which the full lattice has 20 million control points
MIRRORS: dict[int, tuple[tuple[int, ...], ...]] = {3: ((1, 1, -1), (-1, -1, 1), (-1, -1, -1)), 4: ((1, 1, -1, -1),)}
"""The symmetries of lattices, by the number of axes: the sign of each coordinate, counted from the cube's middle."""
HALVED: dict[int, tuple[bool, ...]] = {3: (True, False, True), 4: (False, False, False, True)}
"""The axes of which half is stored."""
_DENSE_POINTS = 8192        # points evaluated at a time: fits the processor's cache
_FEW_POINTS = 1000          # points whose control points are read at once: the calls of NumPy take longest


@dataclass(frozen=True, eq=False)
class DenseLattice:
    """A lattice that stores all of its control points."""

    level: int
    control_points: SingleArray     # shape(level, axes) + (channels,)

    @property
    def axes(self) -> int:
        """The number of axes."""
        return self.control_points.ndim - 1

    @property
    def nbytes(self) -> int:
        """Bytes of the control points."""
        return self.control_points.nbytes

    @property
    def count(self) -> int:
        """Control points stored, counted once whatever the number of channels."""
        return self.control_points[..., 0].size

    def evaluate(self, x: FloatArray) -> FloatArray:
        """The spline at coordinates (n, axes): (n, channels)."""
        return evaluate(self.control_points, self.level, x)


def cells(level: int) -> int:
    """Number of cells along an axis, M = 2^h."""
    return 1 << level


def origin(level: int, axes: int = 3) -> tuple[int, ...]:
    """Lattice index of the first stored control point along each axis."""
    half = cells(level) // 2 - 1
    return tuple(half if halved else -1 for halved in HALVED[axes])


def shape(level: int, axes: int = 3) -> tuple[int, ...]:
    """Number of stored control points along each axis.

    Examples
    --------
    >>> shape(4), origin(4)
    ((11, 19, 11), (7, -1, 7))
    >>> shape(3, 4), origin(3, 4)
    ((11, 11, 11, 7), (-1, -1, -1, 3))
    """
    return tuple(cells(level) + 2 - first for first in origin(level, axes))


def full_size(level: int, axes: int = 3) -> int:
    """Number of control points of the full lattice, (2^h + 3)^3 of three axes, which the paper counts."""
    return (cells(level) + 3) ** axes


def weights(s: FloatArray) -> FloatArray:
    """Uniform cubic B-spline basis at s in [0, 1]: (n,) to (n, 4) (Lee, Wolberg and Shin 1997, section 3.1)."""
    s = s[:, None]
    powers = np.concatenate([np.ones_like(s), s, s * s, s * s * s], axis=1)
    return powers @ _BASIS


_BASIS = np.array([[1, 4, 1, 0], [-3, 0, 3, 0], [3, -6, 3, 0], [-1, 3, -3, 1]]) / 6


def locate(x: FloatArray, level: int) -> tuple[IntArray, list[FloatArray]]:
    """The first of the four control points that coordinates (n, axes) in [0, 1], also of mirror images, read along each
    axis: (n, axes) array indices, negative where not stored; and the basis along each, (n, 4). 1 is in the last
    cell."""
    scaled, axes = x * cells(level), x.shape[1]
    cell = np.clip(np.floor(scaled), 0, cells(level) - 1)
    w = [weights(scaled[:, axis] - cell[:, axis]) for axis in range(axes)]
    return cell.astype(np.intp) - 1 - np.array(origin(level, axes)), w


def strides(level: int, axes: int = 3) -> IntArray:
    """By how much the position in the flattened box grows along each axis: (axes,) int."""
    return np.cumprod((1, *shape(level, axes)[:0:-1]))[::-1]


def tensor(w: Sequence[FloatArray]) -> FloatArray:
    """Products of the weights along each axis: several (n, 4) to (n, 4^axes), the last axis fastest."""
    total = w[0]
    for along in w[1:]:
        total = (total[:, :, None] * along[:, None, :]).reshape(len(total), -1)
    return total


class Grid:
    """Where samples lie on a lattice, by coordinates x, (n, axes), in the stored part of the cube: their control
    points, of which `first`, (n,), is the first in the flattened box, and the basis functions there."""

    def __init__(self, x: FloatArray, level: int) -> None:
        corner, self._along = locate(x, level)
        step = strides(level, x.shape[1])
        self.first = corner @ step
        self._offsets = tap_offsets(step)

    def taps(self, sample: int | IntArray) -> IntArray:
        """The control points of samples: (...) or (..., 1) indices to (..., 4^axes)."""
        return np.asarray(self.first[sample] + self._offsets)

    def basis(self, samples: IntArray) -> FloatArray:
        """The weights of the control points of samples: (m,) to (m, 4^axes)."""
        return tensor([along[samples] for along in self._along])


def tap_offsets(step: IntArray) -> IntArray:
    """The positions of the control points that a sample reads, from the first, by those of `strides`: (4^axes,) int."""
    offsets = np.zeros(1, dtype=step.dtype)
    for each in step:
        offsets = (offsets[:, None] + np.arange(4) * each).ravel()
    return offsets


def evaluate(control_points: FloatArray | SingleArray, level: int, x: FloatArray) -> FloatArray:
    """The spline at points in the stored part of the cube (Kameya and Lewis 2002, equation 7): control points,
    shape(level, axes) + (channels,), and coordinates, (n, axes), to (n, channels) float64."""
    flat = np.ascontiguousarray(control_points.reshape(-1, control_points.shape[-1]).T, dtype=np.float64)
    result = np.empty((len(flat), len(x)))
    for start in range(0, len(x), _DENSE_POINTS):
        part = slice(start, start + _DENSE_POINTS)
        result[:, part] = _evaluate_chunk(flat, level, x[part])
    return result.T


def _evaluate_chunk(flat: FloatArray, level: int, x: FloatArray) -> FloatArray:
    """The spline of control points (channels, points) at a few points (n, axes): (channels, n)."""
    step = strides(level, x.shape[1])
    first, w = locate(x, level)
    base = first @ step
    if len(x) <= _FEW_POINTS:
        every, basis = base[:, None] + tap_offsets(step), tensor(w)
        return np.stack([np.einsum("nt,nt->n", points.take(every), basis) for points in flat])
    *outer, inner = (np.ascontiguousarray(axis.T) for axis in w)
    total = np.zeros((len(flat), len(x)))
    for taps in itertools.product(range(4), repeat=len(outer)):
        tap = base + int(step[:-1] @ taps)
        weight = outer[0][taps[0]]
        for along, number in zip(outer[1:], taps[1:], strict=True):
            weight = weight * along[number]
        for channel, points in enumerate(flat):         # by itself: indices of one axis are read quickest
            row = inner[0] * points.take(tap)
            for c in range(1, 4):
                row += inner[c] * points.take(tap + c)
            total[channel] += weight * row
    return total


def refine(control_points: FloatArray, level: int) -> FloatArray:
    """Represent the same spline on the next finer lattice, exactly (Lee, Wolberg and Shin 1997, section 4.2):
    shape(level, axes) + (channels,) to shape(level + 1, axes) + (channels,)."""
    axes = control_points.ndim - 1
    skipped = np.array(origin(level + 1, axes)) - (2 * np.array(origin(level, axes)) + 1)
    for axis, (skip, count) in enumerate(zip(skipped.tolist(), shape(level + 1, axes), strict=True)):
        coarse = np.moveaxis(control_points, axis, 0)
        even = (coarse[:-2] + 6 * coarse[1:-1] + coarse[2:]) / 8        # fine[2i]
        odd = (coarse[:-1] + coarse[1:]) / 2                            # fine[2i + 1]
        both = np.empty((2 * len(odd) - 1, *coarse.shape[1:]))
        both[0::2], both[1::2] = odd, even                              # its first point is number 2 origin(level) + 1
        control_points = np.moveaxis(both[skip:skip + count], 0, axis)
    return np.ascontiguousarray(control_points)


def refine_to_level(control_points: FloatArray | SingleArray, level: int, finer: int) -> FloatArray:
    """Represent the same spline on the lattice of a level that is at least as fine: `refine`, as often as it takes."""
    fine = np.asarray(control_points, dtype=float)
    for each in range(level, finer):
        fine = refine(fine, each)
    return fine


def nodes(level: int) -> FloatArray:
    """Corners of the cells in the stored quarter of the cube of three axes: (a, b, c, 3) float64 in [0, 1]."""
    m = cells(level)
    outer, whole = np.arange((m + 1) // 2, m + 1) / m, np.arange(m + 1) / m
    return np.stack(np.meshgrid(outer, whole, outer, indexing="ij"), axis=-1)


def interpolate(values: FloatArray, level: int) -> FloatArray:
    """The control points of the natural cubic spline through values at `nodes`, (a, b, c, channels): shape(level) +
    (channels,). The symmetries give the values at the mirror images."""
    m = cells(level)
    first = (m + 1) // 2
    full = np.empty((m + 1, m + 1, m + 1, values.shape[-1]))
    full[first:, :, first:] = values
    full[first:, :, :first] = full[first:, :, :m - first:-1]
    full[:first] = full[:m - first:-1, ::-1]
    spline = (np.eye(m + 3, k=-1) + 4 * np.eye(m + 3) + np.eye(m + 3, k=1)) / 6
    spline[0, :3] = spline[-1, -3:] = 1, -2, 1                          # natural: no curvature at the ends
    inverse = np.linalg.inv(spline)[:, 1:-1]
    for axis in range(3):
        full = np.moveaxis(np.tensordot(inverse, full, (1, axis)), 0, axis)
    return np.ascontiguousarray(full[m // 2:, :, m // 2:])


@lru_cache(maxsize=2)
def representative(level: int, axes: int = 3) -> IntArray:
    """For each stored control point, the first of its mirror images in the flattened box: shape(level, axes) int."""
    box, start = np.array(shape(level, axes)), np.array(origin(level, axes))
    point = np.moveaxis(np.indices(tuple(box)), 0, -1) + start
    first = np.arange(box.prod()).reshape(box)
    for signs in MIRRORS[axes]:
        image = np.where(np.array(signs) > 0, point, cells(level) - point) - start
        inside = ((image >= 0) & (image < box)).all(axis=-1)
        first = np.where(inside, np.minimum(first, image @ strides(level, axes)), first)
    return first


def reachable(level: int, axes: int = 3) -> BoolArray:
    """Whether any pair of directions reads a stored control point, by Nusselt coordinates: shape(level, axes) bool.
    ``(kappa_o, lambda_o)`` lies in a disk, and so do both directions of which four coordinates are the half sum and the
    half difference: the corners of the box are never read."""
    half = cells(level) / 2
    # control point j is read over [j - 2, j + 2] / M: its distance from the middle, in cells
    along = [first + np.arange(count) - half for first, count in zip(origin(level, axes), shape(level, axes),
                                                                     strict=True)]
    if axes == 3:
        _, kappa, lambda_ = (np.maximum(np.abs(each) - 2, 0) for each in along)
        return np.broadcast_to(np.hypot(kappa[:, None], lambda_) < half, shape(level))
    a, b, c, d = along
    reached = np.ones((), dtype=bool)
    for sign in (1, -1):
        x, y = (np.maximum(np.abs(of_sum[:, None] + sign * of_difference) - 4, 0)
                for of_sum, of_difference in ((a, c), (b, d)))
        reached = reached & (np.hypot(x[:, None, :, None], y[None, :, None, :]) < half)
    return reached

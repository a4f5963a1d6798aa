"""Control lattices of uniform cubic B-splines in the unit cube: indexing, evaluation and refinement.

At level h the cube is divided into M = 2^h cells along each axis. The full lattice has (M + 3)^3 control points,
numbered -1 to M + 1 along each axis; cell i reads the points i - 1 to i + 2 (Kameya and Lewis 2002, equation 7).

Two symmetries of an isotropic reflectance halve two of the axes. A lattice that is symmetric under
``lambda -> 1 - lambda`` (bilateral symmetry) is C2 across the plane of incidence. One that is symmetric under
``(kappa_i, kappa_o) -> (1 - kappa_i, 1 - kappa_o)`` (both directions rotated by 180 degrees) is C2 through normal
incidence. All directions have ``kappa_i >= 1/2`` and ``lambda_o >= 1/2``, so only the control points that a cell in
that quarter of the cube reads are stored: M/2 - 1 to M + 1 along those two axes, a box of
(M/2 + 3) (M + 3) (M/2 + 3). `osl/lattice.h` reads the same box; the baker writes `shape` and `origin` into the shader.
"""

from dataclasses import dataclass
from functools import lru_cache

import numpy as np

from ..arrays import BoolArray, FloatArray, IntArray, SingleArray

MAX_LEVEL = 8
_CHUNK = 8192               # points evaluated at a time: fits the processor's cache


@dataclass(frozen=True, eq=False)
class DenseLattice:
    """A lattice that stores all of its control points.

    Attributes
    ----------
    level : int
    control_points : shape(level) + (channels,) float32
    """

    level: int
    control_points: SingleArray

    @property
    def nbytes(self) -> int:
        """Bytes of the control points."""
        return self.control_points.nbytes

    @property
    def count(self) -> int:
        """Control points stored, counted once whatever the number of channels."""
        return self.control_points[..., 0].size

    def evaluate(self, x: FloatArray) -> FloatArray:
        """The spline at coordinates (n, 3): (n, channels)."""
        return evaluate(self.control_points, self.level, x)


def cells(level: int) -> int:
    """Number of cells along an axis, M = 2^h.

    Examples
    --------
    >>> cells(6)
    64
    """
    return 1 << level


def origin(level: int) -> tuple[int, int, int]:
    """Lattice index of the first stored control point along each axis."""
    half = cells(level) // 2 - 1
    return half, -1, half


def shape(level: int) -> tuple[int, int, int]:
    """Number of stored control points along each axis.

    Examples
    --------
    >>> shape(4), origin(4)
    ((11, 19, 11), (7, -1, 7))
    """
    a, b, c = (cells(level) + 2 - first for first in origin(level))
    return a, b, c


def full_size(level: int) -> int:
    """Number of control points of the full lattice, (2^h + 3)^3, which the paper counts.

    Examples
    --------
    >>> full_size(6)
    300763
    """
    return (cells(level) + 3) ** 3


def weights(s: FloatArray) -> FloatArray:
    """Uniform cubic B-spline basis at s in [0, 1]: (n,) to (n, 4) (Lee, Wolberg and Shin 1997, section 3.1).

    Examples
    --------
    >>> (6 * weights(np.array([0.0, 1.0]))).round(9).tolist()
    [[1.0, 4.0, 1.0, 0.0], [0.0, 1.0, 4.0, 1.0]]
    """
    s = s[:, None]
    powers = np.concatenate([np.ones_like(s), s, s * s, s * s * s], axis=1)
    return powers @ _BASIS


_BASIS = np.array([[1, 4, 1, 0], [-3, 0, 3, 0], [3, -6, 3, 0], [-1, 3, -3, 1]]) / 6


def locate(x: FloatArray, level: int) -> tuple[IntArray, list[FloatArray]]:
    """Find the control points that points read, and their weights. The coordinate 1 falls in the last cell.

    Parameters
    ----------
    x : (n, 3) float64
        Coordinates in [0, 1], also of mirror images.

    Returns
    -------
    first : (n, 3) int
        Array index of the first of the four control points along each axis; negative if that is not stored.
    w : list of three (n, 4) float64
        The basis along each axis.
    """
    scaled = x * cells(level)
    cell = np.clip(np.floor(scaled), 0, cells(level) - 1)
    w = [weights(scaled[:, axis] - cell[:, axis]) for axis in range(3)]
    return cell.astype(np.intp) - 1 - np.array(origin(level)), w


class Grid:
    """Where samples lie on a lattice: their control points, and the basis functions there.

    Parameters
    ----------
    x : (n, 3) float64
        Coordinates in the stored quarter of the cube.
    level : int

    Attributes
    ----------
    first : (n,) int
        The first of each sample's control points, in the flattened box.
    """

    def __init__(self, x: FloatArray, level: int) -> None:
        _, rows, columns = shape(level)
        corner, self._along = locate(x, level)
        self.first = (corner[:, 0] * rows + corner[:, 1]) * columns + corner[:, 2]
        four = np.arange(4)
        self._offsets = ((four[:, None, None] * rows + four[:, None]) * columns + four).ravel()

    def taps(self, sample: int | IntArray) -> IntArray:
        """The control points of samples: (...) or (..., 1) indices to (..., 64)."""
        return np.asarray(self.first[sample] + self._offsets)

    def basis(self, samples: IntArray) -> FloatArray:
        """The weights of the control points of samples: (m,) to (m, 64)."""
        a, b, c = (along[samples] for along in self._along)
        return (a[:, :, None, None] * b[:, None, :, None] * c[:, None, None, :]).reshape(-1, 64)


def evaluate(control_points: FloatArray | SingleArray, level: int, x: FloatArray) -> FloatArray:
    """The spline at points in the stored quarter of the cube (Kameya and Lewis 2002, equation 7).

    Parameters
    ----------
    control_points : shape(level) + (channels,) array
    x : (n, 3) float64
        Coordinates, as a `coordinates.Coordinates` encodes directions.

    Returns
    -------
    (n, channels) float64

    Examples
    --------
    The basis sums to 1: equal control points make a constant.

    >>> evaluate(np.full((*shape(2), 1), 0.3), 2, np.array([[0.5, 0.1, 0.9], [1, 1, 1]])).round(9).tolist()
    [[0.3], [0.3]]
    """
    flat = np.ascontiguousarray(control_points.reshape(-1, control_points.shape[-1]).T, dtype=np.float64)
    result = np.empty((len(flat), len(x)))
    for start in range(0, len(x), _CHUNK):
        part = slice(start, start + _CHUNK)
        result[:, part] = _evaluate_chunk(flat, level, x[part])
    return result.T


def _evaluate_chunk(flat: FloatArray, level: int, x: FloatArray) -> FloatArray:
    """The spline of control points (channels, points) at a few points (n, 3): (channels, n)."""
    _, rows, columns = shape(level)
    first, w = locate(x, level)
    wa, wb, wc = (np.ascontiguousarray(axis.T) for axis in w)
    base = (first[:, 0] * rows + first[:, 1]) * columns + first[:, 2]
    total = np.zeros((len(flat), len(x)))
    for a in range(4):
        for b in range(4):
            tap = base + (a * rows + b) * columns
            wab = wa[a] * wb[b]
            for channel, points in enumerate(flat):     # by itself: indices of one axis are read quickest
                along_c = wc[0] * points.take(tap)
                for c in range(1, 4):
                    along_c += wc[c] * points.take(tap + c)
                total[channel] += wab * along_c
    return total


def refine(control_points: FloatArray, level: int) -> FloatArray:
    """Represent the same spline on the next finer lattice, exactly (Lee, Wolberg and Shin 1997, section 4.2).

    Parameters
    ----------
    control_points : shape(level) + (channels,) float64

    Returns
    -------
    shape(level + 1) + (channels,) float64

    Examples
    --------
    >>> coarse, x = np.random.default_rng(1).random((*shape(2), 1)), np.array([[0.7, 0.2, 0.6]])
    >>> bool(np.allclose(evaluate(refine(coarse, 2), 3, x), evaluate(coarse, 2, x)))
    True
    """
    for axis in range(3):
        coarse = np.moveaxis(control_points, axis, 0)
        even = (coarse[:-2] + 6 * coarse[1:-1] + coarse[2:]) / 8        # fine[2i]
        odd = (coarse[:-1] + coarse[1:]) / 2                            # fine[2i + 1]
        both = np.empty((2 * len(odd) - 1, *coarse.shape[1:]))
        both[0::2], both[1::2] = odd, even                              # its first point is number 2 origin(level) + 1
        skip = origin(level + 1)[axis] - (2 * origin(level)[axis] + 1)
        fine = both[skip:skip + shape(level + 1)[axis]]
        control_points = np.moveaxis(fine, 0, axis)
    return np.ascontiguousarray(control_points)


def nodes(level: int) -> FloatArray:
    """Corners of the cells in the stored quarter of the cube: (a, b, c, 3) float64 in [0, 1]."""
    m = cells(level)
    outer, whole = np.arange((m + 1) // 2, m + 1) / m, np.arange(m + 1) / m
    return np.stack(np.meshgrid(outer, whole, outer, indexing="ij"), axis=-1)


def interpolate(values: FloatArray, level: int) -> FloatArray:
    """The control points of the natural cubic spline through values at the nodes.

    Parameters
    ----------
    values : (a, b, c, channels) float64
        At `nodes(level)`; the symmetries give those at the mirror images.

    Returns
    -------
    shape(level) + (channels,) float64

    Examples
    --------
    >>> values = np.random.default_rng(1).random((3, 5, 3, 1))
    >>> at_nodes = evaluate(interpolate(values, 2), 2, nodes(2).reshape(-1, 3))
    >>> bool(np.allclose(at_nodes, values.reshape(-1, 1)))
    True
    """
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
def representative(level: int) -> IntArray:
    """For each stored control point, the first of its mirror images in the flattened box, or itself: shape(level) int.
    """
    box, start = np.array(shape(level)), np.array(origin(level))
    point = np.moveaxis(np.indices(shape(level)), 0, -1) + start
    first = np.full(box, box.prod())
    for signs, shift in (([1, 1, 1], [0, 0, 0]), ([1, 1, -1], [0, 0, 1]), ([-1, -1, 1], [1, 1, 0]),
                         ([-1, -1, -1], [1, 1, 1])):
        image = point * signs + np.array(shift) * cells(level) - start
        inside = ((image >= 0) & (image < box)).all(axis=-1)
        flat = (image[..., 0] * box[1] + image[..., 1]) * box[2] + image[..., 2]
        first = np.where(inside, np.minimum(first, flat), first)
    return first


def reachable(level: int) -> BoolArray:
    """Whether any pair of directions reads a stored control point: shape(level) bool.

    ``(kappa_o, lambda_o)`` lies in a disk, so the corners of the box are never read.

    Examples
    --------
    >>> around_normal, corner = reachable(4)[0, 9, 1], reachable(4)[0, 0, -1]
    >>> bool(around_normal), bool(corner)
    (True, False)
    """
    m = cells(level)
    _, rows, columns = shape(level)
    _, first_row, first_column = origin(level)
    row = first_row + np.arange(rows)
    column = first_column + np.arange(columns)
    # control point j is read over [j - 2, j + 2] / M: the least distance of that from the disk's centre, in cells
    in_kappa = np.maximum(0, np.abs(row - m / 2) - 2)
    in_lambda = np.maximum(0, column - 2 - m / 2)
    disk = np.hypot(in_kappa[:, None], in_lambda) < m / 2
    return np.broadcast_to(disk, shape(level))

"""A thin-plate spline of the logarithm of reflectance: the interpolant of scattered data that needs no model.

J. Duchon: Splines Minimizing Rotation-Invariant Semi-Norms in Sobolev Spaces, 1977, by SciPy's `RBFInterpolator` in
half and difference coordinates mu: f = exp(p(mu) + sum_k a_k |mu - mu_k|^2 log |mu - mu_k|) - offset. Its
smoothing is that of a few which predicts best what is held out of an inner fit.
The solution takes the cube of the number of samples: of more than `MOST` the spline takes those that lie farthest
apart.
"""

from collections.abc import Callable
from dataclasses import dataclass
from functools import partial

import numpy as np
from scipy.interpolate import RBFInterpolator

from fitter.arrays import ArrayLike, FloatArray, IntArray
from fitter.coordinates.half_difference import HalfDifference
from fitter.model.transform import LEAST_OFFSET, bounded_log
from fitter.quality.cross_validation import cross_validate
from fitter.samples import Samples, choice, subset

from . import ceiling

MOST = 3000                 # samples of an exact solution
OFFSET = 0.1                # of the logarithm, over the median of the samples: .01 to 10 tried on CURET's odd samples
SMOOTHINGS = (1e-6, 1e-4, 1e-3, 1e-2, 1e-1, 1.0)       # the first for one that no rounding can make singular
INNER_FOLDS = 5
_CANDIDATES = 50_000       # samples among which those that lie farthest apart are looked for
_SEED = 1977                # of the inner folds
_FLAT = 1e-6                # extent of a coordinate, over the largest, below which the samples do not determine it


@dataclass(frozen=True)
class ThinPlate:
    """A fitted model."""

    spline: Callable[[FloatArray], FloatArray]      # coordinates (n, axes) to (n, channels)
    centre: FloatArray      # (3,), the mean of the coordinates of the samples
    axes: FloatArray        # (3, axes), orthogonal, in which they differ; all, unless they lie in a plane or on a line
    count: int              # of samples that the spline holds
    offset: float           # 1/sr
    ceiling: FloatArray     # (channels,), the largest value, 1/sr

    @property
    def coefficient_count(self) -> int:
        """Coefficients a channel: one a sample, and those of the polynomial."""
        return self.count + 1 + self.axes.shape[1]

    @property
    def nbytes(self) -> int:
        """Bytes of the coordinates of the samples, and of the coefficients of all channels, in single precision."""
        return 4 * (self.count * self.axes.shape[1] + self.coefficient_count * len(self.ceiling))

    def evaluate(self, theta_i: ArrayLike, phi_i: ArrayLike, theta_o: ArrayLike, phi_o: ArrayLike) -> FloatArray:
        """The BRDF, 1/sr: angles broadcast to (...), radians, to (..., channels) float64."""
        mu = _coordinates(theta_i, phi_i, theta_o, phi_o)
        field = self.spline(((mu - self.centre) @ self.axes).reshape(-1, self.axes.shape[1]))
        with np.errstate(over="ignore"):
            values = np.exp(field) - self.offset
        return np.clip(values, 0, self.ceiling).reshape(*mu.shape[:-1], -1)


def fit(samples: Samples) -> ThinPlate:
    """Fit all channels of samples, with the smoothing that predicts best.

    Examples
    --------
    The spline of a surface that reflects the same everywhere does.

    >>> theta = np.linspace(0.1, 1.4, 20)
    >>> white = Samples(theta, 0 * theta, theta[::-1], 2 * theta, np.full((20, 1), 0.3))
    >>> fit(white).evaluate(0.5, 0, 0.2, 1).round(9).tolist()
    [0.3]
    """
    samples = subset(samples, spread(places(samples), MOST))
    if len(samples) < INNER_FOLDS:
        return fit_smoothed(samples, SMOOTHINGS[0])
    errors = [cross_validate(samples, partial(fit_smoothed, smoothing=smoothing), INNER_FOLDS, _SEED).cube_root_rmse
              for smoothing in SMOOTHINGS]
    return fit_smoothed(samples, SMOOTHINGS[int(np.argmin(errors))])


def fit_smoothed(samples: Samples, smoothing: float) -> ThinPlate:
    """Fit all channels of at most `MOST` samples with one smoothing: the weight of roughness against deviations."""
    mu = _coordinates(*samples.directions)
    centre = mu.mean(axis=0)
    _, extents, axes = np.linalg.svd(mu - centre, full_matrices=False)
    axes = axes[extents > _FLAT * extents[0]].T
    offset = _offset(samples.values)
    spline = RBFInterpolator((mu - centre) @ axes, bounded_log(samples.values, offset), smoothing=smoothing,
                             kernel="thin_plate_spline")
    return ThinPlate(spline, centre, axes, len(samples), offset, ceiling(samples.values))


def places(samples: Samples) -> FloatArray:
    """Where samples are: coordinates and height, which keeps a peak among many samples: (n, 4)."""
    height = bounded_log(samples.values, _offset(samples.values)).mean(axis=1)
    return np.column_stack([_coordinates(*samples.directions), height / max(float(np.ptp(height)), 1.0)])


def _offset(values: FloatArray) -> float:
    """The offset of the logarithm, 1/sr: positive."""
    magnitude = np.abs(values)
    return float(max(OFFSET * np.median(magnitude), 1e-6 * magnitude.max(), LEAST_OFFSET))


def _coordinates(theta_i: ArrayLike, phi_i: ArrayLike, theta_o: ArrayLike, phi_o: ArrayLike) -> FloatArray:
    """Half and difference coordinates mu: angles broadcast to (...), radians, to (..., 3)."""
    return 2 * HalfDifference().encode(theta_i, phi_i, theta_o, phi_o) - 1


def spread(points: FloatArray, most: int) -> IntArray:
    """Indices of at most `most` of points (n, axes), each in turn the farthest from those before, in ascending order.

    Examples
    --------
    >>> spread(np.array([[0.0], [0.1], [1.0], [0.4]]), 3).tolist()
    [0, 2, 3]
    """
    if len(points) <= most:
        return np.arange(len(points))
    candidates = choice(len(points), _CANDIDATES)
    points = points[candidates]
    chosen = np.zeros(most, dtype=int)
    distance = np.full(len(points), np.inf)
    for k in range(1, most):
        distance = np.minimum(distance, ((points - points[chosen[k - 1]]) ** 2).sum(axis=1))
        chosen[k] = np.argmax(distance)
    return np.asarray(candidates[np.sort(chosen)])

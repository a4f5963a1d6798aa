"""Regression kriging: a microfacet model, a Gaussian process of its residuals, and splines that store the result.

In geostatistics, regression kriging is a regression whose residuals are interpolated by a Gaussian process (T. Hengl,
G. B. M. Heuvelink, D. G. Rossiter: About regression-kriging, Computers & Geosciences 33(10), 2007). Here it has five
steps:

1. Fit the prior, a microfacet model, to the samples (`prior`).
2. Interpolate the field of `LogRelative`, the samples' log-ratio to the prior, over half and difference coordinates
   (`gaussian_process`).
3. Interpolate that field by the dense lattice, which so has values where there are no samples.
4. Fit the sparse lattice to the residuals at the samples, by weighted least squares (`lattice.least_squares`).
5. Where the fit reflects more light than it receives, lower the field and fit again (`energy`).

The prior is a Lambertian where there are too few samples to determine lobes.
"""

from dataclasses import replace
from typing import Any

import numpy as np

from ..arrays import BoolArray, Directions, FloatArray
from ..coordinates.half_difference import SOFTENING, HalfDifference
from ..lattice import dense, least_squares
from ..lattice.dense import DenseLattice
from ..lattice.sparse import SparseLattice
from ..model.fit import Fit
from ..model.transform import LEAST_OFFSET, LogRelative
from ..samples import Samples, subset
from . import energy, gaussian_process, prior
from .levels import Levels

CEILING = 4.0               # a fit is at most 4 times the largest sample
_DROPOUT_NOISE = 10.0       # variance, relative to the field's: a dropout hardly influences the field
_LEAST_FOR_LOBES = 500      # samples: from fewer, a prior with lobes predicts worse than a Lambertian
_AZIMUTHS = 16              # averaged over at exact retro-reflection
_ROUNDS = 3                 # of weighted least squares
_MOST_SAMPLES = 20_000      # fitted by the sparse lattice; larger sets are subsampled at random


class Estimate:
    """The prior and the interpolated field of samples: most of the work, which fits of several levels share.

    Parameters
    ----------
    samples : Samples
    softening : float
        The softening radius delta of `half_difference`.

    Attributes
    ----------
    transform : LogRelative
    coordinates : HalfDifference
    field : gaussian_process.Field
        Over 2 x - 1 of the coordinates x.
    """

    def __init__(self, samples: Samples, softening: float = SOFTENING) -> None:
        self.coordinates = HalfDifference(softening)
        used = subset(samples, gaussian_process.choice(len(samples)))
        offset = _offset(used.values)
        ceiling = CEILING * np.maximum(samples.values.max(axis=0), 1e-6 * offset)
        model, noise = prior.lambertian(used.values), np.full(len(used), gaussian_process.NOISE)
        if len(used) >= _LEAST_FOR_LOBES and np.ptp(used.values):
            model = prior.fit(used, offset)
            lobes = model.evaluate(*used.directions)
            noise[_dropouts(used.values, lobes)] = _DROPOUT_NOISE
        self.transform = LogRelative(model, offset, ceiling)
        self.field = gaussian_process.krige(2 * self.coordinates.encode(*used.directions) - 1,
                                            self.transform.field(used.values, *used.directions), noise)
        self._at_nodes: dict[int, tuple[Directions, FloatArray]] = {}

    def at_nodes(self, level: int) -> tuple[Directions, FloatArray]:
        """The nodes of the dense lattice of a level.

        Returns
        -------
        directions : four (a, b, c) float64
            Of the nodes, radians.
        field : (a, b, c, channels) float64
        """
        if level not in self._at_nodes:
            nodes = dense.nodes(level)
            values = self.field.at(2 * nodes.reshape(-1, 3) - 1).reshape(*nodes.shape[:-1], -1)
            if level > 0:
                values[0] = _azimuthal_mean(self.field, 2 * nodes[0] - 1)
            self._at_nodes[level] = self.coordinates.decode(nodes), values
        return self._at_nodes[level]


def prepare(samples: Samples) -> dict[str, Any]:
    """The options of `fit` that do not depend on the levels."""
    return {"estimated": Estimate(samples)}


def fit(samples: Samples, levels: Levels, plausible: bool = True, estimated: Estimate | None = None) -> Fit:
    """Fit samples by regression kriging.

    Parameters
    ----------
    samples : Samples
    levels : Levels
    plausible : bool
        Make the fit nowhere negative, with a directional albedo of at most 1. `Fit.changes` says what that changed.
    estimated : Estimate, optional
        Of these samples, if it was made before.

    Returns
    -------
    Fit

    Examples
    --------
    A single measurement says nothing of other directions, so the fit is a Lambertian:

    >>> one = Samples([0.5], [0], [0.5], [0], [[0.2]])
    >>> float(fit(one, Levels(2, 3, 99.0)).evaluate(0, 0, 1.2, 2)[0])
    0.2
    """
    estimated = estimated or Estimate(samples)
    transform = replace(estimated.transform, floor=0.0) if plausible else estimated.transform
    used = subset(samples, gaussian_process.choice(len(samples), _MOST_SAMPLES))
    reduction = energy.Reduction.none(samples.values.shape[1])
    if not plausible:
        return _fit(used, levels, estimated, transform, reduction)

    fitted = _fit(used, levels, estimated, transform, reduction)
    before = albedo = energy.albedo(fitted)
    if energy.conserves(before):
        return fitted
    for _ in range(energy.ROUNDS - 1):
        reduction = reduction.increased(albedo, transform.offset)
        fitted = _fit(used, levels, estimated, transform, reduction)
        albedo = energy.albedo(fitted)
        if energy.conserves(albedo):
            break
    else:
        fitted = energy.with_ceiling(fitted, transform)
        albedo = energy.albedo(fitted)
    return replace(fitted, changes=(energy.description(before, albedo),))


def _fit(samples: Samples, levels: Levels, estimated: Estimate, transform: LogRelative,
         reduction: energy.Reduction) -> Fit:
    """Fit both lattices to the field lowered by a reduction."""
    (node_theta_i, _, node_theta_o, _), values = estimated.at_nodes(levels.diffuse)
    control_points = dense.interpolate(reduction.applied(values, node_theta_i, node_theta_o), levels.diffuse)
    diffuse, specular = DenseLattice(levels.diffuse, control_points.astype(np.float32)), None
    if levels.specular is not None:
        field = transform.field(samples.values, *samples.directions)
        x = estimated.coordinates.encode(*samples.directions)
        specular = _specular(samples, x, transform, reduction.applied(field, samples.theta_i, samples.theta_o),
                             diffuse, levels.specular, levels.kept)
    return Fit(estimated.coordinates, diffuse, specular, transform, levels.dropped, samples.channels,
               name=samples.name, source=samples.source)


def _specular(samples: Samples, x: FloatArray, transform: LogRelative, field: FloatArray, diffuse: DenseLattice,
              level: int, kept: int) -> SparseLattice:
    """Fit the sparse lattice to the residual of the dense one at the samples."""
    coarse = diffuse.evaluate(x)
    residual = field - coarse
    bright = np.maximum(samples.values, 0)
    for _ in range(_ROUNDS):
        # an error of the field causes one of the reflectance in proportion to f + offset; f is the larger of the
        # measured and the fitted value, so that no dark sample is fitted too bright
        weights = np.sqrt(np.mean((bright + transform.offset) ** 2, axis=1))
        specular = least_squares.sparse_fit(x, residual, weights, level, kept)
        fitted = transform.reflectance(coarse + specular.evaluate(x), *samples.directions)
        bright = np.maximum(bright, fitted)
    return specular


def _azimuthal_mean(field: gaussian_process.Field, mu: FloatArray) -> FloatArray:
    """The mean of the field over all azimuths of H: (b, c, 3) to (b, c, channels).

    For the nodes at d = 0, which no pair of directions reaches. They only influence how the fit interpolates between
    samples near retro-reflection; equal values at all azimuths keep it from oscillating there.
    """
    radius, which = np.unique(np.round(np.hypot(mu[..., 1], mu[..., 2]), 9), return_inverse=True)
    angle = (np.arange(_AZIMUTHS) + 0.5) * (np.pi / 2 / _AZIMUTHS)      # a quarter turn: the field is even in x and y
    ring = np.stack([np.zeros((len(radius), _AZIMUTHS)), np.outer(radius, np.cos(angle)),
                     np.outer(radius, np.sin(angle))], axis=-1)
    mean = field.at(ring.reshape(-1, 3)).reshape(len(radius), _AZIMUTHS, -1).mean(axis=1)
    return mean[which.reshape(mu.shape[:-1])]


def _dropouts(values: FloatArray, lobes: FloatArray) -> BoolArray:
    """Samples that are nearly 0 where the lobes are bright, as if the detector had failed: (n,) bool."""
    median = np.median(np.abs(values))
    dark = np.abs(values).max(axis=1) < 0.1 * median
    return dark & (lobes.max(axis=1) > 3 * median)


def _offset(values: FloatArray) -> float:
    """The offset of `LogRelative`: the median of the samples, at least a millionth of the largest; 1/sr."""
    largest = np.abs(values).max()
    return float(max(np.median(np.abs(values)), 1e-6 * largest, LEAST_OFFSET)) if largest else 1.0

"""Regression kriging: a microfacet model explains what it can, a Gaussian process the rest, and splines store the sum.

Regression kriging is the geostatistical name for a regression whose residuals are interpolated by a Gaussian process
(T. Hengl, G. B. M. Heuvelink, D. G. Rossiter: About regression-kriging, Computers & Geosciences 33(10), 2007). Here

1. the prior, a microfacet model, is fitted to the samples (`prior`);
2. what the samples have beyond it, as the field of `LogRelative`, is interpolated over half and difference coordinates
   (`gaussian_process`);
3. the dense lattice interpolates that field, also where there are no samples;
4. the sparse lattice brings the fit to the samples, by weighted least squares (`lattice.least_squares`);
5. where the fit reflects more than it receives, its field is lowered and fitted again (`energy`).

The prior has lobes where the samples are many enough to determine them, and is a Lambertian otherwise.
"""

from dataclasses import replace

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

CEILING = 4.0               # times the largest sample: no estimate is above it
_DROPOUT_NOISE = 10.0       # variance, relative to the field's: such a sample says next to nothing
_SHOWS_LOBES = 500          # fewer samples than these mislead a prior with lobes more often than they help it
_AZIMUTHS = 16              # averaged over at exact retro-reflection
_ROUNDS = 3                 # of weighted least squares
_MOST_SAMPLES = 20_000      # that the sparse lattice is fitted to: of more, a random choice


class Estimate:
    """The prior and the interpolated field of some samples: most of the work, kept for fits of several levels.

    Parameters
    ----------
    samples : Samples
    softening : float
        The softening radius of `half_difference`.

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
        if len(used) >= _SHOWS_LOBES and np.ptp(used.values):
            model = prior.fit(used, offset)
            lobes = model.evaluate(*used.directions)
            noise[_dropouts(used.values, lobes)] = _DROPOUT_NOISE
        self.transform = LogRelative(model, offset, ceiling)
        self.field = gaussian_process.krige(2 * self.coordinates.encode(*used.directions) - 1,
                                            self.transform.field(used.values, *used.directions), noise)
        self._at_nodes: dict[int, tuple[Directions, FloatArray]] = {}

    def at_nodes(self, level: int) -> tuple[Directions, FloatArray]:
        """The directions of the nodes of a dense lattice, (a, b, c) each, and the field there, (a, b, c, channels)."""
        if level not in self._at_nodes:
            nodes = dense.nodes(level)
            values = self.field.at(2 * nodes.reshape(-1, 3) - 1).reshape(*nodes.shape[:-1], -1)
            if level > 0:
                values[0] = _mean_over_azimuths(self.field, 2 * nodes[0] - 1)
            self._at_nodes[level] = self.coordinates.decode(nodes), values
        return self._at_nodes[level]


def fit(samples: Samples, levels: Levels, plausible: bool = True, estimated: Estimate | None = None) -> Fit:
    """Fit samples.

    Parameters
    ----------
    samples : Samples
    levels : Levels
    plausible : bool
        Make the fit nowhere negative, and of a directional albedo of at most 1. `Fit.changes` says what that changed.
    estimated : Estimate, optional
        Of these samples, where it is at hand.

    Returns
    -------
    Fit
    """
    estimated = estimated or Estimate(samples)
    transform = replace(estimated.transform, floor=0.0) if plausible else estimated.transform
    used = subset(samples, gaussian_process.choice(len(samples), _MOST_SAMPLES))
    reduction = energy.Reduction.none(samples.values.shape[1])
    if not plausible:
        return _fit(used, levels, estimated, transform, reduction)

    before = None
    for _ in range(energy.ROUNDS):
        fitted = _fit(used, levels, estimated, transform, reduction)
        albedo = energy.albedo(fitted)
        before = albedo if before is None else before
        if energy.conserves(albedo):
            break
        reduction = reduction.increased(albedo, transform.offset)
    if energy.conserves(before):
        return fitted
    if not energy.conserves(albedo):
        fitted = energy.with_ceiling(fitted, transform)
        albedo = energy.albedo(fitted)
    return replace(fitted, changes=(energy.description(before, albedo),))


def _fit(samples: Samples, levels: Levels, estimated: Estimate, transform: LogRelative,
         reduction: energy.Reduction) -> Fit:
    """The lattices of a field that is lowered by a reduction."""
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
    """The sparse lattice of what the dense one leaves of the field at the samples."""
    coarse = diffuse.evaluate(x)
    residual = field - coarse
    bright = np.maximum(samples.values, 0)
    for _ in range(_ROUNDS):
        # an error of the field is one of the reflectance in proportion to f + offset, with f what is measured or, if
        # that is more, what is fitted: a dark sample must not end bright
        weights = np.sqrt(np.mean((bright + transform.offset) ** 2, axis=1))
        specular = least_squares.sparse_fit(x, residual, weights, level, kept)
        fitted = transform.reflectance(coarse + specular.evaluate(x), *samples.directions)
        bright = np.maximum(bright, fitted)
    return specular


def _mean_over_azimuths(field: gaussian_process.Field, mu: FloatArray) -> FloatArray:
    """The mean of the field over all azimuths of H: (b, c, 3) to (b, c, channels).

    For the nodes at d = 0, which no pair of directions reaches: what they hold only decides what lies between the
    samples around retro-reflection, and there an azimuth that nobody measured must not make the fit oscillate.
    """
    radius, which = np.unique(np.round(np.hypot(mu[..., 1], mu[..., 2]), 9), return_inverse=True)
    angle = (np.arange(_AZIMUTHS) + 0.5) * (np.pi / 2 / _AZIMUTHS)      # the field is even in both: a quarter tells all
    ring = np.stack([np.zeros((len(radius), _AZIMUTHS)), np.outer(radius, np.cos(angle)),
                     np.outer(radius, np.sin(angle))], axis=-1)
    mean = field.at(ring.reshape(-1, 3)).reshape(len(radius), _AZIMUTHS, -1).mean(axis=1)
    return mean[which.reshape(mu.shape[:-1])]


def _dropouts(values: FloatArray, lobes: FloatArray) -> BoolArray:
    """Where an instrument read next to nothing in the midst of a lobe: (n,) bool."""
    median = np.median(np.abs(values))
    dark = np.abs(values).max(axis=1) < 0.1 * median
    return dark & (lobes.max(axis=1) > 3 * median)


def _offset(values: FloatArray) -> float:
    """Of the order of the darker half of the samples, and no less than a millionth of the largest."""
    largest = np.abs(values).max()
    return float(max(np.median(np.abs(values)), 1e-6 * largest, LEAST_OFFSET)) if largest else 1.0

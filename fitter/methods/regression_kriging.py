"""The compact fit: the field of `estimate` in a coarse dense lattice, and in a sparse one what the samples say beyond.

The same two lattices as the paper's, over half and difference coordinates, of the logarithmic field instead of the
reflectance itself. The dense lattice interpolates the field, also where there are no samples; the sparse one brings
the fit to the samples.
"""

from dataclasses import replace

import numpy as np

from ..coordinates.half_difference import SOFTENING, directions, half_difference
from ..lattice import dense, least_squares
from ..quality import cross_validation
from . import energy, gaussian_process
from .prior import estimate

_AZIMUTHS = 16
_ROUNDS = 3
_MOST_SAMPLES = 20_000      # that the sparse lattice is fitted to: beyond, a random choice


class Estimate:
    """What `estimate` makes of samples, kept for fits of several levels: most of the work."""

    def __init__(self, samples, softening=SOFTENING):
        self.softening = softening
        self.prior, self._field = estimate(samples, softening)
        self._at_nodes = {}

    def at_nodes(self, level):
        """The nodes of a dense lattice, and the field there: (a, b, c, 3) and (a, b, c, channels) float64."""
        if level not in self._at_nodes:
            nodes = dense.nodes(level)
            values = self._field.at(2 * nodes.reshape(-1, 3) - 1).reshape(*nodes.shape[:-1], -1)
            if level > 0:
                values[0] = _around(self._field, 2 * nodes[0] - 1)
            self._at_nodes[level] = nodes, values
        return self._at_nodes[level]


def approximate(samples, estimated, diffuse_level, specular_level, kept, plausible, assemble):
    """Fit samples.

    Parameters
    ----------
    samples : Samples
    estimated : Estimate
        Of these samples.
    diffuse_level : int
    specular_level : int or None
    kept : int
        Control points of the sparse lattice.
    plausible : bool
        Nowhere negative, and of directional albedo at most 1.
    assemble : callable
        Makes a `Fit` of the keyword arguments `prior`, `softening`, `diffuse` and `specular`.

    Returns
    -------
    Fit
    """
    samples = cross_validation.subset(samples, gaussian_process.choice(len(samples), _MOST_SAMPLES))
    prior = replace(estimated.prior, floor=0.0) if plausible else estimated.prior
    nodes, values = estimated.at_nodes(diffuse_level)
    node_directions, z = directions(nodes, estimated.softening), prior.field(samples.values, *samples.directions)

    def approximation(taken):
        diffuse = dense.interpolate(values - taken(node_directions[0]) - taken(node_directions[2]), diffuse_level)
        diffuse, specular = diffuse.astype(np.float32), None
        if specular_level is not None:
            target = z - taken(samples.theta_i) - taken(samples.theta_o)
            x = half_difference(*samples.directions, estimated.softening)
            specular = _specular(samples, x, prior, target, diffuse, diffuse_level, specular_level, kept)
        return assemble(prior=prior, softening=estimated.softening, diffuse=diffuse, specular=specular)

    return energy.conserve(approximation, prior.offset, z.shape[1]) if plausible else approximation(lambda theta: 0.0)


def _around(field, mu):
    """The mean of the field over all azimuths of H: (b, c, 3) to (b, c, channels).

    For the nodes at d = 0, which no pair of directions reaches: what they hold decides between the samples around
    retro-reflection only, and there an azimuth that nobody measured must not make the fit turn back and forth.
    """
    radius, which = np.unique(np.round(np.hypot(mu[..., 1], mu[..., 2]), 9), return_inverse=True)
    angle = (np.arange(_AZIMUTHS) + 0.5) * (np.pi / 2 / _AZIMUTHS)      # the field is even in both: a quarter tells all
    ring = np.stack([np.zeros((len(radius), _AZIMUTHS)), np.outer(radius, np.cos(angle)),
                     np.outer(radius, np.sin(angle))], axis=-1)
    mean = field.at(ring.reshape(-1, 3)).reshape(len(radius), _AZIMUTHS, -1).mean(axis=1)
    return mean[which.reshape(mu.shape[:-1])]


def _specular(samples, x, prior, target, diffuse, diffuse_level, level, kept):
    coarse = dense.evaluate(diffuse, diffuse_level, x)
    residual = target - coarse
    bright = np.maximum(samples.values, 0)
    specular = None
    for _ in range(_ROUNDS):
        # an error of the field is one of the reflectance in proportion to f + offset, with f what is measured or, if
        # that is more, what is fitted: a dark sample must not end bright
        weights = np.sqrt(np.mean((bright + prior.offset) ** 2, axis=1))
        specular = least_squares.sparse_fit(x, residual, weights, level, kept)
        fitted = prior.reflectance(coarse + dense.evaluate(specular.dense, level, x), *samples.directions)
        bright = np.maximum(bright, fitted)
    return specular

"""Mixtures of lobes of all kinds, and the density of the directions that the shader samples by a mixture."""

import numpy as np

from fitter.cycles import node_lobes
from fitter.cycles.node_mixture import NodeMixture, Sampling
from fitter.shader_constants import GRAZING

STOPS = 9
KINDS = "diffuse", "GGX", "Beckmann", "sheen", "diffuse", "GGX"


def made_mixture(turn=None, channels=3):
    """A mixture of random numbers that change smoothly with the polar angle, of a fit that is isotropic without a turn.

    Its lobes are wide: sums over a grid of directions are good to a thousandth.
    """
    random = np.random.default_rng(5)
    theta = GRAZING * (1 - np.linspace(1, 0, STOPS) ** 1.5)

    def smooth(low, high, *shape):
        first, last = low + (high - low) * random.random((2, *shape))
        return first + (last - first) * np.linspace(0, 1, STOPS).reshape(-1, *(1 for _ in shape)) ** 2

    lobes = len(KINDS)
    plain = np.arange(lobes) > 0
    tilted = plain & (np.array(KINDS) != "sheen")
    # the viewer must see the normal of each lobe
    tilt = np.maximum(smooth(-0.5, 0.8, lobes), -0.7 * np.cos(theta / 2)[:, None] ** 2) * tilted
    shape = node_lobes.Shape(np.where(plain, smooth(0.45, 0.95, lobes), 1.0), tilt, smooth(-0.6, 0.6, lobes) * plain)
    shares = smooth(0.5, 1.5, lobes + 1)
    colour = smooth(0.05, 0.3, lobes, 1 if turn is None else 2, 3)[..., :channels]
    reflected = (smooth(low, high, channels) for low, high in ((0.5, 1.0), (0.1, 0.4), (0.8, 1.0)))
    sampling = Sampling(0.7 * colour, shares / shares.sum(axis=1, keepdims=True), smooth(0.2, 1.0), *reflected)
    return NodeMixture(KINDS, theta, shape, colour, turn, sampling, 0.0, 0.0, 0.0)


def any_mixture(fit):
    """What may be baked with a fit where only the fit is looked at: to find its own takes seconds."""
    return made_mixture(None if fit.isotropic else 0.0, channels=len(fit.channels))


def density(mixture, wo, wi):
    """With which the shader samples directions wi (n, 3) by a mixture, per solid angle: (n,).

    They and wo (3,) are in the frame of the shader: x is the first principal axis or, of an isotropic fit, toward the
    viewer.
    """
    theta = np.arccos(wo[2])

    def at(values):
        return np.array([np.interp(theta, mixture.theta, column) for column in values.T])

    shape = node_lobes.Shape(*(at(each) for each in mixture.shape))
    pairs = node_lobes.Pairs.make(wo[None], wi[None], np.array([[1.0, 0, 0]]))
    found = [node_lobes.pdf(kind, node_lobes.Shape(*(each[[number]] for each in shape)), pairs)[0]
             for number, kind in enumerate(mixture.kinds)]
    return at(mixture.sampling.selection_probabilities) @ np.array([*found, np.full(len(wi), 1 / (2 * np.pi))])

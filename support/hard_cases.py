"""Samples that are hard to fit, and the requirements for fits to them, for every preset."""

from dataclasses import dataclass

import numpy as np

import fitter
from fitter.formats import curet
from support import checkout

RIGHT = np.pi / 2
# no value of a fit is larger than this many times the largest sample
BOUND = {"Draft": 4.01, "Standard": 4.01, "Reference": 4.01, "Paper": 2.0}
# bound of the RMSE at the samples, over the largest absolute sample, unless a case has its own; Draft has a coarse
# one for narrow features
ERROR = {"Draft": 0.5, "Standard": 0.1, "Reference": 0.1, "Paper": 0.1}


@dataclass(frozen=True)
class Case:
    """Samples, and how a fit to them is judged.

    A fit to samples that reflect more light than there is, or less than none, is judged without being made plausible.
    """

    samples: fitter.Samples
    error: float | None = None      # bound of the RMSE instead of `ERROR`: larger for random values, which are noise
    plausible: bool = True

    def fit(self, preset):
        """The samples fitted."""
        return fitter.fit(self.samples, **fitter.PRESETS[preset], plausible=self.plausible)

    def bound(self, preset):
        """Of the RMSE at the samples, over the largest absolute sample."""
        return ERROR[preset] if self.error is None else self.error


def gloss(theta_i, theta_o, delta_phi):
    """A smooth reflectance: a Lambertian and a lobe about the mirror direction, 1/sr."""
    cosine = np.cos(theta_i) * np.cos(theta_o) - np.sin(theta_i) * np.sin(theta_o) * np.cos(delta_phi)
    return 0.1 + 0.9 * np.maximum(cosine, 0) ** 20


def probe():
    """Directions at which to evaluate fits: a grid with normal, horizon and plane of incidence, and random ones."""
    theta = np.concatenate([[0, 1e-9, 1e-4], np.linspace(0.1, 1.5, 8), [RIGHT - 1e-4, RIGHT]])
    delta_phi = np.concatenate([[0, 1e-6], np.linspace(0.2, 3, 8), [np.pi]])
    grid = [axis.ravel() for axis in np.meshgrid(theta, theta, delta_phi, indexing="ij")]
    scattered = np.random.default_rng(5).random((3, 3000)) * [[RIGHT], [RIGHT], [2 * np.pi]]
    theta_i, theta_o, phi = np.concatenate([grid, scattered], axis=1)
    return theta_i, np.zeros_like(phi), theta_o, phi


def hard_cases():
    """All cases except the million samples: {name: Case}."""
    rng = np.random.default_rng(2002)
    theta_i, theta_o, phi = rng.random((3, 300)) * [[1.5], [1.5], [2 * np.pi]]
    smooth = gloss(theta_i, theta_o, phi)
    plane = np.repeat([0, np.pi], 150)
    from_normal, to_normal = np.where(np.arange(300) % 2, 0, theta_i), np.where(np.arange(300) % 3, theta_o, 0)
    grazing_i, grazing_o = np.where(np.arange(300) % 2, RIGHT, theta_i), np.where(np.arange(300) % 3, theta_o, RIGHT)
    spike = np.full(300, 0.1)
    spike[150] = 1000
    hole = _outside_hole(theta_o, phi)
    geometry = curet.geometry()
    noise = rng.standard_normal(300)
    decades = 10 ** (10 * rng.random(300) - 10)
    single = [angle.astype(np.float32) for angle in (theta_i, theta_o, phi, smooth)]
    cases = {
        "one sample": Case(_samples([0.5], [0.7], [2.0], [0.3]), 1e-5),
        "two values in one direction": Case(_samples([0.5, 0.5], [0.7, 0.7], [2.0, 2.0], [0.2, 0.6]), 0.4),
        "all values equal": Case(_samples(geometry[:, 2], geometry[:, 0], geometry[:, 1] - geometry[:, 3],
                                          np.full(len(geometry), 0.3))),
        "all in the plane of incidence": Case(_samples(theta_i, theta_o, plane, gloss(theta_i, theta_o, plane))),
        "half of them at normal incidence": Case(_samples(from_normal, to_normal, phi,
                                                          gloss(from_normal, to_normal, phi))),
        "half of them at grazing angles": Case(_samples(grazing_i, grazing_o, phi, gloss(grazing_i, grazing_o, phi))),
        "values in single precision": Case(_samples(*single)),
        "values over 10 orders of magnitude": Case(_samples(theta_i, theta_o, phi, decades), 0.5),
        "one value 10,000 times the others": Case(_samples(theta_i, theta_o, phi, spike), plausible=False),
        "retro-reflection only": Case(_samples(theta_i, theta_i, np.zeros(300), 0.03 + 0.25 * np.cos(theta_i))),
        "negative values and zeros": Case(_samples(theta_i, theta_o, phi, np.where(noise > 1, 0, noise)), 1.0, False),
        "nothing but negative values": Case(_samples(theta_i, theta_o, phi, -smooth), 1.0, False),
        "nothing but zeros": Case(_samples(theta_i, theta_o, phi, np.zeros(300))),
        "a hole of 40 degrees": Case(_samples(theta_i[hole], theta_o[hole], phi[hole], smooth[hole])),
        "values near the largest that are taken": Case(_samples(theta_i, theta_o, phi, smooth * 1e29), plausible=False),
        "values near the smallest": Case(_samples(theta_i, theta_o, phi, smooth * 1e-29))}
    cayman = checkout.measurements() / "cornell" / "cayman.astm"
    if cayman.is_file():
        cases["cayman"] = Case(fitter.load(cayman))
    return cases


def many(count=1_000_000):
    """So many random samples of `gloss`."""
    theta_i, theta_o, phi = np.random.default_rng(1).random((3, count)) * [[RIGHT], [RIGHT], [2 * np.pi]]
    return _samples(theta_i, theta_o, phi, gloss(theta_i, theta_o, phi))


def _samples(theta_i, theta_o, phi, values):
    return fitter.Samples(theta_i, np.zeros_like(theta_i), theta_o, phi, np.reshape(values, (-1, 1)))


def _outside_hole(theta_o, phi):
    """Which outgoing directions are 20 degrees or more from one that stands at 45 degrees, away from the light."""
    cosine = np.sin(theta_o) * -np.cos(phi) * np.sqrt(0.5) + np.cos(theta_o) * np.sqrt(0.5)
    return cosine < np.cos(np.radians(20))

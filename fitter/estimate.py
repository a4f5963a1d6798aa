"""What a reflectance is between its samples: a prior, and a smooth field of how far the samples depart from it.

The field is s = log((f + offset) / (b + offset)), with b the prior of `microfacet`: logarithms make a peak no more
than a hill, keep the reflectance positive, and ask for relative rather than absolute accuracy. Which prior and which
kernel describe a material is decided by cross-validation.
"""

from dataclasses import dataclass
from itertools import product

import numpy as np

from . import cross_validation, half_difference, kriging, microfacet

LENGTHS = ((0.3, 0.1), (0.3, 0.3), (1.0, 0.3), (1.0, 1.0))  # along |D| and across, in coordinates from -1 to 1
NOISES = (1e-4, 1e-2, 1e-1)
CEILING = 16.0              # an estimate is at most this often the largest sample
_FEW = 10                   # samples that are too few to choose by
_JUDGED = 500               # samples that are enough to choose by


@dataclass(frozen=True)
class Prior:
    """What turns the field s into a reflectance.

    Attributes
    ----------
    lobe : microfacet.Microfacet
    offset : float
        1/sr: reflectance well below it counts as dark.
    ceiling : (channels,) float64
        1/sr: no value is above it.
    """

    lobe: microfacet.Microfacet
    offset: float
    ceiling: np.ndarray

    @property
    def nbytes(self):
        """Bytes of the parameters in single precision."""
        return self.lobe.nbytes + 4 + 4 * len(self.ceiling)

    def reflectance(self, s, theta_i, phi_i, theta_o, phi_o):
        """Reflectance of a field: (n, channels) to (n, channels), 1/sr, not negative."""
        around = self.lobe.evaluate(theta_i, phi_i, theta_o, phi_o) + self.offset
        return np.clip(around * np.exp(np.minimum(s, 80)) - self.offset, 0, self.ceiling)

    def field(self, values, theta_i, phi_i, theta_o, phi_o):
        """The field that gives reflectances: (n, channels) 1/sr to (n, channels)."""
        around = self.lobe.evaluate(theta_i, phi_i, theta_o, phi_o)
        return microfacet.compress(values, self.offset) - microfacet.compress(around, self.offset)


def estimate(samples):
    """The prior, and the field by kernel regression.

    Parameters
    ----------
    samples : Samples

    Returns
    -------
    prior : Prior
    field : kriging.Field
    """
    used = cross_validation.subset(samples, kriging.choice(len(samples)))
    offset = _offset(used.values)
    ceiling = CEILING * np.maximum(samples.values.max(axis=0), 1e-6 * offset)
    kernel = kriging.Kernel(0.3, 0.3, 1e-4)
    lobe = microfacet.lambertian(used.values)
    if len(used) >= _FEW and np.ptp(used.values):
        fitted = microfacet.fit(used, offset)
        kernel, has_lobe = _choose(cross_validation.subset(used, kriging.choice(len(used), _JUDGED)), offset, fitted)
        lobe = fitted if has_lobe else lobe
    prior = Prior(lobe, offset, ceiling)
    return prior, kriging.krige(_mu(used), prior.field(used.values, *used.directions), kernel)


def _choose(samples, offset, fitted):
    """The kernel, and whether there is a lobe, that predict held-out samples best."""
    mu, parts = _mu(samples), cross_validation.folds(len(samples))
    predicted = {}
    for part in parts:
        seen = np.ones(len(samples), dtype=bool)
        seen[part] = False
        training, held = cross_validation.subset(samples, seen), cross_validation.subset(samples, part)
        priors = [Prior(lobe, offset, np.full(samples.values.shape[1], np.inf)) for lobe in
                  (microfacet.lambertian(training.values), microfacet.fit(training, offset, fitted))]
        # one kernel matrix serves all noises, one solution both priors
        z = np.concatenate([prior.field(training.values, *training.directions) for prior in priors], axis=1)
        for lengths in LENGTHS:
            kernel = kriging.Kernel(*lengths, 0.0)
            matrix, cross = kernel.matrix(mu[seen], mu[seen]), kernel.matrix(mu[part], mu[seen])
            for noise in NOISES:
                field = np.hsplit(cross @ np.linalg.solve(matrix + noise * np.eye(len(matrix)), z), 2)
                for which, (prior, s) in enumerate(zip(priors, field, strict=True)):
                    store = predicted.setdefault((lengths, noise, which), np.empty(samples.values.shape))
                    store[part] = prior.reflectance(s, *held.directions)
    best = min(product(LENGTHS, NOISES, (0, 1)), key=lambda choice: _score(samples, predicted[choice]))
    (along, across), noise, which = best
    return kriging.Kernel(along, across, noise), bool(which)


def _score(samples, predicted):
    """The product of the two held-out errors."""
    return np.prod(cross_validation.errors(samples, predicted))


def _offset(values):
    """Of the order of the darker half of the samples, and no less than a millionth of the largest."""
    largest = np.abs(values).max()
    return float(max(np.median(np.abs(values)), 1e-6 * largest)) or 1.0


def _mu(samples):
    return 2 * half_difference.half_difference(*samples.directions) - 1

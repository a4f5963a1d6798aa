"""What a reflectance is between its samples: a prior, and a smooth field of how far the samples depart from it.

The field is s = log((f + offset) / (b + offset)), with b the prior of `microfacet`: logarithms make a peak no more
than a hill, keep the reflectance positive, and ask for relative rather than absolute accuracy. The prior has lobes
where the samples are many enough to determine them, and is a Lambertian otherwise.
"""

from dataclasses import dataclass

import numpy as np

from . import cross_validation, kriging, microfacet
from .half_difference import SOFTENING, half_difference
from .shader_constants import STEEPEST

CEILING = 4.0               # an estimate is at most this often the largest sample
_DROPOUT_NOISE = 10.0       # relative to the field's variance: such a sample says next to nothing
LEAST_OFFSET = 1e-30        # 1/sr: no reflectance is as dark, and in single precision it is a number yet
_SHOWS_LOBES = 500          # samples that determine the lobes of a prior; fewer mislead more often than they help


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
    floor : float
        1/sr: no value is below it; 0, or less where noise around 0 shall stay what it is.
    """

    lobe: microfacet.Microfacet
    offset: float
    ceiling: np.ndarray
    floor: float = -np.inf

    @property
    def nbytes(self):
        """Bytes of the parameters in single precision."""
        return self.lobe.nbytes + 8 + 4 * len(self.ceiling)

    def reflectance(self, s, theta_i, phi_i, theta_o, phi_o):
        """Reflectance of a field: (n, channels) to (n, channels), 1/sr."""
        around = self.lobe.evaluate(theta_i, phi_i, theta_o, phi_o) + self.offset
        return np.clip(around * np.exp(np.minimum(s, STEEPEST)) - self.offset, self.floor, self.ceiling)

    def field(self, values, theta_i, phi_i, theta_o, phi_o):
        """The field that gives reflectances: (n, channels) 1/sr to (n, channels)."""
        around = self.lobe.evaluate(theta_i, phi_i, theta_o, phi_o)
        return microfacet.compress(values, self.offset) - microfacet.compress(around, self.offset)


def estimate(samples, softening=SOFTENING):
    """The prior, and the field by kernel regression.

    Parameters
    ----------
    samples : Samples
    softening : float
        The radius of `half_difference`.

    Returns
    -------
    prior : Prior
    field : kriging.Field
    """
    used = cross_validation.subset(samples, kriging.choice(len(samples)))
    offset = _offset(used.values)
    ceiling = CEILING * np.maximum(samples.values.max(axis=0), 1e-6 * offset)
    lobe, noise = microfacet.lambertian(used.values), np.full(len(used), kriging.NOISE)
    if len(used) >= _SHOWS_LOBES and np.ptp(used.values):
        lobe = microfacet.fit(used, offset)
        noise[_dropouts(used, lobe)] = _DROPOUT_NOISE
    prior = Prior(lobe, offset, ceiling)
    return prior, kriging.krige(_mu(used, softening), prior.field(used.values, *used.directions), noise)


def _dropouts(samples, lobe):
    """Where an instrument read next to nothing in the midst of a lobe: (n,) bool."""
    median = np.median(np.abs(samples.values))
    dark = np.abs(samples.values).max(axis=1) < 0.1 * median
    return dark & (lobe.evaluate(*samples.directions).max(axis=1) > 3 * median)


def _offset(values):
    """Of the order of the darker half of the samples, and no less than a millionth of the largest."""
    largest = np.abs(values).max()
    return float(max(np.median(np.abs(values)), 1e-6 * largest, LEAST_OFFSET)) if largest else 1.0


def _mu(samples, softening):
    return 2 * half_difference(*samples.directions, softening) - 1

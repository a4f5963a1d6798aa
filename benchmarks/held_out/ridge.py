"""Energy and colour along the ridge of mirror directions: does a highlight fade or change between measured incidences?

The energy at an angle of incidence is the integral of f cos theta_o over the cone of `HALF_ANGLE` about the mirror
direction, as far as it is above the horizon: what a lamp puts into its highlight.
"""

import numpy as np

HALF_ANGLE = np.radians(10)
INCIDENCES = np.radians(np.arange(0, 86, 1.25))
_NODES, _AZIMUTHS = 24, 12
_LEAST = 10                 # samples at one incidence, for it to be a measured one
_MOST = 20                  # measured incidences; more are no grid


def energy(model, theta_i):
    """The energy of highlights: angles (n,), radians, to (n, channels).

    Examples
    --------
    Of a Lambertian seen from above, f pi sin^2 of the half angle.

    >>> from fitter.methods import prior
    >>> found = energy(prior.lambertian(np.array([[0.5]])), np.array([0.0]))
    >>> float(found[0, 0] / (0.5 * np.pi * np.sin(HALF_ANGLE) ** 2))
    1.00000
    """
    nodes, weights = np.polynomial.legendre.leggauss(_NODES)
    u = (nodes + 1) / 2
    away = HALF_ANGLE * u ** 2              # close to the axis, where narrow lobes are
    around = (np.arange(_AZIMUTHS) + 0.5) * np.pi / _AZIMUTHS       # the other half is its mirror image
    weight = (weights * HALF_ANGLE * u * np.sin(away))[:, None] * np.full(_AZIMUTHS, 2 * np.pi / _AZIMUTHS)
    x, y, z = (np.sin(away)[:, None] * np.cos(around), np.sin(away)[:, None] * np.sin(around),
               np.cos(away)[:, None] * np.ones(_AZIMUTHS))
    sin_i, cos_i = (function(theta_i)[:, None, None] for function in (np.sin, np.cos))
    # the mirror direction is at azimuth pi; in these coordinates at 0, and the light at pi
    ahead, up = cos_i * x + sin_i * z, cos_i * z - sin_i * x
    above = up > 1e-6
    theta_o, phi_o = np.arccos(np.clip(up, 1e-6, 1)), np.arctan2(y, ahead)
    value = np.maximum(model.evaluate(theta_i[:, None, None], np.pi, theta_o, phi_o), 0)
    return np.einsum("ijkc,ijk,jk->ic", value, np.where(above, up, 0), weight)


def measured(samples):
    """The angles of incidence, radians, at which samples were taken on a grid: (n,), empty if they are scattered."""
    degrees, counts = np.unique(np.degrees(samples.theta_i).round(1), return_counts=True)
    found = np.radians(degrees[counts >= _LEAST])
    return found if len(found) <= _MOST else found[:0]

"""A ring about retro-reflection: what fits invent within 5 degrees of it, where most instruments hide the lamp."""

import numpy as np

DEGREES = 10, 20, 30, 45, 60, 70
_AROUND, _WITHIN = (5, 6, 7, 8, 9), (0.25, 0.5, 1, 1.5, 2, 2.5, 3, 4)         # degrees from retro-reflection
_AZIMUTHS = (np.arange(16) + 0.5) * np.pi / 8


def ring(fit):
    """By how much a fit within 4 degrees of retro-reflection is off the paraboloid through it at 5 to 9 degrees: the
    largest ratio less 1, of any of `DEGREES` of incidence, of the mean over channels."""
    worst = 0.0
    for theta in np.radians(DEGREES):
        around, within = (_paraboloid_terms(fit, theta, np.radians(degrees)) for degrees in (_AROUND, _WITHIN))
        paraboloid = np.linalg.lstsq(around[0], around[1], rcond=None)[0]
        ratio = np.maximum(within[1], 1e-9) / np.maximum(within[0] @ paraboloid, 1e-9)
        worst = max(worst, float(np.abs(np.log(ratio)).max()))
    return np.exp(worst) - 1


def _paraboloid_terms(fit, theta, radii):
    """Terms of a paraboloid in the offsets from the direction (theta, 0), (n, 4), and the fit there, (n,)."""
    radius, azimuth = (grid.ravel() for grid in np.meshgrid(radii, _AZIMUTHS))
    x, y, z = np.sin(radius) * np.cos(azimuth), np.sin(radius) * np.sin(azimuth), np.cos(radius)
    x, z = np.cos(theta) * x + np.sin(theta) * z, np.cos(theta) * z - np.sin(theta) * x
    found = fit.evaluate(theta, 0.0, np.arctan2(np.hypot(x, y), z), np.arctan2(y, x)).mean(axis=-1)
    along, across = radius * np.cos(azimuth), radius * np.sin(azimuth)
    return np.stack([np.ones_like(along), along, along ** 2, across ** 2], axis=1), found

"""Anisotropic materials of one lobe, and grids of directions in which instruments measure them: truths for tests.

Functions of four angles, (n,) radians each to (n, 3) float64, 1/sr; phi = 0 is the tangent.
"""

import numpy as np

from . import anisotropic

COLOUR = np.array([1.0, 0.8, 0.5])


def unit(theta, phi):
    """Unit vectors: (3, n)."""
    return np.stack([np.sin(theta) * np.cos(phi), np.sin(theta) * np.sin(phi), np.cos(theta)])


def ggx(along=0.12, across=0.45, diffuse=0.1, turn=0.0, specular=1.0):
    """A GGX lobe of two roughnesses on a Lambertian; the frame is turned by `turn` radians."""
    return _on_lambertian(anisotropic.ggx, along, across, diffuse, turn, specular)


def ward(along=0.1, across=0.3, diffuse=0.2, turn=0.0, specular=1.2):
    """The same of Ward's lobe."""
    return _on_lambertian(anisotropic.ward, along, across, diffuse, turn, specular)


def _on_lambertian(lobe, along, across, diffuse, turn, specular):
    def function(*directions):
        wi, wo = (anisotropic.turned(w, turn) for w in anisotropic.vectors(*directions))
        return np.outer(diffuse / np.pi + specular * lobe(wi, wo, along, across), COLOUR)
    return function


def grid(theta_i, phi_i, theta_o, apart):
    """All combinations of angles in degrees, of which `apart` is phi_o - phi_i: four (n,), radians."""
    axes = np.meshgrid(*(np.radians(np.asarray(axis, float)) for axis in (theta_i, phi_i, theta_o, apart)),
                       indexing="ij")
    theta_i, phi_i, theta_o, apart = (axis.ravel() for axis in axes)
    return theta_i, phi_i, theta_o, phi_i + apart


def goniometer(rotations=range(0, 360, 15)):
    """Directions of a goniometer that turns the sample: 75 to 15 degrees of incidence, 9 x 18 outgoing directions."""
    return grid(range(15, 76, 15), rotations, range(0, 81, 10), range(0, 360, 20))


def scattered(count, random):
    """Directions anywhere above 10 degrees from the horizon: four (count,), radians."""
    share = random.random((4, count))
    return (np.arcsin(np.sqrt(0.97 * share[0])), 2 * np.pi * share[1], np.arcsin(np.sqrt(0.97 * share[2])),
            2 * np.pi * share[3])

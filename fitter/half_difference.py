"""Half and difference coordinates of a pair of directions, in a projection that spreads grazing angles.

Each direction is projected to a point of the unit disk at the radius ``r(theta) = sin theta / (1 + 2 cos theta)``:
as smooth at the normal as the Nusselt projection sin theta, but with room at grazing angles, where measured reflectance
changes fastest. Of the two points q_i and q_o the half vector H = (q_i + q_o) / 2 and the difference
D = (q_i - q_o) / 2 are taken, seen from the frame whose x axis is D (after S. Rusinkiewicz: A New Change of Variables
for Efficient BRDF Representation, 1998, whose half angle and difference angle they stand for) ::

    mu = (|D|, H_x, |H_y|)

A mirror lobe lies along the axis H = 0 whatever the angle of incidence, normal incidence is a point like any other, and
exchanging the two directions only changes the sign of H_x. The image has the symmetries and the bounds of Nusselt
coordinates, so that the same lattices serve both.
"""

import numpy as np


def half_difference(theta_i, phi_i, theta_o, phi_o):
    """Coordinates of direction pairs: angles broadcast to (...), radians, to (..., 3) in [0, 1].

    (mu + 1) / 2, as `nusselt.nusselt` scales its own: the first and the third are at least 1/2.
    """
    q_i, q_o = (project(theta) * np.exp(1j * np.asarray(phi, dtype=float))
                for theta, phi in ((theta_i, phi_i), (theta_o, phi_o)))
    half, difference = (q_i + q_o) / 2, (q_i - q_o) / 2
    length = np.abs(difference)
    # where the directions coincide their difference has no azimuth: that of the half vector stands in
    axis = np.where(length > 1e-7, difference, np.where(np.abs(half) > 1e-7, half, 1))
    seen = half * np.conj(axis) / np.abs(axis)
    return (np.stack([length, seen.real, np.abs(seen.imag)], axis=-1) + 1) / 2


def directions(coordinates):
    """The inverse of `half_difference`, up to a turn about the normal: (..., 3) to four (...) arrays, radians.

    Coordinates outside the image are taken for the nearest rim.
    """
    length, x, y = np.moveaxis(2 * np.asarray(coordinates, dtype=float) - 1, -1, 0)
    half = x + 1j * y
    q_i, q_o = half + length, half - length
    return _theta(np.abs(q_i)), np.angle(q_i), _theta(np.abs(q_o)), np.angle(q_o)


def project(theta):
    """Radius of a direction's projection, r(theta): radians to [0, 1]."""
    theta = np.asarray(theta, dtype=float)
    return np.sin(theta) / (1 + 2 * np.cos(theta))


def _theta(radius):
    """The angle whose radius this is: with t = tan(theta / 2), r = 2 t / (3 - t^2)."""
    radius = np.minimum(radius, 1)
    return 2 * np.arctan(3 * radius / (1 + np.sqrt(1 + 3 * radius * radius)))

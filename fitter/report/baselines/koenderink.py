"""Koenderink's representation: products of Zernike polynomials on the two hemispheres.

J. J. Koenderink, A. J. van Doorn, M. Stavridi: Bidirectional Reflection Distribution Function Expressed in Terms of
Surface Scattering Modes, ECCV 1996. An isotropic, bilaterally symmetric and reciprocal reflectance is ::

    f = sum a_nml [R_n^l(r_i) R_m^l(r_o) + R_m^l(r_i) R_n^l(r_o)] cos(l delta_phi),    r = sqrt(2) sin(theta / 2)

over n >= m >= l >= 0 with n - l and m - l even and n <= order: 5 parameters at order 2, 55 at order 8. The paper's
first baseline, fitted by linear least squares.
"""

from dataclasses import dataclass
from math import factorial

import numpy as np

ORDER = 8


@dataclass(frozen=True)
class Koenderink:
    """A fitted reflectance.

    Attributes
    ----------
    order : int
    coefficients : (modes(order), channels) float64
    """

    order: int
    coefficients: np.ndarray

    @property
    def coefficient_count(self):
        """Parameters a channel."""
        return len(self.coefficients)

    @property
    def nbytes(self):
        """Bytes of the parameters of all channels in single precision."""
        return 4 * self.coefficients.size

    def evaluate(self, theta_i, phi_i, theta_o, phi_o):
        """The fitted BRDF, 1/sr: angles (n,) in radians to (n, channels) float64."""
        return design_matrix(self.order, theta_i, phi_i, theta_o, phi_o) @ self.coefficients


def fit(samples, order=ORDER):
    """Fit a measured reflectance by linear least squares, all channels at once.

    Parameters
    ----------
    samples : Samples
    order : int

    Returns
    -------
    Koenderink
    """
    matrix = design_matrix(order, *samples.directions)
    coefficients, *_ = np.linalg.lstsq(matrix, samples.values, rcond=None)
    return Koenderink(order, coefficients)


def modes(order):
    """The indices of the parameters: a list of (n, m, l)."""
    return [(n, m, l) for n in range(order + 1) for m in range(n + 1) for l in range(m + 1)
            if (n - l) % 2 == 0 and (m - l) % 2 == 0]


def zernike_radial(n, l, r):
    """The Zernike radial polynomial R_n^l, whose integral of R_n^l R_m^l r dr over 0 to 1 is 1 / (2 n + 2) or 0.

    Parameters
    ----------
    n, l : int
        n - l even and not negative.
    r : array_like
    """
    r = np.asarray(r, dtype=float)
    half = (n - l) // 2
    return sum((-1) ** k * factorial(n - k) / (factorial(k) * factorial((n + l) // 2 - k) * factorial(half - k))
               * r ** (n - 2 * k) for k in range(half + 1))


def design_matrix(order, theta_i, phi_i, theta_o, phi_o):
    """The basis functions at direction pairs: (n,) angles to (n, parameters)."""
    r_i, r_o = (np.sqrt(2) * np.sin(np.asarray(theta, dtype=float) / 2) for theta in (theta_i, theta_o))
    delta_phi = np.asarray(phi_o, dtype=float) - phi_i
    radial = {(n, l): (zernike_radial(n, l, r_i), zernike_radial(n, l, r_o)) for n, _, l in modes(order)}
    columns = []
    for n, m, l in modes(order):
        (n_i, n_o), (m_i, m_o) = radial[n, l], radial[m, l]
        columns.append((n_i * m_o + m_i * n_o) * np.cos(l * delta_phi))
    return np.stack(np.broadcast_arrays(*columns), axis=-1)

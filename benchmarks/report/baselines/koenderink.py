"""Koenderink's model: products of Zernike polynomials on the two hemispheres.

J. J. Koenderink, A. J. van Doorn, M. Stavridi: Bidirectional Reflection Distribution Function Expressed in Terms of
Surface Scattering Modes, ECCV 1996. An isotropic, bilaterally symmetric and reciprocal reflectance is expanded as ::

    f = sum a_nml [R_n^l(r_i) R_m^l(r_o) + R_m^l(r_i) R_n^l(r_o)] cos(l delta_phi),    r = sqrt(2) sin(theta / 2)

over n >= m >= l >= 0 with n - l and m - l even and n <= order: 5 parameters at order 2, 55 at order 8. It is the first
baseline of Kameya and Lewis 2002, fitted by linear least squares.
"""

from dataclasses import dataclass
from math import factorial

import numpy as np

from fitter.arrays import ArrayLike, FloatArray
from fitter.samples import Samples

ORDER = 8


@dataclass(frozen=True)
class Koenderink:
    """A fitted model."""

    order: int
    coefficients: FloatArray        # (modes(order), channels)

    @property
    def coefficient_count(self) -> int:
        """Parameters a channel."""
        return len(self.coefficients)

    @property
    def nbytes(self) -> int:
        """Bytes of all channels in single precision."""
        return 4 * self.coefficients.size

    def evaluate(self, theta_i: ArrayLike, phi_i: ArrayLike, theta_o: ArrayLike, phi_o: ArrayLike) -> FloatArray:
        """The BRDF, 1/sr: angles broadcast to (...), radians, to (..., channels) float64."""
        return design_matrix(self.order, theta_i, phi_i, theta_o, phi_o) @ self.coefficients


def fit(samples: Samples, order: int = ORDER) -> Koenderink:
    """Fit samples by linear least squares.

    Examples
    --------
    A Lambertian is the first mode alone.

    >>> theta = np.linspace(0, 1.5, 30)
    >>> white = Samples(theta, 0 * theta, theta[::-1], theta, np.full((30, 1), 0.3))
    >>> (2 * fit(white, 2).coefficients[:, 0]).round(9).tolist()
    [0.3, 0.0, 0.0, 0.0, 0.0]
    """
    matrix = design_matrix(order, *samples.directions)
    coefficients, *_ = np.linalg.lstsq(matrix, samples.values, rcond=None)
    return Koenderink(order, np.asarray(coefficients, dtype=float))


def modes(order: int) -> list[tuple[int, int, int]]:
    """The indices (n, m, l) of the parameters.

    Examples
    --------
    >>> len(modes(2)), len(modes(8))
    (5, 55)
    """
    return [(n, m, l) for n in range(order + 1) for m in range(n + 1) for l in range(m + 1)
            if (n - l) % 2 == 0 and (m - l) % 2 == 0]


def zernike_radial(n: int, l: int, r: ArrayLike) -> FloatArray:
    """The Zernike radial polynomial R_n^l.

    n - l is even and not negative, and r from 0 to 1. The polynomials of one l are orthogonal: the integral of
    R_n^l R_m^l r dr over 0 to 1 is 1 / (2 n + 2) if n = m, otherwise 0.

    Examples
    --------
    R_2^0 = 2 r^2 - 1:

    >>> zernike_radial(2, 0, [0, 0.5, 1]).tolist()
    [-1.0, -0.5, 1.0]
    """
    r = np.asarray(r, dtype=float)
    half = (n - l) // 2
    terms = ((-1) ** k * factorial(n - k) / (factorial(k) * factorial((n + l) // 2 - k) * factorial(half - k))
             * r ** (n - 2 * k) for k in range(half + 1))
    return sum(terms, np.zeros_like(r))


def design_matrix(order: int, theta_i: ArrayLike, phi_i: ArrayLike, theta_o: ArrayLike,
                  phi_o: ArrayLike) -> FloatArray:
    """The basis functions at pairs of directions: angles broadcast to (...), radians, to (..., parameters)."""
    r_i, r_o = (np.sqrt(2) * np.sin(np.asarray(theta, dtype=float) / 2) for theta in (theta_i, theta_o))
    delta_phi = np.asarray(phi_o, dtype=float) - phi_i
    radial = {(n, l): (zernike_radial(n, l, r_i), zernike_radial(n, l, r_o)) for n, _, l in modes(order)}
    columns = []
    for n, m, l in modes(order):
        (n_i, n_o), (m_i, m_o) = radial[n, l], radial[m, l]
        columns.append((n_i * m_o + m_i * n_o) * np.cos(l * delta_phi))
    return np.stack(np.broadcast_arrays(*columns), axis=-1)

"""CIE illuminants (CIE 15:2018): relative spectral power of the light under which spectra become colours.

D65 is the CIE's table; D50 its daylight of 5003 K, from the components of D. B. Judd, D. L. MacAdam, G. Wyszecki, 1964;
A is Planck's law at 2848 K for the second radiation constant of 1931, 0.01435 m K; E is equal power everywhere.
"""

from functools import cache
from pathlib import Path

import numpy as np

from ..arrays import FloatArray

DEFAULT = "D65"
ILLUMINANTS = (DEFAULT, "D50", "A", "E")
_ILLUMINANT_DATA = Path(__file__).parent / "data"
_D50 = 5000 * 1.4388 / 1.4380       # K: the nominal temperature, by today's second radiation constant


@cache
def cie() -> FloatArray:
    """Wavelength in nm, x-bar, y-bar, z-bar and D65: (rows, 5)."""
    return np.loadtxt(_ILLUMINANT_DATA / "cie_1931_d65.csv", delimiter=",", comments="#", skiprows=3)


def power(name: str) -> FloatArray:
    """The relative spectral power of one of `ILLUMINANTS` at the wavelengths of `cie`: (rows,).

    Examples
    --------
    >>> at_560 = cie()[:, 0] == 560
    >>> [float(power(name)[at_560][0].round(9)) for name in ILLUMINANTS]
    [100.0, 100.0, 100.0, 100.0]
    """
    wavelength = cie()[:, 0]
    if name == "D65":
        return cie()[:, 4]
    if name == "D50":
        return _daylight(wavelength, _D50)
    if name == "A":
        return np.asarray(100 * (560 / wavelength) ** 5 * np.expm1(1.435e7 / (2848 * 560))
                          / np.expm1(1.435e7 / (2848 * wavelength)))
    return np.full_like(wavelength, 100)


def white(name: str) -> FloatArray:
    """XYZ of one of `ILLUMINANTS`, with Y = 1: (3,)."""
    xyz = cie()[:, 1:4].T @ power(name)
    return np.asarray(xyz / xyz[1])


def _daylight(wavelength: FloatArray, temperature: float) -> FloatArray:
    """The power of CIE daylight of 4000 to 7000 K; factors rounded and table interpolated as the CIE says."""
    x = -4.6070e9 / temperature ** 3 + 2.9678e6 / temperature ** 2 + 0.09911e3 / temperature + 0.244063
    y = -3 * x ** 2 + 2.87 * x - 0.275
    divisor = 0.0241 + 0.2562 * x - 0.7341 * y
    first = round((-1.3515 - 1.7703 * x + 5.9114 * y) / divisor, 3)
    second = round((0.0300 - 31.4424 * x + 30.0717 * y) / divisor, 3)
    table = np.loadtxt(_ILLUMINANT_DATA / "cie_daylight.csv", delimiter=",", comments="#", skiprows=3).T
    return np.interp(wavelength, table[0], table[1] + first * table[2] + second * table[3])

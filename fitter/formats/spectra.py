"""Conversion of spectral reflectance to linear sRGB under a CIE illuminant.

Colour matching functions: CIE 1931 2-degree standard observer (CIE 018:2019). Primaries and white point: IEC 61966-2-1.
Illuminants: CIE 15:2018. D65 is its table; D50 its daylight of 5003 K; A is Planck's law at 2848 K for the second
radiation constant of 1931, 0.01435 m K; E is equal power. Colours seen under another than D65 are adapted to it
(`colours.adaptation`).
"""

from functools import cache
from pathlib import Path

import numpy as np

from ..arrays import ArrayLike, FloatArray
from ..colours import adaptation
from ..errors import DatasetError

DEFAULT = "D65"
ILLUMINANTS = (DEFAULT, "D50", "A", "E")
SPAN = 200                  # nm that the bands of a spectrum must span
XYZ_TO_SRGB = np.array([[3.2404542, -1.5371385, -0.4985314],
                        [-0.9692660, 1.8760108, 0.0415560],
                        [0.0556434, -0.2040259, 1.0572252]])
_D50 = 1, -1.039, 0.363         # factors of the components of daylight at 5003 K: M1 and M2, as the CIE rounds them


def _read_table(name: str) -> FloatArray:
    return np.loadtxt(Path(__file__).parent / "data" / name, delimiter=",", comments="#", skiprows=3)


@cache
def cie() -> FloatArray:
    """Wavelength in nm, x-bar, y-bar, z-bar and D65: (rows, 5)."""
    return _read_table("cie_1931_d65.csv")


def power(name: str) -> FloatArray:
    """The relative spectral power of one of `ILLUMINANTS` at the wavelengths of `cie`, 100 at 560 nm: (rows,)."""
    wavelength = cie()[:, 0]
    if name == "D65":
        return cie()[:, 4]
    if name == "D50":
        nodes, *components = _read_table("cie_daylight.csv").T
        return np.interp(wavelength, nodes, sum(factor * each for factor, each in zip(_D50, components, strict=True)))
    if name == "A":
        return np.asarray(100 * (560 / wavelength) ** 5 * np.expm1(1.435e7 / (2848 * 560))
                          / np.expm1(1.435e7 / (2848 * wavelength)))
    return np.full_like(wavelength, 100)


def white(name: str) -> FloatArray:
    """XYZ of one of `ILLUMINANTS`, with Y = 1: (3,)."""
    xyz = cie()[:, 1:4].T @ power(name)
    return np.asarray(xyz / xyz[1])


def srgb_weights(wavelengths: FloatArray, illuminant: str = DEFAULT) -> FloatArray:
    """The matrix that converts a reflectance spectrum to linear sRGB: (bands,) nm to (3, bands).

    Bands are integrated by the trapezoidal rule; those outside the tables, 380 to 780 nm, have weight 0. Each row is
    normalised to the sum 1, so that a flat spectrum is exactly grey, even if the bands do not cover the visible range.
    """
    wavelength, *xyz, _ = cie().T
    visible = (wavelengths >= wavelength[0]) & (wavelengths <= wavelength[-1])
    width = np.zeros(len(wavelengths))
    width[visible] = np.gradient(wavelengths[visible])
    width[np.flatnonzero(visible)[[0, -1]]] /= 2
    light = width * np.interp(wavelengths, wavelength, power(illuminant), left=0, right=0)
    matching = np.array([np.interp(wavelengths, wavelength, bar, left=0, right=0) for bar in xyz])
    adapted = np.eye(3) if illuminant == DEFAULT else adaptation(white(illuminant), white(DEFAULT))
    weights = XYZ_TO_SRGB @ adapted @ (matching * light)
    return weights / weights.sum(axis=1, keepdims=True)


def to_linear_srgb(wavelengths: ArrayLike, values: ArrayLike, line: int | None = None,
                   illuminant: str = DEFAULT) -> FloatArray:
    """Convert spectra, (n, bands), to linear sRGB under one of `ILLUMINANTS`: (n, 3). Saturated colours may have
    negative components.

    Raises DatasetError, with the line of the wavelengths, unless these, in nm and in any order, differ, and at
    least three are within 400 to 700 nm and span 200 nm.
    """
    wavelengths, values = np.asarray(wavelengths, dtype=float), np.asarray(values, dtype=float)
    if (np.diff(wavelengths) < 0).any():
        order = np.argsort(wavelengths, kind="stable")
        wavelengths, values = wavelengths[order], values[:, order]
    visible = wavelengths[(wavelengths >= 400) & (wavelengths <= 700)]
    if not (np.diff(wavelengths) > 0).all() or len(visible) < 3 or np.ptp(visible) < SPAN:
        raise DatasetError(f"wavelengths must differ, with at least three from 400 to 700 nm that span {SPAN} nm",
                           line=line)
    return values @ srgb_weights(wavelengths, illuminant).T

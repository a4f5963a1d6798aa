"""Spectral reflectance to linear sRGB, as it looks under D65.

Colour matching: CIE 1931 2-degree standard observer (CIE 018:2019). Primaries: IEC 61966-2-1.
"""

from functools import cache
from pathlib import Path

import numpy as np

from ..errors import DatasetError

XYZ_TO_SRGB = np.array([[3.2404542, -1.5371385, -0.4985314],
                        [-0.9692660, 1.8760108, 0.0415560],
                        [0.0556434, -0.2040259, 1.0572252]])


@cache
def _cie():
    table = Path(__file__).parent / "data" / "cie_1931_d65.csv"
    return np.loadtxt(table, delimiter=",", comments="#", skiprows=3)


def srgb_weights(wavelengths):
    """Weights that turn a reflectance spectrum into linear sRGB: (bands,) nm to (3, bands).

    The bands are integrated by the trapezoidal rule; those outside the tables (380 to 780 nm) do not count. Each row
    sums to 1, so that a spectrally flat reflectance is grey exactly, whatever part of the visible range they cover.
    """
    wavelength, *xyz, d65 = _cie().T
    seen = (wavelengths >= wavelength[0]) & (wavelengths <= wavelength[-1])
    width = np.zeros(len(wavelengths))
    width[seen] = np.gradient(wavelengths[seen])
    width[np.flatnonzero(seen)[[0, -1]]] /= 2
    light = width * np.interp(wavelengths, wavelength, d65, left=0, right=0)
    matching = np.array([np.interp(wavelengths, wavelength, bar, left=0, right=0) for bar in xyz])
    weights = XYZ_TO_SRGB @ (matching * light)
    return weights / weights.sum(axis=1, keepdims=True)


def to_linear_srgb(wavelengths, values, path=None, line=None):
    """Spectra to linear sRGB under D65; saturated colours may be negative.

    Parameters
    ----------
    wavelengths : (bands,) array
        nm, rising, at least three from 400 to 700 and these 200 nm apart or more.
    values : (n, bands) array
    path, line
        Where they come from, for the error.

    Returns
    -------
    (n, 3) float64
    """
    wavelengths = np.asarray(wavelengths, dtype=float)
    visible = wavelengths[(wavelengths >= 400) & (wavelengths <= 700)]
    if not (np.diff(wavelengths) > 0).all() or len(visible) < 3 or np.ptp(visible) < 200:
        raise DatasetError("wavelengths must rise, with at least three from 400 to 700 nm that span 200 nm", path, line)
    return values @ srgb_weights(wavelengths).T

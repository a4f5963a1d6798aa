"""Conversion of spectral reflectance to linear sRGB under an illuminant.

Colour matching functions: CIE 1931 2-degree standard observer (CIE 018:2019). Primaries and white point: IEC 61966-2-1.
Colours seen under another illuminant than D65 are adapted to it (`colours.adaptation`).
"""


import numpy as np

from ..arrays import ArrayLike, FloatArray
from ..colours import adaptation
from ..errors import DatasetError
from .illuminants import DEFAULT, cie, power, white

SPAN = 200                  # nm that the bands of a spectrum must span
XYZ_TO_SRGB = np.array([[3.2404542, -1.5371385, -0.4985314],
                        [-0.9692660, 1.8760108, 0.0415560],
                        [0.0556434, -0.2040259, 1.0572252]])


def srgb_weights(wavelengths: FloatArray, illuminant: str = DEFAULT) -> FloatArray:
    """The matrix that converts a reflectance spectrum to linear sRGB: (bands,) nm to (3, bands).

    Bands are integrated by the trapezoidal rule; those outside the tables, 380 to 780 nm, have weight 0. Each row is
    normalised to the sum 1, so that a flat spectrum is exactly grey, even if the bands do not cover the visible range.

    Examples
    --------
    >>> weights = srgb_weights(np.arange(400.0, 701, 10))
    >>> weights.shape, weights.sum(axis=1).round(9).tolist()
    ((3, 31), [1.0, 1.0, 1.0])
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

    Examples
    --------
    >>> to_linear_srgb([400, 550, 700], [[0.2, 0.2, 0.2]]).round(9).tolist()
    [[0.2, 0.2, 0.2]]
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

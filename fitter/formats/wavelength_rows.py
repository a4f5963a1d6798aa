"""Tables with a row for each wavelength: a column of wavelengths, and one of values."""

from pathlib import Path

import numpy as np

from ..arrays import FloatArray, IntArray
from ..errors import DatasetError

_MOST = 1000                # wavelengths
_MICRONS = 20               # a wavelength below it is in micrometres
_SAME_WRITTEN = 1e-9        # of angles, as they are written
_FEWEST = 0.5               # of the cells that directions and wavelengths make, at least this share must be there


def wavelengths_to_columns(angles: FloatArray, wavelengths: FloatArray, values: FloatArray, in_microns: bool | None,
                           path: str | Path, line: int) -> tuple[FloatArray, FloatArray, list[str], str]:
    """One row for each pair of directions that has all wavelengths, in the order in which they begin, and a column for
    each wavelength. What was measured more than once is averaged.

    Raises DatasetError if the directions hardly share their wavelengths.

    Parameters
    ----------
    angles : (n, 4) float64
    wavelengths, values : (n,) float64
    in_microns : bool, or None
        Whether the wavelengths are in micrometres; by their size if that is not known.

    Returns
    -------
    angles, values : (m, 4) and (m, bands) float64
    channels : list of str
        Such as 550nm.
    note : str
    """
    if in_microns or (in_microns is None and np.abs(wavelengths).max() < _MICRONS):
        wavelengths = wavelengths * 1000
    bands, band = np.unique(np.round(wavelengths, 6), return_inverse=True)
    rounded = np.round(angles / _SAME_WRITTEN)
    _, first, pair = np.unique(rounded, axis=0, return_index=True, return_inverse=True)
    pair = pair.ravel()
    cells = len(first) * len(bands)
    if len(bands) > _MOST or cells * _FEWEST > len(values):
        raise DatasetError(f"{len(bands):,} wavelengths at {len(first):,} pairs of directions in {len(values):,} rows "
                           "found, expected the same wavelengths at all", path, line)
    cell: IntArray = pair * len(bands) + band
    count = np.bincount(cell, minlength=cells)
    mean = (np.bincount(cell, values, cells) / np.maximum(count, 1)).reshape(len(first), len(bands))
    whole = (count > 0).reshape(len(first), len(bands)).all(axis=1)
    if not whole.any():
        raise DatasetError("no pair of directions has all wavelengths, expected the same at all", path, line)
    kept = np.flatnonzero(whole)[np.argsort(first[whole])]
    lacking = f"; {np.count_nonzero(~whole):,} without some are left out" if not whole.all() else ""
    note = f"{len(bands)} wavelength{'s' * (len(bands) > 1)} at {len(kept):,} pairs of directions, in rows{lacking}"
    return angles[first[kept]], mean[kept], [f"{number:g}nm" for number in bands], note

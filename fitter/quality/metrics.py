"""Errors of a fit at the measurements (Kameya and Lewis 2002, equations 8 to 10)."""

from typing import NamedTuple

import numpy as np

from ..arrays import ArrayLike


class ErrorMetrics(NamedTuple):
    """Errors of a fit at its samples."""

    rmse: float
    """Root mean square error, 1/sr (equation 8)."""
    mae: float
    """Maximum absolute deviation, 1/sr: the paper's MAE, which is a maximum and not a mean (equation 9)."""
    mre: float
    """Maximum absolute deviation over the maximum absolute datum (equation 10); nan where all data are 0."""


def error_metrics(measured: ArrayLike, fitted: ArrayLike) -> ErrorMetrics:
    """RMSE, MAE and MRE over all samples and channels.

    Parameters
    ----------
    measured, fitted : (n,) or (n, channels) array_like
        BRDF values, 1/sr.

    Raises
    ------
    ValueError
        If the shapes differ, or the arrays are empty.

    Examples
    --------
    >>> error_metrics([1, 2, 4, 1], [1, 2, 3, 1])
    ErrorMetrics(rmse=0.5, mae=1.0, mre=0.25)
    """
    measured, fitted = np.asarray(measured, dtype=float), np.asarray(fitted, dtype=float)
    if measured.shape != fitted.shape or not measured.size:
        raise ValueError(f"measured {measured.shape} and fitted {fitted.shape} must have one shape, and not be empty")
    deviation = np.abs(measured - fitted)
    largest = np.abs(measured).max()
    mae = deviation.max()
    return ErrorMetrics(float(np.sqrt(np.mean(deviation ** 2))), float(mae),
                        float(mae / largest) if largest else float("nan"))


def channel_metrics(measured: ArrayLike, fitted: ArrayLike) -> list[ErrorMetrics]:
    """`error_metrics` of each channel: (n, channels) each, 1/sr.

    Examples
    --------
    >>> [errors.mae for errors in channel_metrics([[1, 2], [3, 4]], [[1, 2.5], [3, 4]])]
    [0.0, 0.5]
    """
    columns = zip(np.asarray(measured).T, np.asarray(fitted).T, strict=True)
    return [error_metrics(*pair) for pair in columns]

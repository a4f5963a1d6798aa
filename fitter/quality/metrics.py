"""How far a fit is from the measurements (Kameya and Lewis 2002, equations 8 to 10)."""

from typing import NamedTuple

import numpy as np


class ErrorMetrics(NamedTuple):
    """Errors of a fit at its samples."""

    rmse: float
    """Root mean square error, 1/sr (equation 8)."""
    mae: float
    """Maximum absolute deviation, 1/sr: the paper's MAE, which is a maximum and not a mean (equation 9)."""
    mre: float
    """Maximum absolute deviation over the maximum absolute datum (equation 10); nan where all data are 0."""


def error_metrics(measured, fitted):
    """RMSE, MAE and MRE over all samples and channels.

    Parameters
    ----------
    measured, fitted : (n,) or (n, channels) array_like
        BRDF values, 1/sr.

    Returns
    -------
    ErrorMetrics

    Examples
    --------
    >>> error_metrics([1, 2, 4], [1, 2, 3]).mre
    0.25
    """
    measured, fitted = np.asarray(measured, dtype=float), np.asarray(fitted, dtype=float)
    if measured.shape != fitted.shape or not measured.size:
        raise ValueError(f"measured {measured.shape} and fitted {fitted.shape} must have one shape, and not be empty")
    deviation = np.abs(measured - fitted)
    largest = np.abs(measured).max()
    mae = deviation.max()
    return ErrorMetrics(float(np.sqrt(np.mean(deviation ** 2))), float(mae),
                        float(mae / largest) if largest else float("nan"))


def channel_metrics(measured, fitted):
    """`error_metrics` of each channel by itself: a list of ErrorMetrics.

    Parameters
    ----------
    measured, fitted : (n, channels) array_like
    """
    columns = zip(np.asarray(measured).T, np.asarray(fitted).T, strict=True)
    return [error_metrics(*pair) for pair in columns]

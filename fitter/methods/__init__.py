"""Fitting: methods make a `Fit` of `Samples`, and a fit knows no method.

A method is a function ``fit(samples, levels, plausible=True, **options)`` in a module of its own, entered in `METHODS`.
"""

from collections.abc import Callable
from dataclasses import replace
from typing import Any

from ..model.fit import Fit
from ..samples import Samples, distinct_channels
from . import kameya_lewis, regression_kriging
from .levels import Levels

METHODS: dict[str, Callable[..., Fit]] = {"mba": kameya_lewis.fit, "kriging": regression_kriging.fit}


def fit(samples: Samples, diffuse_level: int = 4, specular_level: int | None = 6, compression: float = 95.0,
        method: str = "mba", plausible: bool = True, **options: Any) -> Fit:
    """Fit a measured reflectance.

    Parameters
    ----------
    samples : Samples
    diffuse_level : int, 0 to 8
        D, the level of the dense lattice.
    specular_level : int, 0 to 8, or None
        S, the level of the sparse lattice; None for the dense lattice alone, by "mba" plain MBA (section 3).
    compression : float, 0 to 100
        C, the percentage of the (2^S + 3)^3 specular control points to drop.
    method : {"mba", "kriging"}
        "mba": as Kameya and Lewis (2002), `kameya_lewis`. "kriging": closer to the samples in a fraction of the
        storage, and closer to what was not sampled, `regression_kriging`.
    plausible : bool
        By "kriging", make the fit physically plausible: nowhere negative, and of directional albedo at most 1. What
        that changed is in `Fit.changes`. The paper's method has no means to it.
    **options
        Of the method.

    Returns
    -------
    Fit

    Raises
    ------
    ValueError
        If a level, the compression or the method is out of range.

    Examples
    --------
    >>> import numpy as np
    >>> theta = np.radians([0.0, 30.0, 60.0])
    >>> samples = Samples(theta, np.zeros(3), theta, np.full(3, np.pi), np.array([[0.2], [0.3], [0.4]]))
    >>> fitted = fit(samples, diffuse_level=2, specular_level=4, compression=0.0)
    >>> bool(np.allclose(fitted.evaluate(*samples.directions), samples.values, atol=1e-3))
    True
    """
    levels = Levels(diffuse_level, specular_level, compression)
    if method not in METHODS:
        raise ValueError(f"method is {method!r}, expected one of {', '.join(METHODS)}")
    distinct, columns = distinct_channels(samples)
    fitted = METHODS[method](distinct, levels, plausible=plausible, **options)
    return replace(fitted, channels=samples.channels, columns=columns)

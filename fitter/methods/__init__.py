"""Fitting methods: each makes a `Fit` of `Samples`; a `Fit` does not know which method made it.

A method is a function of samples of which no two channels are equal, `Levels`, whether the fit is to be physically
plausible, and options of its own, which returns a fit with the samples' channels, name and source. It is entered in
`METHODS` and `MethodName`; CONTRIBUTING.md shows how.
"""

from collections.abc import Callable
from dataclasses import replace
from typing import Any, Literal

from ..model.fit import Fit
from ..samples import Samples, distinct_channels, surface_samples
from . import kameya_lewis, regression_kriging
from .levels import Levels

MethodName = Literal["mba", "kriging"]
METHODS: dict[MethodName, Callable[..., Fit]] = {"mba": kameya_lewis.fit, "kriging": regression_kriging.fit}


def prepare(samples: Samples, method: MethodName = "mba") -> dict[str, Any]:
    """The part of a fit that does not depend on the levels, where a method has one that takes long: options for `fit`,
    with the same samples and method and any levels; else empty."""
    if method != "kriging":
        return {}
    return {"estimated": regression_kriging.estimate(distinct_channels(surface_samples(samples))[0])}


def fit(samples: Samples, diffuse_level: int = 4, specular_level: int | None = 6, compression: float = 95.0,
        method: MethodName = "mba", plausible: bool = True, **options: Any) -> Fit:
    """Fit a measured reflectance.

    Parameters
    ----------
    diffuse_level : int, 0 to 8
        D, the level of the dense lattice.
    specular_level : int, 0 to 8, or None
        S, the level of the sparse lattice; None for the dense lattice alone, which with "mba" is the paper's plain MBA
        (Kameya and Lewis 2002, section 3).
    compression : float, 0 to 100
        C, the percentage of the (2^S + 3)^3 specular control points to drop.
    method : {"mba", "kriging"}
        "mba" is the method of Kameya and Lewis (2002), `kameya_lewis`. "kriging", `regression_kriging`, fits the
        samples more closely with less storage, and predicts unmeasured directions better.
    plausible
        With "kriging", make the fit physically plausible: nowhere negative, with a directional albedo of at most 1.
        `Fit.changes` says what that changed. "mba" ignores it.
    **options
        Of the method, as `prepare` returns them.

    Raises
    ------
    ValueError
        If a level, the compression or the method is out of range, or there is not enough memory for the levels.

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
    distinct, columns = distinct_channels(surface_samples(samples))
    try:
        fitted = METHODS[method](distinct, levels, plausible=plausible, **options)
    except MemoryError as error:
        raise ValueError("not enough memory for a fit of these levels: choose lower ones, or a higher "
                         "compression") from error
    return replace(fitted, channels=samples.channels, columns=columns, subsurface=samples.subsurface)

"""Measured reflectance as arrays: a list of direction pairs and the values measured there."""

from dataclasses import dataclass

import numpy as np

from .errors import DatasetError

HORIZON = np.pi / 2
LARGEST_VALUE = 1e30        # 1/sr; fits are stored in single precision, and no measurement comes near
_ROUNDING = 1e-5            # files print angles to 6 decimals, so pi/2 may come out slightly above itself


@dataclass(frozen=True, eq=False)
class Samples:
    """A measured isotropic BRDF.

    Directions point away from the surface; theta is measured from the normal, so that every theta is within
    0 to pi/2.

    Attributes
    ----------
    theta_i, phi_i, theta_o, phi_o : (n,) float64
        Incident and outgoing direction, radians.
    values : (n, channels) float64
        BRDF, 1/sr.
    channels : tuple of str
        One name a channel: ``('R', 'G', 'B')``, or ``('grey',)``.
    name : str
        What was measured.
    source : str
        Where it came from: a path, or a description of how it was made.

    Raises
    ------
    DatasetError
        If the arrays do not have these shapes, or hold anything that is not a finite number, a direction below
        the horizon, or a value that single precision cannot take.
    """

    theta_i: np.ndarray
    phi_i: np.ndarray
    theta_o: np.ndarray
    phi_o: np.ndarray
    values: np.ndarray
    channels: tuple = ("grey",)
    name: str = "untitled"
    source: str = ""

    def __post_init__(self):
        values = np.array(self.values, dtype=float)
        if values.ndim != 2 or not values.size:
            raise DatasetError(f"values have the shape {values.shape}, expected (samples, channels) with at least "
                               f"one sample", self.source or None)
        if np.abs(values).max() > LARGEST_VALUE:
            raise DatasetError(f"a value of {np.abs(values).max():g} / sr found, expected at most {LARGEST_VALUE:g}",
                               self.source or None)
        if len(self.channels) != values.shape[1]:
            raise DatasetError(f"{values.shape[1]} columns of values for the channels {self.channels}",
                               self.source or None)
        self._freeze("values", values)
        for field in ("theta_i", "phi_i", "theta_o", "phi_o"):
            angle = np.array(getattr(self, field), dtype=float)
            if angle.shape != (len(values),):
                raise DatasetError(f"{field} has the shape {angle.shape}, expected ({len(values)},)",
                                   self.source or None)
            if field.startswith("theta"):
                beyond = np.flatnonzero((angle < 0) | (angle > HORIZON + _ROUNDING))
                if len(beyond):
                    raise DatasetError(f"{field}[{beyond[0]}] is {angle[beyond[0]]:g}, expected 0 to pi/2 radians",
                                       self.source or None)
                angle = np.minimum(angle, HORIZON)
            self._freeze(field, angle)
        object.__setattr__(self, "channels", tuple(map(str, self.channels)))

    def _freeze(self, field, array):
        if not np.isfinite(array).all():
            raise DatasetError(f"{field} holds numbers that are not finite", self.source or None)
        array.flags.writeable = False
        object.__setattr__(self, field, array)

    def __len__(self):
        return len(self.values)

    @property
    def directions(self):
        """``(theta_i, phi_i, theta_o, phi_o)``, as `Fit.evaluate` takes them."""
        return self.theta_i, self.phi_i, self.theta_o, self.phi_o

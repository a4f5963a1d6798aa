"""What fits are compared with between the nodes of RGL's files, and at the rims of balls."""

import numpy as np

from fitter.methods.energy import reflected_light

_CELLS = 64, 24


class Clipped:
    """A table of RGL without negative values."""

    isotropic = True

    def __init__(self, table):
        self.table = table

    def evaluate(self, *angles):
        """As `Fit.evaluate`."""
        broadcast = np.broadcast_arrays(*(np.asarray(angle, dtype=float) for angle in angles))
        values = self.table.evaluate(*(angle.ravel() for angle in broadcast))
        return np.maximum(values, 0).reshape(*broadcast[0].shape, -1)


def albedo(model, degrees):
    """Of light that leaves at angles: (angles, channels)."""
    return reflected_light(model, np.radians(degrees), _CELLS).sum(axis=2).mean(axis=0)


def error(model, golden):
    """The relative root mean square of differences of cube roots of f cos theta_o, of a table of golden values."""
    found = np.cbrt(np.maximum(model.evaluate(*golden[:, :4].T), 0) * np.cos(golden[:, 2])[:, None])
    wanted = np.cbrt(np.maximum(golden[:, 4:7], 0))
    return float(np.sqrt(((found - wanted) ** 2).mean() / (wanted ** 2).mean()))

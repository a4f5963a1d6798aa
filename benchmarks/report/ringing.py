"""Ringing: how much a fit oscillates between neighbouring samples (Kameya and Lewis 2002, section 4.3.1).

Between two neighbouring samples, along a straight line in Nusselt coordinates, a fit that does not ring is monotone:
its total variation is the difference of its values at the ends. Any variation beyond that is ringing. Neighbours are
joined by an edge of the Delaunay tessellation of the samples.
"""

import numpy as np
from scipy.spatial import Delaunay

from fitter.arrays import FloatArray
from fitter.coordinates.nusselt import Nusselt
from fitter.model import Reflectance
from fitter.samples import Samples

Lines = tuple[FloatArray, FloatArray, FloatArray]
"""What `neighbours` returns."""

_STEPS = 24                 # along a line


def ringing(samples: Samples, model: Reflectance, lines: Lines | None = None) -> float:
    """The variation of a model between neighbouring samples beyond that of a monotone one, relative to the data's.

    Parameters
    ----------
    samples : Samples
    model : Reflectance
    lines : tuple of arrays, optional
        `neighbours(samples)`, if it was computed before.

    Returns
    -------
    float
        The sum over all lines of the total variation less the difference of the ends, divided by the sum of the
        differences of the measured values at the ends; 0 for a model that is monotone along every line.
    """
    start, end, difference = neighbours(samples) if lines is None else lines
    t = np.linspace(0, 1, _STEPS + 1)[:, None, None]
    value = model.evaluate(*Nusselt().decode((1 - t) * start + t * end))
    variation = np.abs(np.diff(value, axis=0)).sum(axis=0)
    excess = variation - np.abs(value[-1] - value[0])
    total = difference.sum()
    return float(excess.sum() / total) if total else 0.0


def neighbours(samples: Samples) -> Lines:
    """The lines between neighbouring samples.

    Samples with equal coordinates, such as mirror images, count as one, with the mean of their values.

    Returns
    -------
    start, end : (m, 3) float64
        Nusselt coordinates.
    difference : (m, channels) float64
        Absolute difference of the measured values at the ends, 1/sr.
    """
    x, at = np.unique(Nusselt().encode(*samples.directions).round(5), axis=0, return_inverse=True)
    values = np.zeros((len(x), samples.values.shape[1]))
    np.add.at(values, at.ravel(), samples.values)
    values /= np.bincount(at.ravel(), minlength=len(x))[:, None]
    # QJ joggles the points, which often lie on a grid; up to four points are one simplex
    simplices = Delaunay(x, qhull_options="QJ Qbb").simplices if len(x) > 4 else np.arange(len(x))[None]
    corners = np.array([(a, b) for a in range(simplices.shape[1]) for b in range(a)]).reshape(-1, 2)
    a, b = np.unique(np.sort(simplices[:, corners].reshape(-1, 2), axis=1), axis=0).T
    return x[a], x[b], np.abs(values[a] - values[b])

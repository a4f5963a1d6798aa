"""Ringing: how much a fit oscillates between neighbouring samples (Kameya and Lewis 2002, section 4.3.1).

Along the straight line, in Nusselt coordinates, between two neighbouring samples a fit that does not ring goes from
one value to the other without turning back: its total variation is their difference. What it has beyond that is
ringing. Neighbours are the ends of the edges of a Delaunay tessellation of the samples, which needs SciPy.
"""

import numpy as np

from ..coordinates.nusselt import directions, nusselt

_STEPS = 24                 # along a line


def ringing(samples, model, lines=None):
    """The variation of a model between neighbouring samples that these do not ask for, relative to what they do.

    Parameters
    ----------
    samples : Samples
    model
        Anything with the `evaluate` of `Fit`.
    lines : tuple of arrays, optional
        What `neighbours(samples)` returns, where it is at hand.

    Returns
    -------
    float
        The sum over all lines of (total variation - difference of the ends) over the sum of the differences of the
        measured ends; 0 for a model that is monotone along every line.
    """
    start, end, difference = neighbours(samples) if lines is None else lines
    t = np.linspace(0, 1, _STEPS + 1)[:, None, None]
    value = model.evaluate(*directions((1 - t) * start + t * end))
    variation = np.abs(np.diff(value, axis=0)).sum(axis=0)
    excess = variation - np.abs(value[-1] - value[0])
    total = difference.sum()
    return float(excess.sum() / total) if total else 0.0


def neighbours(samples):
    """Lines between neighbouring samples: their ends (m, 3) and (m, 3), and how far the data there differ (m, c).

    Samples at one place, as mirror images of each other are, count as one, with the mean of their values.

    Raises
    ------
    ImportError
        Where SciPy is not installed.
    """
    try:
        from scipy.spatial import Delaunay
    except ImportError as error:
        raise ImportError("ringing needs SciPy, an optional extra: pip install scipy") from error
    x, at = np.unique(nusselt(*samples.directions).round(5), axis=0, return_inverse=True)
    values = np.zeros((len(x), samples.values.shape[1]))
    np.add.at(values, at.ravel(), samples.values)
    values /= np.bincount(at.ravel(), minlength=len(x))[:, None]
    # QJ: measured directions often lie on a grid; up to four are one tetrahedron, or less
    simplices = Delaunay(x, qhull_options="QJ Qbb").simplices if len(x) > 4 else np.arange(len(x))[None]
    corners = np.array([(a, b) for a in range(simplices.shape[1]) for b in range(a)]).reshape(-1, 2)
    a, b = np.unique(np.sort(simplices[:, corners].reshape(-1, 2), axis=1), axis=0).T
    return x[a], x[b], np.abs(values[a] - values[b])

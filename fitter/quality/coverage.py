"""The widest hole between samples: of a lattice of direction pairs, the one that is farthest from all of them.

The distance of two direction pairs is the larger of those between their incident and between their outgoing
directions, and samples count for their mirror images and reciprocals. Samples in one cell of a grid lie within
`_ACROSS` of each other, so the first of each cell tells which cells have to be looked at sample by sample. The result
is that of every sample held against every probe, without the matrix of all their distances.
"""

import numpy as np

_PROBE_THETA = np.radians(np.arange(10, 81, 10))            # nearer to the horizon few instruments measure
_PROBE_AZIMUTH = np.radians(np.arange(0, 181, 15))
_CELL = np.radians(6)
_ACROSS = 2 * _CELL + 1e-6  # along a meridian and along a circle of latitude, which is no longer than its azimuths
_CELLS = 32                 # in azimuth, and more than there are in polar angle
_AT_ONCE = 1024              # samples held against all probes: as many numbers as a processor's cache takes


def widest_hole(samples):
    """The probed pair of directions that is farthest from every sample.

    Parameters
    ----------
    samples : Samples

    Returns
    -------
    distance : float
        Degrees.
    at : (float, float, float)
        Incident and outgoing polar angle, and the azimuth between them, degrees.
    """
    grids = np.meshgrid(_PROBE_THETA, _PROBE_THETA, _PROBE_AZIMUTH, indexing="ij")
    probes = np.stack([grid.ravel() for grid in grids], axis=1)
    azimuth = _folded(np.remainder(samples.phi_o, 2 * np.pi) - np.remainder(samples.phi_i, 2 * np.pi))
    sides = [_Cells(*angles) for angles in ((samples.theta_i, samples.theta_o, azimuth),
                                            (samples.theta_o, samples.theta_i, azimuth))]
    nearest = np.full(len(probes), -1.0)                    # cosines of distances
    for cells in sides:
        for part in _parts(cells.first):
            np.maximum(nearest, _cosines(probes, *cells.at(part)).max(axis=1), out=nearest)
    distance = np.arccos(np.minimum(nearest, 1))
    candidates = np.flatnonzero(distance >= distance.max() - _ACROSS)
    probes, nearest = probes[candidates], nearest[candidates]
    for cells in sides:
        cells.look_closer(probes, nearest)
    k = nearest.argmin()
    return float(np.degrees(np.arccos(min(nearest[k], 1.0)))), tuple(map(float, np.degrees(probes[k])))


class _Cells:
    """Samples sorted by cell, and cut into runs of one cell each and at most `_AT_ONCE` samples."""

    def __init__(self, theta_i, theta_o, azimuth):
        self._angles = theta_i, theta_o, azimuth
        cell = np.zeros(len(azimuth), dtype=np.uint16)
        for angle in self._angles:
            cell = cell * np.uint16(_CELLS) + (angle / _CELL).astype(np.uint16)
        self._order = np.argsort(cell, kind="stable")
        cell = cell[self._order]
        begins = np.arange(len(cell)) % _AT_ONCE == 0
        begins[1:] |= cell[1:] != cell[:-1]
        self._starts = np.flatnonzero(begins)
        self._stops = np.append(self._starts[1:], len(cell))
        self.first = self._order[self._starts]

    def at(self, which):
        """Their incident and outgoing polar angle and azimuth."""
        return (angle[which] for angle in self._angles)

    def look_closer(self, probes, nearest):
        """Raise `nearest` to what all samples of the cells make it that can be near enough."""
        for start in range(0, len(self.first), _AT_ONCE):
            part = slice(start, start + _AT_ONCE)
            reach = np.minimum(np.arccos(np.minimum(nearest, 1)) + _ACROSS, np.pi)
            near = _cosines(probes, *self.at(self.first[part])) >= np.cos(reach)[:, None]
            more = near.any(axis=0) & (self._stops[part] - self._starts[part] > 1)
            for run in np.flatnonzero(more):
                which = np.flatnonzero(near[:, run])
                inside = self._order[self._starts[start + run]:self._stops[start + run]]
                found = _cosines(probes[which], *self.at(inside)).max(axis=1)
                nearest[which] = np.maximum(nearest[which], found)


def _parts(indices):
    return (indices[start:start + _AT_ONCE] for start in range(0, len(indices), _AT_ONCE))


def _cosines(probes, theta_i, theta_o, azimuth):
    """Of the distances from probes to samples: (p, 3) and three (n,) to (p, n)."""
    incident = np.cos(theta_i), np.sin(theta_i)
    between = np.outer(np.cos(probes[:, 0]), incident[0]) + np.outer(np.sin(probes[:, 0]), incident[1])
    outgoing = _vectors(probes[:, 1], probes[:, 2]) @ _vectors(theta_o, azimuth).T
    return np.minimum(between, outgoing, out=outgoing)


def _vectors(theta, azimuth):
    """Unit vectors in the frame of the incident direction: (n,) and (n,) to (n, 3)."""
    sin = np.sin(theta)
    return np.stack([sin * np.cos(azimuth), sin * np.sin(azimuth), np.cos(theta)], axis=1)


def _folded(azimuth):
    """Azimuths of mirror images are one, between 0 and pi."""
    return np.arctan2(np.abs(np.sin(azimuth)), np.cos(azimuth))

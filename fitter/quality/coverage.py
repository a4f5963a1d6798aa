"""The widest hole between samples: of a grid of direction pairs, the probes, the one farthest from all samples. The
distance is the larger of the angles between the incident and between the outgoing directions.

Mirror images, of isotropic materials, and reciprocals count as samples. The result equals that of a search over all
pairs: samples in one cell are within `_ACROSS` of each other, so that the first of each tells which cells are searched.
Of an anisotropic material the outgoing directions nearest to the probes are found for each direction of incidence.
"""

from collections.abc import Iterator

import numpy as np

from ..arrays import FloatArray, IntArray, unit_vectors
from ..samples import Samples

_PROBE_THETA = np.radians(np.arange(10, 81, 10))            # few instruments measure closer to the horizon
_PROBE_AZIMUTH = np.radians(np.arange(0, 181, 15))
_CELL_ANGLE = np.radians(6)
_ACROSS = 2 * _CELL_ANGLE + 1e-6  # bound of the diameter of a cell: along a meridian, then along a circle of latitude
_AZIMUTH_CELLS = 32         # in azimuth; more than there are in polar angle
_ANISOTROPIC_AZIMUTH = np.radians(np.arange(0, 360, 30))    # of the probes' directions
_MOST_INCIDENT = 2000       # directions of incidence that are told apart exactly
_MERGED = np.radians(3)     # and how far those are apart that are not
_AT_ONCE = 1024             # samples compared with all probes at a time: fits the processor's cache


def widest_gap(samples: Samples) -> tuple[float, tuple[float, ...]]:
    """The widest gap in angular coverage: the distance of the probe that is farthest from the nearest sample, degrees;
    and its incident and outgoing polar angle, the azimuth between them, and of an anisotropic material the azimuth of
    incidence, degrees."""
    if not samples.isotropic:
        return _widest_of_anisotropic(samples)
    grids = np.meshgrid(_PROBE_THETA, _PROBE_THETA, _PROBE_AZIMUTH, indexing="ij")
    probes = np.stack([grid.ravel() for grid in grids], axis=1)
    azimuth = fold_azimuth(np.remainder(samples.phi_o, 2 * np.pi) - np.remainder(samples.phi_i, 2 * np.pi))
    sides = [_Cells(*angles) for angles in ((samples.theta_i, samples.theta_o, azimuth),
                                            (samples.theta_o, samples.theta_i, azimuth))]
    nearest = np.full(len(probes), -1.0)                    # cosines of distances
    for cells in sides:
        for start in range(0, len(cells.first), _AT_ONCE):
            part = cells.first[start:start + _AT_ONCE]
            np.maximum(nearest, cosines(probes, *cells.angles(part)).max(axis=1), out=nearest)
    distance = np.arccos(np.minimum(nearest, 1))
    candidates = np.flatnonzero(distance >= distance.max() - _ACROSS)
    probes, nearest = probes[candidates], nearest[candidates]
    for cells in sides:
        cells.refine(probes, nearest)
    k = nearest.argmin()
    theta_i, theta_o, delta_phi = map(float, np.degrees(probes[k]))
    return float(np.degrees(np.arccos(min(nearest[k], 1.0)))), (theta_i, theta_o, delta_phi)


def _widest_of_anisotropic(samples: Samples) -> tuple[float, tuple[float, ...]]:
    theta, phi = (grid.ravel() for grid in np.meshgrid(_PROBE_THETA, _ANISOTROPIC_AZIMUTH, indexing="ij"))
    probes = unit_vectors(theta, phi)
    incident, group = _directions_of_incidence(samples)
    order = np.argsort(group, kind="stable")
    outgoing = unit_vectors(samples.theta_o[order], samples.phi_o[order])
    ends = np.searchsorted(group[order], np.arange(1, len(incident) + 1)).tolist()
    nearest = np.full((len(probes), len(probes)), -1.0)     # cosines of distances, (incident, outgoing)
    for start, end, toward in zip([0, *ends], ends, incident @ probes.T, strict=False):
        reached = np.max([(outgoing[at:min(at + _AT_ONCE, end)] @ probes.T).max(axis=0)
                          for at in range(start, end, _AT_ONCE)], axis=0)
        np.maximum(nearest, np.minimum(toward[:, None], reached), out=nearest)
    nearest = np.maximum(nearest, nearest.T)                # a sample's reciprocal is one
    i, o = np.unravel_index(nearest.argmin(), nearest.shape)
    at = theta[i], theta[o], np.mod(phi[o] - phi[i], 2 * np.pi), phi[i]
    return float(np.degrees(np.arccos(min(nearest[i, o], 1.0)))), tuple(map(float, np.degrees(at)))


def _directions_of_incidence(samples: Samples) -> tuple[FloatArray, IntArray]:
    """Those that differ, unit vectors (m, 3), and for each sample which it is, (n,)."""
    incident = unit_vectors(samples.theta_i, samples.phi_i)
    for step in (1e-6, _MERGED / np.sqrt(3)):
        cells = np.rint(incident / step).astype(np.int64) + round(2 / step)
        packed = cells[:, 0] * round(4 / step) + cells[:, 1]        # z follows from x and y
        _, first, group = np.unique(packed, return_index=True, return_inverse=True)
        if len(first) <= _MOST_INCIDENT:
            break
    return incident[first], group


class _Cells:
    """Samples sorted by cell, and divided into runs: at most `_AT_ONCE` samples of one cell. `first` is the index of
    the first sample of each run."""

    def __init__(self, theta_i: FloatArray, theta_o: FloatArray, azimuth: FloatArray) -> None:
        self._angles = theta_i, theta_o, azimuth
        cell = np.zeros(len(azimuth), dtype=np.uint16)
        for angle in self._angles:
            cell = cell * np.uint16(_AZIMUTH_CELLS) + (angle / _CELL_ANGLE).astype(np.uint16)
        self._order = np.argsort(cell, kind="stable")
        cell = cell[self._order]
        begins = np.arange(len(cell)) % _AT_ONCE == 0
        begins[1:] |= cell[1:] != cell[:-1]
        self._starts = np.flatnonzero(begins)
        self._stops = np.append(self._starts[1:], len(cell))
        self.first = self._order[self._starts]

    def angles(self, which: IntArray) -> Iterator[FloatArray]:
        """Incident and outgoing polar angle and azimuth of samples, radians."""
        return (angle[which] for angle in self._angles)

    def refine(self, probes: FloatArray, nearest: FloatArray) -> None:
        """Update `nearest`, the cosines of distances to first samples, by all samples of the runs near enough."""
        for start in range(0, len(self.first), _AT_ONCE):
            part = slice(start, start + _AT_ONCE)
            reach = np.minimum(np.arccos(np.minimum(nearest, 1)) + _ACROSS, np.pi)
            near = cosines(probes, *self.angles(self.first[part])) >= np.cos(reach)[:, None]
            more = near.any(axis=0) & (self._stops[part] - self._starts[part] > 1)
            for run in np.flatnonzero(more):
                which = np.flatnonzero(near[:, run])
                inside = self._order[self._starts[start + run]:self._stops[start + run]]
                nearest[which] = np.maximum(nearest[which], cosines(probes[which], *self.angles(inside)).max(axis=1))


def cosines(probes: FloatArray, theta_i: FloatArray, theta_o: FloatArray, azimuth: FloatArray) -> FloatArray:
    """Cosines of the distances from probes to samples: (p, 3) and three (n,) radians to (p, n).

    The azimuth is that between the directions, `fold_azimuth`.
    """
    incident = np.cos(theta_i), np.sin(theta_i)
    between = np.outer(np.cos(probes[:, 0]), incident[0]) + np.outer(np.sin(probes[:, 0]), incident[1])
    outgoing = unit_vectors(probes[:, 1], probes[:, 2]) @ unit_vectors(theta_o, azimuth).T
    return np.minimum(between, outgoing, out=outgoing)


def fold_azimuth(azimuth: FloatArray) -> FloatArray:
    """Fold azimuths by bilateral symmetry, to 0 to pi."""
    return np.arctan2(np.abs(np.sin(azimuth)), np.cos(azimuth))

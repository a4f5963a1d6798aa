"""The share of light that a table of scattered light returns, integrated over its own grid: the total integrated
scatter (TIS) of optical design programs, which is the directional albedo.
"""

import numpy as np

from ..arrays import FloatArray

_STEP = np.radians(0.5)     # of the sums, within which values are interpolated linearly
_WHOLE = 2 * np.pi
_SAME = 1e-6                # radians


def weights(azimuths: FloatArray, radials: FloatArray, tilt: float) -> FloatArray:
    """What each value of a table counts in the integral of f cos(theta_o) over the hemisphere: (azimuths, radials).

    The angles, (n,) and (m,) radians, rise: about an axis, and away from it. `tilt` is the axis' angle from the normal,
    towards the azimuth pi: 0, or theta_i of tables about the mirrored ray. Between the nodes, values are linear in both
    angles. Azimuths over half a turn stand for the other half as well; those that lack the end of a turn are closed.
    """
    around, share = _azimuth_weights(azimuths)
    outward, steps = _interpolation(radials)
    radial = radials[0] + (np.arange(len(outward)) + 0.5) * steps
    turn = around[:, -1][:, None]
    cosine = np.cos(tilt) * np.cos(radial) + np.sin(tilt) * np.sin(radial) * np.cos(turn)
    area = share * steps * np.sin(radial) * np.maximum(cosine, 0)
    return np.asarray(around[:, :-1].T @ area @ outward)


def _azimuth_weights(azimuths: FloatArray) -> tuple[FloatArray, float]:
    """For each step of azimuth the weights of the nodes and the azimuth itself, (steps, n + 1); what a step stands for.
    """
    span = azimuths[-1] - azimuths[0]
    if span < _SAME:
        turns = np.arange(0, _WHOLE, _STEP)
        return np.column_stack([np.ones((len(turns), 1)) / len(azimuths) * np.ones(len(azimuths)), turns]), _STEP
    closed = azimuths if span > _WHOLE - _SAME or span < np.pi + _SAME else np.append(azimuths, azimuths[0] + _WHOLE)
    nodes, step = _interpolation(closed)
    turns = closed[0] + (np.arange(len(nodes)) + 0.5) * step
    if len(closed) > len(azimuths):
        nodes[:, 0] += nodes[:, -1]
        nodes = nodes[:, :-1]
    return np.column_stack([nodes, turns]), step * _WHOLE / (closed[-1] - closed[0])


def _interpolation(nodes: FloatArray) -> tuple[FloatArray, float]:
    """The weights of the nodes at the middle of each step between the first and the last, and the step."""
    count = max(round((nodes[-1] - nodes[0]) / _STEP), 1)
    step = (nodes[-1] - nodes[0]) / count
    at = nodes[0] + (np.arange(count) + 0.5) * step
    return np.stack([np.interp(at, nodes, one) for one in np.eye(len(nodes))], axis=1), float(step)

"""The light that a narrow highlight reflects, where an even grid over the hemisphere would miss it."""

import numpy as np


def mirror_albedo(fit, theta):
    """Directional albedo (channels,) at a polar angle in radians, by rings about the mirror direction, closer there."""
    mirror, x = np.array([-np.sin(theta), 0, np.cos(theta)]), np.array([np.cos(theta), 0, np.sin(theta)])
    y = np.cross(mirror, x)
    u, turn = (np.arange(400) + 0.5) / 400, 2 * np.pi * (np.arange(240) + 0.5) / 240
    away, width = np.pi * u ** 3, 3 * np.pi * u ** 2 / 400
    to = (np.cos(away)[:, None, None] * mirror + np.sin(away)[:, None, None]
          * (np.cos(turn)[:, None] * x + np.sin(turn)[:, None] * y))
    up = to[..., 2] > 1e-3
    value = fit.evaluate(theta, 0.0, np.arccos(np.clip(to[up, 2], -1, 1)), np.arctan2(to[up, 1], to[up, 0]))
    weight = np.broadcast_to((np.sin(away) * width)[:, None] * (2 * np.pi / 240), up.shape)[up] * to[up, 2]
    return value.T @ weight

"""Spheres by numerical integration of `Fit.evaluate`: references for renders, and pictures under lamps far away.

A lamp is the direction to it, and its irradiance over pi.
"""

import numpy as np

from fitter.imaging.pictures import draw_sphere, sphere, srgb

LAMPS = ((-0.5, 0.6, 0.62), 1.0), ((0.9, -0.1, 0.42), 0.25)


def normals(resolution):
    """Normals of the unit sphere at the pixels of a picture of it, those that miss left out: (n, 3)."""
    x = (np.arange(resolution) + 0.5) / resolution * 2 - 1
    x, y = np.meshgrid(x, x)
    on_it = x**2 + y**2 < 1
    return np.stack([x[on_it], y[on_it], np.sqrt(1 - x[on_it]**2 - y[on_it]**2)], axis=1)


def reflected(fit, n, toward):
    """f(toward, viewer) cos theta_i at points with normals n (m, 3), seen from +z: (m, channels)."""
    cos_i, cos_o = (n * toward).sum(axis=1), n[:, 2]
    toward_t, viewer_t = toward - cos_i[:, None] * n, [0, 0, 1] - cos_o[:, None] * n
    delta_phi = np.arctan2((np.cross(toward_t, viewer_t) * n).sum(axis=1), (toward_t * viewer_t).sum(axis=1))
    value = fit.evaluate(np.arccos(cos_i.clip(0, 1)), 0, np.arccos(cos_o.clip(0, 1)), delta_phi)
    return np.maximum(value, 0) * cos_i.clip(0)[:, None]


def radial(n):
    """The tangents that Blender gives a mesh by default, at points of the unit sphere (m, 3): around its z axis."""
    return np.stack([-n[:, 1], n[:, 0], np.zeros(len(n))], axis=1)


def turned_tangents(n, tangent, turn):
    """Tangents and bitangents at points with normals n (m, 3), turned about these by an angle in radians."""
    along = tangent - (tangent * n).sum(axis=1, keepdims=True) * n
    along = along / np.linalg.norm(along, axis=1, keepdims=True)
    across = np.cross(n, along)
    return np.cos(turn) * along + np.sin(turn) * across, np.cos(turn) * across - np.sin(turn) * along


def reflected_on(fit, n, tangent, toward, turn=0.0):
    """As `reflected`, of an anisotropic surface with tangents (m, 3), which are turned by an angle in radians."""
    along, across = turned_tangents(n, tangent, turn)
    cos_i, cos_o = (n * toward).sum(axis=1), n[:, 2]
    phi_i = np.arctan2((across * toward).sum(axis=1), (along * toward).sum(axis=1))
    value = fit.evaluate(np.arccos(cos_i.clip(0, 1)), phi_i, np.arccos(cos_o.clip(0, 1)),
                         np.arctan2(across[:, 2], along[:, 2]))
    return np.maximum(value, 0) * cos_i.clip(0)[:, None]


def reflected_by_lamps(fit, normals, lamps):
    """What a surface with normals (n, 3) reflects to the viewer, (n, 3); its tangents go around the vertical axis."""
    tangents = np.cross([0.0, 1.0, 0.0], normals)
    radiance = np.zeros((len(normals), 3))
    for direction, strength in lamps:
        radiance += np.pi * strength * reflected_on(fit, normals, tangents, direction / np.linalg.norm(direction))
    return radiance


def lamp_sphere(fit, size, lamps):
    """The picture of a sphere whose colours are in Rec.709: (size, size, 4) float32."""
    return draw_sphere(srgb(reflected_by_lamps(fit, sphere(size)[0], lamps)), size)

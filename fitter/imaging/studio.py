"""A photographer's studio, in which thumbnails of materials are drawn, and what a sphere reflects of it: a square
window above on the left, a narrow light on the right, a reflector below, and walls that are lighter toward the ceiling,
so that a metal has something to show. The view is (0, 0, 1), orthographic; y is up.

Of an isotropic material what a sphere shows depends on its normal's angle to the view, and turns with the normal's
azimuth about the view: the BRDF is integrated in rings about the view's axis, for some angles only, and correlated with
the studio over the azimuth. Where the material is anisotropic, each of fewer normals is looked at by itself.
"""

from collections.abc import Callable
from functools import cache

import numpy as np

from ..arrays import FloatArray, IntArray, unit_vectors
from ..model import Reflectance, is_isotropic

Sky = Callable[[FloatArray], FloatArray]        # radiance from unit vectors (..., 3): (...)
_WINDOW_LIGHT = (-0.5, 0.6, 0.62), 0.42, 0.42, 8.4  # direction, half width and half height as slopes, and radiance
_STRIP_LIGHT = (0.93, 0.05, 0.36), 0.13, 0.75, 3.1
_UPPER, _WALL, _LOWER, _REFLECTOR = 0.66, 0.19, 0.12, 0.54  # radiances
_ANGLES = 40                # of the normal to the view, at which a sphere is looked at
_STUDIO_RINGS, _STUDIO_SECTORS = 72, 108  # cells of the studio about the view: their angle from it, and their azimuth
_WHITE = 3.5                # what the tone curve x (1 + a x) / (1 + b x) takes to 1
_CURVE_B = 2.6
_CURVE_A = ((1 + _WHITE * _CURVE_B) / _WHITE - 1) / _WHITE
# half vectors: angles from the normal, azimuths, and parts of their cells
_HALF_VECTORS, _HALF_TURNS, _CELL_PARTS = 36, 32, 3
_MIDDLE = _CELL_PARTS ** 2 // 2        # of the parts
_LAST, _LAST_COSINE = np.radians(89), np.cos(np.radians(89))  # where a material is looked at last: angle, and cosine
_FEW_ANGLES, _FEW_SECTORS, _FEW_HALF, _FEW_TURNS = 18, 40, 28, 24       # the same of an anisotropic material
_FIRST_ANGLE, _EVEN_FROM = 1e-3, 0.6  # radians: the first of these angles, and from which on they are evenly spaced


def radiance(direction: FloatArray) -> FloatArray:
    """The studio's radiance from unit vectors (..., 3): (...).

    Examples
    --------
    The window is brighter than the ceiling, that than the wall; light comes from below too.

    >>> at = np.array([[-0.5, 0.6, 0.62], [0, 1, 0], [0, 0, 1], [0, -0.8, 0.6]])
    >>> window, ceiling, wall, below = radiance(at / np.linalg.norm(at, axis=1, keepdims=True))
    >>> bool(window > ceiling > wall), bool(below > wall)
    (True, True)
    """
    height = direction[..., 1]
    found = _WALL + (_UPPER - _WALL) * _step(-0.1, 0.9, height) + (_LOWER - _WALL) * _step(0.05, -0.1, height)
    found = found + _REFLECTOR * _step(-0.5, -0.75, height) * _step(-0.5, 0.3, direction[..., 2])
    for toward, half_width, half_height, strength in (_WINDOW_LIGHT, _STRIP_LIGHT):
        found = found + strength * softbox(direction, toward, half_width, half_height)
    return np.asarray(found)


def softbox(direction: FloatArray, toward: tuple[float, float, float], half_width: float,
            half_height: float) -> FloatArray:
    """What a rectangular light far away, of radiance 1, shows in directions (..., 3): (...), 0 beyond its soft edges.
    `toward` is the direction of its middle, which is not along y, and half of its sides are slopes. y is up."""
    axis = np.array(toward) / np.linalg.norm(toward)
    side = np.cross([0, 1, 0], axis)
    side /= np.linalg.norm(side)
    along = direction @ axis
    slopes = [np.abs(direction @ each) / np.maximum(along, 1e-6) for each in (side, np.cross(axis, side))]
    inside = (_step(half_width + 0.02, half_width - 0.02, slopes[0])
              * _step(half_height + 0.02, half_height - 0.02, slopes[1]))
    return np.asarray(inside * (along > 0))


def _step(first: float, last: float, value: FloatArray) -> FloatArray:
    """From 0 at `first` to 1 at `last`, smoothly."""
    share = np.clip((value - first) / (last - first), 0, 1)
    return np.asarray(share ** 2 * (3 - 2 * share))


def tone_map(linear: FloatArray) -> FloatArray:
    """Linear values (..., 3) compressed for a picture: the largest channel x becomes x (1 + a x) / (1 + b x), which
    leaves dark paints as they are and takes 3.5 to 1. The other channels keep their ratios to it, and so the hue.

    Examples
    --------
    >>> tone_map(np.array([[0.01, 0.02, 0.01], [3.5, 3.5, 1.75]])).round(3).tolist()
    [[0.01, 0.02, 0.01], [1.0, 1.0, 0.5]]
    """
    largest = np.maximum(linear.max(axis=-1, keepdims=True), 0)
    return np.asarray(linear * (1 + _CURVE_A * largest) / (1 + _CURVE_B * largest))


def on_sphere(fit: Reflectance, normal: FloatArray) -> FloatArray:
    """What a sphere, whose tangent goes around the vertical axis, shows of the studio at normals (n, 3): (n,
    channels)."""
    return sky_radiances(fit, normal, (radiance,))[0]


def sky_radiances(fit: Reflectance, normal: FloatArray, skies: tuple[Sky, ...]) -> FloatArray:
    """The same under several skies, (skies, n, channels), in the time of one."""
    isotropic = is_isotropic(fit)
    angles, sectors = (_ANGLES, _STUDIO_SECTORS) if isotropic else (_FEW_ANGLES, _FEW_SECTORS)
    theta_o = np.linspace(0, _LAST, angles)
    seen_at = _radiance_over_azimuth if isotropic else _radiance_at_normals
    shown = np.stack([seen_at(fit, theta, skies) for theta in theta_o], axis=1)     # skies, angles, sectors, channels
    row = np.arccos(np.clip(normal[:, 2], 0, 1)) / theta_o[1]
    column = np.arctan2(normal[:, 1], normal[:, 0]) / (2 * np.pi) * sectors
    above, left = np.minimum(row.astype(int), angles - 2), np.floor(column).astype(int)
    down, right = np.minimum(row - above, 1)[:, None], (column - left)[:, None]
    first, second = left % sectors, (left + 1) % sectors
    return np.asarray((1 - down) * ((1 - right) * shown[:, above, first] + right * shown[:, above, second])
                      + down * ((1 - right) * shown[:, above + 1, first] + right * shown[:, above + 1, second]))


def _radiance_over_azimuth(fit: Reflectance, theta_o: float, skies: tuple[Sky, ...]) -> FloatArray:
    """Skies correlated with the BRDF over the azimuth, at an angle to the view: (skies, sectors, channels)."""
    theta_i, phi_i, cell, weight = _light_directions(theta_o)
    value = np.maximum(fit.evaluate(theta_i, phi_i, theta_o, 0), 0)
    weights = np.stack([np.bincount(cell, (weight * channel[:, None]).ravel(), _STUDIO_RINGS * _STUDIO_SECTORS)
                        for channel in value.T], axis=-1)
    spectrum = np.conj(np.fft.rfft(weights.reshape(_STUDIO_RINGS, _STUDIO_SECTORS, -1), axis=1))
    correlated = np.stack([np.einsum("rsc,rs->sc", spectrum, _sky_spectrum(sky)) for sky in skies])
    return np.asarray(np.fft.irfft(correlated, _STUDIO_SECTORS, axis=1))


@cache
def _light_directions(theta_o: float) -> tuple[FloatArray, FloatArray, IntArray, FloatArray]:
    """Incident directions of cells of half vectors, for a normal at an angle to the view: theta_i and phi_i, (n,); and
    of their parts the cell of the sky about the view, (n * parts,), and the projected solid angle, (n, parts)."""
    h, size = _half_vectors(_HALF_VECTORS, _HALF_TURNS)
    view = np.array([np.sin(theta_o), 0, np.cos(theta_o)])
    light, weight = _incident(h, size, view)
    middle = light[:, _MIDDLE]
    # to the picture's frame, in which the view is z and the normal leans toward x
    lean = light @ np.array([-np.cos(theta_o), 0, np.sin(theta_o)])
    ring = np.minimum((np.arccos(np.clip(light @ view, -1, 1)) / np.pi * _STUDIO_RINGS).astype(int), _STUDIO_RINGS - 1)
    azimuth = np.arctan2(light[..., 1], lean) / (2 * np.pi)
    sector = np.floor(azimuth * _STUDIO_SECTORS + 0.5).astype(int) % _STUDIO_SECTORS
    return (np.arccos(np.clip(middle[:, 2], _LAST_COSINE, 1)), np.arctan2(middle[:, 1], middle[:, 0]),
            (ring * _STUDIO_SECTORS + sector).ravel(), weight)


def _radiance_at_normals(fit: Reflectance, theta_o: float, skies: tuple[Sky, ...]) -> FloatArray:
    """The same of an anisotropic material, (skies, few sectors, channels)."""
    h, size = _half_vectors(_FEW_HALF, _FEW_TURNS)
    view, found = np.array([0.0, 0.0, 1.0]), []
    for azimuth in np.arange(_FEW_SECTORS) * 2 * np.pi / _FEW_SECTORS:
        normal = unit_vectors(theta_o, azimuth)
        tangent = np.array([normal[2], 0, -normal[0]])          # the vertical axis x normal
        tangent /= max(np.linalg.norm(tangent), 1e-9)
        frame = np.stack([tangent, np.cross(normal, tangent), normal])
        toward = frame @ view
        light, weight = _incident(h, size, toward)
        middle = light[:, _MIDDLE]
        value = np.maximum(fit.evaluate(np.arccos(np.clip(middle[:, 2], _LAST_COSINE, 1)),
                                        np.arctan2(middle[:, 1], middle[:, 0]), theta_o,
                                        np.arctan2(toward[1], toward[0])), 0)
        found.append([(weight * sky(light @ frame)).sum(axis=1) @ value for sky in skies])
    return np.stack(found, axis=1)


def _incident(h: FloatArray, size: FloatArray, view: FloatArray) -> tuple[FloatArray, FloatArray]:
    """The light that half vectors (n, parts, 3) send to the view, and its solid angles times its cosines."""
    cosine = h @ view
    light = 2 * cosine[..., None] * h - view
    return light, 4 * np.maximum(cosine, 0) * size * np.maximum(light[..., 2], 0)


@cache
def _sky_spectrum(sky: Sky) -> FloatArray:
    """A sky's radiance in cells about the view, transformed over the azimuth."""
    theta = (np.arange(_STUDIO_RINGS) + 0.5) / _STUDIO_RINGS * np.pi
    phi = np.arange(_STUDIO_SECTORS) / _STUDIO_SECTORS * 2 * np.pi
    return np.asarray(np.fft.rfft(sky(unit_vectors(theta[:, None], phi)), axis=1))


@cache
def _half_vectors(count: int, turns: int) -> tuple[FloatArray, FloatArray]:
    """Half vectors about the normal, (n, parts, 3), and their solid angles, (n, parts): cells, where the material is
    looked at, and parts of these, where the studio is."""
    place = np.concatenate([[0.0], np.geomspace(_FIRST_ANGLE, np.pi / 2, 4000)])
    way = np.log1p(place / _FIRST_ANGLE) + place / (_EVEN_FROM / np.log(_EVEN_FROM / _FIRST_ANGLE))
    edges = np.interp(np.linspace(0, way[-1], count * _CELL_PARTS + 1), way, place)
    theta, phi = np.meshgrid((edges[1:] + edges[:-1]) / 2,
                             (np.arange(turns * _CELL_PARTS) + 0.5) / (turns * _CELL_PARTS) * 2 * np.pi, indexing="ij")
    h = unit_vectors(theta, phi)
    size = np.broadcast_to((-np.diff(np.cos(edges)) * 2 * np.pi / (turns * _CELL_PARTS))[:, None], theta.shape)
    return (_arrange_cells(h.reshape(count, _CELL_PARTS, turns, _CELL_PARTS, 3)).reshape(count * turns, -1, 3),
            _arrange_cells(size.reshape(count, _CELL_PARTS, turns, _CELL_PARTS)).reshape(count * turns, -1))


def _arrange_cells(parts: FloatArray) -> FloatArray:
    return np.swapaxes(parts, 1, 2).copy()

"""Synthetic photographs of a flat sample of several materials, by a small renderer that shares nothing with
`fitter.photographs`: by dot products at each point, in no frame of its own."""

from dataclasses import dataclass
from typing import Any

import numpy as np
from scipy.ndimage import map_coordinates

from .ball_scene import Scene

CAMERA, TARGET = np.array([0.03, -0.12, 0.5]), np.zeros(3)
SIZE = 0.1                  # m, along u; along v it is .8 of it
ANGLE = 2 * np.degrees(np.arctan(0.125))         # that the width of a picture takes
INTENSITY = np.array([2.0, 1.5, 1.0])
UNUSED = np.array([0.3, 0.15, 0.55])


@dataclass(frozen=True)
class Sample:
    """Materials, and functions of u and v, both (n,), to their weights, (n, materials), and slopes, (n, 2)."""

    fits: tuple
    weights: Any
    slopes: Any

    def normals(self, u, v):
        """Unit normals, (n, 3): the plane's is z."""
        slope = self.slopes(u, v)
        steep = np.column_stack([slope, np.ones(len(slope))])
        return steep / np.sqrt((steep ** 2).sum(axis=1))[:, None]


def corners():
    """Of the sample, (4, 3): u runs along x, v along y."""
    x, y = SIZE / 2, SIZE * 0.4
    return np.array([[-x, -y, 0], [x, -y, 0], [x, y, 0], [-x, y, 0]])


def lamps(count=16):
    """Places of lamps in rings around the camera, (count, 3), half a metre to a metre away."""
    k = np.arange(count)
    theta, phi = np.radians(np.array([12, 30, 48, 62]))[k % 4], 2.399 * k + 0.3
    distance = 0.6 + 0.05 * (k % 5)
    return distance[:, None] * np.column_stack([np.sin(theta) * np.cos(phi), np.sin(theta) * np.sin(phi),
                                                np.cos(theta)])


def radiance(sample, u, v, lamp, camera=CAMERA):
    """What points of the sample send to the camera: (n, 3)."""
    place = np.column_stack([(u - 0.5) * SIZE, (v - 0.5) * SIZE * 0.8, np.zeros(len(u))])
    normal, to_lamp, to_camera = sample.normals(u, v), lamp - place, camera - place
    d = np.sqrt((to_lamp ** 2).sum(axis=1))
    light, view = to_lamp / d[:, None], to_camera / np.sqrt((to_camera ** 2).sum(axis=1))[:, None]
    cos_i, cos_o, cos_phase = (each.sum(axis=1) for each in (normal * light, normal * view, light * view))
    lit = (cos_i > 0) & (cos_o > 0)
    cos_i, cos_o = np.clip(cos_i, 0, 1), np.clip(cos_o, 0, 1)
    sines = np.sqrt((1 - cos_i ** 2) * (1 - cos_o ** 2))
    azimuth = np.arccos(np.clip((cos_phase - cos_i * cos_o) / np.maximum(sines, 1e-12), -1, 1))
    values = np.stack([fit.evaluate(np.arccos(cos_i), 0, np.arccos(cos_o), azimuth) * np.ones(3)
                       for fit in sample.fits], axis=2)
    weights = sample.weights(u, v) * (cos_i / d ** 2)[:, None]
    return np.where(lit[:, None], (values * weights[:, None]).sum(axis=2), 0) * INTENSITY


def rays(size, camera=CAMERA):
    """Unit directions through the centres of so many pixels, (height, width), that see the sample: (h, w, 3)."""
    return Scene(camera, TARGET, size=size, angle=ANGLE).rays()


def project(points, size):
    """Where points (n, 3) are in a picture of this height and width: (n, 2), pixels from the left and top."""
    forward, right, up = Scene(CAMERA, TARGET).basis()
    toward = points - CAMERA
    step = (toward @ forward) * 0.25 / size[1]
    return np.column_stack([size[1] / 2 + toward @ right / step, size[0] / 2 - toward @ up / step])


def photograph(sample, lamp, size=(90, 100), noise=0.01, seed=0, camera=CAMERA):
    """A photograph, (h, w, 3), dark around the sample; noise is relative, with a floor of .1 % of what is typical."""
    toward = rays(size, camera).reshape(-1, 3)
    place = camera - toward * (camera[2] / toward[:, 2])[:, None]
    u, v = place[:, 0] / SIZE + 0.5, place[:, 1] / (SIZE * 0.8) + 0.5
    inside = (u > 0) & (u < 1) & (v > 0) & (v < 1)
    picture = np.zeros((len(toward), 3))
    picture[inside] = radiance(sample, u[inside], v[inside], lamp, camera)
    random = np.random.default_rng(seed)
    typical = np.median(picture[inside])
    picture = picture * (1 + noise * random.standard_normal(picture.shape))
    return (picture + 0.1 * noise * typical * random.standard_normal(picture.shape)).reshape(*size, 3)


def texels(shape):
    """u and v of the centres of texels, row by row: (n,) each."""
    v, u = (np.mgrid[:shape[0], :shape[1]] + 0.5) / np.array(shape)[:, None, None]
    return u.ravel(), v.ravel()


def smooth_weights(count):
    """Weights of 2 or 3 materials that pass into one another, of sum 1."""
    def weights(u, v):
        first = 0.5 + 0.5 * np.sin(5 * u + 2 * v)
        second = (1 - first) * (1 if count == 2 else 0.5 + 0.5 * np.cos(6 * v - u))
        return np.column_stack([first, second, 1 - first - second][:count])
    return weights


def sharp_weights(count):
    """Weights of 2 or 3 materials in fields beside each other."""
    def weights(u, v):
        field = np.where((u - 0.5) ** 2 + (v - 0.5) ** 2 < 0.1, 0, 1 if count == 2 else 1 + (u > 0.5))
        return np.eye(count)[field]
    return weights


def bumps(u, v):
    """Slopes to 15 degrees."""
    steepest = np.tan(np.radians(15)) / np.sqrt(2)
    return steepest * np.column_stack([np.sin(9 * u + 3 * v), np.cos(7 * v - 2 * u)])


def shown(picture, shape):
    """A picture at the centres of texels, by SciPy's linear interpolation: (h, w, 3)."""
    u, v = texels(shape)
    x, y = project(np.column_stack([(u - 0.5) * SIZE, (v - 0.5) * SIZE * 0.8, np.zeros(len(u))]),
                   picture.shape[:2]).T - 0.5
    return np.stack([map_coordinates(picture[..., k], [y, x], order=1) for k in range(3)], axis=1).reshape(*shape, 3)

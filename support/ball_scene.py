"""Synthetic photographs of a painted ball, by a small renderer that shares nothing with `fitter.photographs`.

In each pixel the radiance is the mean over points of its area of an integral over the lamp, an evenly bright ball; a
lamp without a size is one direction. Around the ball it is dark.
"""

from dataclasses import dataclass, replace

import numpy as np

from . import truths

FLOOR = 1e-3                # noise of a pixel beside what is relative to it, of the picture's typical brightness


@dataclass(frozen=True)
class Scene:
    """A camera, a ball and a lamp; metres, and W/sr in units of the picture. z is up."""

    camera: tuple = (0.0, -1.5, 0.0)
    target: tuple = (0.0, 0.0, 0.0)         # that the camera looks to
    centre: tuple = (0.0, 0.0, 0.0)
    radius: float = 0.05
    lamp: tuple = (0.5, -1.0, 0.5)
    intensity: tuple = (2.0, 2.0, 2.0)
    lamp_radius: float = 0.0
    size: tuple = (120, 120)                # height and width, pixels
    angle: float = 4.2                      # that the width takes, degrees

    def basis(self):
        """The directions forward, right and up in the picture."""
        forward = np.subtract(self.target, self.camera)
        forward /= np.linalg.norm(forward)
        right = np.cross(forward, (0, 0, 1))
        right /= np.linalg.norm(right)
        return forward, right, np.cross(right, forward)

    def toward(self, row, column):
        """Unit directions through places of the picture, in pixels: the centre of the first is (.5, .5)."""
        height, width = self.size
        forward, right, up = self.basis()
        step = 2 * np.tan(np.radians(self.angle) / 2) / width
        found = (forward + ((np.asarray(column) - width / 2) * step)[..., None] * right
                 + ((height / 2 - np.asarray(row)) * step)[..., None] * up)
        return found / np.linalg.norm(found, axis=-1)[..., None]

    def rays(self):
        """Unit directions through the pixels' centres: (height, width, 3)."""
        rows, columns = np.mgrid[:self.size[0], :self.size[1]] + 0.5
        return self.toward(rows, columns)


def at_phase(degrees, turn=0.0, distance=1.2, **settings):
    """A `Scene` whose lamp stands at an angle from the camera, as the ball sees both, and turned about that axis."""
    scene = Scene(**settings)
    forward, right, up = scene.basis()
    phase, turn = np.radians((degrees, turn))
    across = np.cos(turn) * right + np.sin(turn) * up
    place = np.asarray(scene.centre) + distance * (-np.cos(phase) * forward + np.sin(phase) * across)
    return replace(scene, lamp=tuple(place))


def photograph(model, scene, points=2, directions=12, noise=0.0, seed=0):
    """What the camera of a scene sees: (height, width, 3) float64.

    There are so many points along each side of a pixel, and directions to a lamp with a size. The noise is the relative
    standard deviation of a pixel; `FLOOR` says what is added in the dark.
    """
    height, width = scene.size
    places = (np.arange(points) + 0.5) / points
    picture = np.zeros((height * width, 3))
    for row in places:
        for column in places:
            y, x = np.mgrid[:height, :width]
            picture += _seen(model, scene, scene.toward(y + row, x + column).reshape(-1, 3), directions)
    picture = (picture / points ** 2).reshape(height, width, 3)
    if noise:
        random = np.random.default_rng(seed)
        typical = np.median(picture[picture > 0]) if (picture > 0).any() else 0.0
        picture = (picture * (1 + noise * random.standard_normal(picture.shape))
                   + FLOOR * typical * random.standard_normal(picture.shape))
    return picture


def _seen(model, scene, ray, directions):
    """The radiance along rays (n, 3): (n, 3)."""
    centre, origin = np.asarray(scene.centre), np.asarray(scene.camera)
    nearest = (centre - origin) @ ray.T
    miss2 = np.sum((origin + nearest[:, None] * ray - centre) ** 2, axis=1)
    met = np.flatnonzero((miss2 < scene.radius ** 2) & (nearest > 0))
    point = origin + (nearest[met] - np.sqrt(scene.radius ** 2 - miss2[met]))[:, None] * ray[met]
    normal = (point - centre) / scene.radius
    found = np.zeros((len(ray), 3))
    for toward, share in _lamp(scene, point, directions):
        lit = np.flatnonzero(np.sum(toward * normal, axis=1) > 0)
        # a frame for each point, whose x axis is toward the light
        n, light, view = normal[lit], toward[lit], -ray[met][lit]
        cosine = np.sum(n * light, axis=1)
        tangent = light - cosine[:, None] * n
        tangent /= np.maximum(np.linalg.norm(tangent, axis=1, keepdims=True), 1e-12)
        other = np.cross(n, tangent)
        x, y, z = (np.sum(view * axis, axis=1) for axis in (tangent, other, n))
        value = model.evaluate(np.arctan2(np.linalg.norm(np.cross(n, light), axis=1), cosine), np.zeros(len(lit)),
                               np.arctan2(np.hypot(x, y), np.maximum(z, 0)), np.arctan2(y, x))
        found[met[lit]] += np.maximum(value, 0) * (share[lit] * cosine)[:, None]
    return found * np.asarray(scene.intensity)


def _lamp(scene, point, directions):
    """Directions to a lamp (n, 3), and what each brings, for an intensity of 1 (n,)."""
    away = np.asarray(scene.lamp) - point
    distance = np.linalg.norm(away, axis=1)
    axis = away / distance[:, None]
    if not scene.lamp_radius:
        yield axis, 1 / distance ** 2
        return
    helper = np.where(np.abs(axis[:, 2:]) < 0.9, (0.0, 0.0, 1.0), (1.0, 0.0, 0.0))
    first = np.cross(axis, helper)
    first /= np.linalg.norm(first, axis=1, keepdims=True)
    second = np.cross(axis, first)
    edge = np.sqrt(1 - (scene.lamp_radius / distance) ** 2)
    for k in range(directions):         # evenly over the cone: a golden spiral
        cosine = 1 - (k + 0.5) / directions * (1 - edge)
        sine, turn = np.sqrt(1 - cosine ** 2), k * np.pi * (3 - np.sqrt(5))
        toward = (cosine[:, None] * axis + (sine * np.cos(turn))[:, None] * first
                  + (sine * np.sin(turn))[:, None] * second)
        yield toward, 2 * np.pi * (1 - edge) / directions / (np.pi * scene.lamp_radius ** 2)


PHASES = 12, 35, 55, 75, 95, 115, 135, 150      # degrees from the camera, of eight lamps
UNUSED = 65, 200                                # phase and turn of a lamp that is none of them


def scenes(phases=PHASES, **settings):
    """A `Scene` for each phase angle; from one to the next the lamp turns about the camera's axis by 40 degrees."""
    return [at_phase(phase, 40.0 * k, **{"lamp_radius": 0.02, **settings}) for k, phase in enumerate(phases)]


def matte():
    """A matte paint, by Oren and Nayar."""
    return truths.Truth("matte", "paint", truths._matte([0.5, 0.4, 0.3], 0.4))


def satin():
    """A paint with a wide highlight."""
    return truths.Truth("satin", "paint", truths._sum(
        truths.Truth("", "", truths._matte([0.1, 0.2, 0.3], 0.3)), truths._lobe(0.6, 0.35, f0=0.05)))


def glossy():
    """A paint with a highlight of GGX .1."""
    return truths.Truth("glossy", "paint", truths._sum(
        truths.Truth("", "", truths._matte([0.3, 0.05, 0.05], 0.3)), truths._lobe(4.0, 0.1, f0=0.05)))


def velvet():
    """Fibres that shine at grazing angles."""
    return truths.TRUTHS["velvet a"]

"""Light below a surface, from measured coefficients; and the inputs with which Cycles' random walk shows it.

A half-space scatters by sigma'_s, reduced as by H. W. Jensen, S. Marschner, M. Levoy, P. Hanrahan (A Practical Model
for Subsurface Light Transport, SIGGRAPH 2001), and absorbs by sigma_a, below a smooth dielectric. Without a surface it
reflects from direction mu' to mu, with the single scattering albedo a = sigma'_s / (sigma'_s + sigma_a) ::

    a / 2 mu' / (mu + mu') H(mu) H(mu'),    1 / H(mu) = sqrt(1 - a) + a / 2 integral mu' H(mu') / (mu + mu') dmu'

(S. Chandrasekhar: Radiative Transfer, 1960, sections 33 and 39), and Fresnel's equations send a part of that back.

Cycles' random walk (intern/cycles/kernel/integrator/subsurface_random_walk.h and closure/bssrdf.h of Blender 5.0) has
nothing that sends light back, ends after 256 steps, and makes of a radius the mean free path, radius / (4 pi). So the
colour is that whose walk reflects as much, and the radius is divided by a factor, `_WIDER`, with which the radii within
which half and nine tenths of the light leave are right in their geometric mean: `python -m benchmarks.translucent`
finds it by photons. Refracted by the root of the index as it enters, both are.
"""

from collections.abc import Callable
from dataclasses import dataclass
from functools import cache
from typing import NamedTuple

import numpy as np

from ..arrays import ArrayLike, FloatArray
from .fresnel import fresnel

INDICES = 1.1, 2.0                  # bounds of the index of refraction
LONGEST = 1000.0                    # mm: of mean free paths
_NEAR, _FAR = (1.8260523782, 5.1124679032, 1.09686102424), (0.496310210422, 4.2350090365, 2.40602999408)
_LEAST_SCATTERED, _MOST_SCATTERED, _WALK_STEPS = 0.2, 0.999999, 256  # of Cycles' walk: single scattering albedo, steps
_HALVINGS, _ITERATIONS, _CLOSE = 40, 2000, 1e-9
ABSORBED = np.array([0.012, 0.025, 0.05, 0.1, 0.2, 0.35, 0.5, 0.65, 0.8, 0.93, 0.985])    # sqrt(1 - a) of columns,
INDICES_OF_FACTOR = np.array([1.1, 1.3, 1.5, 1.75, 2.0])                                  # and index of rows
_WIDER = np.array([[0.659, 0.739, 0.792, 0.800, 0.802, 0.823, 0.867, 0.934, 1.026, 1.192, 1.300],
                   [0.494, 0.558, 0.575, 0.579, 0.591, 0.645, 0.734, 0.867, 1.058, 1.399, 1.539],
                   [0.390, 0.430, 0.441, 0.448, 0.474, 0.541, 0.661, 0.837, 1.135, 1.577, 1.794],
                   [0.310, 0.325, 0.333, 0.345, 0.379, 0.467, 0.610, 0.820, 1.239, 1.795, 2.129],
                   [0.238, 0.249, 0.255, 0.275, 0.315, 0.413, 0.572, 0.842, 1.323, 2.027, 2.381]])


class Walk(NamedTuple):
    """Inputs of Cycles' random walk, (3,) each."""

    color: FloatArray
    radius: FloatArray      # mm
    rest: FloatArray        # albedo that walks of 256 steps do not reach: a diffuse surface has it
    entry: float            # the index by which light is refracted as it enters
    albedo: FloatArray      # of light that has entered, with the rest
    surface: float          # the index of the surface above


@dataclass(frozen=True, eq=False)
class Subsurface:
    """What is below a surface."""

    albedo: FloatArray              # (3,): the share of light that enters, evenly from all sides, which leaves again
    mean_free_path: FloatArray      # (3,): 1 / (sigma'_s + sigma_a), mm
    index: float                    # of refraction

    def diffuse(self, theta_i: ArrayLike, theta_o: ArrayLike) -> FloatArray:
        """The diffuse surface of the same albedo, 1/sr: angles that broadcast to (...), radians, to (..., 3)."""
        through = self._transmittance(theta_i) * self._transmittance(theta_o) / self._mean_transmittance
        return np.asarray(through[..., None] * self.albedo / np.pi)

    def _transmittance(self, theta: ArrayLike) -> FloatArray:
        return 1 - fresnel(self.index, np.maximum(np.cos(np.asarray(theta, dtype=float)), 0))

    @property
    def _mean_transmittance(self) -> float:
        cosine, weight = _gauss(0, 1)
        return float(2 * (cosine * weight) @ (1 - fresnel(self.index, cosine)))

    @property
    def single_scattering_albedo(self) -> FloatArray:
        """The single scattering albedo, (3,)."""
        return np.array([bisect(lambda a: multiple_scattering_albedo(a, self.index), each) for each in self.albedo])

    @property
    def walk(self) -> Walk:
        """The inputs of Cycles' walk."""
        index = float(np.sqrt(self.index))
        reached = np.minimum(self.albedo, walk_albedo(_MOST_SCATTERED, index))
        scattered = np.array([bisect(lambda a: walk_albedo(a, index), each) for each in reached])
        color = np.array([bisect(color_to_single_scattering, each) for each in scattered])
        radius = 4 * np.pi * self.mean_free_path / path_widening(self.single_scattering_albedo, self.index)
        return Walk(color, radius, self.albedo - reached, index, self.albedo, self.index)


def medium_from_coefficients(scattering: ArrayLike, absorption: ArrayLike, index: float) -> Subsurface:
    """Of reduced scattering and of absorption, (3,) each, 1/mm. Raises ValueError as `check` does."""
    scattering, absorption = (np.asarray(each, dtype=float) for each in (scattering, absorption))
    if not ((scattering >= 0) & (absorption >= 0) & (scattering + absorption > 0)).all():
        raise ValueError(f"scattering {scattering.tolist()} and absorption {absorption.tolist()}, expected numbers "
                         "of at least 0, of which one of each channel is above")
    extinction = scattering + absorption
    check(np.zeros(3), 1 / extinction, index)
    albedo = np.array([multiple_scattering_albedo(each, index) for each in scattering / extinction])
    return Subsurface(albedo, 1 / extinction, index)


def check(albedo: FloatArray, mean_free_path: FloatArray, index: float) -> None:
    """Raise ValueError where the numbers are those of no medium."""
    for name, numbers, low, high in (("albedo", albedo, 0, 1), ("mean free path", mean_free_path, 1e-6, LONGEST),
                                     ("index", np.array([index]), *INDICES)):
        if not ((numbers >= low) & (numbers <= high)).all():
            raise ValueError(f"{name} {np.ravel(numbers).tolist()}, expected {low:g} to {high:g}")


def color_to_single_scattering(color: float) -> float:
    """The single scattering albedo of which Cycles makes a colour's channel (M. Chiang, P. Kutz, B. Burley: Practical
    and Controllable Subsurface Scattering for Production Path Tracing, SIGGRAPH 2016 Talks; M. Wrenninge, R. Villemin,
    C. Hery: Path Traced Subsurface Scattering using Anisotropic Phase Functions and Non-Exponential Free Flights,
    2017)."""
    (a, b, c), (d, e, f), blend = _NEAR, _FAR, color ** 0.25
    return float(min((1 - blend) * a * np.arctan(b * color) ** c + blend * d * np.arctan(e * color) ** f,
                     _MOST_SCATTERED))


def multiple_scattering_albedo(scattered: float, index: float) -> float:
    """The albedo of a medium below a smooth dielectric for even light from outside, by Chandrasekhar's H."""
    if scattered >= 1:
        return 1.0
    critical = np.sqrt(1 - 1 / index ** 2)
    (held, of_held), (open_, of_open) = _gauss(0, critical), _gauss(critical, 1)
    mu, weight, passed = np.append(held, open_), np.append(of_held, of_open), np.zeros(2 * len(held))
    passed[len(held):] = 1 - fresnel(index, np.sqrt(1 - index ** 2 * (1 - open_ ** 2)))    # either way it is the same
    h = _h(scattered, mu, weight)
    below = scattered / 2 * np.outer(h, h * mu * weight) / np.add.outer(mu, mu)
    up = np.linalg.solve(np.eye(len(mu)) - below * (1 - passed), below @ passed)
    return float((mu * weight * passed) @ up / ((mu * weight) @ passed))


def walk_albedo(scattered: float, index: float) -> float:
    """The albedo of Cycles' random walk for even light from outside, refracted by an index. Without a surface a
    half-space reflects 1 - H(mu) sqrt(1 - a) of light from mu; a share of walks that falls as k^(-3/2) has k steps."""
    a = max(scattered, _LEAST_SCATTERED)
    root, weight = _gauss(0, 1)
    lost = _mean_entry_h(1.0, index) / np.sqrt(np.pi * _WALK_STEPS) * (weight @ a ** (_WALK_STEPS / root ** 2))
    return float((1 - _mean_entry_h(a, index) * np.sqrt(1 - a) - lost) * min(1.0, scattered / _LEAST_SCATTERED))


@cache
def _mean_entry_h(scattered: float, index: float) -> float:
    """The mean of H over even light from outside, refracted by an index."""
    cosine, weight = _gauss(0, 1)
    inside = np.sqrt(1 - (1 - cosine ** 2) / index ** 2)
    return float(2 * (cosine * weight) @ np.interp(inside, cosine, _h(scattered, cosine, weight)))


def path_widening(scattered: FloatArray, index: float) -> FloatArray:
    """The ratio of the distances at which light leaves by the walk and below a surface, of one path: (3,)."""
    at = np.sqrt(1 - scattered)
    rows = np.array([np.interp(at, ABSORBED, row) for row in _WIDER])
    return np.array([np.interp(index, INDICES_OF_FACTOR, column) for column in rows.T])


def _gauss(low: float, high: float) -> tuple[FloatArray, FloatArray]:
    """Nodes and weights of an integral, Gauss and Legendre's."""
    x, weight = np.polynomial.legendre.leggauss(24)
    return low + (high - low) * (x + 1) / 2, weight * (high - low) / 2


def _h(scattered: float, mu: FloatArray, weight: FloatArray) -> FloatArray:
    """Chandrasekhar's H at the nodes of an integral."""
    h, kernel = np.ones_like(mu), scattered / 2 * mu * weight / np.add.outer(mu, mu)
    for _ in range(_ITERATIONS):
        before, h = h, (h + 1 / (np.sqrt(1 - scattered) + kernel @ h)) / 2
        if np.abs(h - before).max() < _CLOSE:
            break
    return h


def bisect(function: Callable[[float], float], value: float) -> float:
    """The argument in [0, 1] at which a rising function has a value, by bisection."""
    low, high = 0.0, 1.0
    for _ in range(_HALVINGS):
        middle = (low + high) / 2
        low, high = (middle, high) if function(middle) < value else (low, middle)
    return high if value >= function(high) else low

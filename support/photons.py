"""Photons in a half-space that scatters isotropically: the truth that translucent materials are tested against, and
the random walk of Cycles, as its source has it. Lengths are in transport mean free paths, 1 / (sigma'_s + sigma_a).

In truth light is reflected inwards again by Fresnel's equations each time it meets the surface from below. In Cycles
(intern/cycles/kernel/integrator/subsurface_random_walk.h, Blender 5.0) nothing reflects inwards, a walk ends after 256
steps, and where the single-scattering albedo is below .2 it is .2, and the walk counts less.
"""

from collections.abc import Iterator

import numpy as np

from fitter.arrays import FloatArray
from fitter.optics.subsurface import Subsurface, color_to_single_scattering

SHARES = 0.5, 0.9                   # of the light that leaves: radii are compared within which these do
STEPS, LEAST_ALBEDO = 256, 0.2      # of Cycles' walk
_FADED = 0.1                        # weight below which half of the photons are given up, and the rest count twice


def radii(albedo: float, index: float, count: int, seed: int = 0) -> tuple[FloatArray, FloatArray]:
    """Where photons leave: their distances from where they entered, and what each counts, (n,); the weights add to the
    share of light that leaves again."""
    random = np.random.default_rng(seed)
    outside = np.sqrt(random.random(4 * count))
    inside = np.sqrt(1 - (1 - outside ** 2) / index ** 2)
    entered = inside[random.random(len(inside)) >= reflected(inside, index)][:count]
    return _walk(entered, np.full(count, 1 / count), albedo, index, None, random)


def cycles_radii(albedo: float, index: float, count: int, seed: int = 1) -> tuple[FloatArray, FloatArray]:
    """The same of Cycles' walk, whose light enters evenly from outside, refracted by an index."""
    random = np.random.default_rng(seed)
    weight = np.full(count, min(1.0, albedo / LEAST_ALBEDO) / count)
    inside = np.sqrt(1 - random.random(count) / index ** 2)
    return _walk(inside, weight, max(albedo, LEAST_ALBEDO), 1.0, STEPS, random)


def reflected(cosine: FloatArray, index: float) -> FloatArray:
    """Fresnel's reflectance of unpolarised light from within a medium, at angles of these cosines inside."""
    sine2 = index ** 2 * (1 - cosine ** 2)
    beyond = np.sqrt(np.maximum(1 - sine2, 0))
    s = (index * cosine - beyond) / np.maximum(index * cosine + beyond, 1e-12)
    p = (cosine - index * beyond) / np.maximum(cosine + index * beyond, 1e-12)
    return np.where(sine2 >= 1, 1.0, (s ** 2 + p ** 2) / 2)


def _walk(cosine: FloatArray, weight: FloatArray, albedo: float, index: float, steps: int | None,
          random: np.random.Generator) -> tuple[FloatArray, FloatArray]:
    way, at, faded = _directions(cosine, random), np.zeros((3, len(cosine))), _FADED * weight[0]
    left: list[FloatArray] = [np.zeros((2, 0))]
    step = 0
    while len(weight) and (steps is None or step < steps):
        step += 1
        next_at = at - np.log1p(-random.random(len(weight))) * way
        out = np.flatnonzero(next_at[2] < 0)
        next_at[:, out] = at[:, out] - at[2, out] / way[2, out] * way[:, out]
        next_at[2, out] = 0
        inwards = (random.random(len(out)) < reflected(-way[2, out], index)) & (index > 1)
        gone, back = out[~inwards], out[inwards]
        left.append(np.stack([np.hypot(*next_at[:2, gone]), weight[gone]]))
        scattered = np.ones(len(weight), bool)
        scattered[out] = False
        new = _directions(2 * random.random(scattered.sum()) - 1, random)
        way[:, scattered], way[2, back] = new, -way[2, back]
        weight = np.where(scattered, albedo * weight, weight)
        is_faded, lucky = weight < faded, random.random(len(weight)) < 0.5
        weight = np.where(is_faded, 2 * weight, weight)
        stays = lucky | ~is_faded
        stays[gone] = False
        at, way, weight = next_at[:, stays], way[:, stays], weight[stays]
    distance, counts = np.concatenate(left, axis=1)
    return distance, counts


def _directions(cosine: FloatArray, random: np.random.Generator) -> FloatArray:
    """Directions of these cosines to the depth, with random azimuths: (3, n)."""
    azimuth, sine = 2 * np.pi * random.random(len(cosine)), np.sqrt(1 - cosine ** 2)
    return np.stack([sine * np.cos(azimuth), sine * np.sin(azimuth), cosine])


def quantile(found: tuple[FloatArray, FloatArray], share: float) -> float:
    """The radius within which a share of the light that leaves does."""
    distance, weight = found
    order = np.argsort(distance)
    total = np.cumsum(weight[order])
    return float(distance[order][np.searchsorted(total, share * total[-1])])


def compare_walk(medium: Subsurface, count: int) -> Iterator[tuple[list[float], list[float]]]:
    """Of each channel: albedo, and the radii of `SHARES` in mm, below a surface and by Cycles' walk with the inputs
    that the extension gives it."""
    walk = medium.walk
    both = zip(medium.single_scattering_albedo, medium.mean_free_path, strict=True)
    for channel, (scattered, path) in enumerate(both):
        truth = radii(scattered, medium.index, count)
        walks = cycles_radii(color_to_single_scattering(walk.color[channel]), walk.entry, count)
        yield tuple([float(found[1].sum()) + more, *(length * quantile(found, each) for each in SHARES)]
                    for found, length, more in ((truth, path, 0.0),
                                                (walks, walk.radius[channel] / (4 * np.pi), walk.rest[channel])))


def straight_radii(albedo: float, count: int, seed: int = 2) -> tuple[FloatArray, FloatArray]:
    """As `cycles_radii`, of light that enters along the normal."""
    weight = np.full(count, min(1.0, albedo / LEAST_ALBEDO) / count)
    return _walk(np.ones(count), weight, max(albedo, LEAST_ALBEDO), 1.0, STEPS, np.random.default_rng(seed))


def share_beyond(radius: FloatArray, edge: float) -> FloatArray:
    """How often a point at this distance, in a random direction, lies beyond an edge at a distance: (n,)."""
    return np.arccos(np.clip(edge / np.maximum(radius, 1e-12), -1, 1)) / np.pi

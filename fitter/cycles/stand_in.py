"""What a reflectance looks like to renderers that know no measurements: its albedo, and a Principled BSDF like it."""

from dataclasses import dataclass

import numpy as np

_ROUGHNESS = np.linspace(0.05, 1, 39)
_DIELECTRIC = 0.08          # the Principled BSDF's reflectance at normal incidence at a specular level of 1
_GLANCING = np.radians(80)  # beyond it measurements are noise more often than not


@dataclass(frozen=True)
class Principled:
    """Inputs of a Principled BSDF.

    Attributes
    ----------
    base_color : (3,) float64
        Linear.
    roughness, metallic : float
    specular_level : float
        0.5 for a reflectance of 4 % at normal incidence.
    """

    base_color: np.ndarray
    roughness: float
    metallic: float
    specular_level: float


def albedo(fit, steps=24):
    """Share of even light that is reflected: (3,) float64, linear, within 0 to 1.

    The integral of f cos cos over both hemispheres, over pi, by the midpoint rule in squared sines and azimuth.
    """
    sin2 = (np.arange(steps) + 0.5) / steps
    theta, azimuth = np.arcsin(np.sqrt(sin2)), (np.arange(steps) + 0.5) / steps * np.pi
    theta_i, theta_o, phi = (grid.ravel() for grid in np.meshgrid(theta, theta, azimuth, indexing="ij"))
    mean = np.maximum(fit.evaluate(theta_i, 0 * phi, theta_o, phi), 0).mean(axis=0)
    return np.clip(np.broadcast_to(np.pi * mean, 3), 0, 1)


def principled(samples):
    """The Principled BSDF that is nearest to measurements.

    A Lambertian and a lobe of microfacets (Trowbridge and Reitz 1975, with Smith's shadowing and Schlick's Fresnel
    term), by least squares at every roughness of a grid. Errors are weighted as if of the cube root: a highlight must
    not outweigh the colour, which covers most of a picture.

    Returns
    -------
    Principled
    """
    seen = (samples.theta_i < _GLANCING) & (samples.theta_o < _GLANCING)
    if not seen.any():
        seen[:] = True
    angles = [angle[seen] for angle in samples.directions]
    values = np.maximum(np.broadcast_to(samples.values[seen], (np.count_nonzero(seen), 3)), 0)
    weight = (values + np.median(values) + 1e-6) ** (-2 / 3)
    best, found = np.inf, None
    for roughness in _ROUGHNESS:
        lobe, grazing = _microfacets(*angles, roughness)
        error, diffuse, f0 = 0.0, np.zeros(3), np.zeros(3)
        for c in range(3):
            diffuse[c], f0[c], residual = _two_terms(lobe, grazing, values[:, c], weight[:, c])
            error += residual
        if error < best:
            best, found = error, (roughness, np.pi * diffuse, f0)
    return _inputs(*found)


def _microfacets(theta_i, phi_i, theta_o, phi_o, roughness):
    """The lobe's two parts: times F0, and times 1 - F0 toward grazing (Schlick): (n,) and (n,)."""
    wi, wo = (np.stack([np.sin(theta) * np.cos(phi), np.sin(theta) * np.sin(phi), np.cos(theta)])
              for theta, phi in ((theta_i, phi_i), (theta_o, phi_o)))
    half = wi + wo
    half /= np.linalg.norm(half, axis=0)
    a2 = roughness ** 4
    distribution = a2 / (np.pi * (half[2] ** 2 * (a2 - 1) + 1) ** 2)
    root = [cos * np.sqrt(a2 + (1 - a2) * other ** 2) for cos, other in ((wi[2], wo[2]), (wo[2], wi[2]))]
    lobe = distribution / (2 * (root[0] + root[1]))
    fresnel = (1 - np.clip((half * wi).sum(axis=0), 0, 1)) ** 5
    return lobe * (1 - fresnel), lobe * fresnel


def _two_terms(lobe, grazing, values, weight):
    """Least squares of kd + f0 lobe + grazing, both factors from 0 to their largest: kd, f0, sum of squares."""
    columns = np.stack([weight, lobe * weight], axis=1)
    target = (values - grazing) * weight
    candidates = [np.linalg.lstsq(columns, target, rcond=None)[0]]
    for k in (0, 1):
        column = columns[:, k]
        alone = np.zeros(2)
        alone[k] = max(column @ target / max(column @ column, 1e-30), 0)
        candidates.append(alone)
    upper = np.array([1 / np.pi, 1.0])
    candidates = [np.minimum(pair, upper) for pair in candidates if (pair >= 0).all()]
    errors = [float(((columns @ pair - target) ** 2).sum()) for pair in candidates]
    k = int(np.argmin(errors))
    return *candidates[k], errors[k]


def _inputs(roughness, diffuse, f0):
    """As the Principled BSDF divides them: what a dielectric cannot reflect is a metal's."""
    metal = np.maximum(f0 - _DIELECTRIC, 0) if f0.mean() > _DIELECTRIC else np.zeros(3)
    total = diffuse.sum() + metal.sum()
    metallic = float(metal.sum() / total) if total > 0 else 0.0
    level = 0.5 if metallic > 0.5 else min(float(f0.mean()) / _DIELECTRIC, 1.0)
    return Principled(np.clip(diffuse + metal, 0, 1), float(roughness), metallic, level)

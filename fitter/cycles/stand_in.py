"""Stand-ins for a measured BRDF in renderers that cannot evaluate it: its albedo, and a similar Principled BSDF."""

from dataclasses import dataclass

import numpy as np

from ..arrays import FloatArray
from ..model import Reflectance
from ..samples import Samples

_ROUGHNESS = np.linspace(0.05, 1, 39)
_DIELECTRIC = 0.08          # reflectance at normal incidence of a Principled BSDF with a specular level of 1
_GOLDEN_ANGLE = np.pi * (3 - np.sqrt(5))        # azimuths that are multiples of it are spread evenly
_GRAZING = np.radians(80)   # measurements at larger polar angles are mostly noise


@dataclass(frozen=True)
class Principled:
    """Inputs of a Principled BSDF.

    Attributes
    ----------
    base_color : (3,) float64
        Linear, in the colour space of the samples.
    roughness, metallic : float
    specular_level : float
        0.5 for a reflectance of 4 % at normal incidence.
    """

    base_color: FloatArray
    roughness: float
    metallic: float
    specular_level: float


def albedo(fit: Reflectance, steps: int = 24) -> FloatArray:
    """The bihemispherical albedo: the share of uniform light that is reflected, (3,) float64, in 0 to 1.

    1 / pi times the integral of f cos(theta_i) cos(theta_o) over both hemispheres, by the midpoint rule in sin^2 theta
    and azimuth; negative values count as 0. Linear, in the colour space of the fit.

    Examples
    --------
    >>> from ..methods import prior
    >>> albedo(prior.lambertian(np.array([[0.8 / np.pi]])), 4).round(9).tolist()
    [0.8, 0.8, 0.8]
    """
    sin2 = (np.arange(steps) + 0.5) / steps
    theta, azimuth = np.arcsin(np.sqrt(sin2)), (np.arange(steps) + 0.5) / steps * np.pi
    theta_i, theta_o, phi = (grid.ravel() for grid in np.meshgrid(theta, theta, azimuth, indexing="ij"))
    # light from all azimuths, and both turns: of an isotropic fit they make no difference
    phi_i = np.arange(len(phi)) * _GOLDEN_ANGLE
    phi_o = phi_i + np.where(np.arange(len(phi)) % 2, phi, -phi)
    mean = np.maximum(fit.evaluate(theta_i, phi_i, theta_o, phi_o), 0).mean(axis=0)
    return np.clip(np.broadcast_to(np.pi * mean, 3), 0, 1)


def principled(samples: Samples) -> Principled:
    """Fit a Principled BSDF to measurements.

    The model is a Lambertian and a microfacet lobe with the distribution of T. S. Trowbridge, K. P. Reitz: Average
    Irregularity Representation of a Rough Surface for Ray Reflection, 1975, Smith's shadowing and Schlick's Fresnel
    term; least squares determine it at every roughness of a grid. Errors are weighted as if they were of the cube root,
    so that a small highlight does not outweigh the colour.

    Returns
    -------
    Principled

    Examples
    --------
    A Lambertian has its albedo as base colour, and no metal:

    >>> theta = np.linspace(0, 1.3, 14)
    >>> white = Samples(theta, 0 * theta, theta, 0 * theta + np.pi, np.full((14, 1), 0.8 / np.pi))
    >>> found = principled(white)
    >>> float(found.base_color[0]), found.metallic
    (0.8, 0.0)
    """
    seen = (samples.theta_i < _GRAZING) & (samples.theta_o < _GRAZING)
    if not seen.any():
        seen[:] = True
    theta_i, phi_i, theta_o, phi_o = (angle[seen] for angle in samples.directions)
    values = np.maximum(np.broadcast_to(samples.values[seen], (len(theta_i), 3)), 0)
    weight = (values + np.median(values) + 1e-6) ** (-2 / 3)
    best, found = np.inf, (1.0, np.zeros(3), np.zeros(3))
    for roughness in _ROUGHNESS:
        lobe, grazing = _microfacets(theta_i, phi_i, theta_o, phi_o, roughness)
        error, diffuse, f0 = 0.0, np.zeros(3), np.zeros(3)
        for c in range(3):
            diffuse[c], f0[c], residual = _two_terms(lobe, grazing, values[:, c], weight[:, c])
            error += residual
        if error < best:
            best, found = error, (roughness, np.pi * diffuse, f0)
    return _principled_inputs(*found)


def _microfacets(theta_i: FloatArray, phi_i: FloatArray, theta_o: FloatArray, phi_o: FloatArray,
                 roughness: float) -> tuple[FloatArray, FloatArray]:
    """The parts a and b of the lobe F0 a + b, whose Fresnel term is F0 + (1 - F0) (1 - cos)^5: (n,) and (n,)."""
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


def _two_terms(lobe: FloatArray, grazing: FloatArray, values: FloatArray,
               weight: FloatArray) -> tuple[float, float, float]:
    """Least squares of kd + f0 lobe + grazing with bounds, 0 to 1 / pi and 0 to 1: kd, f0, sum of squares."""
    columns = np.stack([weight, lobe * weight], axis=1)
    target = (values - grazing) * weight
    candidates = [np.linalg.lstsq(columns, target, rcond=None)[0]]
    for k in (0, 1):
        column = columns[:, k]
        alone = np.zeros(2)
        alone[k] = max(float(column @ target) / max(float(column @ column), 1e-30), 0)
        candidates.append(alone)
    upper = np.array([1 / np.pi, 1.0])
    candidates = [np.minimum(pair, upper) for pair in candidates if (pair >= 0).all()]
    errors = [float(((columns @ pair - target) ** 2).sum()) for pair in candidates]
    k = int(np.argmin(errors))
    kd, f0 = candidates[k]
    return float(kd), float(f0), errors[k]


def _principled_inputs(roughness: float, diffuse: FloatArray, f0: FloatArray) -> Principled:
    """Convert to the inputs of the node: reflectance at normal incidence above a dielectric's makes it metallic."""
    metal = np.maximum(f0 - _DIELECTRIC, 0) if f0.mean() > _DIELECTRIC else np.zeros(3)
    total = diffuse.sum() + metal.sum()
    metallic = float(metal.sum() / total) if total > 0 else 0.0
    level = 0.5 if metallic > 0.5 else min(float(f0.mean()) / _DIELECTRIC, 1.0)
    return Principled(np.clip(diffuse + metal, 0, 1), float(roughness), metallic, level)

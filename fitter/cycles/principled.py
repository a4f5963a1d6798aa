"""What viewports and exporters show of a measured BRDF: its albedo, and the closest Principled BSDF."""

from collections.abc import Callable
from dataclasses import replace
from operator import attrgetter
from typing import Any, NamedTuple

import numpy as np

from ..arrays import FloatArray
from ..least_squares import damped_step, levenberg_marquardt
from ..model import Reflectance, is_isotropic
from ..model.microfacet import Geometry, geometry
from .principled_bsdf import SHEEN_ROUGHNESS, Principled

_GOLDEN_ANGLE = np.pi * (3 - np.sqrt(5))        # azimuths that are multiples of it are spread evenly
_VIEWS, _HALF_ANGLES, _HALF_AZIMUTHS = 8, 14, 6  # viewing angles, half angles and azimuths of half vectors
_AVERAGED_AZIMUTHS = 6      # azimuths over which an anisotropic fit is averaged
_HORIZON_COSINE = 0.02      # cosine of the least elevation of the light
_LAMP = np.radians(2)       # half angles that are smaller count less: lamps and pixels blur them
_DARK_SHARE = 0.02          # of the mean reflected radiance: errors of the cube root count less below
_ALBEDO_WEIGHT = 2.0        # of errors of the albedo, over those of the reflectance
_START_ROUGHNESSES = np.geomspace(0.05, 1, 12)  # roughnesses from which a search may start,
_SPECULAR_LEVELS = 0.5, 0.1, 1.0  # specular levels,
_SEARCHES = 2               # and from how many it goes on
_FIRST_STEPS = 3
_AS_GOOD = 1.01             # an error this much larger is
_DESCENT_STEPS = 14
_QUOTIENT_STEP = 1e-3       # of a difference quotient
_ENOUGH = 1e-3              # a step that makes the error smaller by less than this share is the last
_FAR = np.radians(45)       # half angles, from which what is reflected is not a highlight,
_STEEP_ANGLE = np.radians(60)  # of viewing angles, and of the light's, up to this
_METAL_SHARE = 0.5          # a metal reflects at least this share of the light in a highlight,
_METAL_ALBEDO = 0.07        # and this share of all light; most dielectrics reflect 0.04
_METAL_LOSS = 1.5           # a metal whose error is larger by this than a dielectric's is none
_LAYER_GAIN = 0.85          # a sheen or a coat must make the error this much smaller,
_LEAST_GAIN = 0.003         # and by this

# what is searched for: names of inputs, how many numbers each is, and their bounds
_INPUTS = (("base_color", 3, 0.0, 1.0), ("roughness", 1, 0.04, 1.0), ("metallic", 1, 0.0, 1.0),
           ("specular_level", 1, 0.0, 1.0),
           ("sheen_tint", 3, 0.0, 1.0), ("sheen_roughness", 1, *SHEEN_ROUGHNESS),
           ("coat_weight", 1, 0.0, 1.0), ("coat_roughness", 1, 0.04, 0.6))
_METAL_INPUTS = ("base_color", "roughness")
_DIELECTRIC_INPUTS = (*_METAL_INPUTS, "specular_level")
_MAPS = (*_METAL_INPUTS, "metallic")
_SHEEN_INPUTS = ("sheen_tint", "sheen_roughness")
_COAT = ("coat_weight", "coat_roughness")


class _DirectionPairs(NamedTuple):
    """Directions that are spread over both hemispheres, with more of them around the mirror direction."""

    theta_i: FloatArray     # (n,)
    phi: FloatArray         # the azimuth between the directions, (n,)
    theta_o: FloatArray     # (n,)
    theta_h: FloatArray     # the half angle, (n,)
    weight: FloatArray      # of squared errors, (n,), of sum 1
    share: FloatArray       # (views, n): row v times the reflectance is the albedo for light from all that view v sees


class _Target(NamedTuple):
    """What is fitted."""

    at: Geometry
    toward: FloatArray          # as `Principled.evaluate_geometry` takes it
    cosine: FloatArray          # of the angle of the light, (n, 1)
    share: FloatArray           # as in `_DirectionPairs`
    root_weight: FloatArray     # of errors of reflected radiance and of albedo, (n + views, 1)
    albedo: FloatArray          # its mean over the viewing angles, (3,)
    mean: float                 # mean reflected radiance
    metallic: bool              # whether it looks like a metal
    perceptual: FloatArray      # both, as `_perceptual_values` makes them, (n + views, 3)


def albedo(fit: Reflectance, steps: int = 24) -> FloatArray:
    """The bihemispherical albedo: the share of uniform light that is reflected, (3,) in 0 to 1, linear in the colours
    of the fit. By the midpoint rule in sin^2 theta and azimuth; negative values count as 0."""
    sin2 = (np.arange(steps) + 0.5) / steps
    theta, azimuth = np.arcsin(np.sqrt(sin2)), (np.arange(steps) + 0.5) / steps * np.pi
    theta_i, theta_o, phi = (grid.ravel() for grid in np.meshgrid(theta, theta, azimuth, indexing="ij"))
    # light from all azimuths, and both turns: of an isotropic fit they make no difference
    phi_i = np.arange(len(phi)) * _GOLDEN_ANGLE
    phi_o = phi_i + np.where(np.arange(len(phi)) % 2, phi, -phi)
    mean = np.maximum(fit.evaluate(theta_i, phi_i, theta_o, phi_o), 0).mean(axis=0)
    return np.clip(np.broadcast_to(np.pi * mean, 3), 0, 1)


def principled(fit: Reflectance) -> Principled:
    """The Principled BSDF that is closest to a fit: of least squares of the cube root of the reflected radiance, as
    eyes see it, and of the albedo for every view, with more directions about the mirror's, where lamps make pictures
    bright. It is a metal where a highlight is most of what is reflected, and more than a dielectric's; it has sheen or
    a coat where the error becomes clearly smaller by it."""
    target = _target(fit)
    plain = _fit_plain(0.0, _DIELECTRIC_INPUTS, target)
    best = min(_add_sheen(plain, target), _add_coat(plain, _DIELECTRIC_INPUTS, target), key=attrgetter("error"))
    if target.metallic:
        metal = _add_coat(_fit_plain(1.0, _METAL_INPUTS, target), _METAL_INPUTS, target)
        best = metal if metal.error < _METAL_LOSS * best.error else best
    closest = best.inputs
    # without a highlight any roughness is as good; others than Blender may show one
    dull = replace(closest, roughness=1.0)
    return dull if _error(dull, target) < _AS_GOOD * _error(closest, target) else closest


def fit_without_layers(fit: Reflectance) -> tuple[Principled, ...]:
    """The closest Principled BSDFs without sheen and coat, of base colour and roughness alone: a dielectric of an index
    of refraction of 1.5, a metal, and what is between both."""
    target = _target(fit)
    dielectric, metal = (_fit_plain(metallic, _METAL_INPUTS, target).inputs for metallic in (0.0, 1.0))
    return dielectric, metal, _search_starts([dielectric, metal], _MAPS, target).inputs


def _points() -> _DirectionPairs:
    sin2 = (np.arange(_VIEWS) + 0.5) / _VIEWS
    even = (np.arange(_HALF_ANGLES) + 0.5) / _HALF_ANGLES
    azimuth = (np.arange(_HALF_AZIMUTHS) + 0.5) / _HALF_AZIMUTHS * np.pi
    view, spread, phi_h = (grid.ravel() for grid in np.meshgrid(np.arange(_VIEWS), even, azimuth, indexing="ij"))
    sin_o, cos_o = np.sqrt(sin2[view]), np.sqrt(1 - sin2[view])
    theta_h = np.pi / 2 * spread ** 2
    h = np.stack([np.sin(theta_h) * np.cos(phi_h), np.sin(theta_h) * np.sin(phi_h), np.cos(theta_h)])
    cos_d = h[0] * sin_o + h[2] * cos_o
    x, y, z = 2 * cos_d * h - np.stack([sin_o, 0 * sin_o, cos_o])
    above = (z > _HORIZON_COSINE) & (cos_d > 0)
    # solid angle of the light: 4 cos(theta_d) times that of the half vector
    solid_angle = z * cos_d * np.sin(theta_h) * spread
    share = np.where(view == np.arange(_VIEWS)[:, None], solid_angle, 0)[:, above]
    share *= np.pi / share.sum(axis=1, keepdims=True)           # all light, of a Lambertian
    theta_i, phi, theta_o, theta_h = (angle[above] for angle in (np.arccos(np.minimum(z, 1)), np.arctan2(y, x),
                                                                 np.arcsin(sin_o), theta_h))
    weight = theta_h / (theta_h + _LAMP)
    return _DirectionPairs(theta_i, phi, theta_o, theta_h, weight / weight.sum(), share)


def _target(fit: Reflectance) -> _Target:
    points = _points()
    at = geometry(points.theta_i, 0 * points.phi, points.theta_o, points.phi)
    if is_isotropic(fit):
        values = np.maximum(fit.evaluate(points.theta_i, 0 * points.phi, points.theta_o, points.phi), 0)
    else:
        number = np.arange(len(points.phi))
        phi_i = number * _GOLDEN_ANGLE + np.arange(_AVERAGED_AZIMUTHS)[:, None] * 2 * np.pi / _AVERAGED_AZIMUTHS
        turned = np.where((number + np.arange(_AVERAGED_AZIMUTHS)[:, None]) % 2, points.phi, -points.phi)
        values = np.maximum(fit.evaluate(points.theta_i, phi_i, points.theta_o, phi_i + turned), 0).mean(axis=0)
    values = np.array(np.broadcast_to(values, (len(points.phi), 3)))
    cosine = at.cos_i[:, None]
    mean = max(float((points.share @ values).mean()) / np.pi, 1e-9)
    weight = np.concatenate([points.weight, np.full(_VIEWS, _ALBEDO_WEIGHT / _VIEWS)]) / 3
    albedo, toward = (points.share @ values).mean(axis=0), np.sin(points.theta_i) * np.cos(points.phi)
    target = _Target(at, toward, cosine, points.share, np.sqrt(weight)[:, None], albedo, mean,
                     _looks_metallic(values, points), values)
    return target._replace(perceptual=_perceptual_values(values, target))


def _looks_metallic(values: FloatArray, points: _DirectionPairs) -> bool:
    """Whether most of the light, and more than a dielectric's surface can reflect, is reflected in a highlight."""
    far = (points.theta_h > _FAR) & (np.maximum(points.theta_i, points.theta_o) < _STEEP_ANGLE)
    steep = points.share[np.sqrt((np.arange(_VIEWS) + 0.5) / _VIEWS) < np.sin(_STEEP_ANGLE)]
    reflected = float((steep @ values).mean())
    highlight = reflected - np.pi * float(np.median(values[far], axis=0).mean())
    return highlight > max(_METAL_ALBEDO, _METAL_SHARE * reflected)


def _perceptual_values(values: FloatArray, target: _Target) -> FloatArray:
    """Cube roots of reflected radiance and of albedo, (n + views, 3), weighted so that they can be subtracted."""
    radiance, reflected = values * target.cosine, target.share @ values / np.pi
    return np.asarray(np.cbrt(np.concatenate([radiance, reflected]) / target.mean + _DARK_SHARE) * target.root_weight)


def _residuals(inputs: Principled, target: _Target) -> FloatArray:
    return (_perceptual_values(inputs.evaluate_geometry(target.at, target.toward), target) - target.perceptual).ravel()


def _error(inputs: Principled, target: _Target) -> float:
    return float(np.linalg.norm(_residuals(inputs, target)))


class _Candidate(NamedTuple):
    """What a search found: the error, and the inputs."""

    error: float
    inputs: Principled


def _fit_plain(metallic: float, names: tuple[str, ...], target: _Target) -> _Candidate:
    """The closest BSDF without sheen and coat, from the best of many starts."""
    color = np.clip(target.albedo, 0.02, 0.98)
    starts = [Principled(color, roughness, metallic, level) for roughness in _START_ROUGHNESSES
              for level in (_SPECULAR_LEVELS if "specular_level" in names else _SPECULAR_LEVELS[:1])]
    starts.sort(key=lambda start: _error(start, target))
    return _search_starts(starts[:2 * _SEARCHES], names, target)


def _add_sheen(plain: _Candidate, target: _Target) -> _Candidate:
    """A BSDF with sheen, if that is clearly closer, or the one without."""
    tint = np.full(3, 0.1)
    starts = [replace(plain.inputs, sheen_tint=tint, sheen_roughness=roughness) for roughness in (0.3, 0.6)]
    return _clearly_closer(plain, _search_starts(starts, (*_DIELECTRIC_INPUTS, *_SHEEN_INPUTS), target))


def _add_coat(plain: _Candidate, names: tuple[str, ...], target: _Target) -> _Candidate:
    """A BSDF with a coat, if that is clearly closer, or the one without."""
    rough = plain.inputs.roughness
    starts = [replace(plain.inputs, roughness=under, coat_weight=weight, coat_roughness=over)
              for under in ((rough + 1) / 2, 0.8, 0.4) for over, weight in ((rough, 0.5), (0.2, 0.5), (0.05, 0.1))]
    return _clearly_closer(plain, _search_starts(starts, (*names, *_COAT), target))


def _clearly_closer(plain: _Candidate, layered: _Candidate) -> _Candidate:
    return layered if layered.error < min(_LAYER_GAIN * plain.error, plain.error - _LEAST_GAIN) else plain


def _search_starts(starts: list[Principled], names: tuple[str, ...], target: _Target) -> _Candidate:
    """The closest BSDF near several starts: a few steps from each, and more from where the best of them end."""
    near = sorted((_search(start, names, target, _FIRST_STEPS) for start in starts), key=attrgetter("error"))
    return min((_search(found.inputs, names, target, _DESCENT_STEPS) for found in near[:_SEARCHES]),
               key=attrgetter("error"))


def _search(start: Principled, names: tuple[str, ...], target: _Target, steps: int) -> _Candidate:
    """The closest BSDF near a start, by the steps of K. Levenberg and D. W. Marquardt within bounds."""
    chosen = [(name, size, lower, upper) for name, size, lower, upper in _INPUTS if name in names]
    lower, upper = (np.concatenate([np.full(size, bounds[k]) for _, size, *bounds in chosen]) for k in (0, 1))

    def inputs(x: FloatArray) -> Principled:
        parts = np.split(x, np.cumsum([size for _, size, _, _ in chosen])[:-1])
        values: dict[str, Any] = {name: part if size > 1 else float(part[0])
                                  for (name, size, _, _), part in zip(chosen, parts, strict=True)}
        return replace(start, **values)

    def evaluate(x: FloatArray) -> tuple[float, FloatArray]:
        residuals = _residuals(inputs(x), target)
        return float(residuals @ residuals), residuals

    def linearise(x: FloatArray, residuals: FloatArray) -> Callable[[float], FloatArray]:
        away = np.where(x + _QUOTIENT_STEP > upper, -_QUOTIENT_STEP, _QUOTIENT_STEP)
        slopes = np.stack([(_residuals(inputs(x + step), target) - residuals) for step in np.diag(away)], axis=1) / away
        normal, right = slopes.T @ slopes, slopes.T @ residuals
        # an input at a bound that it would cross stays there
        free = ~((x <= lower) & (right > 0) | (x >= upper) & (right < 0))

        def try_damping(damping: float) -> FloatArray:
            step = np.zeros(len(x))
            step[free] = damped_step(normal[np.ix_(free, free)], -right[free], damping)
            return np.clip(x + step, lower, upper)
        return try_damping

    # from the start, moved within the bounds
    x, error, _ = levenberg_marquardt(
        np.clip(np.concatenate([np.ravel(getattr(start, name)) for name, *_ in chosen]), lower, upper), evaluate,
        linearise, steps=steps, tries=4, grow=8, shrink=5, enough=_ENOUGH)
    return _Candidate(float(np.sqrt(error)), inputs(x))

"""The closure mixture: a sum of closures close to a fit and seldom above it, which Cycles can sample by itself.

For each tabulated outgoing angle it approximates the reflected radiance T = f cos theta_i by

- a `diffuse_ramp` about the normal: a piecewise linear function of the cosine;
- three lobes, each a `phong_ramp` about a direction in the plane of incidence, cos^e times a piecewise linear function
  of cos^e, or a `microfacet` lobe (GGX, without a Fresnel factor) about a normal that is tilted in that plane.

The lobes are chosen for each view among many, one after the other. No coefficient is negative, and where the sum
exceeds T errors count many times: what the mixture leaves, sampled directions carry, and so hardly anything has to be
subtracted. The value of a ramp closure is its weight times its colours. Cycles picks a closure with a probability in
proportion to its weight, which is therefore what the closure reflects. `osl/mixture.h` evaluates the same sum.
"""

from typing import TYPE_CHECKING, NamedTuple

import numpy as np
from numpy.typing import NDArray

from .. import progress
from ..shader_constants import GGX, HORIZON, LOBE_NUMBERS, LOBES, PHONG, REMAINDER_PROBABILITY, STEEPEST_AXIS
from . import direction_grid
from .anisotropic_mixture import anisotropic_mixture
from .mixture_table import (
    DIM,
    LAST_SHOWN,
    UNIFORM,
    UNIFORM_REFLECTED,
    Mixture,
    albedo_scale,
    coefficients_of,
    hats,
    remainder_numbers,
    rounded,
    row,
)
from .nonnegative import solve, weights
from .sampling_table import sampling_table

if TYPE_CHECKING:
    from ..model.fit import Fit

_EXPONENTS = (4, 12, 36, 110, 330, 1000, 3000, 10000)                   # candidates for the phong_ramps ...
_AXES = np.radians((-30, -20, -12, -7, -4, -2, 0, 2, 4, 7, 12))         # ... and for their angles from the mirror
_RETRO_EXPONENTS = (12, 110)                                            # ... direction; those that look back
_ROUGHNESS = (0.03, 0.06, 0.12, 0.2, 0.3, 0.45)                         # candidates for microfacet lobes ...
_TILTS = np.radians((-5, 0, 5))                                         # ... and the tilts of their normals
_STRIDE = 3                     # of the points that are looked at in the search
_TRIED = 6                      # candidates for a lobe that are looked at closer
_GGX_COST = 1.15                # factor on the error of a choice, per microfacet lobe: they take Cycles longer
_STEPS = 40                     # of the least squares, in the search


class Lobe(NamedTuple):
    """A lobe of one view.

    Attributes
    ----------
    kind : int
        PHONG or GGX.
    shape : float
        The exponent, or the roughness.
    angle : float
        Radians: from the mirror direction to the axis, or from the surface's normal to the lobe's; positive toward the
        horizon on the mirror side.
    """

    kind: int
    shape: float
    angle: float


def closure_mixture(fit: "Fit") -> Mixture:
    """The closure mixture of a fit.

    Parameters
    ----------
    fit : Fit
        Only its `evaluate` is used, and whether it is isotropic; an anisotropic one has a mixture of another kind.

    Returns
    -------
    Mixture
    """
    if not getattr(fit, "isotropic", True):
        return anisotropic_mixture(fit)
    angles = direction_grid.views(between=1)
    grids = [direction_grid.grid(angle) for angle in angles]
    targets = [_target(fit, angle, to) for angle, to in zip(angles, grids, strict=True)]
    found = [_View.of(at, angles, grids, targets) for at in progress.each(range(0, len(angles), 2))]
    errors = np.array([view.error for view in found])
    shown = angles[::2] <= LAST_SHOWN
    solid_angle, reachable = (np.stack([getattr(to, name) for to in grids[::2]])
                              for name in ("solid_angle", "reachable"))
    remainder, reflected = (
        sampling_table(np.stack([getattr(view, name) for view in found]), solid_angle, reachable, uniform)
        for name, uniform in (("remainder", UNIFORM), ("reflected", UNIFORM_REFLECTED)))
    missing = np.stack([direction_grid.cells(view.missing).mean(axis=1) for view in found])
    return Mixture(np.stack([view.row for view in found]), np.stack([view.numbers for view in found]),
                   rounded(missing), remainder, reflected, float(errors.mean()), float(errors[shown].max()))


class _View(NamedTuple):
    """What is tabulated of a view. The last three are at the points of its grid, the last two (n,)."""

    row: NDArray[np.float64]
    numbers: NDArray[np.float64]
    error: float                        # of Fast
    missing: NDArray[np.float64]        # the target less the mixture: (n, channels)
    remainder: NDArray[np.float64]      # about what a sampled direction carries beside the mixture
    reflected: NDArray[np.float64]      # and without one

    @classmethod
    def of(cls, at: int, angles: NDArray[np.float64], grids: list[direction_grid.Directions],
           targets: list[NDArray[np.float64]]) -> "_View":
        """The view of `angles[at]`. The others are half a step apart: one and two steps to each side are seen with its
        lobes too."""
        target, to = targets[at], grids[at]
        lobes = _choose(angles[at], target, to)
        basis, seen = _basis(angles[at], lobes, to.unit), to.solid_angle > 0
        coefficients = solve(basis[seen], target[seen], to.solid_angle[seen])
        around = [number for number in (at, at - 1, at + 1, at - 2, at + 2) if 0 <= number < len(angles)]
        missing = [targets[number] - _basis(angles[number], lobes, grids[number].unit) @ coefficients
                   for number in around]
        mixture = target - missing[0]
        scale = albedo_scale(target, mixture, to.solid_angle)
        light = max(float((to.solid_angle @ target).sum()), 1e-12)
        dim = DIM * target.sum(axis=1)
        table = row([lobe.kind for lobe in lobes], basis, coefficients, scale,
                    _densities(angles[at], lobes, to.unit), to.solid_angle)
        share = float(to.solid_angle @ np.abs(missing[0]).sum(axis=1)) / light
        numbers = np.concatenate([np.array(lobes).ravel(), remainder_numbers(share)])
        error = float(to.solid_angle @ np.abs(target - scale * mixture).sum(axis=1)) / light
        return cls(table, numbers, error, missing[0],
                   np.max([np.abs(each).sum(axis=1) for each in missing], axis=0) + dim,
                   np.mean([targets[number] for number in around], axis=0).sum(axis=1) + dim)


def evaluate(mixture: Mixture, view: int, theta_o: float, wi: NDArray[np.float64]) -> NDArray[np.float64]:
    """The reflected radiance of the mixture of a tabulated view, seen from an angle near it.

    Parameters
    ----------
    mixture : Mixture
    view : int
        The tabulated view.
    theta_o : float
        The outgoing angle, radians.
    wi : (n, 3)
        Unit vectors above the horizon, in the frame where the outgoing direction has azimuth 0.

    Returns
    -------
    (n, channels)
    """
    lobes = [Lobe(int(kind), shape, angle)
             for kind, shape, angle in mixture.numbers[view, :REMAINDER_PROBABILITY].reshape(LOBES, LOBE_NUMBERS)]
    return _basis(theta_o, lobes, wi) @ coefficients_of(mixture.table[view], [lobe.kind for lobe in lobes])


def _target(fit: "Fit", theta_o: float, to: direction_grid.Directions) -> NDArray[np.float64]:
    """The reflected radiance at the points of a grid: (n, channels), 0 below the horizon."""
    above = to.solid_angle > 0
    value = fit.evaluate(to.theta[above], to.phi[above], theta_o, 0.0)
    target = np.zeros((len(above), value.shape[-1]))
    target[above] = np.maximum(value, 0) * np.cos(to.theta[above])[:, None]
    return target


def _candidates(theta_o: float) -> list[Lobe]:
    """Lobes to choose from, of which none is narrower than the grid is there."""
    lobes = [Lobe(PHONG, exponent, float(axis)) for exponent in _EXPONENTS for axis in _AXES
             if exponent * direction_grid.spacing(abs(float(axis))) ** 2 <= 1]
    lobes += [Lobe(PHONG, exponent, -2 * theta_o) for exponent in _RETRO_EXPONENTS]
    return lobes + [Lobe(GGX, alpha, float(tilt)) for alpha in _ROUGHNESS for tilt in _TILTS]


def _choose(theta_o: float, target: NDArray[np.float64], to: direction_grid.Directions) -> list[Lobe]:
    """The lobes for a view: each in turn is the one beside which the error is smallest."""
    candidates = _candidates(theta_o)
    some = np.flatnonzero(to.solid_angle)[::_STRIDE]
    unit, solid_angle = to.unit[some], to.solid_angle[some]
    mean = target[some].mean(axis=1, keepdims=True)
    weight = weights(mean, solid_angle)[:, 0]
    simple = np.stack([_outline(theta_o, lobe, unit) for lobe in candidates], axis=1)
    size = np.sqrt(weight @ simple ** 2) + 1e-12
    chosen: list[Lobe] = []
    left = mean[:, 0]
    for _ in range(LOBES):
        order = np.argsort(-(weight * left @ simple) / size)
        best, found = np.inf, chosen
        for number in [n for n in order if candidates[n] not in chosen][:_TRIED]:
            tried = [*chosen, candidates[number]]
            basis = _basis(theta_o, tried, unit)
            remaining = mean - basis @ solve(basis, mean, solid_angle, _STEPS, 2)
            error = float(weight @ remaining[:, 0] ** 2)
            error *= _GGX_COST ** sum(lobe.kind == GGX for lobe in tried)
            if error < best:
                best, found, left = error, tried, remaining[:, 0]
        chosen = found
    return chosen


def _basis(theta_o: float, lobes: list[Lobe], wi: NDArray[np.float64]) -> NDArray[np.float64]:
    """The basis functions of the diffuse ramp and of the lobes: (n, columns)."""
    hat = hats(wi[:, 2])
    hat[:, 0] = 0                   # Cycles evaluates the ramp below the horizon too, where it must be black
    return np.hstack([hat / np.pi, *(_lobe(theta_o, lobe, wi) for lobe in lobes)])


def _lobe(theta_o: float, lobe: Lobe, wi: NDArray[np.float64]) -> NDArray[np.float64]:
    """The basis functions of a lobe: (n, KNOTS) for a phong_ramp, (n, 1) for a microfacet lobe."""
    wo = _in_plane(theta_o)
    if lobe.kind == GGX:
        return _ggx(wo, wi, lobe.shape, lobe.angle)[:, None]
    axis = _axis(theta_o, lobe)
    half = (wo + axis) / np.linalg.norm(wo + axis)
    falloff = np.maximum(wi @ axis, 0) ** lobe.shape
    height = np.maximum(wi @ half, 0) * (lobe.shape + 2) / (2 * np.pi) * falloff
    return height[:, None] * hats(falloff)


def _outline(theta_o: float, lobe: Lobe, wi: NDArray[np.float64]) -> NDArray[np.float64]:
    """A lobe with a ramp of 1: (n,)."""
    if lobe.kind == GGX:
        return _ggx(_in_plane(theta_o), wi, lobe.shape, lobe.angle)
    return np.asarray(np.maximum(wi @ _axis(theta_o, lobe), 0) ** lobe.shape)


def _axis(theta_o: float, lobe: Lobe) -> NDArray[np.float64]:
    """The axis of a phong_ramp."""
    return _in_plane(-min(theta_o + lobe.angle, STEEPEST_AXIS))


def _in_plane(theta: float) -> NDArray[np.float64]:
    """A direction in the plane of incidence, on the viewer's side where theta is positive."""
    return np.array([np.sin(theta), 0, np.cos(theta)])


def _ggx(wo: NDArray[np.float64], wi: NDArray[np.float64], alpha: float, tilt: float) -> NDArray[np.float64]:
    """GGX reflection about a tilted normal, with height-correlated masking and no Fresnel factor, times the cosine of
    that normal and wi (Walter et al. 2007; Heitz 2014): (n,)."""
    normal = _in_plane(-tilt)
    cos_o, cos_i = float(wo @ normal), wi @ normal
    seen, least = (cos_i > HORIZON) & (cos_o > HORIZON), max(cos_o, HORIZON)
    masking = 1 + _smith(least, alpha) + _smith(np.maximum(cos_i, HORIZON), alpha)
    return np.where(seen, _ggx_distribution(normal, wo, wi, alpha) / (4 * least * masking), 0)


def _ggx_distribution(normal: NDArray[np.float64], wo: NDArray[np.float64], wi: NDArray[np.float64],
                      alpha: float) -> NDArray[np.float64]:
    """The density of microfacets that reflect wi toward wo: (n,)."""
    half = wi + wo
    cos_h = (half @ normal) / np.linalg.norm(half, axis=1)
    return np.asarray(alpha**2 / (np.pi * (cos_h**2 * (alpha**2 - 1) + 1) ** 2))


def _smith(z: NDArray[np.float64] | float, alpha: float) -> NDArray[np.float64]:
    """Smith's Lambda, from the cosine z of a direction."""
    return np.asarray((np.sqrt(1 + alpha**2 * (1 / np.square(z) - 1)) - 1) / 2)


def _densities(theta_o: float, lobes: list[Lobe], wi: NDArray[np.float64]) -> NDArray[np.float64]:
    """The density per solid angle with which Cycles samples the diffuse ramp and each lobe: (LOBES + 1, n)."""
    wo, densities = _in_plane(theta_o), [np.maximum(wi[:, 2], 0) / np.pi]
    for lobe in lobes:
        if lobe.kind == GGX:        # Cycles samples the microfacets that are visible from wo
            normal = _in_plane(-lobe.angle)
            cos_o = max(float(wo @ normal), HORIZON)
            visible = _ggx_distribution(normal, wo, wi, lobe.shape) / (4 * cos_o * (1 + _smith(cos_o, lobe.shape)))
            densities.append(np.where(wi @ normal > 0, visible, 0))
        else:
            densities.append((lobe.shape + 1) / (2 * np.pi) * _outline(theta_o, lobe, wi))
    return np.stack(densities)

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

from ..shader_constants import (
    ALBEDO_SCALE,
    GGX,
    HORIZON,
    KNOTS,
    LOBE_NUMBERS,
    LOBES,
    PHONG,
    REMAINDER_PROBABILITY,
    ROW,
    STEEPEST_AXIS,
    WEIGHTS,
)
from . import direction_grid
from .sampling_table import sampling_table

if TYPE_CHECKING:
    from ..model.fit import Fit

_EXPONENTS = (4, 12, 36, 110, 330, 1000, 3000, 10000)                   # candidates for the phong_ramps ...
_AXES = np.radians((-30, -20, -12, -7, -4, -2, 0, 2, 4, 7, 12))         # ... and for their angles from the mirror
_RETRO_EXPONENTS = (12, 110)                                            # ... direction; those that look back
_ROUGHNESS = (0.03, 0.06, 0.12, 0.2, 0.3, 0.45)                         # candidates for microfacet lobes ...
_TILTS = np.radians((-5, 0, 5))                                         # ... and the tilts of their normals
_FLOOR = 0.1                    # relative errors count in full above this fraction of the mean reflected radiance
_OVER = 5.0                     # weight of errors where the mixture exceeds the fit
_STRIDE = 3                     # of the points that are looked at in the search
_TRIED = 6                      # candidates for a lobe that are looked at closer
_GGX_COST = 1.15                # factor on the error of a choice, per microfacet lobe: they take Cycles longer
_STEPS, _LAST_STEPS = 40, 150   # of the least squares, in the search and at last
_REWEIGHTINGS = 6               # of the errors where the mixture exceeds the fit
_PROBABILITY = 6.0              # REMAINDER_PROBABILITY per share of the light that the mixture misplaces ...
_PROBABILITIES = (0.2, 1.0)     # ... and its bounds
_ITERATIONS = 30                # of the weights, which then change by less than a percent
_LEAST_WEIGHT = 0.01            # minimum share of the weights, so that every lobe gets sampled
_ALBEDOS = (0.95, 1.05)         # bounds of the sum of the weights, in albedos, where microfacet lobes fix a part ...
_LEAST_FREE = 1.02              # ... and the least sum, in weights that are fixed
_LEAST_COLOUR = 0.02            # of a lobe in a channel, in the largest of them: no channel is lost
_MOST_PICKED = 0.5              # probability of following a sampled direction, where there is one
_ALBEDO_SCALES = (0.7, 1.5)     # bounds of the factor that gives the mixture the albedo of the fit
_LAST_SHOWN = np.radians(80)    # the last view whose error the panel states
_DIM = 0.1                      # share of the target that the sampled directions are prepared to carry anywhere
_UNIFORM_REFLECTED = 0.02       # share of that table that is spread evenly
_UNIFORM = 0.05                 # share of the table that is spread evenly


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


class Mixture(NamedTuple):
    """The mixture for every tabulated view.

    Attributes
    ----------
    table : (VIEWS, ROW, channels)
        Rows as `shader_constants` describes them. The knots of a ramp are divided by its weight.
    numbers : (VIEWS, NUMBERS)
        What is equal in all channels, as `shader_constants` describes it.
    missing : (VIEWS, RINGS * SECTORS, channels)
        The reflected radiance of the fit less the mixture, in the middle of each cell of `direction_grid`.
    remainder, reflected : (VIEWS, RINGS * SECTORS) float32
        The sampling tables: of the remainder, and of directions that stand in for the mixture and carry all of the
        reflected radiance.
    error, worst : float
        Of Fast: the fraction of the reflected light that it puts in the wrong direction, in the mean over the views and
        in the worst of them up to 80 degrees.
    """

    table: NDArray[np.float64]
    numbers: NDArray[np.float64]
    missing: NDArray[np.float64]
    remainder: NDArray[np.float32]
    reflected: NDArray[np.float32]
    error: float
    worst: float


def closure_mixture(fit: "Fit") -> Mixture:
    """The closure mixture of a fit.

    Parameters
    ----------
    fit : Fit
        Only its `evaluate` is used.

    Returns
    -------
    Mixture
    """
    angles = direction_grid.views(between=1)
    grids = [direction_grid.grid(angle) for angle in angles]
    targets = [_target(fit, angle, to) for angle, to in zip(angles, grids, strict=True)]
    found = [_View.of(at, angles, grids, targets) for at in range(0, len(angles), 2)]
    errors = np.array([view.error for view in found])
    shown = angles[::2] <= _LAST_SHOWN
    solid_angle, reachable = (np.stack([getattr(to, name) for to in grids[::2]])
                              for name in ("solid_angle", "reachable"))
    remainder, reflected = (
        sampling_table(np.stack([getattr(view, name) for view in found]), solid_angle, reachable, uniform)
        for name, uniform in (("remainder", _UNIFORM), ("reflected", _UNIFORM_REFLECTED)))
    missing = np.stack([direction_grid.cells(view.missing).mean(axis=1) for view in found])
    return Mixture(np.stack([view.row for view in found]), np.stack([view.numbers for view in found]),
                   _rounded(missing), remainder, reflected, float(errors.mean()), float(errors[shown].max()))


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
        coefficients = _solve(_basis(angles[at], lobes, to.unit), target, to.solid_angle)
        around = [number for number in (at, at - 1, at + 1, at - 2, at + 2) if 0 <= number < len(angles)]
        missing = [targets[number] - _basis(angles[number], lobes, grids[number].unit) @ coefficients
                   for number in around]
        mixture = target - missing[0]
        albedo, reflected = to.solid_angle @ target, to.solid_angle @ mixture
        scale = np.clip(np.where(reflected > 0, albedo / np.where(reflected > 0, reflected, 1), 1.0), *_ALBEDO_SCALES)
        light = max(float(albedo.sum()), 1e-12)
        dim = _DIM * target.sum(axis=1)
        row = _row(angles[at], lobes, coefficients, scale, to)
        share = float(to.solid_angle @ np.abs(missing[0]).sum(axis=1)) / light
        probability = float(np.clip(_PROBABILITY * share, *_PROBABILITIES))
        picked = min(share / (1 + share) / probability, _MOST_PICKED)
        numbers = np.concatenate([np.array(lobes).ravel(), [probability, picked]])
        error = float(to.solid_angle @ np.abs(target - scale * mixture).sum(axis=1)) / light
        return cls(row, numbers, error, missing[0],
                   np.max([np.abs(each).sum(axis=1) for each in missing], axis=0) + dim,
                   np.mean([targets[number] for number in around], axis=0).sum(axis=1) + dim)


def _rounded(values: NDArray[np.float64]) -> NDArray[np.float64]:
    """Values to four digits, which keeps the shader's source short."""
    unit = 10.0 ** (np.floor(np.log10(np.abs(values) + 1e-30)) - 3)
    return np.asarray(np.round(values / unit) * unit)


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
    row = mixture.table[view]
    lobes = [Lobe(int(kind), shape, angle)
             for kind, shape, angle in mixture.numbers[view, :REMAINDER_PROBABILITY].reshape(LOBES, LOBE_NUMBERS)]
    ramps = row[:WEIGHTS].reshape(LOBES + 1, KNOTS, -1) * row[WEIGHTS:WEIGHTS + LOBES + 1, None]
    parts = [ramps[0], *(ramps[1 + k] if lobe.kind == PHONG else row[WEIGHTS + 1 + k][None]
                         for k, lobe in enumerate(lobes))]
    return _basis(theta_o, lobes, wi) @ np.concatenate(parts)


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
    weight = _weights(mean, solid_angle)[:, 0]
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
            remaining = mean - basis @ _solve(basis, mean, solid_angle, _STEPS, 2)
            error = float(weight @ remaining[:, 0] ** 2)
            error *= _GGX_COST ** sum(lobe.kind == GGX for lobe in tried)
            if error < best:
                best, found, left = error, tried, remaining[:, 0]
        chosen = found
    return chosen


def _basis(theta_o: float, lobes: list[Lobe], wi: NDArray[np.float64]) -> NDArray[np.float64]:
    """The basis functions of the diffuse ramp and of the lobes: (n, columns)."""
    hat = _hats(wi[:, 2])
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
    return height[:, None] * _hats(falloff)


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


def _hats(x: NDArray[np.float64]) -> NDArray[np.float64]:
    """Piecewise linear basis on KNOTS knots over [0, 1]: (n,) to (n, KNOTS)."""
    return np.maximum(0, 1 - np.abs(np.clip(x, 0, 1)[:, None] * (KNOTS - 1) - np.arange(KNOTS)))


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


def _shares(mixture: NDArray[np.float64], density: NDArray[np.float64],
            solid_angle: NDArray[np.float64]) -> NDArray[np.float64]:
    """The best probability of picking each lobe: (LOBES + 1,), of sum 1.

    It minimises the second moment of the estimate under an even light, the integral of M^2 / sum_k s_k p_k, by a
    fixed-point iteration that keeps the shares positive.
    """
    squared = mixture.mean(axis=1) ** 2 * solid_angle
    shares = np.full(len(density), 1 / len(density))
    for _ in range(_ITERATIONS):
        shares = shares * np.sqrt(density @ (squared / np.maximum(shares @ density, 1e-9) ** 2))
        shares = np.maximum(shares / max(shares.sum(), 1e-12), _LEAST_WEIGHT)
    return np.asarray(shares / shares.sum())


def _weights(target: NDArray[np.float64], solid_angle: NDArray[np.float64]) -> NDArray[np.float64]:
    """Of the squared errors, relative to the target above a floor: (n, channels)."""
    mean = solid_angle @ target / np.pi
    return np.asarray(solid_angle[:, None] / (target + _FLOOR * mean + 1e-12))


def _solve(basis: NDArray[np.float64], target: NDArray[np.float64],
           solid_angle: NDArray[np.float64], steps: int = _LAST_STEPS,
           reweightings: int = _REWEIGHTINGS) -> NDArray[np.float64]:
    """Coefficients of the basis functions, none negative: (columns, channels).

    Least squares of errors relative to the target; those where the sum exceeds it count `_OVER` times. D. D. Lee, H. S.
    Seung: Algorithms for Non-negative Matrix Factorization, NIPS 2000, have the steps, which keep coefficients positive
    and suit weights that change.
    """
    seen = solid_angle > 0
    basis, target, solid_angle = basis[seen], target[seen], solid_angle[seen]
    weight = _weights(target, solid_angle)
    scale = np.sqrt(basis.T ** 2 @ weight.mean(axis=1)) + 1e-12
    basis = basis / scale[:, None].T
    x = np.full((basis.shape[1], target.shape[1]), 1e-3)
    x *= (solid_angle @ target + 1e-12) / np.maximum(solid_angle @ (basis @ x), 1e-12)
    for _ in range(reweightings):
        w = weight * np.where(basis @ x > target, _OVER, 1.0)
        normal = np.stack([basis.T @ (basis * w[:, c, None]) for c in range(w.shape[1])])
        right = basis.T @ (w * target)
        for _ in range(steps // reweightings):
            x *= (right + 1e-15) / (np.matmul(normal, x.T[..., None])[..., 0].T + 1e-15)
    return np.asarray(np.where(scale[:, None] > 1e-9 * scale.max(), x / scale[:, None], 0))


def _row(theta_o: float, lobes: list[Lobe], coefficients: NDArray[np.float64], scale: NDArray[np.float64],
         to: direction_grid.Directions) -> NDArray[np.float64]:
    """A row of the table: (ROW, channels)."""
    row = np.zeros((ROW, coefficients.shape[1]))
    mixture = _basis(theta_o, lobes, to.unit) @ coefficients
    albedo = float((to.solid_angle @ mixture).mean())
    shares = _shares(mixture, _densities(theta_o, lobes, to.unit), to.solid_angle)
    # the coefficient of a microfacet lobe is its weight; the others follow from the best shares
    fixed = [k for k, lobe in enumerate(lobes, 1) if lobe.kind == GGX]
    free = [k for k in range(LOBES + 1) if k not in fixed]
    parts, start = [], 0
    for k in range(LOBES + 1):
        parts.append(coefficients[start:start + (1 if k in fixed else KNOTS)])
        start += len(parts[-1])
    taken = sum(float(parts[k].mean()) for k in fixed)
    total = max(albedo, 1e-6)
    if taken > 0:
        least, most = (bound * albedo for bound in _ALBEDOS)
        total = float(np.clip(taken / shares[fixed].sum(), least, most))
    total = max(total, _LEAST_FREE * taken)
    for k in fixed:
        row[WEIGHTS + k] = parts[k][0]
    for k in free:
        columns = _basis(theta_o, [], to.unit) if k == 0 else _lobe(theta_o, lobes[k - 1], to.unit)
        mean = shares[k] / shares[free].sum() * (total - taken)
        row[WEIGHTS + k] = mean * _colours(to.solid_angle @ (columns @ parts[k]))
        row[k * KNOTS:(k + 1) * KNOTS] = parts[k] / row[WEIGHTS + k]
    row[ALBEDO_SCALE] = scale
    return row


def _colours(reflected: NDArray[np.float64]) -> NDArray[np.float64]:
    """What a lobe reflects, (channels,), scaled to a colour of mean 1."""
    reflected = np.maximum(reflected, _LEAST_COLOUR * reflected.max()) + 1e-9
    return np.asarray(reflected / reflected.mean())

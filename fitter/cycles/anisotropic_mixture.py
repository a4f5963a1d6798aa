"""The closure mixture of an anisotropic fit: tabulated over viewing directions, with lobes of two widths.

As that of an isotropic fit (`closure_mixture`), with these differences:

- Everything is in the principal axes of the surface, which `principal` finds, and over the directions of
  `half_vector_grid`.
- A `microfacet` lobe has a width along each of the principal axes.
- The lobes of a polar angle are the same for all azimuths of the viewer, and are chosen for all of them together; their
  coefficients are not. Axes of phong_ramps and tilts of microfacet lobes are in the plane of the viewer and the normal.

`osl/mixture.h` and `osl/anisotropic_views.h` evaluate the same sum.
"""

from typing import TYPE_CHECKING, NamedTuple

import numpy as np
from numpy.typing import NDArray

from .. import progress
from ..shader_constants import (
    GGX,
    HORIZON,
    LOBE_NUMBERS,
    LOBES,
    NUMBERS,
    PHONG,
    POLAR_VIEWS,
    STEEPEST_AXIS,
)
from . import half_vector_grid
from .direction_grid import Directions
from .half_vector_grid import CELLS
from .mixture_table import (
    DIM,
    LAST_SHOWN,
    UNIFORM,
    UNIFORM_REFLECTED,
    Mixture,
    Principal,
    albedo_scale,
    coefficients_of,
    hats,
    remainder_numbers,
    rounded,
    row,
)
from .nonnegative import solve, weights
from .principal import principal
from .sampling_table import sampling_table

if TYPE_CHECKING:
    from ..model.fit import Fit

_WIDTHS = (0.025, 0.05, 0.09, 0.16, 0.28, 0.5, 0.9)             # candidates for microfacet lobes, along either axis ...
_TILTS = np.radians((-5, 0, 5))                                 # ... and the tilts of their normals
_EXPONENTS = (4, 12, 36, 110)                                   # candidates for the phong_ramps ...
_AXES = np.radians((-30, -15, -7, 0, 7))                        # ... and for their angles from the mirror direction
_RETRO_EXPONENTS = (12, 110)                                    # those that look back
_LEANS = np.tan(np.radians((6, 12, 20)))                        # for microfacets of threads that lie at a slope
_NARROW, _LONG = (0.05, 0.09, 0.16, 0.28), (0.28, 0.5, 0.9)     # ... which are narrow across it, and long along it
_HARD = 0.2                     # share of misplaced light from which on these are looked at too
_SKIPPED, _STRIDE = 2, 3        # of the views, and of the points of each, that are looked at in the search
_TRIED = 5                      # candidates for a lobe that are looked at closer
_GGX_COST = 1.1                 # factor on the error of a choice, per microfacet lobe: they take Cycles longer
_STEPS = 30                     # of the least squares, in the search


class Lobe(NamedTuple):
    """A lobe of one polar angle.

    Attributes
    ----------
    kind : int
        PHONG or GGX.
    shape : float
        The exponent, or the roughness along the first principal axis.
    angle : float
        Radians: from the mirror direction to the axis, or from the surface's normal to the lobe's; positive toward the
        horizon on the mirror side.
    across : float
        The roughness along the second principal axis.
    lean_x, lean_y : float
        Added to the first components of the normal of a microfacet lobe, which is then made a unit vector again: it
        leans along the principal axes.
    """

    kind: int
    shape: float
    angle: float
    across: float
    lean_x: float = 0.0
    lean_y: float = 0.0


class _Row(NamedTuple):
    """All azimuths of one polar angle."""

    wo: NDArray[np.float64]             # (azimuths, 3)
    to: Directions                      # (azimuths, n, ...)
    target: NDArray[np.float64]         # (azimuths, n, channels)


def anisotropic_mixture(fit: "Fit") -> Mixture:
    """The closure mixture of an anisotropic fit, of which only `evaluate` is used."""
    axes = principal(fit)
    azimuths = half_vector_grid.azimuths(axes.half_turn)
    with progress.part(0.0, 0.4):
        rows = [_row(fit, axes, number, azimuths) for number in progress.each(range(POLAR_VIEWS))]
    lobes: list[list[Lobe]] = []
    for each in progress.each(rows):
        lobes.append(_choose(each, [lobe for chosen in lobes for lobe in chosen]))
    coefficients = [solve(basis(chosen, each.wo, each.to.unit), each.target, each.to.solid_angle)
                    for chosen, each in zip(lobes, rows, strict=True)]
    tables, numbers, errors, missing, remainder, reflected, reachable = [], [], [], [], [], [], []
    for number, (each, chosen, found) in enumerate(zip(rows, lobes, coefficients, strict=True)):
        around = _around(rows, number, axes)
        left = [there.target - basis(chosen, there.wo, there.to.unit) @ found for there in around]
        bright = np.max([np.abs(values).sum(axis=-1) for values in left], axis=0)
        light = np.mean([there.target for there in around], axis=0).sum(axis=-1)
        if number == 0:                 # the normal, which has no azimuth
            bright, light = bright.max(axis=0)[None], light.mean(axis=0)[None]
        density, columns = _densities(chosen, each.wo, each.to.unit), basis(chosen, each.wo, each.to.unit)
        for view in range(len(bright)):
            to, target = each.to.solid_angle[view], each.target[view]
            mixture = target - left[0][view]
            scale = albedo_scale(target, mixture, to)
            total = max(float((to @ target).sum()), 1e-12)
            share = float(to @ np.abs(left[0][view]).sum(axis=1)) / total
            tables.append(row([lobe.kind for lobe in chosen], columns[view], found[view], scale, density[view], to))
            numbers.append(_numbers(chosen, share))
            errors.append(float(to @ np.abs(target - scale * mixture).sum(axis=1)) / total)
            dim = DIM * target.sum(axis=1)
            missing.append(CELLS.gather(left[0][view].T).mean(axis=-1).T)
            remainder.append(bright[view] + dim)
            reflected.append(light[view] + dim)
            reachable.append(each.to.reachable[view])
    solid_angle = np.concatenate([rows[0].to.solid_angle[:1], *(each.to.solid_angle for each in rows[1:])])
    sampling = [sampling_table(np.stack(carried), solid_angle, np.stack(reachable), uniform, CELLS)
                for carried, uniform in ((remainder, UNIFORM), (reflected, UNIFORM_REFLECTED))]
    return Mixture(np.stack(tables), np.stack(numbers), rounded(np.stack(missing)),
                   sampling[0], sampling[1], *_errors(errors, len(azimuths)), axes)


def evaluate(mixture: Mixture, view: int, wo: NDArray[np.float64], wi: NDArray[np.float64]) -> NDArray[np.float64]:
    """The reflected radiance of the mixture of a tabulated view, seen from a direction near it.

    Parameters
    ----------
    mixture : Mixture
    view : int
        The tabulated view, as `half_vector_grid.views` counts them.
    wo : (3,)
        The viewing direction, a unit vector in the principal axes.
    wi : (n, 3)
        Unit vectors above the horizon, in the principal axes.

    Returns
    -------
    (n, channels)
    """
    numbers = mixture.numbers[view]
    first, more = numbers[:LOBES * LOBE_NUMBERS].reshape(LOBES, -1), numbers[NUMBERS:].reshape(LOBES, -1)
    lobes = [Lobe(int(kind), *rest, *others) for (kind, *rest), others in zip(first, more, strict=True)]
    found = coefficients_of(mixture.table[view], [lobe.kind for lobe in lobes])
    return np.asarray(basis(lobes, wo[None], wi[None])[0] @ found)


def _row(fit: "Fit", axes: Principal, number: int, azimuths: NDArray[np.float64]) -> _Row:
    """The fit, seen from a polar angle, by its number."""
    theta_o = float(half_vector_grid.polar_angles()[number])
    wo = half_vector_grid.outgoing(theta_o, azimuths if theta_o > 0 else azimuths[:1])
    reached = half_vector_grid.reached(number, axes.half_turn, axes.stretch)
    to = half_vector_grid.grid(wo, axes.stretch, reached[:len(wo)])
    above = to.solid_angle > 0
    phi_o = np.broadcast_to(azimuths[:len(wo), None], above.shape)[above]
    value = fit.evaluate(to.theta[above], to.phi[above] + axes.turn, theta_o, phi_o + axes.turn)
    target = np.zeros((*above.shape, value.shape[-1]))
    target[above] = np.maximum(value, 0) * np.cos(to.theta[above])[:, None]
    if len(wo) < len(azimuths):
        wo, target, *parts = (np.repeat(each, len(azimuths), axis=0) for each in (wo, target, *to))
        to = Directions(*parts)
    return _Row(wo, to, target)


def _around(rows: list[_Row], number: int, axes: Principal) -> list[_Row]:
    """For each azimuth of a row the views that may be shown with its lobes: itself, and those beside it."""
    found = [rows[number]]
    if number > 0:
        found += [_beside(rows[number], step, axes) for step in (1, -1)]
    return found + [rows[other] for other in (number - 1, number + 1) if 0 <= other < len(rows)]


def _beside(here: _Row, step: int, axes: Principal) -> _Row:
    """Each view of a row in the place of the one before it, or behind it. Beyond half a turn, all are turned by it."""
    def turned(values: NDArray[np.float64], vector: bool = False) -> NDArray[np.float64]:
        moved = np.roll(values, -step, axis=0)
        if axes.half_turn:
            last = -1 if step > 0 else 0
            if values.ndim > 1 and values.shape[1] == len(here.to.theta[0]):
                points = (CELLS.rings * CELLS.points[0], CELLS.sectors * CELLS.points[1], *values.shape[2:])
                moved[last] = np.roll(moved[last].reshape(points), points[1] // 2, axis=1).reshape(moved[last].shape)
            if vector:
                moved[last] = moved[last] * [-1, -1, 1]
        return moved

    to = here.to._replace(unit=turned(here.to.unit, True), solid_angle=turned(here.to.solid_angle))
    return _Row(turned(here.wo, True), to, turned(here.target))


def _errors(errors: list[float], azimuths: int) -> tuple[float, float]:
    """Of Fast: in the mean over the polar angles, and in the worst view that is shown."""
    by_angle = np.array(errors[1:]).reshape(-1, azimuths)
    mean = np.concatenate([errors[:1], by_angle.mean(axis=1)])
    shown = half_vector_grid.polar_angles()[1:] <= LAST_SHOWN
    return float(mean.mean()), float(max(errors[0], by_angle[shown].max()))


def _numbers(lobes: list[Lobe], share: float) -> NDArray[np.float64]:
    """What is equal in all channels: (NUMBERS + 3 LOBES,)."""
    first = np.array([lobe[:LOBE_NUMBERS] for lobe in lobes]).ravel()
    return np.concatenate([first, remainder_numbers(share), np.array([lobe[LOBE_NUMBERS:] for lobe in lobes]).ravel()])


def _candidates(theta_o: float) -> list[Lobe]:
    """Lobes to choose from; seen from the normal there is no plane in which they could lean."""
    axes, tilts = (_AXES, _TILTS) if theta_o > 0 else (np.zeros(1), np.zeros(1))
    lobes = [Lobe(PHONG, exponent, float(axis), exponent) for exponent in _EXPONENTS for axis in axes]
    if theta_o > 0:
        lobes += [Lobe(PHONG, exponent, -2 * theta_o, exponent) for exponent in _RETRO_EXPONENTS]
    return lobes + [Lobe(GGX, along, float(tilt), across) for along in _WIDTHS for across in _WIDTHS for tilt in tilts]


def _leaning() -> list[Lobe]:
    """More of them, for a surface of threads."""
    slopes = [float(side * lean) for lean in _LEANS for side in (-1, 1)]
    return [lobe for narrow in _NARROW for long in _LONG for lean in slopes
            for lobe in (Lobe(GGX, narrow, 0.0, long, lean, 0.0), Lobe(GGX, long, 0.0, narrow, 0.0, lean))]


def _choose(at: _Row, before: list[Lobe]) -> list[Lobe]:
    """The lobes for a polar angle, where others were chosen before. Where one of those leans, more of them may."""
    theta_o = float(np.arccos(np.clip(at.wo[0, 2], 0, 1)))
    candidates = _candidates(theta_o)
    if not any(lobe.lean_x or lobe.lean_y for lobe in before):
        chosen, misplaced = _best(at, theta_o, candidates)
        if misplaced < _HARD:
            return chosen
    return _best(at, theta_o, candidates + _leaning())[0]


def _best(at: _Row, theta_o: float, candidates: list[Lobe]) -> tuple[list[Lobe], float]:
    """The best lobes among candidates, each in turn the one beside which the error is smallest; and the share of the
    light that they misplace."""
    views = slice(None, None, _SKIPPED) if theta_o > 0 else slice(1)
    some = (views, slice(None, None, _STRIDE))
    wo, unit, solid_angle = at.wo[views], at.to.unit[some], at.to.solid_angle[some]
    mean = at.target[some].mean(axis=-1, keepdims=True)
    weight = weights(mean, solid_angle)[..., 0]
    simple = np.stack([_outline(lobe, wo, unit) for lobe in candidates])
    size = np.einsum("an,can->ca", weight, simple ** 2) + 1e-12
    chosen: list[Lobe] = []
    left = mean[..., 0]
    for _ in range(LOBES):
        gain = np.maximum(np.einsum("an,can->ca", weight * left, simple), 0) ** 2 / size
        best, found = np.inf, chosen
        for number in [n for n in np.argsort(-gain.sum(axis=1)) if candidates[n] not in chosen][:_TRIED]:
            tried = [*chosen, candidates[number]]
            columns = basis(tried, wo, unit)
            remaining = mean - columns @ solve(columns, mean, solid_angle, _STEPS, 2)
            error = float((weight * remaining[..., 0] ** 2).sum())
            error *= _GGX_COST ** sum(lobe.kind == GGX for lobe in tried)
            if error < best:
                best, found, left = error, tried, remaining[..., 0]
        chosen = found
    return chosen, float((solid_angle * np.abs(left)).sum() / max(float((solid_angle * mean[..., 0]).sum()), 1e-12))


def basis(lobes: list[Lobe], wo: NDArray[np.float64], wi: NDArray[np.float64]) -> NDArray[np.float64]:
    """The basis functions of the diffuse ramp and of the lobes: (views, 3) and (views, n, 3) to (views, n, columns)."""
    hat = hats(wi[..., 2])
    hat[..., 0] = 0                 # Cycles evaluates the ramp below the horizon too, where it must be black
    return np.concatenate([hat / np.pi, *(_lobe(lobe, wo, wi) for lobe in lobes)], axis=-1)


def _lobe(lobe: Lobe, wo: NDArray[np.float64], wi: NDArray[np.float64]) -> NDArray[np.float64]:
    """The basis functions of a lobe: (views, n, KNOTS) for a phong_ramp, (views, n, 1) for a microfacet lobe."""
    if lobe.kind == GGX:
        return _ggx(lobe, wo, wi)[0][..., None]
    axis = _axis(lobe, wo)
    half = wo + axis
    half /= np.linalg.norm(half, axis=-1)[:, None]
    falloff = np.maximum(_dot(wi, axis), 0) ** lobe.shape
    height = np.maximum(_dot(wi, half), 0) * (lobe.shape + 2) / (2 * np.pi) * falloff
    return height[..., None] * hats(falloff)


def _outline(lobe: Lobe, wo: NDArray[np.float64], wi: NDArray[np.float64]) -> NDArray[np.float64]:
    """A lobe with a ramp of 1: (views, n)."""
    if lobe.kind == GGX:
        return _ggx(lobe, wo, wi)[0]
    return np.asarray(np.maximum(_dot(wi, _axis(lobe, wo)), 0) ** lobe.shape)


def _axis(lobe: Lobe, wo: NDArray[np.float64]) -> NDArray[np.float64]:
    """The axis of a phong_ramp: (views, 3)."""
    return _mirror_side(wo, np.minimum(np.arccos(np.clip(wo[:, 2], 0, 1)) + lobe.angle, STEEPEST_AXIS))


def _mirror_side(wo: NDArray[np.float64], theta: NDArray[np.float64] | float) -> NDArray[np.float64]:
    """Directions at an angle from the normal, in the planes of it and viewers, opposite to them: (views, 3)."""
    sine = np.hypot(wo[:, 0], wo[:, 1])
    azimuth = np.where(sine > 0, np.arctan2(wo[:, 1], wo[:, 0]), 0.0)
    return half_vector_grid.outgoing(theta, azimuth + np.pi)


def _dot(wi: NDArray[np.float64], axis: NDArray[np.float64]) -> NDArray[np.float64]:
    """(views, n, 3) and (views, 3) to (views, n)."""
    return np.asarray((wi @ axis[..., None])[..., 0])


def _ggx(lobe: Lobe, wo: NDArray[np.float64],
         wi: NDArray[np.float64]) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """GGX reflection of two widths about a tilted normal, with height-correlated masking and no Fresnel factor, times
    the cosine of that normal and wi (Walter et al. 2007; Heitz 2014); and the density with which Cycles samples it, of
    the microfacets that are visible from wo: both (views, n)."""
    normal = _mirror_side(wo, lobe.angle) + [lobe.lean_x, lobe.lean_y, 0]
    normal /= np.linalg.norm(normal, axis=-1)[:, None]
    second = np.cross(normal, [1.0, 0.0, 0.0])
    second /= np.linalg.norm(second, axis=-1)[:, None]
    turn = np.stack([np.cross(second, normal), second, normal], axis=-1)        # (views, 3, 3)
    outgoing, incident = (wo[:, None] @ turn)[:, 0], wi @ turn
    half = incident + outgoing[:, None]
    size = np.array([lobe.shape, lobe.across])
    stretched2 = ((half[..., :2] / size) ** 2).sum(axis=-1) + half[..., 2] ** 2
    bottom = (stretched2 / np.maximum((half ** 2).sum(axis=-1), 1e-20)) ** 2
    distribution = 1 / (np.pi * lobe.shape * lobe.across * np.maximum(bottom, 1e-20))
    seen = (incident[..., 2] > HORIZON) & (outgoing[:, None, 2] > HORIZON)
    masking_i, masking_o = (np.sqrt(1 + ((w[..., :2] * size) ** 2).sum(axis=-1) / np.maximum(w[..., 2], HORIZON) ** 2)
                            for w in (incident, outgoing))
    facets = distribution / (2 * np.maximum(outgoing[:, 2], HORIZON))[:, None]
    return (np.where(seen, facets / (masking_o[:, None] + masking_i), 0),
            np.where(seen, facets / (1 + masking_o[:, None]), 0))


def _densities(lobes: list[Lobe], wo: NDArray[np.float64], wi: NDArray[np.float64]) -> NDArray[np.float64]:
    """The density per solid angle with which Cycles samples the diffuse ramp and each lobe: (views, LOBES + 1, n)."""
    densities = [np.maximum(wi[..., 2], 0) / np.pi]
    densities += [_ggx(lobe, wo, wi)[1] if lobe.kind == GGX else (lobe.shape + 1) / (2 * np.pi) * _outline(lobe, wo, wi)
                  for lobe in lobes]
    return np.stack(densities, axis=1)

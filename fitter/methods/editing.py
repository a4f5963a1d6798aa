"""Makes edits of fits: chooses the level that splits a fit, and balances the light of a widened highlight."""

from collections.abc import Callable
from dataclasses import replace
from typing import NamedTuple

import numpy as np

from ..arrays import ArrayLike, FloatArray, broadcast_directions
from ..coordinates.half_difference import unproject
from ..model import Reflectance, edit
from ..model.edit import COAT_WIDTHS, WIDTH_BOUNDS, Edit
from ..model.fit import Fit
from ..model.transform import factor_of_angle
from ..samples import RGB
from ..shader_constants import DAMPING_KNOTS
from . import energy

_PAIRS = 4096               # of directions that the level is found from
_EDIT_AZIMUTHS = 8          # azimuths at which an anisotropic fit is looked at
_QUANTILE = 0.25            # of the reflectance over the projected hemispheres: half of a lobe that is broad lies above
_LEAST_LEVEL = 1e-6         # 1/sr (numerical)
_BALANCE_CELLS = 48, 24     # of the integrals of the balance; `energy.reflected_light` explains them
_ROUNDS = 40                # each brings the light much closer to what it was
_LARGEST_FACTOR = 16.0      # of the balance: where a highlight has lost all of its light, there is nothing to raise
_KNOT_ANGLES = unproject(np.minimum(np.arange(DAMPING_KNOTS) / (DAMPING_KNOTS - 1), 0.995))


def edited(fit: Fit, diffuse: ArrayLike = 1.0, highlight: ArrayLike = 1.0, width: float = 1.0, coat: float = 0.0,
           coat_width: float = 0.1) -> Fit:
    """Edit a fit; an edit that it has already is replaced.

    Parameters
    ----------
    diffuse, highlight : float or (channels,) array_like
        Factors of the diffuse part and of the highlight: gain times tint. A grey fit may get three.
    width
        Of the highlight, 1 as measured: from 1/4, which sharpens, to 4, which roughens. Its energy is kept.
    coat
        Weight of a clear coat, 0 to 1.
    coat_width
        Alpha of the coat, a GGX: 0.01 to 1.

    `Fit.edit` says what was edited, `model.edit` what it means; without any edit, the fit as it was
    measured.

    Raises
    ------
    ValueError
        If a number is not within its bounds.

    Examples
    --------
    A Lambertian has no highlight:

    >>> from ..coordinates.nusselt import Nusselt
    >>> from ..lattice import dense
    >>> grey = Fit(Nusselt(), dense.DenseLattice(1, np.full((*dense.shape(1), 1), 0.2, dtype=np.float32)))
    >>> edited(grey, diffuse=0.5, highlight=9.0).evaluate(0.3, 0, 0.5, 1).round(6).tolist()
    [0.1]
    """
    factors = [_factor("diffuse", diffuse), _factor("highlight", highlight)]
    for name, value, (low, high) in (("width", width, WIDTH_BOUNDS), ("coat", coat, (0.0, 1.0)),
                                     ("coat_width", coat_width, COAT_WIDTHS)):
        if not low <= value <= high:
            raise ValueError(f"{name} is {value}, expected {low:g} to {high:g}")
    fit = replace(fit, edit=None)
    if width == 1 and not coat and all((factor == 1).all() for factor in factors):
        return fit
    channels = max(len(fit.channels), *(factor.size for factor in factors))
    if channels not in (1, len(RGB)) or any(factor.size not in (1, channels) for factor in factors):
        raise ValueError(f"factors of {[factor.size for factor in factors]} channels for a fit of {len(fit.channels)}")
    if channels > len(fit.channels):
        fit = replace(fit, channels=RGB, columns=fit.columns * channels)
    columns = tuple(range(max(fit.columns) + 1))
    stored = replace(fit.surface, channels=tuple(map(str, columns)), columns=columns)
    level = split_level(stored, fit.isotropic)
    balance = np.zeros((0, len(level))) if width == 1 else _balance(stored, level, width)
    return replace(fit, edit=Edit(np.broadcast_to(factors[0], channels).copy(),
                                  np.broadcast_to(factors[1], channels).copy(), level, float(width), balance,
                                  float(coat), float(coat_width),
                                  _coat_transmittance(coat, coat_width) if coat else np.zeros((0, 1))))


def _factor(name: str, value: ArrayLike) -> FloatArray:
    factor = np.atleast_1d(np.asarray(value, dtype=float))
    if factor.ndim != 1 or not (np.isfinite(factor) & (factor >= 0)).all():
        raise ValueError(f"{name} is {factor.tolist()}, expected numbers of at least 0")
    return factor


class _Function(NamedTuple):
    """A function as a `Reflectance`."""

    evaluate: Callable[..., FloatArray]
    isotropic: bool = True


def split_level(model: Reflectance, isotropic: bool = True) -> FloatArray:
    """The level that splits a reflectance, (channels,), 1/sr: a quarter of all pairs, distributed as a Lambertian
    reflects, is below."""
    at = np.arange(_PAIRS)
    u, v, turn = ((0.5 + at * step) % 1 for step in (0.8191725134, 0.6710436067, 0.5497004779))     # a rank-1 lattice
    theta_i, theta_o, phi_o = np.arcsin(np.sqrt(u)), np.arcsin(np.sqrt(v)), 2 * np.pi * turn
    phi_i = np.zeros(_PAIRS) if isotropic else 2 * np.pi * (at % _EDIT_AZIMUTHS) / _EDIT_AZIMUTHS
    values = np.maximum(model.evaluate(theta_i, phi_i, theta_o, phi_i + phi_o), 0)
    return np.maximum(np.quantile(values, _QUANTILE, axis=0), _LEAST_LEVEL)


def _balance(fit: Fit, level: FloatArray, width: float) -> FloatArray:
    """`Edit.balance`, (DAMPING_KNOTS, columns), of a fit with a channel for each column of its lattices."""
    def light(each: Edit) -> FloatArray:
        def highlight(*angles: ArrayLike) -> FloatArray:
            at = broadcast_directions(*angles)
            value = each.widen_highlight(fit.evaluate, *(angle.ravel() for angle in at))
            return value.reshape(*at[0].shape, -1)

        return energy.reflected_light(_Function(highlight, fit.isotropic), _KNOT_ANGLES, _BALANCE_CELLS).mean(axis=0)

    before, after = (light(Edit(np.ones(len(level)), np.ones(len(level)), level, each)) for each in (1.0, width))
    wanted, control_points = before.sum(axis=1), np.ones((DAMPING_KNOTS, len(level)))
    for _ in range(_ROUNDS):
        reflected = factor_of_angle(control_points, _KNOT_ANGLES) * np.einsum("vkc,kc->vc", after, control_points)
        ratio = np.divide(wanted, reflected, out=np.ones_like(wanted), where=(reflected > 0) & (wanted > 0))
        control_points = np.clip(control_points * np.sqrt(ratio), 1 / _LARGEST_FACTOR, _LARGEST_FACTOR)
    return control_points


def _coat_transmittance(weight: float, width: float) -> FloatArray:
    """`Edit.through`: (DAMPING_KNOTS, 1). The albedo is smooth, so that control points may be its values."""
    alone = _Function(lambda *angles: edit.coat(width, *angles)[..., None])
    return 1 - weight * energy.reflected_light(alone, _KNOT_ANGLES, _BALANCE_CELLS).mean(axis=0).sum(axis=1)

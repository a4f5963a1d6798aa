"""Variations of a material: what `editing.edited` is to do so that it looks worn, wet or dusty; plausible guesses.

- wet: a smooth coat, as lacquered; what is porous gets darker, because light that it scatters is sent back by the
  water's surface and scattered again. With p = 0.474, what a surface of index 1.33 reflects of diffuse light from
  within, an albedo A becomes A (1 - p) / (1 - p A) (J. Lekner, M. C. Dorf: Why Some Things Are Darker When Wet, Applied
  Optics 27(7), 1988, with all light that enters scattered). What shines is no pore: there water only coats.
- dusty: two fifths of the surface under dust. An edit multiplies, so that a metal, which has no diffuse part, gets dull
  but not grey.
"""

from typing import Any

import numpy as np

from ..arrays import FloatArray
from ..methods.editing import edited
from ..model.edit import COAT_WIDTHS
from ..model.fit import Fit
from ..quality.physics import directional_albedo

WITHIN_WATER = 0.474
_SHINES = 3.0               # times the diffuse part that a mirror direction has of what shines
_MIRROR_ANGLE = np.radians(45)
_DUST, _COVERED = np.array([0.42, 0.38, 0.32]), 0.4     # its albedo, and how much of the surface is under it
_LARGEST = 20.0             # factor of a diffuse part: of what is nearly black
_LEAST = 1e-4               # albedo that counts
_SMOOTH = {"coat": 1.0, "coat_width": COAT_WIDTHS[0]}
_FIXED_VARIATIONS: dict[str, dict[str, Any]] = {       # whatever the fit is
    "satin": {"width": 2.0}, "aged": {"diffuse": [0.85, 0.78, 0.66], "highlight": [0.7, 0.65, 0.55], "width": 1.6},
    "lacquered": _SMOOTH}
VARIATIONS = (*_FIXED_VARIATIONS, "wet", "dusty")


def variation(name: str, fit: Fit) -> dict[str, Any]:
    """The keyword arguments of `edited` for a variation of a fit as it was measured.

    Raises ValueError if `name` is not one of `VARIATIONS`.
    """
    if name in _FIXED_VARIATIONS:
        return {**_FIXED_VARIATIONS[name]}
    if name == "wet":
        if _is_shiny(fit):
            return {**_SMOOTH}
        albedo = _diffuse_albedo(fit)
        return {"diffuse": ((1 - WITHIN_WATER) / (1 - WITHIN_WATER * np.minimum(albedo, 1))).tolist(), **_SMOOTH}
    if name == "dusty":
        albedo = np.maximum(_diffuse_albedo(fit), _LEAST)
        factor = np.minimum(1 - _COVERED + _COVERED * _DUST / albedo, _LARGEST)
        return {"diffuse": factor.tolist(), "highlight": 1 - _COVERED, "width": 1.5}
    raise ValueError(f"the variation {name!r}, expected one of {', '.join(VARIATIONS)}")


def _is_shiny(fit: Fit) -> bool:
    """Whether it reflects more where a mirror would than its diffuse part does."""
    at = _MIRROR_ANGLE, 0, _MIRROR_ANGLE, np.pi
    whole, diffuse = (each.evaluate(*at).sum() for each in (fit, edited(fit, highlight=0)))
    return bool(whole > _SHINES * diffuse)


def _diffuse_albedo(fit: Fit) -> FloatArray:
    """That of the diffuse part: (3,)."""
    return np.broadcast_to(directional_albedo(edited(fit, highlight=0), [_MIRROR_ANGLE])[0], (3,))

"""A medium below a smooth or rough dielectric surface: GGX of its index, and the diffuse surface of the same albedo."""

import re
from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from ..arrays import ArrayLike, FloatArray
from ..optics.subsurface import Subsurface, check, medium_from_coefficients
from .conductor import Conductor

TRANSLUCENT = "translucent"
WORDS = {"scattering": "", "absorption": "", "albedo": "", "path": "", "index": "1.3", "width": "0.1"}
"""What a material is described by: reduced scattering and absorption, 1/mm, or albedo and mean free path, mm, three
numbers each; the index of refraction; and the width of the surface's slopes. With what is meant where none is given.
"""
SURFACE_WIDTHS = 0.01, 1.0


@dataclass(frozen=True, eq=False)
class Translucent:
    """A translucent material; as a BRDF, as if light left where it entered."""

    subsurface: Subsurface
    surface: Conductor

    @property
    def isotropic(self) -> bool:
        """Whether the surface is."""
        return self.surface.isotropic

    def evaluate(self, theta_i: ArrayLike, phi_i: ArrayLike, theta_o: ArrayLike, phi_o: ArrayLike) -> FloatArray:
        """The BRDF, 1/sr: angles broadcast to (...), radians, to (..., 3) float64."""
        return self.surface.evaluate(theta_i, phi_i, theta_o, phi_o) + self.subsurface.diffuse(theta_i, theta_o)


def parse_words(words: Mapping[str, str]) -> Translucent:
    """A material by `WORDS`; three numbers are separated by spaces or commas, and one counts for all. Raises ValueError
    if a word is missing, or a number is none or out of range."""
    given = WORDS | {name: text.strip() for name, text in words.items() if name in WORDS and text and text.strip()}
    index, width = (_numbers(name, given[name], 1)[0] for name in ("index", "width"))
    if not SURFACE_WIDTHS[0] <= width <= SURFACE_WIDTHS[1]:
        raise ValueError(f"width {width:g}, expected {SURFACE_WIDTHS[0]:g} to {SURFACE_WIDTHS[1]:g}")
    pairs = [(first, second) for first, second in (("scattering", "absorption"), ("albedo", "path"))
             if given[first] and given[second]]
    if len(pairs) != 1:
        raise ValueError("expected scattering and absorption, or albedo and path")
    first, second = (_numbers(name, given[name], 3) for name in pairs[0])
    if pairs[0][0] == "scattering":
        below = medium_from_coefficients(first, second, index)
    else:
        check(first, second, index)
        below = Subsurface(first, second, index)
    return Translucent(below, Conductor(np.array([index]), np.zeros(1), np.ones((3, 1)), width, width))


def _numbers(name: str, text: str, count: int) -> FloatArray:
    try:
        numbers = np.array([float(each) for each in re.split(r"[\s,]+", text)])
    except ValueError:
        numbers = np.zeros(0)
    if len(numbers) not in (1, count) or not np.isfinite(numbers).all():
        raise ValueError(f"{name} {text!r}, expected {'a number' if count == 1 else 'three numbers'}")
    return np.broadcast_to(numbers, count).copy()

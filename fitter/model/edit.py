"""Edits of a fitted reflectance: its diffuse part and its highlight scaled apart, the highlight widened, a clear coat.

A fit f is split by a level of its own, at each pair of directions and in each channel. Up to the level all of f is
diffuse; above it ever less is added, up to one and a half times the level from twice the level on ::

    diffuse(f) = f - (f - level)^2 / (2 level)      for level < f < 2 level
    highlight(f) = f - diffuse(f)

The highlight is widened in the slopes of microfacets, the tangents of the half angle theta_h: it is taken where the
half vector has its slope divided by `width`, both directions turned with it so that the difference angle stays, times
the Jacobian (B. Walter, S. Marschner, H. Li, K. Torrance: Microfacet Models for Refraction through Rough Surfaces, EGSR
2007) and a factor g, which keeps the directional albedo at every polar angle; it is close to 1 where masking and the
horizon play no part ::

    highlight'(i, o) = highlight(i', o') (cos theta_h' / cos theta_h)^4 / width^2 g(theta_i) g(theta_o)

The clear coat is a dielectric of index 1.5 above: GGX with Schlick's Fresnel term F, and below it what both directions
leave of the rest, where A is the directional albedo of the coat ::

    f'(i, o) = coat D F V + t(theta_i) t(theta_o) f(i, o),    t = 1 - coat A

All of it is reciprocal where the fit is. A coat never makes an albedo exceed 1; a gain may.
"""

from collections.abc import Callable
from dataclasses import dataclass, field

import numpy as np

from ..arrays import FloatArray
from ..shader_constants import COAT_F0, LEAST_HEIGHT_2, LEAST_HORIZON_COSINE, LEAST_LENGTH
from .ggx import ggx
from .microfacet import geometry
from .transform import factor_of_angle

WIDTH_BOUNDS = 0.25, 4.0    # bounds of the width
COAT_WIDTHS = 0.01, 1.0     # and of that of a coat: alpha of GGX
_Measured = Callable[[FloatArray, FloatArray, FloatArray, FloatArray], FloatArray]


@dataclass(frozen=True, eq=False)
class Edit:
    """An edit of a fit; `fitter.edited` makes it."""

    diffuse: FloatArray                     # factor of the diffuse part, (channels,),
    highlight: FloatArray                   # and of the highlight
    level: FloatArray                       # of the split, in each column of the fit's lattices, 1/sr; positive
    width: float = 1.0                      # of the highlight, relative to the measured one: within `WIDTH_BOUNDS`
    # g, as `LogRelative.damping` has a factor of each polar angle: (DAMPING_KNOTS, columns), or (0, columns) where the
    # width is 1
    balance: FloatArray = field(default_factory=lambda: np.zeros((0, 1)))
    coat: float = 0.0                       # the coat's weight, 0 to 1
    coat_width: float = COAT_WIDTHS[0]      # its alpha, within `COAT_WIDTHS`
    # t, as `balance` has g: (DAMPING_KNOTS, 1), or (0, 1) without a coat
    through: FloatArray = field(default_factory=lambda: np.zeros((0, 1)))

    @property
    def nbytes(self) -> int:
        """Bytes of the parameters in single precision."""
        arrays = self.diffuse, self.highlight, self.level, self.balance, self.through
        return 4 * (sum(array.size for array in arrays) + 3)

    def reflectance(self, measured: _Measured, columns: tuple[int, ...], theta_i: FloatArray, phi_i: FloatArray,
                    theta_o: FloatArray, phi_o: FloatArray) -> FloatArray:
        """The edited reflectance at directions (n,), radians: (n, channels), 1/sr. `measured` is the fit as it was:
        four (n,) to (n, columns). Where that is negative it counts as 0."""
        directions = theta_i, phi_i, theta_o, phi_o
        value = np.maximum(measured(*directions), 0)
        diffuse = diffuse_part(value, self.level)
        highlight = value - diffuse if self.width == 1 else self.widen_highlight(measured, *directions)
        total = self.diffuse * diffuse[:, columns] + self.highlight * highlight[:, columns]
        if not self.coat:
            return total
        through = factor_of_angle(self.through, theta_i) * factor_of_angle(self.through, theta_o)
        return self.coat * coat(self.coat_width, *directions)[:, None] + through * total

    def widen_highlight(self, measured: _Measured, theta_i: FloatArray, phi_i: FloatArray, theta_o: FloatArray,
                        phi_o: FloatArray) -> FloatArray:
        """The widened highlight in all columns: (n, columns), 1/sr."""
        directions, density = narrow_directions(theta_i, phi_i, theta_o, phi_o, self.width)
        value = np.maximum(measured(*directions), 0)
        highlight: FloatArray = (value - diffuse_part(value, self.level)) * density[:, None]
        if len(self.balance):
            highlight *= factor_of_angle(self.balance, theta_i) * factor_of_angle(self.balance, theta_o)
        return highlight


def diffuse_part(value: FloatArray, level: FloatArray) -> FloatArray:
    """What of a reflectance is diffuse: (..., columns) and (columns,), 1/sr, to (..., columns).

    Examples
    --------
    >>> diffuse_part(np.array([[0.1], [0.2], [0.3], [0.4], [9.0]]), np.array([0.2])).round(6).ravel().tolist()
    [0.1, 0.2, 0.275, 0.3, 0.3]
    """
    over = np.clip(value - level, 0, level)
    return np.asarray(np.minimum(value, 2 * level) - over * over / (2 * level))


def narrow_directions(theta_i: FloatArray, phi_i: FloatArray, theta_o: FloatArray, phi_o: FloatArray,
                      width: float) -> tuple[tuple[FloatArray, FloatArray, FloatArray, FloatArray], FloatArray]:
    """The directions at which a widened highlight is read, radians, and the Jacobian of their half vectors, (n,). A
    direction that comes to lie below the horizon is moved to it."""
    incident, outgoing = (np.sin(theta) * np.exp(1j * phi) for theta, phi in ((theta_i, phi_i), (theta_o, phi_o)))
    up_i, up_o = np.cos(theta_i), np.cos(theta_o)
    along = incident + outgoing
    length = np.abs(along)
    slope = length / np.sqrt(np.maximum((up_i + up_o) ** 2, LEAST_HEIGHT_2))
    narrow = slope / width
    scale = 1 / np.sqrt((1 + slope ** 2) * (1 + narrow ** 2))
    cosine, sine = (1 + slope * narrow) * scale, (narrow - slope) * scale
    axis = np.where(length > LEAST_LENGTH, along / np.maximum(length, LEAST_LENGTH), 1)
    angles: list[FloatArray] = []
    for flat, up in ((incident, up_i), (outgoing, up_o)):
        before = (flat * np.conj(axis)).real
        turned = flat + (before * cosine + up * sine - before) * axis
        height = np.maximum(up * cosine - before * sine, LEAST_HORIZON_COSINE)
        angles += [np.arctan2(np.abs(turned), height), np.angle(turned)]
    density = ((1 + slope ** 2) / (1 + narrow ** 2) / width) ** 2
    return (angles[0], angles[1], angles[2], angles[3]), density


def coat(alpha: float, theta_i: FloatArray, phi_i: FloatArray, theta_o: FloatArray, phi_o: FloatArray) -> FloatArray:
    """GGX reflection of the coat, with height-correlated masking: (n,), 1/sr."""
    at = geometry(theta_i, phi_i, theta_o, phi_o)
    return ggx(at, alpha, COAT_F0 + (1 - COAT_F0) * (1 - at.cos_d) ** 5)

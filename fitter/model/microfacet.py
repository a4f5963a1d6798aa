"""A model of lobes, used as the prior of `LogRelative`: b = kd + sum_k ks_k L_k, a Lambertian and up to three lobes,
whose formulas are in docs/fitting.md (step 3).

Each lobe is of one of four kinds:

- "mirror", microfacets that reflect: a generalised Trowbridge-Reitz distribution (B. Burley: Physically Based Shading
  at Disney, 2012), the height-correlated Smith visibility (E. Heitz: Understanding the Masking-Shadowing Function in
  Microfacet-Based BRDFs, JCGT 3(2), 2014) and the Fresnel term of C. Schlick: An Inexpensive BRDF Model for
  Physically-based Rendering, 1994. An anisotropic one has two widths, a and b, along axes of its own: D = ((h_x / a)^2
  + (h_y / b)^2 + h_z^2)^-gamma, as Burley has it, of the half vector h (gamma = 2 is GGX).
- "retro", which shines back at the light: half and difference angle after one direction has been turned about the
  normal by 180 degrees (the back vector of L. Belcour, R. Pacanowski, M. Delahaie, A. Laville-Geay, L. Eupherte: BRDF
  Measurements and Analysis of Retroreflective Materials, JOSA A 31(12), 2014).
- "sheen", fibres that shine where the half vector grazes (M. Ashikhmin, S. Premoze, P. Shirley: A Microfacet-Based BRDF
  Generator, SIGGRAPH 2000, with the denominator of D. Neubelt, M. Pettineo: Crafting a Next-Gen Material Pipeline for
  The Order: 1886, 2013). It has no gamma.
- "fibre", threads that lie along an azimuth and dip to both sides, which shine on cones about their direction: with t
  the sum of both directions along the azimuth and z its height, the mean of D((t - dip z)^2) and D((t + dip z)^2),
  times S with g = 1 - cos theta_d, over the denominator of sheen. The reciprocal form of J. Kajiya, T. Kay: Rendering
  Fur with Three Dimensional Textures, SIGGRAPH 1989; an anisotropic material alone has it.
"""

from collections.abc import Callable
from dataclasses import dataclass, field
from typing import Literal, NamedTuple

import numpy as np

from ..arrays import ArrayLike, ComplexArray, FloatArray
from ..shader_constants import DENSEST, LEAST_HEIGHT_2, LEAST_SLOPE_2

Kind = Literal["mirror", "retro", "sheen", "fibre"]
KINDS: tuple[Kind, ...] = ("mirror", "retro", "sheen", "fibre")
MAX_PRIOR_LOBES = 3
NARROWEST, STEEPEST_TAIL = 1e-3, 32.0       # bounds of alpha and gamma - 1: beyond, single precision is visible
NO_GAMMA = 2.0              # gamma of a sheen lobe, which does not read it
RANGES = {"alpha": (NARROWEST, STEEPEST_TAIL), "gamma": (1 + NARROWEST, 1 + STEEPEST_TAIL), "f0": (0.0, 1.0),
          "across": (NARROWEST, STEEPEST_TAIL), "turn": (-np.pi, np.pi)}


class Geometry(NamedTuple):
    """The quantities that the model depends on, each (...) float64."""

    cos_i: FloatArray
    cos_o: FloatArray
    tan2_h: FloatArray      # squared tangent of the half angle theta_h
    cos_d: FloatArray       # cosine of the difference angle theta_d
    tan2_b: FloatArray      # squared tangent of theta_b, the angle between the normal and the back vector
    cos_r: FloatArray       # cosine of theta_r, the difference angle of the back vector


class SurfaceComponents(NamedTuple):
    """What anisotropic lobes depend on besides: components along the tangent and, imaginary, the bitangent, (...)."""

    incident: ComplexArray
    outgoing: ComplexArray
    slope: ComplexArray     # that of the half vector over its height: a microfacet's slope


@dataclass(frozen=True)
class Microfacet:
    """A Lambertian and lobes.

    A model without anisotropic lobes has no `across` and `turn`. Of an anisotropic lobe of microfacets alpha is the
    width along the azimuth `turn`, radians, and `across` that at a right angle to it; of fibres `turn` is the azimuth,
    and `across` the slope at which they dip. The other kinds have `across` equal to alpha.
    """

    kd: FloatArray                  # diffuse reflectance, (channels,), 1/sr
    ks: FloatArray                  # scale of each lobe, (lobes, channels), 1/sr
    alpha: FloatArray               # its width, (lobes,), as a slope,
    gamma: FloatArray               # the exponent of its tail,
    f0: FloatArray                  # and the value of S where g is 0, relative to that where it is 1
    kinds: tuple[Kind, ...] = ()    # by default all are "mirror"
    across: FloatArray = field(default_factory=lambda: np.zeros(0))  # (lobes,), or none
    turn: FloatArray = field(default_factory=lambda: np.zeros(0))  # likewise

    def __post_init__(self) -> None:
        if not self.kinds:
            object.__setattr__(self, "kinds", ("mirror",) * len(self.alpha))

    @property
    def isotropic(self) -> bool:
        """Whether no lobe has a direction."""
        return "fibre" not in self.kinds and (not len(self.across) or bool((self.across == self.alpha).all()))

    @property
    def shapes(self) -> list[tuple[float, ...]]:
        """Of each lobe alpha, gamma and f0, and of a model with anisotropic lobes `across` and `turn`."""
        numbers = (self.alpha, self.gamma, self.f0)
        return list(zip(*numbers, *(() if self.isotropic else (self.across, self.turn)), strict=True))

    @property
    def nbytes(self) -> int:
        """Bytes of the parameters of all channels in single precision, and one for the kind of each lobe."""
        shapes = (3 if self.isotropic else 5) * self.alpha.size
        return 4 * (self.kd.size + self.ks.size + shapes) + len(self.kinds)

    def evaluate(self, theta_i: ArrayLike, phi_i: ArrayLike, theta_o: ArrayLike, phi_o: ArrayLike) -> FloatArray:
        """The model, 1/sr: angles broadcast to (...), radians, to (..., channels) float64."""
        directions = theta_i, phi_i, theta_o, phi_o
        in_surface = None if self.isotropic else surface_components(*directions)
        return self.evaluate_geometry(geometry(*directions), in_surface)

    def evaluate_geometry(self, geometry: Geometry, in_surface: SurfaceComponents | None = None) -> FloatArray:
        """The model for a geometry of (...): (..., channels), 1/sr. An isotropic one needs no components."""
        total = np.broadcast_to(self.kd, (*np.shape(geometry.tan2_h), len(self.kd)))
        for kind, ks, shape in zip(self.kinds, self.ks, self.shapes, strict=True):
            total = total + ks * lobe(kind, geometry, in_surface, *shape)[..., None]
        return total


def lobe(kind: Kind, at: Geometry, in_surface: SurfaceComponents | None, alpha: float, gamma: float, f0: float,
         across: float | None = None, turn: float = 0.0) -> FloatArray:
    """A lobe of strength 1 at a geometry of (...): (...) float64. One of a single width needs no components."""
    return lobe_with_slopes(kind, at, in_surface, alpha, gamma, f0, across, turn)[0]


def lobe_with_slopes(kind: Kind, at: Geometry, in_surface: SurfaceComponents | None, alpha: float, gamma: float,
                     f0: float, across: float | None = None, turn: float = 0.0,
                     ) -> tuple[FloatArray, Callable[[], list[FloatArray]]]:
    """`lobe`, and its derivatives by log alpha, gamma and f0 and, with components, by log across and turn."""
    cos_i, cos_o = at.cos_i, at.cos_o
    nothing = np.zeros(np.shape(at.tan2_h))
    unturned = [] if in_surface is None else [nothing, nothing]
    # each kind returns its value, and a function of its derivatives
    if kind == "retro":
        ratio, growth = at.tan2_b / alpha ** 2, at.cos_r ** 2
        steepness, fresnel = 1 + ratio, f0 + (1 - f0) * growth
        falloff = steepness ** -gamma
        return falloff * fresnel, lambda: [
            2 * gamma * falloff * fresnel * ratio / steepness, -np.log(steepness) * falloff * fresnel,
            falloff * (1 - growth), *unturned]
    if kind == "sheen":
        exponent, growth = 1 / (alpha ** 2 * np.maximum(at.tan2_h, LEAST_SLOPE_2)), 1 - at.cos_d
        fibres = np.exp(-exponent) / (cos_i + cos_o - cos_i * cos_o + DENSEST)
        sheen = fibres * (f0 + (1 - f0) * growth)
        return sheen, lambda: [2 * exponent * sheen, nothing, fibres * (1 - growth), *unturned]
    if kind == "fibre":
        if in_surface is None or across is None:
            raise ValueError("fibres without the components in the surface")
        return _fibres(at, in_surface, alpha, gamma, f0, across, turn)
    # mirror lobes: Fresnel after Schlick
    growth = (1 - at.cos_d) ** 5
    fresnel = f0 + (1 - f0) * growth
    # one width
    if in_surface is None or across is None:
        m2 = min(alpha, 1.0) ** 2
        ratio = at.tan2_h / alpha ** 2
        steepness = 1 + ratio
        long_i, long_o = (np.sqrt(cosine ** 2 * (1 - m2) + m2) for cosine in (cos_i, cos_o))
        visibility = 0.5 / (cos_o * long_i + cos_i * long_o + DENSEST)
        falloff = steepness ** -gamma * visibility
        value = falloff * fresnel

        def slopes() -> list[FloatArray]:
            by_alpha = 2 * gamma * value * ratio / steepness
            if alpha < 1:
                longer = cos_o * (1 - cos_i ** 2) / long_i + cos_i * (1 - cos_o ** 2) / long_o
                by_alpha -= 2 * m2 * value * visibility * longer
            return [by_alpha, -np.log(steepness) * value, falloff * (1 - growth), *unturned]

        return value, slopes
    # two widths, in the axes of the lobe
    incident, outgoing, slope = (each * np.exp(-1j * turn) for each in in_surface)
    squares = (slope.real / alpha) ** 2, (slope.imag / across) ** 2
    steepness = (1 + squares[0] + squares[1]) / (1 + at.tan2_h)
    m, m_across = min(alpha, 1.0), min(across, 1.0)
    long_i, long_o = (np.sqrt(cosine ** 2 + (m * along.real) ** 2 + (m_across * along.imag) ** 2)
                      for cosine, along in ((cos_i, incident), (cos_o, outgoing)))
    visibility = 0.5 / (cos_o * long_i + cos_i * long_o + DENSEST)
    falloff = steepness ** -gamma * visibility
    value = falloff * fresnel

    def rotated_slopes() -> list[FloatArray]:
        of_squares = gamma * value / (1 + squares[0] + squares[1])
        by_widths = [2 * square * of_squares for square in squares]
        # e^(-i turn) makes the real part grow by the imaginary one, and that fall by the real one
        by_turn = -2 * (1 / alpha ** 2 - 1 / across ** 2) * slope.real * slope.imag * of_squares
        for length, cosine, along in ((long_i, cos_o, incident), (long_o, cos_i, outgoing)):
            of_length = 2 * value * visibility * cosine / length
            for number, (width, part) in enumerate(((alpha, along.real), (across, along.imag))):
                if width < 1:
                    by_widths[number] = by_widths[number] - (width * part) ** 2 * of_length
            by_turn = by_turn - (m ** 2 - m_across ** 2) * along.real * along.imag * of_length
        return [by_widths[0], -np.log(steepness) * value, falloff * (1 - growth), by_widths[1], by_turn]

    return value, rotated_slopes


def _fibres(at: Geometry, in_surface: SurfaceComponents, alpha: float, gamma: float, f0: float, across: float,
            turn: float) -> tuple[FloatArray, Callable[[], list[FloatArray]]]:
    """`lobe_with_slopes` of fibres."""
    in_both = (in_surface.incident + in_surface.outgoing) * np.exp(-1j * turn)
    dip = across * (at.cos_i + at.cos_o)
    sides = [(in_both.real + side) / alpha for side in (-dip, dip)]
    cones = [(1 + side ** 2) ** -gamma / 2 for side in sides]
    growth = 1 - at.cos_d
    over = 1 / (at.cos_i + at.cos_o - at.cos_i * at.cos_o + DENSEST)
    fresnel = over * (f0 + (1 - f0) * growth)

    def slopes() -> list[FloatArray]:
        of_sides = [-2 * gamma * side / (1 + side ** 2) * cone * fresnel
                    for side, cone in zip(sides, cones, strict=True)]
        return [-(of_sides[0] * sides[0] + of_sides[1] * sides[1]),
                -sum(np.log(1 + side ** 2) * cone for side, cone in zip(sides, cones, strict=True)) * fresnel,
                (cones[0] + cones[1]) * over * (1 - growth), (of_sides[1] - of_sides[0]) * dip / alpha,
                (of_sides[0] + of_sides[1]) * in_both.imag / alpha]

    return np.asarray((cones[0] + cones[1]) * fresnel), slopes


def geometry(theta_i: ArrayLike, phi_i: ArrayLike, theta_o: ArrayLike, phi_o: ArrayLike) -> Geometry:
    """The geometry of pairs of directions: angles broadcast to (...), radians."""
    theta_i, theta_o = np.asarray(theta_i, dtype=float), np.asarray(theta_o, dtype=float)
    cos_i, cos_o = np.cos(theta_i), np.cos(theta_o)
    sin_i, sin_o = np.sin(theta_i), np.sin(theta_o)
    squares, product = sin_i ** 2 + sin_o ** 2, 2 * sin_i * sin_o * np.cos(np.asarray(phi_o, dtype=float) - phi_i)
    up2 = np.maximum((cos_i + cos_o) ** 2, LEAST_HEIGHT_2)
    along2, back2 = np.maximum(squares + product, 0), np.maximum(squares - product, 0)
    return Geometry(cos_i, cos_o, along2 / up2, np.minimum(np.sqrt(along2 + up2) / 2, 1),
                    back2 / up2, np.minimum(np.sqrt(back2 + up2) / 2, 1))


def surface_components(theta_i: ArrayLike, phi_i: ArrayLike, theta_o: ArrayLike, phi_o: ArrayLike) -> SurfaceComponents:
    """The components in the surface of pairs of directions: angles broadcast to (...), radians."""
    theta_i, theta_o = np.asarray(theta_i, dtype=float), np.asarray(theta_o, dtype=float)
    incident, outgoing = (np.sin(theta) * np.exp(1j * np.asarray(phi)) for theta, phi in ((theta_i, phi_i),
                                                                                          (theta_o, phi_o)))
    up2 = np.maximum((np.cos(theta_i) + np.cos(theta_o)) ** 2, LEAST_HEIGHT_2)
    return SurfaceComponents(incident, outgoing, (incident + outgoing) / np.sqrt(up2))

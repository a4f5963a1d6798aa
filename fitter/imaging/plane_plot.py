"""The plot of a plane of incidence: a fit, its samples, perhaps a second fit. Up is the normal, left is the light.
`draw` takes a pen: `drawing.Canvas` makes a picture, `addon/inspect/drawing.py` draws the same over a viewport."""

import math
from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import NamedTuple, Protocol

import numpy as np

from ..arrays import ArrayLike, BoolArray, FloatArray, SingleArray
from ..colours import DEFAULT_COLOURS, conversion, luminance
from ..methods import extrapolation
from ..model import Reflectance
from ..samples import Samples
from .drawing import BACKGROUND, INK, LIGHT, Canvas, Color
from .lobe import RADII, Radius, evaluate_in_plane, plane_curve

SIZE = 256                  # pixels of a picture, at a scale of 1
DIM, FAINT = (0.62, 0.62, 0.62, 1.0), (0.75, 0.75, 0.75, 0.35)
PAIR: tuple[Color, Color] = ((1.0, 0.6, 0.2, 1.0), (0.35, 0.7, 1.0, 1.0))       # of two materials that are compared
TEXT, SMALL = 13.0, 11.0    # pixels of text at a scale of 1
IN_PLANE = np.radians(8)    # samples within this angle of the plane of incidence are plotted
_GREY_LINE: Sequence[Color] = ((0.9, 0.9, 0.9, 1.0),)
_RGB_LINES: Sequence[Color] = ((1.0, 0.38, 0.34, 1.0), (0.45, 0.85, 0.4, 1.0), (0.42, 0.62, 1.0, 1.0))
_DISC, _BEHIND = (0.15, 0.15, 0.16, 1.0), (0.05, 0.05, 0.05, 1.0)
_DASH = 5.0                 # pixels of a dash where nobody measured, at a scale of 1
_PLOT_RINGS = (1.0, 0.65, 0.35)  # of the radius, about
_APART = 0.14               # rings, at least
_DIGIT_PIXELS = 8           # pixels of a digit at a scale of 1, at most
_HALF_CIRCLE = np.linspace(-np.pi / 2, np.pi / 2, 91)


class Pen(Protocol):
    """Draws in pixels from the bottom left; points are (n, 2), ends (2 n, 2)."""

    def line(self, points: ArrayLike, color: Color, width: float) -> None:
        """Draw a polyline."""

    def strokes(self, ends: ArrayLike, color: Color, width: float) -> None:
        """Draw lines between pairs of points."""

    def fan(self, points: ArrayLike, color: Color) -> None:
        """Fill a convex outline."""

    def discs(self, centers: FloatArray, radius: float, color: Color) -> None:
        """Fill discs."""

    def text(self, string: str, at: Sequence[float], size: float, color: Color, align: float = 0.0) -> float:
        """Draw text on a base line: its width, of which the share `align` lies left of `at`."""


class Plotted(NamedTuple):
    """A fit, the space of its colours, and how far its measurements go, as far as that is known."""

    fit: Reflectance
    colours: str = DEFAULT_COLOURS
    reaches: Sequence[extrapolation.MeasuredDomain] = ()


class Curve(NamedTuple):
    """What is drawn of a fit: outgoing angles (n,), radians, negative on the light's side; values (n, k), 1/sr; a
    colour for each of k; where it is extrapolated, (n,) bool; and samples, (m,) and (m, k), or None."""

    theta: FloatArray
    values: FloatArray
    colors: Sequence[Color]
    is_extrapolated: BoolArray
    samples: tuple[FloatArray, FloatArray] | None = None


@dataclass(frozen=True, eq=False)
class Plane:
    """What is seen in a plane of incidence. Fits are evaluated once, when that is asked for."""

    fits: Sequence[Plotted]         # one, of which the channels are drawn, or two, of which the luminance; or none
    theta_i: float                  # of the light, radians; of isotropic materials the azimuth does not matter
    phi_i: float = 0.0
    # of the first fit, near the plane, as `samples_near_plane` has them
    samples: tuple[FloatArray, FloatArray] | None = None
    radius: Radius = "cube root"    # what radii are of values

    @cached_property
    def plane_curves(self) -> list[tuple[FloatArray, FloatArray]]:
        """Of each fit, as `plane_curve` returns it."""
        return [plane_curve(each.fit, self.theta_i, self.phi_i) for each in self.fits]

    @cached_property
    def curves(self) -> list[Curve]:
        """One of each fit."""
        made = []
        for number, (each, (theta, values)) in enumerate(zip(self.fits, self.plane_curves, strict=True)):
            colors = _RGB_LINES if values.shape[1] == len(_RGB_LINES) else _GREY_LINE
            if len(self.fits) > 1:
                colors = PAIR[number:number + 1]
            near = None if self.samples is None or number else (self.samples[0], self._select(each, self.samples[1]))
            is_extrapolated = extrapolation.is_extrapolated_in_any(np.full(len(theta), self.theta_i), np.abs(theta),
                                                                   each.reaches)
            made.append(Curve(theta, self._select(each, values), colors, is_extrapolated, near))
        return made

    def _select(self, plotted: Plotted, values: FloatArray) -> FloatArray:
        """What is drawn of values of a fit, (n, channels): of one all channels, of two the luminance, (n, 1)."""
        if len(self.fits) == 1:
            return values
        return np.maximum(luminance(np.broadcast_to(values, (len(values), 3)), plotted.colours), 0)[:, None]

    def read(self, theta: float) -> list[tuple[Color, float]]:
        """The values at an outgoing angle, 1/sr, in the colours that they are drawn in."""
        values = [self._select(each, evaluate_in_plane(each.fit, self.theta_i, self.phi_i, np.array([theta])))[0]
                  for each in self.fits]
        return [(color, float(value)) for curve, row in zip(self.curves, values, strict=True)
                for color, value in zip(curve.colors, row, strict=True)]

    @property
    def largest(self) -> float:
        """The largest value, 1/sr, above 0."""
        values = [each for curve in self.curves for each in (curve.values, *(curve.samples or ())[1:])]
        return max((float(each.max(initial=0)) for each in values), default=0.0) or 1e-9


@dataclass(frozen=True)
class Disc:
    """Half a disc: its center, (2,), and radius in pixels, and the scale of lines and text."""

    center: FloatArray
    radius: float
    scale: float = 1.0

    def points(self, theta: ArrayLike, length: ArrayLike) -> FloatArray:
        """Where angles and lengths, 1 on the outer circle, lie: (...) to (..., 2) pixels."""
        theta, length = np.broadcast_arrays(np.asarray(theta, dtype=float), np.asarray(length, dtype=float))
        return self.center + self.radius * length[..., None] * np.stack([np.sin(theta), np.cos(theta)], axis=-1)


def draw(pen: Pen, disc: Disc, plane: Plane) -> None:
    """Draw a plane of incidence; without fits, its grid."""
    _draw_grid(pen, disc)
    if not plane.fits:
        return
    _draw_rings(pen, disc, plane)
    theta, scale = plane.theta_i, disc.scale
    color = LIGHT if len(plane.curves) == 1 else INK            # LIGHT is much like the first of two
    pen.line(disc.points([-theta, -theta], [0.0, 1.0]), color, 2 * scale)
    pen.discs(disc.points([-theta], [1.0]), 7 * scale, color)
    pen.line(disc.points([theta, theta], [0.0, 1.0]), (*color[:3], 0.45), 1.2 * scale)
    for curve in plane.curves:
        _draw_curve(pen, disc, curve, plane)


def _draw_grid(pen: Pen, disc: Disc) -> None:
    scale = disc.scale
    pen.fan(disc.points(_HALF_CIRCLE, 1.0), _DISC)
    for degrees in range(-90, 91, 15):
        angle = math.radians(degrees)
        is_main = degrees % 30 == 0
        pen.line(disc.points([angle, angle], [0.0 if is_main else 0.96, 1.0]), FAINT, scale)
        if is_main:
            x, y = disc.points(angle, 1.0) + 10 * scale * np.array([math.sin(angle), math.cos(angle)])
            pen.text(f"{abs(degrees)}\u00b0", (x, y - 4 * scale), SMALL * scale, DIM, (1 - math.sin(angle)) / 2)
    pen.line(disc.points(_HALF_CIRCLE, 1.0), FAINT, 1.2 * scale)


def _draw_rings(pen: Pen, disc: Disc, plane: Plane) -> None:
    """Circles with their values, as far as these have room beside one another."""
    unit, below = "1/sr", np.array([0.0, -14 * disc.scale])
    pen.text(unit, disc.center + below, SMALL * disc.scale, DIM, 0.5)
    written = [(0.0, len(unit))]                # length and characters
    for value, length in rings(plane.largest, plane.radius):
        pen.line(disc.points(_HALF_CIRCLE, length), FAINT, disc.scale)
        label = shown_value(value)
        if all(abs(length - other) * disc.radius > (len(label) + count) / 2 * _DIGIT_PIXELS * disc.scale
               for other, count in written):
            written.append((length, len(label)))
            for side in (-np.pi / 2, np.pi / 2):
                pen.text(label, disc.points(side, length) + below, SMALL * disc.scale, DIM, 0.5)


def _draw_curve(pen: Pen, disc: Disc, curve: Curve, plane: Plane) -> None:
    """A line for each channel, dashed where nobody measured, and the samples on it."""
    scale, largest, radius = disc.scale, plane.largest, plane.radius
    parts = np.split(np.arange(len(curve.theta)), np.flatnonzero(np.diff(curve.is_extrapolated)) + 1)
    for channel, color in enumerate(curve.colors):
        points = disc.points(curve.theta, lengths(curve.values[:, channel], largest, radius))
        for part in parts:
            piece = points[part[0]:part[-1] + 2]
            if curve.is_extrapolated[part[0]]:
                pen.strokes(dashes(piece, _DASH * scale), color, 2.2 * scale)
            else:
                pen.line(piece, color, 2.2 * scale)
    if curve.samples is not None:
        theta, values = curve.samples
        for channel, color in enumerate(curve.colors):
            centers = disc.points(theta, lengths(values[:, channel], largest, radius))
            pen.discs(centers, 3.6 * scale, _BEHIND)
            pen.discs(centers, 2.6 * scale, color)


def polar_plot(fits: Sequence[Plotted], samples: Samples | None, theta_i: float, size: int = SIZE,
               phi_i: float = 0.0) -> tuple[SingleArray, float]:
    """One fit or two in the plane of incidence, with the samples of the first near it: (size, size, 4) float32; and the
    angle of incidence of these, radians: the measured one nearest to theta_i; nan without any."""
    near = None if samples is None else samples_near_plane(samples, theta_i, phi_i)
    canvas = Canvas(np.full((size, size, 4), BACKGROUND, dtype=np.float32))
    draw(canvas, picture_disc(size), Plane(fits, theta_i, phi_i, near and near[:2]))
    return canvas.picture, float("nan") if near is None else near[2]


def picture_disc(size: int) -> Disc:
    """Where the plane of incidence is in a picture of a size."""
    return Disc(np.array([0.5, 0.31]) * size, 0.385 * size, size / SIZE)


def turned_plane(fit: Reflectance, theta_i: float, size: int = SIZE, colours: str = DEFAULT_COLOURS) -> SingleArray:
    """The fit in the plane of incidence, for one angle of incidence, radians, while that plane turns about the normal:
    (size, size, 4) float32. The colours are one of `colours.COLOURS`.

    From left to right the light's azimuth goes through a full turn; from bottom to top the outgoing angle goes from
    grazing on the light's side, through the normal, to grazing opposite the light. Cube roots of f cos theta_o are
    shown, the largest of them as 1. Of an isotropic material all columns are equal.
    """
    step = (np.arange(size) + 0.5) / size
    phi, theta = np.meshgrid(2 * np.pi * step, np.pi * (step - 0.5))
    value = fit.evaluate(np.full(phi.size, theta_i), phi.ravel(), np.abs(theta).ravel(),
                         (phi + np.where(theta < 0, 0, np.pi)).ravel()) * np.cos(theta).reshape(-1, 1)
    linear = np.broadcast_to(np.maximum(value, 0), (phi.size, 3)) @ conversion(colours, DEFAULT_COLOURS).T
    shown = np.cbrt(np.maximum(linear, 0))
    picture = np.ones((size, size, 4), dtype=np.float32)
    picture[..., :3] = (shown / max(shown.max(), 1e-6)).reshape(size, size, 3)
    return picture


def lengths(values: FloatArray, largest: float, radius: Radius) -> FloatArray:
    """How far from the center values lie, 1/sr: 1 where they are the largest."""
    return np.asarray(RADII[radius](np.maximum(values, 0) / largest))


def dashes(points: FloatArray, length: float) -> FloatArray:
    """The ends of the dashes of a polyline, which have gaps of their length between them: (n, 2) to (2 m, 2)."""
    along = np.concatenate([[0.0], np.cumsum(np.linalg.norm(np.diff(points, axis=0), axis=1))])
    at = np.arange(0.0, along[-1] + length, length)
    at = at[:len(at) // 2 * 2]
    return np.stack([np.interp(at, along, axis) for axis in points.T], axis=-1)


def rings(largest: float, radius: Radius) -> list[tuple[float, float]]:
    """Values of one digit, 1/sr, and the radii of their circles in a plot, whose outer one is `largest`."""
    circles: list[tuple[float, float]] = []
    for ring in _PLOT_RINGS:
        value = _round_down_to_digit(largest * (ring ** 3 if radius == "cube root" else ring))
        length = float(lengths(np.array(value), largest, radius))
        if not circles or length < circles[-1][1] - _APART:
            circles.append((value, length))
    return circles


def shown_value(value: float) -> str:
    """A value for people, 1/sr: three digits."""
    return f"{value:.1e}" if 0 < abs(value) < 1e-6 else np.format_float_positional(value, 3, fractional=False, trim="-")


def _round_down_to_digit(value: float) -> float:
    """The largest number of one digit that is not above a value."""
    power = 10.0 ** math.floor(math.log10(value))
    return power * max(math.floor(value / power + 1e-9), 1)


def samples_near_plane(samples: Samples, theta_i: float, phi_i: float = 0.0) -> tuple[FloatArray, FloatArray, float]:
    """Samples near the plane of incidence, at the measured angle of incidence nearest to theta_i; of an anisotropic
    material those whose light is near the azimuth phi_i. Their outgoing angles, (k,), radians, negative on the light's
    side; their values, (k, channels); and their angle of incidence, nan without any."""
    azimuth = np.abs((samples.phi_o - samples.phi_i + np.pi) % (2 * np.pi) - np.pi)
    # the direction's angle to the plane, not its azimuth, which near the normal says little
    in_plane = np.sin(samples.theta_o) * np.sin(azimuth) < np.sin(IN_PLANE)
    if not samples.isotropic:
        turned = np.abs((samples.phi_i - phi_i + np.pi) % (2 * np.pi) - np.pi)
        in_plane &= np.sin(samples.theta_i) * np.sin(np.minimum(turned, np.pi / 2)) < np.sin(IN_PLANE)
    off = np.where(in_plane, np.abs(samples.theta_i - theta_i), np.inf)
    if not np.isfinite(off).any():
        return np.zeros(0), np.zeros((0, samples.values.shape[1])), float("nan")
    near = off < off.min() + np.radians(2)
    sign = np.where(azimuth[near] < np.pi / 2, -1, 1)
    return sign * samples.theta_o[near], samples.values[near], float(samples.theta_i[near].mean())

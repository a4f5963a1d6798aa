"""Draws an inspection: the lobe in the scene, and the plot over it."""

import math
from collections.abc import Sequence

import gpu
import numpy as np
from mathutils import Matrix

from ...fitter.arrays import BoolArray, FloatArray
from ...fitter.colours import DEFAULT, conversion
from ...fitter.pictures import srgb
from ..core.annotations import not_none
from . import drawing
from .drawing import Color
from .inspection import HANDLE, Inspection, direction
from .plot import Plot, dashes, lengths, rings, shown_value
from .view import View

_INK, _DIM, _FAINT = (0.92, 0.92, 0.92, 1.0), (0.62, 0.62, 0.62, 1.0), (0.75, 0.75, 0.75, 0.35)
_LIGHT, _TANGENT = (1.0, 0.75, 0.2, 1.0), (0.95, 0.35, 0.75, 1.0)
_BOX, _DISC = (0.09, 0.09, 0.1, 0.93), (0.15, 0.15, 0.16, 1.0)
_GREY: Sequence[Color] = ((0.9, 0.9, 0.9, 1.0),)
_RGB: Sequence[Color] = ((1.0, 0.38, 0.34, 1.0), (0.45, 0.85, 0.4, 1.0), (0.42, 0.62, 1.0, 1.0))
_KEY = np.array([-0.42, 0.58, 0.7])         # direction of the light on the lobe: right, up, toward the viewer
_TEXT, _SMALL = 13.0, 11.0                  # pixels at a scale of 1
_LONGEST = 44               # name, characters
_HIDDEN = 0.3               # opacity of lines behind something
_GUESSED, _DASH = 0.4, 5.0  # brightness of the lobe where nobody measured; pixels of a dash there, at a scale of 1


def draw_lobe(inspection: Inspection, frame: FloatArray, axes: FloatArray, scale: float) -> None:
    """Draw the lobe, the light and the normal into the scene.

    The frame is that of the surface in the world, (4, 4); axes are right, up and toward the viewer, (3, 3); `scale` is
    that of the interface.
    """
    matrix = frame.copy()
    matrix[:3, :3] *= inspection.size
    try:
        with gpu.matrix.push_pop():
            gpu.matrix.multiply_matrix(Matrix(matrix.tolist()))
            local = axes @ frame[:3, :3]
            gpu.state.depth_test_set("LESS_EQUAL")
            gpu.state.depth_mask_set(True)
            _draw_surface(inspection, local)
            _draw_handle(inspection, local)
            gpu.state.depth_mask_set(False)
            _draw_lines(inspection, scale, 1.0)
            gpu.state.depth_test_set("GREATER")
            _draw_lines(inspection, scale, _HIDDEN)
    finally:
        gpu.state.depth_mask_set(False)
        gpu.state.depth_test_set("NONE")
        gpu.state.blend_set("NONE")


def _draw_surface(inspection: Inspection, axes: FloatArray) -> None:
    lobe, shown = inspection.lobe, inspection.shown
    if lobe is None or shown is None:
        return
    theta = np.arccos(np.clip(lobe.directions[:, 2], 0, 1))
    shades = shading(lobe.normals, axes) * np.where(inspection.guessed(theta), _GUESSED, 1)
    colors = lobe_colors(np.maximum(lobe.values, 0), shown.space) * shades[:, None]
    drawing.surface(lobe.vertices / inspection.longest, lobe.faces, srgb(colors))


def _draw_handle(inspection: Inspection, axes: FloatArray) -> None:
    """A ball at the end of the ray."""
    at, radius = HANDLE * inspection.light(), 0.055
    around, up = np.meshgrid(np.linspace(0, 2 * np.pi, 17), np.linspace(0, np.pi, 9))
    ball = direction(up, around).reshape(-1, 3)
    corner = (np.arange(8)[:, None] * 17 + np.arange(16)).ravel()
    faces = np.concatenate([np.stack([corner, corner + 17, corner + 1], axis=-1),
                            np.stack([corner + 1, corner + 17, corner + 18], axis=-1)])
    shades = shading(ball, axes)[:, None] * np.array(_LIGHT[:3])
    drawing.surface(at + radius * ball, faces.astype(np.int32), srgb(1.3 * shades))


def _draw_lines(inspection: Inspection, scale: float, opacity: float) -> None:
    def faded(color: Color) -> Color:
        return (*color[:3], color[3] * opacity)

    light, phi = inspection.light(), inspection.phi_i
    turn = np.linspace(0, 2 * np.pi, 97)
    drawing.line(HANDLE * direction(np.full(97, np.pi / 2), turn), faded(_FAINT), 1.2, scale)
    arc = np.linspace(-np.pi / 2, np.pi / 2, 61)
    drawing.line(HANDLE * direction(arc, phi), faded(_FAINT), 1.2, scale)
    ticks = np.radians(np.arange(-75, 76, 15))
    ends = np.stack([0.97 * HANDLE * direction(ticks, phi), 1.03 * HANDLE * direction(ticks, phi)], axis=1)
    drawing.strokes(ends.reshape(-1, 3), faded(_FAINT), 1.2, scale)
    drawing.line([(0, 0, 0), (0, 0, HANDLE)], faded(_INK), 1.6, scale)
    drawing.line(_arrow(np.array([0, 0, 1.0]), HANDLE, outward=True), faded(_INK), 1.6, scale)
    drawing.line([0 * light, HANDLE * light], faded(_LIGHT), 2.4, scale)
    drawing.line(_arrow(light, 0.62 * HANDLE, outward=False), faded(_LIGHT), 2.4, scale)
    if inspection.shown is not None and not inspection.shown.isotropic:
        drawing.line([(-HANDLE, 0, 0), (HANDLE, 0, 0)], faded(_TANGENT), 2.4, scale)
        drawing.line(_arrow(np.array([1.0, 0, 0]), HANDLE, outward=True), faded(_TANGENT), 2.4, scale)
    if inspection.curve is not None:
        drawing.line(1.004 * inspection.ridge(), faded((0.05, 0.05, 0.05, 0.8)), 1.6, scale)


def _arrow(axis: FloatArray, at: float, outward: bool) -> FloatArray:
    """The head of an arrow on an axis, as a polyline."""
    across = np.cross(axis, (0.0, 1.0, 0.0) if abs(axis[1]) < 0.9 else (1.0, 0.0, 0.0))
    across *= 0.04 / np.linalg.norm(across)
    back = (-0.1 if outward else 0.1) * axis
    return np.stack([at * axis + back + across, at * axis, at * axis + back - across])


def lobe_colors(values: FloatArray, space: str) -> FloatArray:
    """The colours of values that are not negative, (n, channels) 1/sr: (n, 3), linear Rec.709.

    They have the hue and saturation of the values. The brightness falls to half where the values do to 0.
    """
    full = np.broadcast_to(values, (len(values), 3)) @ conversion(space, DEFAULT).T
    full = np.maximum(full, 0)
    brightest = np.maximum(full.max(axis=1, keepdims=True), 1e-12)
    hue = np.where(full.max(axis=1, keepdims=True) > 1e-12, full / brightest, 1.0)
    return np.asarray(hue * (0.5 + 0.5 * np.cbrt(brightest / brightest.max())))


def shading(normals: FloatArray, axes: FloatArray) -> FloatArray:
    """How bright a matt surface with a slight sheen is: (n, 3) to (n,)."""
    key = _KEY / np.linalg.norm(_KEY)
    half = key + (0, 0, 1)
    seen = normals @ axes.T
    facing: BoolArray = seen[:, 2] > 0
    lit = np.maximum(seen @ key, 0)
    gloss = np.maximum(seen @ (half / np.linalg.norm(half)), 0) ** 40
    return np.where(facing, 0.14 + 0.66 * lit + 0.1 * gloss, 0.12 + 0.1 * np.maximum(-(seen @ key), 0))


def draw_labels(inspection: Inspection, frame: FloatArray, view: View, scale: float) -> None:
    """Write angles beside the light and the normal."""
    labels = [(HANDLE * inspection.light(), f"{math.degrees(inspection.theta_i):.1f}\u00b0", _LIGHT),
              (np.array([0, 0, HANDLE]), "Normal", _INK)]
    if inspection.shown is not None and not inspection.shown.isotropic:
        labels.append((np.array([HANDLE, 0, 0]), f"Tangent, {inspection.spot.origin}", _TANGENT))
    for place, string, color in labels:
        at = view.project(frame[:3, 3] + frame[:3, :3] @ (inspection.size * place))
        if np.isfinite(at).all():
            below = 20 if color == _TANGENT else 4      # the light is often beside the tangent
            shadowed(string, (at[0] + 12 * scale, at[1] - below * scale), _TEXT * scale, color)


def shadowed(string: str, at: tuple[float, float], size: float, color: Color) -> None:
    """Text that can be read over anything."""
    for x, y in ((1, -1), (-1, -1), (1, 1), (-1, 1)):
        drawing.text(string, (at[0] + x, at[1] + y), size, (0.0, 0.0, 0.0, 0.6))
    drawing.text(string, at, size, color)


def draw_plot(inspection: Inspection, plot: Plot, waiting: str) -> None:
    """Draw the plane of incidence, or say what is waited for where there is no fit yet."""
    scale = plot.scale
    try:
        drawing.fan(plot.corners, _BOX)
        _draw_grid(plot)
        if inspection.shown is None:
            drawing.text(waiting, plot.line(0), _TEXT * scale, _INK)
            return
        _draw_scale(inspection, plot)
        _draw_light(inspection, plot)
        _draw_curves(inspection, plot)
        _draw_titles(inspection, plot)
        _draw_values(inspection, plot)
    finally:
        gpu.state.blend_set("NONE")


def _draw_grid(plot: Plot) -> None:
    scale, half = plot.scale, np.linspace(-np.pi / 2, np.pi / 2, 91)
    drawing.fan(plot.points(half, 1.0), _DISC)
    for degrees in range(-90, 91, 15):
        angle = math.radians(degrees)
        main = degrees % 30 == 0
        start = 0.0 if main else 0.96
        drawing.line(plot.points([angle, angle], [start, 1.0]), _FAINT, 1.0, scale)
        if main:
            x, y = plot.points(angle, 1.0) + 10 * scale * np.array([math.sin(angle), math.cos(angle)])
            drawing.text(f"{abs(degrees)}\u00b0", (x, y - 4 * scale), _SMALL * scale, _DIM, (1 - math.sin(angle)) / 2)
    drawing.line(plot.points(half, 1.0), _FAINT, 1.2, scale)


def _draw_scale(inspection: Inspection, plot: Plot) -> None:
    half = np.linspace(-np.pi / 2, np.pi / 2, 91)
    for value, length in rings(inspection.largest, inspection.radius):
        drawing.line(plot.points(half, length), _FAINT, 1.0, plot.scale)
        for side in (-1, 1):
            x, y = plot.points(side * np.pi / 2, length)
            drawing.text(shown_value(value), (x, y - 14 * plot.scale), _SMALL * plot.scale, _DIM, 0.5)
    drawing.text("1/sr", (plot.center[0], plot.center[1] - 14 * plot.scale), _SMALL * plot.scale, _DIM, 0.5)


def _draw_light(inspection: Inspection, plot: Plot) -> None:
    theta = -inspection.theta_i
    drawing.line(plot.points([theta, theta], [0.0, 1.0]), _LIGHT, 2.0, plot.scale)
    drawing.discs(plot.points([theta], [1.0]), 7 * plot.scale, _LIGHT, 24)
    drawing.line(plot.points([-theta, -theta], [0.0, 1.0]), (*_LIGHT[:3], 0.45), 1.2, plot.scale)


def _draw_curves(inspection: Inspection, plot: Plot) -> None:
    scale, largest, radius = plot.scale, inspection.largest, inspection.radius
    theta, values = not_none(inspection.curve)
    guessed = inspection.guessed(theta)
    parts = np.split(np.arange(len(theta)), np.flatnonzero(np.diff(guessed)) + 1)
    for channel, color in enumerate(colors_of(values)):
        curve = plot.points(theta, lengths(values[:, channel], largest, radius))
        for part in parts:
            piece = curve[part[0]:part[-1] + 2]
            if guessed[part[0]]:
                drawing.strokes(dashes(piece, _DASH * scale), color, 2.2, scale)
            else:
                drawing.line(piece, color, 2.2, scale)
    if inspection.samples is not None:
        theta, values = inspection.samples[:2]
        for channel, color in enumerate(colors_of(values)):
            centers = plot.points(theta, lengths(values[:, channel], largest, radius))
            drawing.discs(centers, 3.6 * scale, (0.05, 0.05, 0.05, 1.0))
            drawing.discs(centers, 2.6 * scale, color)


def _draw_titles(inspection: Inspection, plot: Plot) -> None:
    scale, shown = plot.scale, not_none(inspection.shown)
    name = shown.name if len(shown.name) <= _LONGEST else f"{shown.name[:_LONGEST - 1]}\u2026"
    drawing.text(name, plot.line(0), _TEXT * scale, _INK)
    parts = [f"Light {math.degrees(inspection.theta_i):.1f}\u00b0", f"radius: {inspection.radius}"]
    if not shown.isotropic:
        parts[0] += f", azimuth {math.degrees(inspection.phi_i) % 360:.0f}\u00b0"
    if inspection.samples is not None and len(inspection.samples.theta_o):
        parts.append(f"dots: {inspection.samples.source} at {math.degrees(inspection.samples.theta_i):.1f}\u00b0")
    if shown.note:
        parts.append(shown.note)
    if inspection.guessed(not_none(inspection.curve)[0]).any():
        parts.append("dashed: a guess")
    drawing.text("   ".join(parts), plot.line(1), _SMALL * scale, _DIM)


def _draw_values(inspection: Inspection, plot: Plot) -> None:
    """The values at the angle under the mouse, or in the mirror direction."""
    scale, mouse = plot.scale, inspection.mouse
    theta, label = inspection.theta_i, "Mirror "
    if mouse is not None and plot.is_read(mouse) and not inspection.drag:
        theta, label = plot.angle(mouse), ""
        drawing.line(plot.points([theta, theta], [0.0, 1.0]), _INK, 1.0, scale)
    values = inspection.read(theta)
    x, y = plot.line(-1)
    label += f"{abs(math.degrees(theta)):.1f}\u00b0" + (" light's side" if theta < 0 else "")
    drawing.text(label, (x, y), _TEXT * scale, _INK)
    for channel, (color, value) in enumerate(zip(colors_of(values[None]), values, strict=True)):
        place = plot.points([theta], lengths(np.array([value]), inspection.largest, inspection.radius))
        drawing.discs(place, 4 * scale, color, 16)
        name = "RGB"[channel] + " " if len(values) > 1 else ""
        drawing.text(name + shown_value(float(value)), (x + (0.34 + 0.19 * channel) * plot.width, y), _TEXT * scale,
                     color)
    drawing.text("1/sr", (2 * plot.center[0] - x, y), _TEXT * scale, _DIM, 1.0)


def colors_of(values: FloatArray) -> Sequence[Color]:
    """A colour for each channel: (k, channels)."""
    return _RGB if values.shape[1] == len(_RGB) else _GREY

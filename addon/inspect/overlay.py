"""Draws an inspection: the lobe in the scene, and the plot over it."""

import math

import gpu
import numpy as np
from mathutils import Matrix

from ...fitter.arrays import BoolArray, FloatArray, unit_vectors
from ...fitter.colours import DEFAULT_COLOURS, conversion
from ...fitter.imaging import plane_plot
from ...fitter.imaging.drawing import Color
from ...fitter.imaging.pictures import srgb
from ...fitter.imaging.plane_plot import DIM, FAINT, INK, LIGHT, PAIR, SMALL, TEXT, Plane, lengths, shown_value
from ...fitter.model import is_isotropic
from ..core.annotations import not_none
from . import drawing
from .inspection import HANDLE, Inspection
from .plot import Plot
from .view import View

_TANGENT, _BOX = (0.95, 0.35, 0.75, 1.0), (0.09, 0.09, 0.1, 0.93)
_KEY = np.array([-0.42, 0.58, 0.7])         # direction of the light on the lobe: right, up, toward the viewer
_LONGEST = 44               # name, characters
_HIDDEN = 0.3               # opacity of lines behind something
_GUESSED = 0.4              # brightness of the lobe where nobody measured


def draw_lobe(inspection: Inspection, frame: FloatArray, axes: FloatArray, scale: float) -> None:
    """Draw the lobe, the light and the normal into the scene: `frame` is that of the surface, (4, 4); `axes` are right,
    up and toward the viewer, (3, 3); `scale` is that of the interface."""
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
    shades = shading(lobe.normals, axes) * np.where(inspection.is_extrapolated(theta), _GUESSED, 1)
    colors = lobe_colors(np.maximum(lobe.values, 0), shown.space) * shades[:, None]
    drawing.surface(lobe.vertices / inspection.longest, lobe.faces, srgb(colors))


def _draw_handle(inspection: Inspection, axes: FloatArray) -> None:
    """A ball at the end of the ray."""
    at, radius = HANDLE * inspection.light(), 0.055
    around, up = np.meshgrid(np.linspace(0, 2 * np.pi, 17), np.linspace(0, np.pi, 9))
    ball = unit_vectors(up, around).reshape(-1, 3)
    corner = (np.arange(8)[:, None] * 17 + np.arange(16)).ravel()
    faces = np.concatenate([np.stack([corner, corner + 17, corner + 1], axis=-1),
                            np.stack([corner + 1, corner + 17, corner + 18], axis=-1)])
    shades = shading(ball, axes)[:, None] * np.array(LIGHT[:3])
    drawing.surface(at + radius * ball, faces.astype(np.int32), srgb(1.3 * shades))


def _draw_lines(inspection: Inspection, scale: float, opacity: float) -> None:
    def fade(color: Color) -> Color:
        return (*color[:3], color[3] * opacity)

    light, phi = inspection.light(), inspection.phi_i
    turn = np.linspace(0, 2 * np.pi, 97)
    drawing.line(HANDLE * unit_vectors(np.full(97, np.pi / 2), turn), fade(FAINT), 1.2 * scale)
    arc = np.linspace(-np.pi / 2, np.pi / 2, 61)
    drawing.line(HANDLE * unit_vectors(arc, phi), fade(FAINT), 1.2 * scale)
    ticks = np.radians(np.arange(-75, 76, 15))
    ends = np.stack([0.97 * HANDLE * unit_vectors(ticks, phi), 1.03 * HANDLE * unit_vectors(ticks, phi)], axis=1)
    drawing.strokes(ends.reshape(-1, 3), fade(FAINT), 1.2 * scale)
    drawing.line([(0, 0, 0), (0, 0, HANDLE)], fade(INK), 1.6 * scale)
    drawing.line(_arrow(np.array([0, 0, 1.0]), HANDLE, outward=True), fade(INK), 1.6 * scale)
    drawing.line([0 * light, HANDLE * light], fade(LIGHT), 2.4 * scale)
    drawing.line(_arrow(light, 0.62 * HANDLE, outward=False), fade(LIGHT), 2.4 * scale)
    if inspection.shown is not None and not is_isotropic(inspection.shown.fit):
        drawing.line([(-HANDLE, 0, 0), (HANDLE, 0, 0)], fade(_TANGENT), 2.4 * scale)
        drawing.line(_arrow(np.array([1.0, 0, 0]), HANDLE, outward=True), fade(_TANGENT), 2.4 * scale)
    if inspection.curve is not None:
        drawing.line(1.004 * inspection.ridge(), fade((0.05, 0.05, 0.05, 0.8)), 1.6 * scale)


def _arrow(axis: FloatArray, at: float, outward: bool) -> FloatArray:
    """The head of an arrow on an axis, as a polyline."""
    across = np.cross(axis, (0.0, 1.0, 0.0) if abs(axis[1]) < 0.9 else (1.0, 0.0, 0.0))
    across *= 0.04 / np.linalg.norm(across)
    back = (-0.1 if outward else 0.1) * axis
    return np.stack([at * axis + back + across, at * axis, at * axis + back - across])


def lobe_colors(values: FloatArray, space: str) -> FloatArray:
    """Colours of the hue and saturation of values, (n, channels) 1/sr, not negative: (n, 3), linear Rec.709. Their
    brightness falls to half where the values do to 0."""
    full = np.broadcast_to(values, (len(values), 3)) @ conversion(space, DEFAULT_COLOURS).T
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
    labels = [(HANDLE * inspection.light(), f"{math.degrees(inspection.theta_i):.1f}\u00b0", LIGHT),
              (np.array([0, 0, HANDLE]), "Normal", INK)]
    if inspection.shown is not None and not is_isotropic(inspection.shown.fit):
        labels.append((np.array([HANDLE, 0, 0]), f"Tangent, {inspection.spot.origin}", _TANGENT))
    for place, string, color in labels:
        at = view.project(frame[:3, 3] + frame[:3, :3] @ (inspection.size * place))
        if np.isfinite(at).all():
            below = 20 if color == _TANGENT else 4      # the light is often beside the tangent
            draw_shadowed(string, (at[0] + 12 * scale, at[1] - below * scale), TEXT * scale, color)


def draw_shadowed(string: str, at: tuple[float, float], size: float, color: Color) -> None:
    """Text that can be read over anything."""
    for x, y in ((1, -1), (-1, -1), (1, 1), (-1, 1)):
        drawing.text(string, (at[0] + x, at[1] + y), size, (0.0, 0.0, 0.0, 0.6))
    drawing.text(string, at, size, color)


def draw_plot(inspection: Inspection, plot: Plot, waiting: str) -> None:
    """Draw the plane of incidence, or say what is waited for where there is no fit yet."""
    scale = plot.scale
    try:
        drawing.fan(plot.corners, _BOX)
        plane = inspection.plane
        plane_plot.draw(drawing, plot.disc, plane)
        if inspection.shown is None:
            drawing.text(waiting, plot.line(0), TEXT * scale, INK)
            return
        _draw_titles(inspection, plot, plane)
        _draw_values(inspection, plot, plane)
    finally:
        gpu.state.blend_set("NONE")


def _draw_titles(inspection: Inspection, plot: Plot, plane: Plane) -> None:
    scale, shown = plot.scale, not_none(inspection.shown)
    names: list[tuple[str, Color]] = [(shown.name, INK)]
    if inspection.second is not None:
        names = [(f"{letter}: {each.name}", color) for letter, each, color in
                 zip("AB", (shown, inspection.second), PAIR, strict=True)]
    x, y = plot.line(0)
    for string, color in names:
        longest = _LONGEST // len(names)
        string = string if len(string) <= longest else f"{string[:longest - 1]}\u2026"
        x += drawing.text(string, (x, y), TEXT * scale, color) + TEXT * scale
    parts = [f"Light {math.degrees(inspection.theta_i):.1f}\u00b0", f"radius: {inspection.radius}"]
    if not is_isotropic(shown.fit):
        parts[0] += f", azimuth {math.degrees(inspection.phi_i) % 360:.0f}\u00b0"
    if inspection.samples is not None and len(inspection.samples.theta_o):
        parts.append(f"dots: {inspection.samples.source} at {math.degrees(inspection.samples.theta_i):.1f}\u00b0")
    if shown.note:
        parts.append(shown.note)
    if any(curve.is_extrapolated.any() for curve in plane.curves):
        parts.append("dashed: a guess")
    x, y = plot.line(1)
    drawing.text("   ".join(parts), (x, y), SMALL * scale, DIM, room=2 * (plot.center[0] - x))


def _draw_values(inspection: Inspection, plot: Plot, plane: Plane) -> None:
    """The values at the angle under the mouse, or in the mirror direction."""
    scale, mouse = plot.scale, inspection.mouse
    theta, label = inspection.theta_i, "Mirror "
    if mouse is not None and plot.is_read(mouse) and not inspection.drag:
        theta, label = plot.angle(mouse), ""
        drawing.line(plot.disc.points([theta, theta], [0.0, 1.0]), INK, 1.0 * scale)
    values = plane.read(theta)
    x, y = plot.line(-1)
    label += f"{abs(math.degrees(theta)):.1f}\u00b0" + (" light's side" if theta < 0 else "")
    drawing.text(label, (x, y), TEXT * scale, INK)
    names = ("",) if len(values) == 1 else "RGB" if inspection.second is None else "AB"
    for number, (name, (color, value)) in enumerate(zip(names, values, strict=True)):
        place = plot.disc.points([theta], lengths(np.array([value]), plane.largest, inspection.radius))
        drawing.discs(place, 4 * scale, color)
        drawing.text(f"{name} {shown_value(value)}".strip(), (x + (0.34 + 0.19 * number) * plot.width, y),
                     TEXT * scale, color)
    drawing.text("1/sr", (2 * plot.center[0] - x, y), TEXT * scale, DIM, 1.0)

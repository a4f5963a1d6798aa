"""Lines, triangles and text in a region, by Blender's `gpu` and `blf`: a pen of `fitter.imaging.plane_plot`.

They work where there is a window only."""

import math
from collections.abc import Sequence
from typing import Any

import blf
import gpu
import numpy as np
from gpu_extras.batch import batch_for_shader

from ...fitter.arrays import ArrayLike, FloatArray, IntArray, SingleArray
from ...fitter.imaging.drawing import Color
from ..core.annotations import not_none

_FONT = 0
_LARGE = 6.0                # pixels of the radius of a disc that has more corners


def line(points: ArrayLike, color: Color, width: float) -> None:
    """Draw a polyline: (n, 2) or (n, 3)."""
    _lines("LINE_STRIP", points, color, width)


def strokes(ends: ArrayLike, color: Color, width: float) -> None:
    """Draw lines between pairs of points: (2 n, 2) or (2 n, 3)."""
    _lines("LINES", ends, color, width)


def surface(vertices: FloatArray, faces: IntArray, colors: FloatArray) -> None:
    """Draw triangles: (n, 3), (m, 3) and (n, 3), a colour for each vertex."""
    shader = gpu.shader.from_builtin("SMOOTH_COLOR")
    full = np.ones((len(vertices), 4), dtype=np.float32)
    full[:, :3] = colors
    _draw(shader, "TRIS", {"pos": _to_3d(vertices), "color": full}, faces)


def fan(points: ArrayLike, color: Color) -> None:
    """Fill a convex outline: (n, 2)."""
    _fill(np.asarray(points)[None], color)


def discs(centers: FloatArray, radius: float, color: Color) -> None:
    """Fill discs: (n, 2) pixels."""
    azimuth = np.linspace(0, 2 * np.pi, 12 if radius < _LARGE else 24, endpoint=False)
    _fill(centers[:, None] + radius * np.stack([np.cos(azimuth), np.sin(azimuth)], axis=-1), color)


def _fill(outlines: FloatArray, color: Color) -> None:
    """Fill convex outlines of as many corners each: (n, corners, 2)."""
    count, corners = outlines.shape[:2]
    if not count:
        return
    fan_of_one = np.stack([np.zeros(corners - 2), np.arange(1, corners - 1), np.arange(2, corners)], axis=-1)
    faces = fan_of_one + corners * np.arange(count)[:, None, None]
    shader = gpu.shader.from_builtin("UNIFORM_COLOR")
    shader.uniform_float("color", color)
    _draw(shader, "TRIS", {"pos": _to_3d(outlines.reshape(-1, 2))}, faces.reshape(-1, 3).astype(np.int32))


def text(string: str, at: Sequence[float], size: float, color: Color, align: float = 0.0,
         room: float = math.inf) -> float:
    """Draw text: its width. `at` is the left end of the base line, (2,), and the size in pixels; `align` is how much of
    the width lies left of it. Where the text is wider than `room`, it is drawn smaller.
    """
    blf.size(_FONT, size)
    width = float(blf.dimensions(_FONT, string)[0])
    while width > room and size > 1:        # again, since hinted letters are not as wide as their size says
        size *= min(room / width, 0.98)
        blf.size(_FONT, size)
        width = float(blf.dimensions(_FONT, string)[0])
    blf.color(_FONT, *color)
    blf.position(_FONT, round(at[0] - align * width), round(at[1]), 0)
    blf.draw(_FONT, string)
    return width


def _lines(kind: str, points: ArrayLike, color: Color, width: float) -> None:
    vertices = _to_3d(points)
    if len(vertices) < 2:
        return
    shader = gpu.shader.from_builtin("POLYLINE_UNIFORM_COLOR")
    shader.uniform_float("viewportSize", not_none(gpu.state.viewport_get())[2:])
    shader.uniform_float("lineWidth", width)
    shader.uniform_float("color", color)
    _draw(shader, kind, {"pos": vertices})


def _draw(shader: gpu.types.GPUShader, kind: Any, content: dict[str, Any], faces: IntArray | None = None) -> None:
    gpu.state.blend_set("ALPHA")            # drawing of text leaves it off
    batch_for_shader(shader, kind, content, indices=faces).draw(shader)


def _to_3d(points: ArrayLike) -> SingleArray:
    """Points with three coordinates, in single precision, as shaders take them."""
    given = np.asarray(points, dtype=np.float32)
    full = np.zeros((len(given), 3), dtype=np.float32)
    full[:, :given.shape[1]] = given
    return full

"""Pictures of fits for the panels: (size, size, 4) float32, sRGB with alpha, the bottom row first."""

import numpy as np

from ..arrays import ArrayLike, BoolArray, FloatArray, SingleArray
from ..colours import DEFAULT_COLOURS, conversion
from ..model import Reflectance, is_isotropic
from ..model.published import PublishedMaterial
from . import studio
from .drawing import INK, LIGHT, Canvas

SIZE = 256
_BRIGHTEST = 0.59           # mean of a thumbnail within its outline
_HEM = 0.93                 # half the side of a cloth, over that of its picture


def lit_sphere(fit: Reflectance, size: int = SIZE, colours: str = DEFAULT_COLOURS,
               with_tangent: bool = False) -> SingleArray:
    """A sphere of the material in a studio (`studio`), in orthographic view on a transparent background: (size, size,
    4) float32. The colours of the fit are one of `colours.COLOURS`. The tangent of an anisotropic material goes around
    the vertical axis; strokes along it are drawn if asked for."""
    normal, _, _ = sphere(size)
    radiance = np.broadcast_to(studio.on_sphere(fit, normal), (len(normal), 3))
    picture = draw_sphere(srgb(studio.tone_map(radiance @ conversion(colours, DEFAULT_COLOURS).T)), size)
    if with_tangent and not is_isotropic(fit):
        canvas = Canvas(picture)
        for stroke in _strokes(size):
            canvas.line(stroke, LIGHT, 1.2)
    return picture


def draw_sphere(colors: FloatArray, size: int) -> SingleArray:
    """The picture of a sphere, (size, size, 4) float32, by its colours, (n, 3), at the pixels that `sphere` has."""
    _, inside, cover = sphere(size)
    picture = np.zeros((size, size, 4), dtype=np.float32)
    picture[inside, :3], picture[..., 3] = colors, cover
    # pixels of the edge whose middle is outside would else darken it
    edge = np.argwhere((cover > 0) & ~inside)
    middle = (size - 1) / 2
    inward = np.round(edge - 1.5 * (edge - middle) / np.linalg.norm(edge - middle, axis=1, keepdims=True)).astype(int)
    picture[edge[:, 0], edge[:, 1], :3] = picture[inward[:, 0], inward[:, 1], :3]
    return picture


def lit_cloth(fit: Reflectance, size: int = SIZE) -> SingleArray:
    """A cloth of the material in folds, which throw no shadows, in a studio, orthographic: (size, size, 4) float32."""
    at = (np.arange(size) + 0.5) / size * 2 - 1
    x, y = np.meshgrid(at, at)
    place = x + 0.22 * y * np.sin(2.2 * x + 0.8)            # across the folds, which lean and widen downward
    slope = 0.75 * np.sin(6.3 * place + 0.6) + 0.3 * np.sin(13.1 * place - 0.9 * y)
    normal = np.stack([-slope, 0.18 * np.cos(5.0 * place + 2.2 * y) + 0.15, np.ones_like(x)], axis=-1)
    normal /= np.linalg.norm(normal, axis=-1, keepdims=True)
    radiance = np.broadcast_to(studio.on_sphere(fit, normal.reshape(-1, 3)), (size * size, 3))
    picture = np.zeros((size, size, 4), dtype=np.float32)
    picture[..., :3] = srgb(studio.tone_map(radiance)).reshape(size, size, 3)
    beyond = [np.abs(axis) + 0.012 * np.sin(9 * other) - _HEM for axis, other in ((x, y), (y, x))]
    picture[..., 3] = np.clip(0.5 - np.maximum(*beyond) * size / 2, 0, 1)
    return picture


def thumbnail(material: PublishedMaterial, size: int = SIZE) -> SingleArray:
    """The picture of a material of the library, (size, size, 4) float32: a cloth where it is one, else a sphere. For
    what is nearly white it is stopped down, as a photographer does."""
    picture = (lit_cloth if "fabric" in material.tags else lit_sphere)(material.model, size)
    cover = picture[..., 3:]
    mean = (picture[..., :3] * cover).sum() / (3 * cover.sum())
    picture[..., :3] *= min(_BRIGHTEST / mean, 1)
    return picture


def split(left: SingleArray, right: SingleArray, at: float = 0.5) -> SingleArray:
    """The left part of one picture beside the right part of another, (height, width, 4) float32 each, with a thin line
    between them: `at` is 0 at the left edge, 1 at the right one. Raises ValueError if their shapes differ."""
    if left.shape != right.shape:
        raise ValueError(f"pictures of {left.shape} and {right.shape}, expected the same shape")
    column, width = np.arange(left.shape[1]), left.shape[1]
    edge, thickness = round(at * width), max(width // 256, 1)
    picture = np.where(column[:, None] < edge, left, right)
    picture[:, (column >= edge - thickness // 2) & (column < edge - thickness // 2 + thickness)] = INK
    return picture


def _strokes(size: int) -> list[FloatArray]:
    """Short lines along the tangent of a sphere, in pixels: (n, 2) each."""
    strokes = []
    for latitude in np.radians((-50, 0, 50)):
        for middle in np.radians((-60, -20, 20, 60)):
            longitude = middle + np.radians(np.linspace(-8, 8, 9))
            at = np.stack([np.cos(latitude) * np.sin(longitude), np.full(9, np.sin(latitude))], axis=-1)
            strokes.append((0.96 * at + 1) / 2 * size)
    return strokes


def sphere(size: int) -> tuple[FloatArray, BoolArray, FloatArray]:
    """What is seen of a sphere in orthographic view from (0, 0, 1): its normals at the pixels inside, (n, 3); which
    these are, (size, size) bool; and how much of each pixel the sphere covers, (size, size), 0 to 1."""
    at = (np.arange(size) + 0.5) / size * 2 - 1
    x, y = (axis / 0.96 for axis in np.meshgrid(at, at))
    r2 = x ** 2 + y ** 2
    inside = r2 < 1
    normal = np.stack([x, y, np.sqrt(np.maximum(1 - r2, 0))], axis=-1)[inside]
    return normal, inside, np.clip((1 - np.sqrt(r2)) * 0.48 * size + 0.5, 0, 1)


def srgb(linear: ArrayLike) -> FloatArray:
    """Encode linear values for display, clipped to 0 to 1 (IEC 61966-2-1).

    Examples
    --------
    >>> srgb([-1, 0, 0.214041, 1, 5]).round(6).tolist()
    [0.0, 0.0, 0.5, 1.0, 1.0]
    """
    clipped = np.clip(np.asarray(linear, dtype=float), 0, 1)
    return np.where(clipped <= 0.0031308, 12.92 * clipped, 1.055 * clipped ** (1 / 2.4) - 0.055)

"""Lines, discs and characters in small pictures: (height, width, 4) float32, the bottom row first."""

import numpy as np

from .arrays import ArrayLike, FloatArray, SingleArray

Color = tuple[float, float, float]

BACKGROUND, GRID, INK = (0.16, 0.16, 0.16), (0.32, 0.32, 0.32), (0.9, 0.9, 0.9)
_FONT = {   # rows of 3 bits
         "0": (7, 5, 5, 5, 7), "1": (2, 6, 2, 2, 7), "2": (7, 1, 7, 4, 7), "3": (7, 1, 7, 1, 7), "4": (5, 5, 7, 1, 1),
         "5": (7, 4, 7, 1, 7), "6": (7, 4, 7, 5, 7), "7": (7, 1, 2, 2, 2), "8": (7, 5, 7, 5, 7), "9": (7, 5, 7, 1, 7),
         "e": (0, 7, 5, 6, 7), "-": (0, 0, 7, 0, 0), "+": (0, 2, 7, 2, 0), ".": (0, 0, 0, 0, 2),
         "A": (2, 5, 7, 5, 5), "B": (6, 5, 6, 5, 6)}


def blank(size: int) -> SingleArray:
    """A square of the background, (size, size, 4)."""
    canvas = np.empty((size, size, 4), dtype=np.float32)
    canvas[...] = (*BACKGROUND, 1)
    return canvas


def line(canvas: SingleArray, points: FloatArray, color: Color, width: float = 1.0) -> None:
    """Draw a polyline as dense dots: points (n, 2) in pixels from the bottom left."""
    steps = np.maximum(np.ceil(2 * np.linalg.norm(np.diff(points, axis=0), axis=1)).astype(int), 1)
    start = np.repeat(points[:-1], steps, axis=0)
    along = np.concatenate([np.arange(count) / count for count in steps])
    dense = start + along[:, None] * np.repeat(np.diff(points, axis=0), steps, axis=0)
    dots(canvas, np.concatenate([dense, points[-1:]]), color, width)


def dots(canvas: SingleArray, centers: FloatArray, color: Color, diameter: float) -> None:
    """Draw antialiased discs at centers (n, 2), in pixels from the bottom left."""
    reach = int(np.ceil(diameter / 2 + 1))
    offset = np.arange(-reach, reach + 1)
    dx, dy = (grid.ravel() for grid in np.meshgrid(offset, offset))
    x, y = (np.floor(centers[:, k])[:, None].astype(int) + step for k, step in ((0, dx), (1, dy)))
    distance = np.hypot(x + 0.5 - centers[:, :1], y + 0.5 - centers[:, 1:])
    cover = np.clip(diameter / 2 + 0.5 - distance, 0, 1)
    inside = (cover > 0) & (x >= 0) & (y >= 0) & (x < canvas.shape[1]) & (y < canvas.shape[0])
    mask = np.zeros(canvas.shape[:2])
    np.maximum.at(mask, (y[inside], x[inside]), cover[inside])
    canvas[..., :3] += (mask[..., None] * (np.asarray(color) - canvas[..., :3])).astype(np.float32)


def write(canvas: SingleArray, text: str, at: ArrayLike, scale: int = 2, color: Color = INK) -> None:
    """Draw characters of `_FONT`, their lower left corner at `at` (2,), in pixels from the bottom left."""
    column, row = (int(place) for place in np.asarray(at))
    for character in text:
        bits = np.array([[glyph >> 2 & 1, glyph >> 1 & 1, glyph & 1] for glyph in _FONT[character]][::-1], dtype=bool)
        block = np.kron(bits, np.ones((scale, scale), dtype=bool))
        part = canvas[max(row, 0):row + block.shape[0], column:column + block.shape[1]]
        part[block[max(-row, 0):][:part.shape[0], :part.shape[1]], :3] = color
        column += 4 * scale

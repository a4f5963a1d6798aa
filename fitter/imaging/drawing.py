"""Lines, discs and characters in small pictures: (height, width, 4) float32, the bottom row first."""

from collections.abc import Sequence

import numpy as np

from ..arrays import ArrayLike, BoolArray, FloatArray

Color = tuple[float, float, float, float]
"""Red, green and blue, as they are displayed, and how much it covers."""

BACKGROUND, INK = (0.16, 0.16, 0.16, 1.0), (0.9, 0.9, 0.9, 1.0)
_PIXEL = 6                  # of the size of text, to a pixel of `_FONT`
_FONT = {   # rows of 3 bits
         "0": (7, 5, 5, 5, 7), "1": (2, 6, 2, 2, 7), "2": (7, 1, 7, 4, 7), "3": (7, 1, 7, 1, 7), "4": (5, 5, 7, 1, 1),
         "5": (7, 4, 7, 1, 7), "6": (7, 4, 7, 5, 7), "7": (7, 1, 2, 2, 2), "8": (7, 5, 7, 5, 7), "9": (7, 5, 7, 1, 7),
         "e": (0, 7, 5, 6, 7), "-": (0, 0, 7, 0, 0), "+": (0, 2, 7, 2, 0), ".": (0, 0, 0, 0, 2), "/": (1, 1, 2, 4, 4),
         "A": (2, 5, 7, 5, 5), "B": (6, 5, 6, 5, 6), "s": (3, 4, 2, 1, 6), "r": (0, 6, 5, 4, 4),
         "\u00b0": (7, 5, 7, 0, 0)}


class Canvas:
    """A square picture that is drawn into, in pixels from the bottom left: a pen of `plane_plot`.

    Attributes
    ----------
    picture : (size, size, 4) float32
    """

    def __init__(self, size: int) -> None:
        self.picture = np.empty((size, size, 4), dtype=np.float32)
        self.picture[...] = BACKGROUND

    def line(self, points: ArrayLike, color: Color, width: float) -> None:
        """Draw a polyline, (n, 2), as dense dots."""
        points = np.asarray(points, dtype=float)
        steps = np.maximum(np.ceil(2 * np.linalg.norm(np.diff(points, axis=0), axis=1)).astype(int), 1)
        start = np.repeat(points[:-1], steps, axis=0)
        along = np.concatenate([np.arange(count) / count for count in steps] or [np.zeros(0)])
        dense = start + along[:, None] * np.repeat(np.diff(points, axis=0), steps, axis=0)
        self.discs(np.concatenate([dense, points[-1:]]), width / 2, color)

    def strokes(self, ends: ArrayLike, color: Color, width: float) -> None:
        """Draw lines between pairs of points: (2 n, 2)."""
        for pair in np.asarray(ends, dtype=float).reshape(-1, 2, 2):
            self.line(pair, color, width)

    def fan(self, points: ArrayLike, color: Color) -> None:
        """Fill a convex outline, (n, 2), clockwise."""
        corners = np.asarray(points, dtype=float)
        y, x = np.indices(self.picture.shape[:2]) + 0.5
        inside = np.ones(x.shape, dtype=bool)
        for (x0, y0), (dx, dy) in zip(corners, np.roll(corners, -1, axis=0) - corners, strict=True):
            inside &= dx * (y - y0) <= dy * (x - x0)
        self._cover(inside.astype(float), color)

    def discs(self, centers: FloatArray, radius: float, color: Color) -> None:
        """Draw antialiased discs at centers, (n, 2)."""
        reach = int(np.ceil(radius + 1))
        offset = np.arange(-reach, reach + 1)
        dx, dy = (grid.ravel() for grid in np.meshgrid(offset, offset))
        x, y = (np.floor(centers[:, k])[:, None].astype(int) + step for k, step in ((0, dx), (1, dy)))
        distance = np.hypot(x + 0.5 - centers[:, :1], y + 0.5 - centers[:, 1:])
        cover = np.clip(radius + 0.5 - distance, 0, 1)
        height, width = self.picture.shape[:2]
        inside: BoolArray = (cover > 0) & (x >= 0) & (y >= 0) & (x < width) & (y < height)
        mask = np.zeros((height, width))
        np.maximum.at(mask, (y[inside], x[inside]), cover[inside])
        self._cover(mask, color)

    def text(self, string: str, at: Sequence[float], size: float, color: Color, align: float = 0.0) -> float:
        """Draw characters of `_FONT` on a base line: their width, of which the share `align` lies left of `at`."""
        scale = max(round(size / _PIXEL), 1)
        width = (4 * len(string) - 1) * scale
        column, row = round(at[0] - align * width), round(at[1])
        mask = np.zeros(self.picture.shape[:2])
        for number, character in enumerate(string):
            bits = np.array([[glyph >> 2 & 1, glyph >> 1 & 1, glyph & 1] for glyph in _FONT[character]][::-1])
            y, x = np.nonzero(np.kron(bits, np.ones((scale, scale))))
            x, y = x + column + 4 * scale * number, y + row
            inside = (x >= 0) & (y >= 0) & (x < mask.shape[1]) & (y < mask.shape[0])
            mask[y[inside], x[inside]] = 1
        self._cover(mask, color)
        return width

    def _cover(self, mask: FloatArray, color: Color) -> None:
        """Lay a colour over the picture: (size, size), 0 to 1."""
        share = color[3] * mask[..., None]
        self.picture[..., :3] += (share * (np.asarray(color[:3]) - self.picture[..., :3])).astype(np.float32)

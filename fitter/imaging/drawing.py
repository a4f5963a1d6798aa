"""Lines, discs and characters in small pictures: (height, width, 4) float32, the bottom row first; in pixels from the
bottom left."""

from collections.abc import Sequence

import numpy as np

from ..arrays import ArrayLike, BoolArray, FloatArray, SingleArray

Color = tuple[float, float, float, float]
"""Red, green and blue, as they are displayed, and how much it covers."""

BACKGROUND, INK = (0.16, 0.16, 0.16, 1.0), (0.92, 0.92, 0.92, 1.0)
LIGHT: Color = (1.0, 0.75, 0.2, 1.0)
_GLYPH_UNIT = 0.115               # of the size of text: that of `_FONT`
_STROKE = 0.115             # likewise: how wide its lines are
_GLYPHS = {  # polylines through points, x and y, from the lower left corner; capitals are 6 high
         "0": "10 30 41 45 36 16 05 01 10", "1": "05 26 20", "2": "05 16 36 45 44 00 40",
         "3": "05 16 36 45 44 33 13,33 42 41 30 10 01", "4": "30 36 02 42", "5": "46 06 04 34 43 41 30 10 01",
         "6": "45 36 16 05 01 10 30 41 42 33 13 02", "7": "06 46 10",
         "8": "13 04 05 16 36 45 44 33 13 02 01 10 30 41 42 33", "9": "01 10 30 41 45 36 16 05 04 13 33 44",
         "e": "02 42 43 34 14 03 01 10 30 41", "-": "03 33", "+": "03 43,21 25", ".": "00 00", "/": "00 36",
         "s": "44 14 03 12 32 41 30 00", "r": "00 04,02 14 24", "\u00b0": "05 16 25 14 05"}


class Canvas:
    """A picture that is drawn into, (height, width, 4) float32: a pen of `plane_plot`."""

    def __init__(self, picture: SingleArray) -> None:
        self.picture = picture

    def line(self, points: ArrayLike, color: Color, width: float) -> None:
        """Draw a polyline: (n, 2)."""
        self.discs(_dots(points), width / 2, color)

    def strokes(self, ends: ArrayLike, color: Color, width: float) -> None:
        """Draw lines between pairs of points: (2 n, 2)."""
        pairs = np.asarray(ends, dtype=float).reshape(-1, 2, 2)
        self.discs(np.concatenate([np.zeros((0, 2)), *map(_dots, pairs)]), width / 2, color)

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
        """Draw characters of `_GLYPHS` on a base line: their width, of which the share `align` lies left of `at`."""
        dots, unit, width = [np.zeros((0, 2))], _GLYPH_UNIT * size, 0.0
        for character in string:
            strokes = [np.array([divmod(int(point), 10) for point in stroke.split()])
                       for stroke in _GLYPHS[character].split(",")]
            dots += [_dots(unit * stroke + (width, 0)) for stroke in strokes]
            width += unit * (max(stroke[:, 0].max() for stroke in strokes) + 2)
        width -= 2 * unit if string else 0
        self.discs(np.concatenate(dots) + np.asarray(at) - (align * width, 0), _STROKE * size / 2, color)
        return width

    def _cover(self, mask: FloatArray, color: Color) -> None:
        """Lay a colour over the picture: (height, width), 0 to 1."""
        share = color[3] * mask[..., None]
        self.picture[..., :3] += (share * (np.asarray(color[:3]) - self.picture[..., :3])).astype(np.float32)


def _dots(points: ArrayLike) -> FloatArray:
    """Points on a polyline, (n, 2), half a pixel apart or less: (m, 2)."""
    points = np.asarray(points, dtype=float)
    steps = np.maximum(np.ceil(2 * np.linalg.norm(np.diff(points, axis=0), axis=1)).astype(int), 1)
    start = np.repeat(points[:-1], steps, axis=0)
    along = np.concatenate([np.arange(count) / count for count in steps] or [np.zeros(0)])
    dense = start + along[:, None] * np.repeat(np.diff(points, axis=0), steps, axis=0)
    return np.concatenate([dense, points[-1:]])

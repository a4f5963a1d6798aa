"""Which materials of the library a photograph of a ball may show, once each has been brought as near as it can be.

The light is taken for a window somewhere and an even sky. Balls of all materials are computed under each
(`studio.sky_radiances`), and the two brightnesses that suit the photograph best are solved for, weighed by its power of
-2/3: errors are relative ones of values to the power of a third. What brings a material nearer is how much brighter, in
each channel, its diffuse part and its highlight would have to be, as `editing.edited` has them.
"""

from collections.abc import Sequence
from functools import cache, partial
from typing import NamedTuple

import numpy as np

from .. import progress
from ..arrays import ArrayLike, FloatArray
from ..errors import DatasetError
from ..imaging import studio
from ..methods.editing import split_level
from ..model import Reflectance, is_isotropic, published
from ..model.edit import diffuse_part

WINDOWS = {"left": (-0.85, 0.25, 0.47), "right": (0.85, 0.25, 0.47), "above": (0.0, 0.88, 0.47),
           "front": (0.0, 0.3, 0.95)}
"""Directions to the middle of a window; the camera looks along -z, x is to the right and y up."""
FEWEST_PIXELS = 32          # along a photograph
_SIZE = 32                  # pixels along a ball that is compared
_WITHIN = 0.92              # of its radius: beyond, the background and the camera's blur show
_HALF_SIDE = 0.45           # half of a window's sides, as slopes
_CLIPPED = 0.99             # of 1: values of a picture that ends there
_DIM_SHARE = 0.02           # of the mean, that is added where errors are relative
_LARGEST = 20.0             # factor that brings a material nearer
_OWN = 0.5                  # what the error without factors counts beside the other: with them alone, three of five
                            # balls of the library's own materials had others before them, a green latex 75
_LEAST = 0.02               # share of what a ball shows, below which a part is left as it is
_RING_BANDS = (0.78, 0.86), (0.86, 0.94), (1.04, 1.12), (1.12, 1.2)  # rings about a ball's outline, of its radius
# of the corners, where there is something beside the ball; in so many an outline is seen
_CORNER_SECTORS, _CLEAR_SECTORS = 8, 2
_BESIDE = 0.5               # of the steps beside an outline, that are no part of its own
_OUTLINE_STEP = 0.22        # relative step at an outline: real balls and the library's before walls of .02 to .15
                            # have .27 or more; gradients, colours and noise of 64 pixels or more at most .21
_FARTHEST = 0.65            # error of the nearest material: of real balls, and of the library's under other skies, at
                            # most .62; of noise of fewer pixels, of checks and of leaves .69 or more. Both limits are
                            # tried by tests/fitter/library/test_matching.py


class Match(NamedTuple):
    """A material that a photograph may show."""

    material: published.PublishedMaterial
    error: float                    # relative difference from the photograph: 0 is none
    adjusted: float                 # the same with the factors
    diffuse: tuple[float, ...]      # factors of both parts, for each channel, as `editing.edited` takes them
    highlight: tuple[float, ...]


class _Split:
    """A reflectance, the diffuse part after the whole, as channels."""

    def __init__(self, model: Reflectance) -> None:
        self._model, self._level = model, split_level(model)

    def evaluate(self, theta_i: ArrayLike, phi_i: ArrayLike, theta_o: ArrayLike, phi_o: ArrayLike) -> FloatArray:
        whole = self._model.evaluate(theta_i, phi_i, theta_o, phi_o)
        return np.concatenate([whole, diffuse_part(whole, self._level)], axis=-1)


def find_nearest(picture: FloatArray, window: str = "", count: int = 5) -> tuple[str, list[Match]]:
    """The isotropic materials of the library that are nearest to a photograph of a ball, each with its factors: those
    first of which least is left with these, and half of what is left without; and the window that the light comes from.

    The picture is (height, width, 3), linear Rec.709, the top row first, cropped to the ball: its outline touches the
    edges of the middle square. The window is one of `WINDOWS`; empty: wherever it suits the photograph best.

    Raises DatasetError if the picture is no such array, or dark; or shows no ball, or one that no material is near to;
    or the window is unknown.
    """
    if window not in ("", *WINDOWS):
        raise DatasetError(f"a window {window!r}, expected one of {', '.join(WINDOWS)}")
    normal, values = _ball_pixels(picture)
    if not _has_outline(picture):
        raise DatasetError("none is near: no outline of a ball is in this picture, expected one that touches the edges "
                           "of its middle square")
    names = [window] if window else [*WINDOWS]
    weight = (values + _DIM_SHARE * values.mean()) ** (-2 / 3)
    materials = [each for each in published.list_offered() if is_isotropic(each.model)]
    found: dict[str, list[Match]] = {name: [] for name in names}
    for number, material in enumerate(materials):
        progress.report(number / len(materials), material.label)
        shown = studio.sky_radiances(_Split(material.model), normal, (_even_light, *map(_sky, names)))
        for name, lit in zip(names, shown[1:], strict=True):
            found[name].append(_match(material, shown[0], lit, values, weight))
    best = min(names, key=lambda name: min(each.error for each in found[name]))
    least = min(found[best], key=lambda each: each.error)
    if least.error > _FARTHEST:
        raise DatasetError(f"none is near: the nearest, {least.material.label}, differs by {least.error:.0%}")
    return best, sorted(found[best], key=lambda each: each.adjusted + _OWN * each.error)[:count]


def _match(material: published.PublishedMaterial, even: FloatArray, lit: FloatArray, values: FloatArray,
           weight: FloatArray) -> Match:
    """A material under both lights, (n, 6) each, beside the photograph, (n, 3)."""
    target, size = weight * values, float(np.linalg.norm(weight * values))
    (first, second), error = _two_factors(weight * even[:, :3], weight * lit[:, :3], target)
    whole = first * even + second * lit
    diffuse, highlight = weight * whole[:, 3:], weight * (whole[:, :3] - whole[:, 3:])
    columns = zip(diffuse.T, highlight.T, target.T, strict=True)
    factors, left = zip(*(_two_factors(*each) for each in columns), strict=True)
    parts = [np.ones(3) if np.linalg.norm(part) < _LEAST * size else np.array(found)
             for part, found in zip((diffuse, highlight), zip(*factors, strict=True), strict=True)]
    return Match(material, error / size, float(np.linalg.norm(left)) / size, *(tuple(each.tolist()) for each in parts))


def _two_factors(first: FloatArray, second: FloatArray, target: FloatArray) -> tuple[FloatArray, float]:
    """Two factors from 0 to `_LARGEST` of two columns whose sum is nearest to a target, and the error that is left."""
    columns, target = np.stack([first.ravel(), second.ravel()], axis=1), target.ravel()
    whole = np.linalg.lstsq(columns, target, rcond=None)[0]
    tried = [whole] if (whole >= 0).all() else []
    for number, column in enumerate(columns.T):
        alone = np.zeros(2)
        alone[number] = max(column @ target / max(column @ column, 1e-30), 0)
        tried.append(alone)
    found = [np.minimum(each, _LARGEST) if first.ndim == 1 else each for each in tried]
    errors = [float(np.linalg.norm(columns @ each - target)) for each in found]
    best = int(np.argmin(errors))
    return np.asarray(found[best], float), errors[best]


def _ball_pixels(picture: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Normals of a ball that fills a picture, (n, 3), and what is seen there, (n, 3)."""
    if picture.ndim != 3 or picture.shape[2] != 3 or min(picture.shape[:2]) < FEWEST_PIXELS:
        raise DatasetError(f"a picture of the shape {picture.shape}, expected three channels and at least "
                           f"{FEWEST_PIXELS} x {FEWEST_PIXELS} pixels")
    square = _square(picture)
    side = len(square)
    cell = side // _SIZE
    reach = (side - cell * _SIZE) // 2
    square = square[reach:, reach:][:cell * _SIZE, :cell * _SIZE]
    blocks = square.reshape(_SIZE, cell, _SIZE, cell, 3)
    values = blocks.mean(axis=(1, 3)).reshape(-1, 3)
    clipped = (blocks.max(axis=(1, 3, 4)) >= _CLIPPED).ravel() & (picture.max() <= 1)
    place = ((np.arange(_SIZE) + 0.5) * 2 / _SIZE - 1) * cell * _SIZE / side
    y, x = (each.ravel() for each in np.meshgrid(-place, place, indexing="ij"))
    used = (x ** 2 + y ** 2 < _WITHIN ** 2) & ~clipped
    if used.sum() < _SIZE or not values[used].mean() > 0:
        raise DatasetError("the picture is dark, or too bright nearly everywhere on the ball")
    normal = np.stack([x, y, np.sqrt(np.maximum(1 - x ** 2 - y ** 2, 0))], axis=-1)
    return normal[used], np.maximum(values[used], 0)


def _square(picture: FloatArray) -> FloatArray:
    """The middle square of a picture."""
    side = min(picture.shape[:2])
    top, left = ((length - side) // 2 for length in picture.shape[:2])
    return picture[top:top + side, left:left + side]


def _has_outline(picture: FloatArray) -> bool:
    """Whether a picture has an edge where a ball's outline is: a step there that is larger than those beside it."""
    square = _square(picture)
    place = (np.arange(len(square)) + 0.5) * 2 / len(square) - 1
    x, y = np.meshgrid(place, place)
    radius, turn = np.hypot(x, y), np.arctan2(y, x)
    clear = 0
    for sector in np.arange(_CORNER_SECTORS) * np.pi / 4:   # the corners are at odd multiples of pi/4: half of each
        inside = (np.mod(turn - sector, 2 * np.pi) < np.pi / 4) & (np.abs(np.sin(2 * turn)) > np.sin(np.pi / 4))
        a, b, c, d = (square[inside & (radius > low) & (radius <= high)].mean(axis=0) for low, high in _RING_BANDS)
        step = np.abs(c - b) - _BESIDE * np.maximum(np.abs(b - a), np.abs(d - c))
        clear += bool((step > _OUTLINE_STEP * (np.abs(b) + np.abs(c))).any())
    return clear >= _CLEAR_SECTORS


def _even_light(direction: FloatArray) -> FloatArray:
    return np.ones(direction.shape[:-1])


@cache
def _sky(name: str) -> studio.Sky:
    return partial(studio.softbox, toward=WINDOWS[name], half_width=_HALF_SIDE, half_height=_HALF_SIDE)


def match_lines(window: str, matches: Sequence[Match]) -> list[str]:
    """Matches as lines of text."""
    return [f"Light from the {window}" if window in ("left", "right") else f"Light from {window}",
            *(f"{each.material.label}: difference {each.error:.0%}, {each.adjusted:.0%} as it is adjusted"
              for each in matches)]

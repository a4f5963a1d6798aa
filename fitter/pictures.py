"""Small pictures of a fit for the panel: (size, size, 4) float32, sRGB with alpha, the bottom row first."""

from collections.abc import Sequence

import numpy as np

from .arrays import ArrayLike, BoolArray, FloatArray, SingleArray
from .colours import DEFAULT, conversion
from .model import Reflectance, is_isotropic
from .samples import Samples

_Color = tuple[float, float, float]

SIZE = 256
IN_PLANE = np.radians(8)       # samples within this angle of the plane of incidence are plotted
Light = tuple[tuple[float, float, float], float]       # direction to a light far away, and its irradiance / pi
LIGHTS: tuple[Light, ...] = (((-0.5, 0.6, 0.62), 1.0), ((0.9, -0.1, 0.42), 0.25))
_BACKGROUND, _GRID, _INK = (0.16, 0.16, 0.16), (0.32, 0.32, 0.32), (0.9, 0.9, 0.9)
_CHANNELS: dict[int, tuple[_Color, ...]] = {
    1: ((0.9, 0.9, 0.9),), 3: ((1.0, 0.38, 0.34), (0.45, 0.85, 0.4), (0.42, 0.62, 1.0))}
_MARK = (1.0, 0.75, 0.2)
_FONT = {   # rows of 3 bits
         "0": (7, 5, 5, 5, 7), "1": (2, 6, 2, 2, 7), "2": (7, 1, 7, 4, 7), "3": (7, 1, 7, 1, 7), "4": (5, 5, 7, 1, 1),
         "5": (7, 4, 7, 1, 7), "6": (7, 4, 7, 5, 7), "7": (7, 1, 2, 2, 2), "8": (7, 5, 7, 5, 7), "9": (7, 5, 7, 1, 7),
         "e": (0, 7, 5, 6, 7), "-": (0, 0, 7, 0, 0), "+": (0, 2, 7, 2, 0), ".": (0, 0, 0, 0, 2)}


def lit_sphere(fit: Reflectance, size: int = SIZE, lights: Sequence[Light] = LIGHTS,
               colours: str = DEFAULT, with_tangent: bool = False) -> SingleArray:
    """A sphere of the material, lit by a key and a fill light, in orthographic view on a transparent background.

    The tangent of an anisotropic material goes around the vertical axis.

    Parameters
    ----------
    fit : Reflectance
    size : int
        Pixels.
    lights : sequence of (direction, strength)
        Far away: the direction to each, and its irradiance / pi. The view is (0, 0, 1).
    colours : str
        One of `colours.COLOURS`: that of the fit.
    with_tangent : bool
        Draw strokes along the tangent of an anisotropic material.

    Returns
    -------
    (size, size, 4) float32

    Examples
    --------
    >>> from .methods import prior
    >>> picture = lit_sphere(prior.lambertian(np.array([[0.3]])), 32)
    >>> picture.shape, float(picture[0, 0, 3]), float(picture[16, 16, 3])
    ((32, 32, 4), 0.0, 1.0)
    """
    normal, inside, cover = sphere(size)
    radiance = np.zeros((len(normal), 3))
    for direction, strength in lights:
        radiance += np.pi * strength * reflected(fit, normal, direction)
    picture = np.zeros((size, size, 4), dtype=np.float32)
    picture[inside, :3] = srgb(radiance @ conversion(colours, DEFAULT).T)
    picture[..., 3] = cover
    if with_tangent and not is_isotropic(fit):
        for stroke in _strokes(size):
            _line(picture, stroke, _MARK, 1.2)
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
    """What is seen of a sphere in orthographic view from (0, 0, 1).

    Returns
    -------
    normal : (n, 3) float64
        At the pixels inside.
    inside : (size, size) bool
    cover : (size, size) float64
        How much of each pixel the sphere covers: 0 to 1.
    """
    at = (np.arange(size) + 0.5) / size * 2 - 1
    x, y = (axis / 0.96 for axis in np.meshgrid(at, at))
    r2 = x ** 2 + y ** 2
    inside = r2 < 1
    normal = np.stack([x, y, np.sqrt(np.maximum(1 - r2, 0))], axis=-1)[inside]
    return normal, inside, np.clip((1 - np.sqrt(r2)) * 0.48 * size + 0.5, 0, 1)


def reflected(fit: Reflectance, normal: FloatArray, direction: ArrayLike) -> FloatArray:
    """What a surface reflects of a light far away toward the view (0, 0, 1): f cos theta_i, not below 0.

    Parameters
    ----------
    fit : Reflectance
    normal : (n, 3) float64
        Of the surface.
    direction : (3,) array_like
        To the light, of any length.

    Returns
    -------
    (n, 3) float64
        1/sr.

    Examples
    --------
    >>> from .methods import prior
    >>> upright = np.array([[0.0, 0.0, 1.0]])
    >>> reflected(prior.lambertian(np.array([[0.3]])), upright, (0, np.sqrt(3), 1)).round(9).tolist()
    [[0.15, 0.15, 0.15]]
    """
    toward = np.asarray(direction) / np.linalg.norm(direction)
    cos_i = normal @ toward
    lit = cos_i > 0
    cos_o = normal[lit, 2]
    if is_isotropic(fit):       # only the azimuth between light and view matters
        sines = np.sqrt(np.maximum((1 - cos_i[lit] ** 2) * (1 - cos_o ** 2), 1e-12))
        phi_o = np.arccos(np.clip((toward[2] - cos_i[lit] * cos_o) / sines, -1, 1))
        phi_i = np.zeros_like(phi_o)
    else:
        tangent = np.stack([normal[lit, 2], 0 * cos_o, -normal[lit, 0]], axis=-1)       # the vertical axis x normal
        bitangent = np.cross(normal[lit], tangent)
        phi_i = np.arctan2(bitangent @ toward, tangent @ toward)
        phi_o = np.arctan2(bitangent[:, 2], tangent[:, 2])
    value = fit.evaluate(np.arccos(np.minimum(cos_i[lit], 1)), phi_i, np.arccos(cos_o), phi_o)
    found = np.zeros((len(normal), 3))
    found[lit] = np.maximum(value, 0) * cos_i[lit, None]
    return found


def polar_plot(fit: Reflectance, samples: Samples | None, theta_i: float, size: int = SIZE,
               phi_i: float = 0.0) -> tuple[SingleArray, float]:
    """Plot the fit in the plane of incidence for one angle of incidence, with the samples near that plane.

    Radii are cube roots, so that dark directions beside a high peak are visible. The light comes from the left.

    Parameters
    ----------
    fit : Reflectance
    samples : Samples, or None
    theta_i : float
        Radians.
    size : int
        Pixels.
    phi_i : float
        Azimuth of the light, radians; of an isotropic material it does not matter.

    Returns
    -------
    picture : (size, size, 4) float32
    shown : float
        Angle of incidence of the plotted samples, radians: the measured one nearest to theta_i; nan without any.
    """
    theta = np.linspace(-np.pi / 2, np.pi / 2, 361)                 # negative on the light's side
    curve = fit.evaluate(np.full(361, theta_i), np.full(361, phi_i), np.abs(theta),
                         phi_i + np.where(theta < 0, 0, np.pi))
    place, values, shown = (np.zeros(0), curve[:0], float("nan")) if samples is None else (
        _near_plane(samples, theta_i, phi_i))
    scale = max(np.cbrt(max(curve.max(), values.max(initial=0))), 1e-6)

    canvas = _canvas(size)
    origin, radius = np.array([0.5, 0.27]) * size, 0.46 * size
    for fraction in (0.5, 1.0):
        _line(canvas, origin + fraction * radius * _on_arc(np.linspace(-np.pi / 2, np.pi / 2, 91)), _GRID)
    for angle in np.radians((-90, -60, -30, 0, 30, 60, 90)):
        _line(canvas, origin + np.outer(np.array([0, radius]), _on_arc(angle)), _GRID)
    _line(canvas, origin + np.outer(np.array([0.25 * radius, 1.08 * radius]), _on_arc(-theta_i)), _MARK, 1.6)
    colors = _CHANNELS[3 if curve.shape[1] == 3 else 1]
    for c, color in enumerate(colors):
        length = np.cbrt(np.maximum(curve[:, c], 0)) / scale * radius
        _line(canvas, origin + length[:, None] * _on_arc(theta), color, 1.4)
    for c, color in enumerate(colors):
        length = np.cbrt(np.maximum(values[:, c], 0)) / scale * radius
        _dots(canvas, origin + length[:, None] * _on_arc(place), color, 2.6)
    return canvas, shown


def turned_plane(fit: Reflectance, theta_i: float, size: int = SIZE, colours: str = DEFAULT) -> SingleArray:
    """The fit in the plane of incidence, for one angle of incidence, while that plane turns about the normal.

    From left to right the light's azimuth goes through a full turn; from bottom to top the outgoing angle goes from
    grazing on the light's side, through the normal, to grazing opposite the light. Cube roots of f cos theta_o are
    shown, the largest of them as 1. Of an isotropic material all columns are equal.

    Parameters
    ----------
    fit : Reflectance
    theta_i : float
        Radians.
    size : int
        Pixels.
    colours : str
        One of `colours.COLOURS`: that of the fit.

    Returns
    -------
    (size, size, 4) float32

    Examples
    --------
    >>> from .methods import prior
    >>> picture = turned_plane(prior.lambertian(np.array([[0.3]])), 0.5, 32)
    >>> picture.shape, bool((picture[:, :1] == picture).all())
    ((32, 32, 4), True)
    """
    step = (np.arange(size) + 0.5) / size
    phi, theta = np.meshgrid(2 * np.pi * step, np.pi * (step - 0.5))
    value = fit.evaluate(np.full(phi.size, theta_i), phi.ravel(), np.abs(theta).ravel(),
                         (phi + np.where(theta < 0, 0, np.pi)).ravel()) * np.cos(theta).reshape(-1, 1)
    linear = np.broadcast_to(np.maximum(value, 0), (phi.size, 3)) @ conversion(colours, DEFAULT).T
    shown = np.cbrt(np.maximum(linear, 0))
    picture = np.ones((size, size, 4), dtype=np.float32)
    picture[..., :3] = (shown / max(shown.max(), 1e-6)).reshape(size, size, 3)
    return picture


def error_plot(levels: Sequence[int], errors: Sequence[float], current: tuple[int, float],
               size: int = SIZE) -> SingleArray:
    """Plot the error against the level, on a logarithmic axis, and mark the current choice.

    Parameters
    ----------
    levels : (n,) sequence of int
    errors : (n,) sequence of float
        1/sr.
    current : (level, error)
    size : int
        Pixels.

    Returns
    -------
    (size, size, 4) float32

    Examples
    --------
    >>> error_plot([2, 3, 4], [0.1, 0.05, 0.01], (3, 0.05), 64).shape
    (64, 64, 4)
    """
    canvas = _canvas(size)
    logs = np.log10(np.maximum([*errors, current[1]], 1e-9))
    low, high = np.floor(logs.min()), max(np.ceil(logs.max()), np.floor(logs.min()) + 1)
    left, bottom, width, height = 0.2 * size, 0.13 * size, 0.74 * size, 0.8 * size

    def at(level: ArrayLike, log: ArrayLike) -> FloatArray:
        across = (np.asarray(level) - levels[0]) / max(levels[-1] - levels[0], 1)
        return np.stack([left + width * across, bottom + height * (np.asarray(log) - low) / (high - low)], axis=-1)

    for decade in np.arange(low, high + 1):
        _line(canvas, at([levels[0], levels[-1]], [decade, decade]), _GRID)
        _write(canvas, f"1e{decade:+.0f}", (0.02 * size, at(levels[0], decade)[1] - 5))
    for level in levels:
        _line(canvas, at([level, level], [low, high]), _GRID)
        _write(canvas, str(level), at(level, low) - (3, 18))
    _line(canvas, at(levels, logs[:-1]), _INK, 1.6)
    _dots(canvas, at(levels, logs[:-1]), _INK, 3.2)
    _dots(canvas, at([current[0]], logs[-1:]), _MARK, 6)
    return canvas


def srgb(linear: ArrayLike) -> FloatArray:
    """Encode linear values for display, clipped to 0 to 1 (IEC 61966-2-1).

    Examples
    --------
    >>> srgb([-1, 0, 0.214041, 1, 5]).round(6).tolist()
    [0.0, 0.0, 0.5, 1.0, 1.0]
    """
    clipped = np.clip(np.asarray(linear, dtype=float), 0, 1)
    return np.where(clipped <= 0.0031308, 12.92 * clipped, 1.055 * clipped ** (1 / 2.4) - 0.055)


def _near_plane(samples: Samples, theta_i: float, phi_i: float = 0.0) -> tuple[FloatArray, FloatArray, float]:
    """Samples near the plane of incidence, at the measured angle of incidence nearest to theta_i; of an anisotropic
    material those whose light is near the azimuth phi_i.

    Returns
    -------
    theta_o : (k,) float64
        Negative on the light's side, radians.
    values : (k, channels) float64
    theta_i : float
        Of the samples; nan without any.
    """
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


def _on_arc(theta: ArrayLike) -> FloatArray:
    """Unit vectors in the plot, at angles from the vertical: (...) radians to (..., 2)."""
    return np.stack([np.sin(theta), np.cos(theta)], axis=-1)


def _canvas(size: int) -> SingleArray:
    canvas = np.empty((size, size, 4), dtype=np.float32)
    canvas[...] = (*_BACKGROUND, 1)
    return canvas


def _line(canvas: SingleArray, points: FloatArray, color: _Color, width: float = 1.0) -> None:
    """Draw a polyline as dense dots: points (n, 2) in pixels from the bottom left."""
    steps = np.maximum(np.ceil(2 * np.linalg.norm(np.diff(points, axis=0), axis=1)).astype(int), 1)
    start = np.repeat(points[:-1], steps, axis=0)
    along = np.concatenate([np.arange(count) / count for count in steps])
    dense = start + along[:, None] * np.repeat(np.diff(points, axis=0), steps, axis=0)
    _dots(canvas, np.concatenate([dense, points[-1:]]), color, width)


def _dots(canvas: SingleArray, centers: FloatArray, color: _Color, diameter: float) -> None:
    """Draw antialiased discs at centers (n, 2)."""
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


def _write(canvas: SingleArray, text: str, at: ArrayLike, scale: int = 2) -> None:
    """Draw characters of `_FONT`, their lower left corner at `at` (2,)."""
    column, row = (int(place) for place in np.asarray(at))
    for character in text:
        bits = np.array([[glyph >> 2 & 1, glyph >> 1 & 1, glyph & 1] for glyph in _FONT[character]][::-1], dtype=bool)
        block = np.kron(bits, np.ones((scale, scale), dtype=bool))
        part = canvas[max(row, 0):row + block.shape[0], column:column + block.shape[1]]
        part[block[max(-row, 0):][:part.shape[0], :part.shape[1]], :3] = _INK
        column += 4 * scale

"""Pictures of fits for the panels: (size, size, 4) float32, sRGB with alpha, the bottom row first."""

from collections.abc import Sequence

import numpy as np

from . import studio
from .arrays import ArrayLike, BoolArray, FloatArray, SingleArray
from .colours import DEFAULT, conversion, luminance
from .drawing import GRID, INK, Color, blank, dots, line, write
from .model import Reflectance, is_isotropic
from .published import Published
from .samples import Samples

SIZE = 256
IN_PLANE = np.radians(8)       # samples within this angle of the plane of incidence are plotted
Light = tuple[tuple[float, float, float], float]       # direction to a light far away, and its irradiance / pi
LIGHTS: tuple[Light, ...] = (((-0.5, 0.6, 0.62), 1.0), ((0.9, -0.1, 0.42), 0.25))
_CHANNELS: dict[int, tuple[Color, ...]] = {
    1: ((0.9, 0.9, 0.9),), 3: ((1.0, 0.38, 0.34), (0.45, 0.85, 0.4), (0.42, 0.62, 1.0))}
_MARK = (1.0, 0.75, 0.2)
PAIR: tuple[Color, Color] = ((1.0, 0.6, 0.2), (0.35, 0.7, 1.0))        # of two materials that are compared
_BRIGHTEST = 0.59           # mean of a thumbnail within its outline
_HEM = 0.93                 # half the side of a cloth, over that of its picture
_ORIGIN, _RADIUS = (0.5, 0.27), 0.46       # of a polar plot, over its size


def lit_sphere(fit: Reflectance, size: int = SIZE, lights: Sequence[Light] = (),
               colours: str = DEFAULT, with_tangent: bool = False) -> SingleArray:
    """A sphere of the material in a studio (`studio`), in orthographic view on a transparent background.

    The tangent of an anisotropic material goes around the vertical axis.

    Parameters
    ----------
    size : int
        Pixels.
    lights : sequence of (direction, strength)
        Instead of the studio: far away, the direction to each, and its irradiance / pi. The view is (0, 0, 1).
    colours : str
        One of `colours.COLOURS`: that of the fit.
    with_tangent : bool
        Draw strokes along the tangent of an anisotropic material.

    Returns
    -------
    (size, size, 4) float32
    """
    normal, inside, cover = sphere(size)
    if lights:
        radiance = np.zeros((len(normal), 3))
        for direction, strength in lights:
            radiance += np.pi * strength * reflected(fit, normal, direction)
    else:
        radiance = np.broadcast_to(studio.on_sphere(fit, normal), (len(normal), 3))
    linear = radiance @ conversion(colours, DEFAULT).T
    picture = np.zeros((size, size, 4), dtype=np.float32)
    picture[inside, :3] = srgb(linear if lights else studio.developed(linear))
    picture[..., 3] = cover
    if with_tangent and not is_isotropic(fit):
        for stroke in _strokes(size):
            line(picture, stroke, _MARK, 1.2)
    return picture


def lit_cloth(fit: Reflectance, size: int = SIZE) -> SingleArray:
    """A cloth of the material that hangs in folds, in a studio (`studio`), in orthographic view.

    Folds throw no shadows. Parameters and result are as of `lit_sphere`.
    """
    at = (np.arange(size) + 0.5) / size * 2 - 1
    x, y = np.meshgrid(at, at)
    place = x + 0.22 * y * np.sin(2.2 * x + 0.8)            # across the folds, which lean and widen downward
    slope = 0.75 * np.sin(6.3 * place + 0.6) + 0.3 * np.sin(13.1 * place - 0.9 * y)
    normal = np.stack([-slope, 0.18 * np.cos(5.0 * place + 2.2 * y) + 0.15, np.ones_like(x)], axis=-1)
    normal /= np.linalg.norm(normal, axis=-1, keepdims=True)
    radiance = np.broadcast_to(studio.on_sphere(fit, normal.reshape(-1, 3)), (size * size, 3))
    picture = np.zeros((size, size, 4), dtype=np.float32)
    picture[..., :3] = srgb(studio.developed(radiance)).reshape(size, size, 3)
    beyond = [np.abs(axis) + 0.012 * np.sin(9 * other) - _HEM for axis, other in ((x, y), (y, x))]
    picture[..., 3] = np.clip(0.5 - np.maximum(*beyond) * size / 2, 0, 1)
    return picture


def thumbnail(material: Published, size: int = SIZE) -> SingleArray:
    """The picture of a material of the library: a cloth where it is one, else a sphere; (size, size, 4) float32.

    For what is nearly white it is stopped down, as a photographer does.
    """
    picture = (lit_cloth if "fabric" in material.tags else lit_sphere)(material.model, size)
    cover = picture[..., 3:]
    mean = (picture[..., :3] * cover).sum() / (3 * cover.sum())
    picture[..., :3] *= min(_BRIGHTEST / mean, 1)
    return picture


def split(left: SingleArray, right: SingleArray, at: float = 0.5) -> SingleArray:
    """The left part of one picture beside the right part of another, with a thin line between them.

    Raises ValueError if the pictures have different shapes.

    Parameters
    ----------
    left, right : (height, width, 4) float32
    at : float
        Where the line is: 0 is the left edge, 1 the right one.

    Returns
    -------
    (height, width, 4) float32

    Examples
    --------
    >>> black, white = np.zeros((1, 8, 4), np.float32), np.ones((1, 8, 4), np.float32)
    >>> split(black, white, 0.5)[0, :, 0].round(1).tolist()
    [0.0, 0.0, 0.0, 0.0, 0.9, 1.0, 1.0, 1.0]
    """
    if left.shape != right.shape:
        raise ValueError(f"pictures of {left.shape} and {right.shape}, expected the same shape")
    width = left.shape[1]
    thickness = max(width // 256, 1)
    edge = round(at * width)
    begin = edge - thickness // 2
    picture = left.copy()
    picture[:, max(edge, 0):] = right[:, max(edge, 0):]
    picture[:, max(begin, 0):max(begin + thickness, 0)] = (*INK, 1)
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
    radiance = np.zeros((len(normal), 3))
    radiance[lit] = np.maximum(value, 0) * cos_i[lit, None]
    return radiance


def polar_plot(fit: Reflectance, samples: Samples | None, theta_i: float, size: int = SIZE,
               phi_i: float = 0.0) -> tuple[SingleArray, float]:
    """Plot the fit in the plane of incidence for one angle of incidence, with the samples near that plane.

    Radii are cube roots, so that dark directions beside a high peak are visible. The light comes from the left.

    Parameters
    ----------
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
    theta, curve = in_plane(fit, theta_i, phi_i)
    place, values, shown = (np.zeros(0), curve[:0], float("nan")) if samples is None else (
        near_plane(samples, theta_i, phi_i))
    scale = max(np.cbrt(max(curve.max(), values.max(initial=0))), 1e-6)
    canvas, pen = _polar_grid(size, theta_i), _pen(size)
    colors = _CHANNELS[3 if curve.shape[1] == 3 else 1]
    for c, color in enumerate(colors):
        line(canvas, polar_points(theta, curve[:, c], scale, size), color, 1.4 * pen)
    for c, color in enumerate(colors):
        dots(canvas, polar_points(place, values[:, c], scale, size), color, 2.6 * pen)
    return canvas, shown


def polar_comparison(first: Reflectance, second: Reflectance, theta_i: float, size: int = SIZE, phi_i: float = 0.0,
                     colours: tuple[str, str] = (DEFAULT, DEFAULT)) -> SingleArray:
    """Plot the luminance of two fits in the plane of incidence, over each other, as `polar_plot` does.

    The first is orange and named A, the second blue and named B; both have the same scale.

    Parameters
    ----------
    theta_i : float
        Radians.
    size : int
        Pixels.
    phi_i : float
        Azimuth of the light, radians; of isotropic materials it does not matter.
    colours : (str, str)
        Those of the fits, from `colours.COLOURS`.

    Returns
    -------
    (size, size, 4) float32
    """
    theta, _ = in_plane(first, theta_i, phi_i)
    curves = [np.broadcast_to(in_plane(fit, theta_i, phi_i)[1], (len(theta), 3)) for fit in (first, second)]
    grey = [np.maximum(luminance(curve, space), 0) for curve, space in zip(curves, colours, strict=True)]
    scale = max(np.cbrt(np.max(grey)), 1e-6)
    canvas, pen = _polar_grid(size, theta_i, INK), _pen(size)
    for values, color in zip(grey, PAIR, strict=True):
        line(canvas, polar_points(theta, values, scale, size), color, 1.6 * pen)
    for number, (name, color) in enumerate(zip("AB", PAIR, strict=True)):
        letter = max(round(2 * pen), 1)
        write(canvas, name, (0.03 * size + 5 * letter * number, 0.97 * size - 5 * letter), letter, color)
    return canvas


def in_plane(fit: Reflectance, theta_i: float, phi_i: float = 0.0) -> tuple[FloatArray, FloatArray]:
    """A fit in the plane of incidence, for light from (theta_i, phi_i), radians.

    Returns
    -------
    theta : (n,) float64
        Outgoing angles from -90 to 90 degrees, negative on the light's side; radians.
    value : (n, channels) float64
        1/sr.
    """
    theta = np.linspace(-np.pi / 2, np.pi / 2, 361)
    full = np.full_like(theta, phi_i)
    return theta, fit.evaluate(np.full_like(theta, theta_i), full, np.abs(theta), full + np.where(theta < 0, 0, np.pi))


def polar_points(theta: FloatArray, value: FloatArray, scale: float, size: int) -> FloatArray:
    """Where values stand in a polar plot: (n,) radians and (n,) 1/sr to (n, 2) pixels from the bottom left.

    Radii are cube roots; a value of scale ** 3 lies on the outer circle.

    Examples
    --------
    >>> polar_points(np.array([0.0]), np.array([8.0]), 2.0, 100).round(9).tolist()
    [[50.0, 73.0]]
    """
    length = np.cbrt(np.maximum(value, 0)) / scale * _RADIUS * size
    return np.array(_ORIGIN) * size + length[:, None] * _on_arc(theta)


def _polar_grid(size: int, theta_i: float, ray: Color = _MARK) -> SingleArray:
    """An empty polar plot, with a ray to the light."""
    canvas, origin, radius = blank(size), np.array(_ORIGIN) * size, _RADIUS * size
    for fraction in (0.5, 1.0):
        line(canvas, origin + fraction * radius * _on_arc(np.linspace(-np.pi / 2, np.pi / 2, 91)), GRID, _pen(size))
    for angle in np.radians((-90, -60, -30, 0, 30, 60, 90)):
        line(canvas, origin + np.outer(np.array([0, radius]), _on_arc(angle)), GRID, _pen(size))
    toward_light = np.outer(np.array([0.25 * radius, 1.08 * radius]), _on_arc(-theta_i))
    line(canvas, origin + toward_light, ray, 1.6 * _pen(size))
    return canvas


def _pen(size: int) -> float:
    """The width of lines in a picture, over that in a small one."""
    return max(size / SIZE, 1.0)


def turned_plane(fit: Reflectance, theta_i: float, size: int = SIZE, colours: str = DEFAULT) -> SingleArray:
    """The fit in the plane of incidence, for one angle of incidence, while that plane turns about the normal.

    From left to right the light's azimuth goes through a full turn; from bottom to top the outgoing angle goes from
    grazing on the light's side, through the normal, to grazing opposite the light. Cube roots of f cos theta_o are
    shown, the largest of them as 1. Of an isotropic material all columns are equal.

    Parameters
    ----------
    theta_i : float
        Radians.
    size : int
        Pixels.
    colours : str
        One of `colours.COLOURS`: that of the fit.

    Returns
    -------
    (size, size, 4) float32
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


def srgb(linear: ArrayLike) -> FloatArray:
    """Encode linear values for display, clipped to 0 to 1 (IEC 61966-2-1).

    Examples
    --------
    >>> srgb([-1, 0, 0.214041, 1, 5]).round(6).tolist()
    [0.0, 0.0, 0.5, 1.0, 1.0]
    """
    clipped = np.clip(np.asarray(linear, dtype=float), 0, 1)
    return np.where(clipped <= 0.0031308, 12.92 * clipped, 1.055 * clipped ** (1 / 2.4) - 0.055)


def near_plane(samples: Samples, theta_i: float, phi_i: float = 0.0) -> tuple[FloatArray, FloatArray, float]:
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

"""Pictures of fits for the panels: (size, size, 4) float32, sRGB with alpha, the bottom row first."""

from collections.abc import Sequence

import numpy as np

from ..arrays import ArrayLike, BoolArray, FloatArray, SingleArray
from ..colours import DEFAULT_COLOURS, conversion
from ..model import Reflectance, is_isotropic
from ..model.published import PublishedMaterial
from ..samples import Samples
from . import studio
from .drawing import LINE_INK, Canvas
from .lobe import plane_curve
from .plane_plot import LIGHT, Disc, Plane, Plotted, curves, draw, near_plane

SIZE = 256
Light = tuple[tuple[float, float, float], float]       # direction to a light far away, and its irradiance / pi
SPHERE_LIGHTS: tuple[Light, ...] = (((-0.5, 0.6, 0.62), 1.0), ((0.9, -0.1, 0.42), 0.25))
_BRIGHTEST = 0.59           # mean of a thumbnail within its outline
_HEM = 0.93                 # half the side of a cloth, over that of its picture
_ORIGIN, _PLOT_RADIUS = (0.5, 0.31), 0.385  # of a polar plot, over its size


def lit_sphere(fit: Reflectance, size: int = SIZE, lights: Sequence[Light] = (),
               colours: str = DEFAULT_COLOURS, with_tangent: bool = False) -> SingleArray:
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
            radiance += np.pi * strength * reflected_light(fit, normal, direction)
    else:
        radiance = np.broadcast_to(studio.on_sphere(fit, normal), (len(normal), 3))
    linear = radiance @ conversion(colours, DEFAULT_COLOURS).T
    canvas = Canvas(size)
    canvas.picture[..., :3] = 0
    canvas.picture[inside, :3] = srgb(linear if lights else studio.develop(linear))
    canvas.picture[..., 3] = cover
    # pixels of the edge whose middle is outside would else darken it
    edge = np.argwhere((cover > 0) & ~inside)
    middle = (size - 1) / 2
    inward = np.round(edge - 1.5 * (edge - middle) / np.linalg.norm(edge - middle, axis=1, keepdims=True)).astype(int)
    canvas.picture[edge[:, 0], edge[:, 1], :3] = canvas.picture[inward[:, 0], inward[:, 1], :3]
    if with_tangent and not is_isotropic(fit):
        for stroke in _strokes(size):
            canvas.line(stroke, LIGHT, 1.2)
    return canvas.picture


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
    picture[..., :3] = srgb(studio.develop(radiance)).reshape(size, size, 3)
    beyond = [np.abs(axis) + 0.012 * np.sin(9 * other) - _HEM for axis, other in ((x, y), (y, x))]
    picture[..., 3] = np.clip(0.5 - np.maximum(*beyond) * size / 2, 0, 1)
    return picture


def thumbnail(material: PublishedMaterial, size: int = SIZE) -> SingleArray:
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
    picture[:, max(begin, 0):max(begin + thickness, 0)] = LINE_INK
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


def reflected_light(fit: Reflectance, normal: FloatArray, direction: ArrayLike) -> FloatArray:
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
    >>> from ..methods import prior
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


def polar_plot(fits: Sequence[Plotted], samples: Samples | None, theta_i: float, size: int = SIZE,
               phi_i: float = 0.0) -> tuple[SingleArray, float]:
    """Plot a fit in the plane of incidence for one angle of incidence, with the samples near that plane (`plane_plot`).

    Of two fits the first is orange, the second blue.

    Parameters
    ----------
    fits : sequence of one or two `Plotted`
    samples : Samples, or None
        Of the first.
    theta_i, phi_i : float
        Of the light, radians; of isotropic materials the azimuth does not matter.
    size : int
        Pixels.

    Returns
    -------
    picture : (size, size, 4) float32
    shown : float
        Angle of incidence of the plotted samples, radians: the measured one nearest to theta_i; nan without any.
    """
    place, values, shown = (None, None, float("nan")) if samples is None else near_plane(samples, theta_i, phi_i)
    near = None if place is None or values is None else (place, values)
    canvas = Canvas(size)
    evaluated = [plane_curve(each.fit, theta_i, phi_i) for each in fits]
    draw(canvas, picture_disc(size), Plane(theta_i, curves(fits, evaluated, theta_i, near)))
    return canvas.picture, shown


def picture_disc(size: int) -> Disc:
    """Where the plane of incidence is in a picture of a size."""
    return Disc(np.array(_ORIGIN) * size, _PLOT_RADIUS * size, size / SIZE)


def turned_plane(fit: Reflectance, theta_i: float, size: int = SIZE, colours: str = DEFAULT_COLOURS) -> SingleArray:
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
    linear = np.broadcast_to(np.maximum(value, 0), (phi.size, 3)) @ conversion(colours, DEFAULT_COLOURS).T
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

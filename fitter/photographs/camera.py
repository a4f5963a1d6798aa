"""A camera's rays: directions through the centres of its pixels, by perspective without distortion of a lens."""

import numpy as np

from ..arrays import ArrayLike, FloatArray
from ..errors import DatasetError


def rays(height: int, width: int, field_of_view: float, orientation: ArrayLike | None = None) -> FloatArray:
    """The directions from a camera through the centres of its pixels.

    Parameters
    ----------
    height, width : int
        Pixels; square ones.
    field_of_view : float
        The angle that the width of the picture takes, radians, above 0 and below pi.
    orientation : (3, 3) array_like, optional
        The rotation from the camera's axes to those of the scene. A camera looks along -z, x is to the right and y up.

    Returns
    -------
    (height, width, 3) float64
        Unit vectors; the top row first.

    Examples
    --------
    >>> rays(1, 2, np.pi / 2)[0].round(3).tolist()
    [[-0.447, 0.0, -0.894], [0.447, 0.0, -0.894]]
    """
    across, down = np.meshgrid(np.arange(width) + 0.5, np.arange(height) + 0.5)
    directions = rays_through(np.stack([across, down], axis=-1), (height, width), field_of_view)
    return np.asarray(directions if orientation is None else directions @ np.asarray(orientation, dtype=float).T)


def rays_through(places: FloatArray, size: tuple[int, int], field_of_view: float) -> FloatArray:
    """Unit vectors, in the camera's axes, through places (..., 2) of a picture of this height and width: pixels from
    its left edge, and from its top."""
    if not 0 < field_of_view < np.pi:
        raise DatasetError(f"a field of view of {np.degrees(field_of_view):g} degrees found, expected 0 to 180")
    (height, width), step = size, 2 * np.tan(field_of_view / 2) / size[1]
    x, y = step * (places[..., 0] - width / 2), step * (height / 2 - places[..., 1])
    directions = np.stack([x, y, -np.ones_like(x)], axis=-1)
    return np.asarray(directions / np.linalg.norm(directions, axis=-1, keepdims=True))


def places_of(directions: FloatArray, size: tuple[int, int], field_of_view: float) -> FloatArray:
    """The inverse of `rays_through`: where directions (..., 3) in the camera's axes are, pixels, (..., 2).

    Examples
    --------
    >>> places_of(rays_through(np.array([[3.0, 7.5]]), (20, 30), 1.0), (20, 30), 1.0).round(9).tolist()
    [[3.0, 7.5]]
    """
    step = 2 * np.tan(field_of_view / 2) / size[1]
    x, y = (directions[..., axis] / -directions[..., 2] / step for axis in (0, 1))
    return np.stack([size[1] / 2 + x, size[0] / 2 - y], axis=-1)


def field_of_view(focal_length: float, sensor_width: float) -> float:
    """The angle that a sensor takes behind a lens, radians; both lengths in one unit."""
    return 2 * float(np.arctan(sensor_width / (2 * focal_length)))


def looking(position: ArrayLike, target: ArrayLike, up: ArrayLike = (0, 0, 1)) -> FloatArray:
    """The orientation of a camera that looks from a position to a target: (3, 3), as `rays` takes it."""
    back = np.asarray(position, dtype=float) - np.asarray(target, dtype=float)
    right = np.cross(np.asarray(up, dtype=float), back)
    lengths = np.linalg.norm(back), np.linalg.norm(right)
    if not lengths[0]:
        raise DatasetError("the camera stands at the point that it looks at")
    if lengths[1] < 1e-9 * lengths[0]:
        raise DatasetError("the camera looks along the direction that is up in its picture")
    z, x = back / lengths[0], right / lengths[1]
    return np.stack([x, np.cross(z, x), z], axis=1)


def pixel_angle(directions: FloatArray) -> float:
    """The angle between rays of neighbouring pixels, the median over the picture: (h, w, 3) to radians."""
    along = [np.linalg.norm(np.diff(directions, axis=axis), axis=-1).ravel() for axis in (0, 1)]
    steps = np.concatenate(along)
    return float(np.median(steps)) if len(steps) else np.pi

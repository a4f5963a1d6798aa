"""The closest surface that images of base colour, roughness and metallic can hold, and how far it is from a fit."""

import numpy as np

from ..arrays import ArrayLike, FloatArray
from ..imaging import studio
from ..model import Reflectance
from ..quality import verdict
from .principled import fit_without_layers
from .principled_bsdf import Principled

_SPHERE_PIXELS = 32         # pixels of a sphere by which a surface is judged


def fit_metallic_roughness(fit: Reflectance) -> Principled:
    """The Principled BSDF of base colour, roughness and metallic alone with the least `difference`: it has no sheen and
    no coat, and the reflectance of an index of refraction of 1.5 where it is no metal.

    Examples
    --------
    >>> from ..methods import prior
    >>> found = fit_metallic_roughness(prior.lambertian(np.array([[0.8 / np.pi]])))
    >>> found.specular_level, found.coat_weight, found.metallic < 0.01
    (0.5, 0.0, True)
    """
    return min(fit_without_layers(fit), key=lambda inputs: difference(fit, inputs))


def difference(fit: Reflectance, inputs: Principled, factor: ArrayLike = 1.0) -> float:
    """How far a sphere of a Principled BSDF in the studio of thumbnails is from one of a fit times a colour, (3,): the
    root mean square in steps of lightness, as `verdict` counts them.

    Examples
    --------
    >>> from ..methods import prior
    >>> grey = Principled(np.full(3, 0.216), 1.0, 0.0, 0.0)
    >>> fit = prior.lambertian(np.array([[0.125 / np.pi]]))
    >>> round(difference(fit, grey), 3), round(difference(fit, grey, 0.216 / 0.125), 3)
    (10.0, 0.0)
    """
    white = _sphere_picture(Principled(np.ones(3), 1.0, 0.0, 0.0))
    one, other = (np.clip(np.cbrt(np.maximum(shown, 0) / white), 0, verdict.BRIGHTEST)
                  for shown in (_sphere_picture(fit) * np.asarray(factor), _sphere_picture(inputs)))
    return 100 * float(np.sqrt(np.mean((one - other) ** 2)))


def _sphere_picture(model: Reflectance) -> FloatArray:
    """What the sphere shows at the middles of the pixels within it: (n, 3)."""
    x, y = np.meshgrid(*(2 * [(2 * np.arange(_SPHERE_PIXELS) + 1) / _SPHERE_PIXELS - 1]))
    flat = np.stack([x, y], axis=-1)[x ** 2 + y ** 2 < 1]
    shown = studio.on_sphere(model, np.column_stack([flat, np.sqrt(1 - (flat ** 2).sum(axis=1))]))
    return np.broadcast_to(shown, (len(flat), 3))

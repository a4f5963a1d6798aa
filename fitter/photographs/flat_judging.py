"""What photographs of a flat sample are judged by: predictions of those that were left out, also by texels that are each
for itself.

Those are a Lambertian, and a polynomial texture map (PTM: T. Malzbender, D. Gelb, H. Wolters: Polynomial Texture Maps,
SIGGRAPH 2001), which is a polynomial of second degree in the direction to the lamp.
"""

from collections.abc import Callable

import numpy as np

from ..arrays import FloatArray
from .flat_photograph import Observed

UNCONSTRAINED = "Lambertian", "PTM"
_RIDGE = 1e-6
_LEAST_SEEN = 10            # values of a photograph that can be judged


def relative_errors(expected: FloatArray, seen: Observed) -> list[float]:
    """How far each photograph that tells of enough texels is from what is expected of it, (n, p, channels), of its root
    mean square."""
    good = seen.good[..., None]
    off, size = (np.sqrt((np.where(good, each, 0) ** 2).sum(axis=(0, 2))) for each in (
        expected - seen.radiance, seen.radiance))
    told = (seen.good.sum(axis=0) >= _LEAST_SEEN) & (size > 0)
    return [float(each) for each in off[told] / size[told]]


def unconstrained(used: Observed, other: Observed, frame: FloatArray) -> dict[str, FloatArray]:
    """What a Lambertian and a PTM of each texel and channel expect of other photographs: (n, p, channels) each."""
    return {name: np.maximum(_linear(basis, used, other, frame), 0) * other.lit.brought
            for name, basis in zip(UNCONSTRAINED, (_lambertian, _polynomial), strict=True)}


def _linear(basis: Callable[[FloatArray], FloatArray], used: Observed, other: Observed,
            frame: FloatArray) -> FloatArray:
    there, here = (basis(seen.lit.light @ frame.T) for seen in (other, used))
    weight = used.good.astype(float)
    gram = np.einsum("np,npi,npj->nij", weight, here, here)
    gram += (_RIDGE * np.trace(gram, axis1=1, axis2=2) + np.finfo(float).tiny)[:, None, None] * np.eye(gram.shape[1])
    right = np.einsum("np,npi,npc->nic", weight, here, used.radiance / used.lit.brought)
    return np.asarray(np.einsum("npi,nic->npc", there, np.linalg.solve(gram, right)))


def _lambertian(light: FloatArray) -> FloatArray:
    return light


def _polynomial(light: FloatArray) -> FloatArray:
    x, y = light[..., 0], light[..., 1]
    return np.stack([x * x, y * y, x * y, x, y, np.ones_like(x)], axis=-1)

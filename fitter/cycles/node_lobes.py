"""The lobes of Blender's closure nodes, as Cycles evaluates them.

A lobe stands on a normal of its own, turned in the plane of the viewer: with n the surface's normal and wo the
direction of the viewer, that of a tilt s is (1 - s) n + s wo, made a unit vector. So s = 0 leaves it alone, s = 1 makes
a lobe that looks back, and a negative s turns it toward the horizon on the mirror side.

- *diffuse*: a Diffuse BSDF, the cosine over pi.
- *GGX*, *Beckmann*: a Glossy BSDF of that distribution, with height-correlated masking and no Fresnel term (B. Walter
  et al.: Microfacet Models for Refraction through Rough Surfaces, EGSR 2007; E. Heitz: Understanding the
  Masking-Shadowing Function in Microfacet-Based BRDFs, JCGT 3(2), 2014). Its widths along the tangent and across it are
  alpha (1 - a) and alpha / (1 - a) for an anisotropy a that is not negative, and alpha / (1 + a) and alpha (1 + a)
  otherwise, at most 1; alpha is the square of the roughness.
- *sheen*: a Sheen BSDF of M. Ashikhmin, S. Premoze, P. Shirley (A Microfacet-Based BRDF Generator, SIGGRAPH 2000). It
  stands on the surface's normal.
"""

from typing import Literal, NamedTuple

import numpy as np

from ..arrays import FloatArray
from ..shader_constants import LEAST_COSINE, STEEPEST_FACET

Kind = Literal["diffuse", "GGX", "Beckmann", "sheen"]
FACETS: tuple[Kind, ...] = ("GGX", "Beckmann")
_NO_LENGTH = 1e-9


class Pairs(NamedTuple):
    """Pairs of a viewing and many incident directions, unit vectors where z is the normal.

    Attributes
    ----------
    wo : (..., 3)
    wi : (..., n, 3)
    half : (..., n, 3)
        Their half vectors.
    tangent : (..., 3)
        Of the lobes; it need not be perpendicular to their normals.
    """

    wo: FloatArray
    wi: FloatArray
    half: FloatArray
    tangent: FloatArray

    @classmethod
    def of(cls, wo: FloatArray, wi: FloatArray, tangent: FloatArray) -> "Pairs":
        """Pairs with their half vectors."""
        half = wi + wo[..., None, :]
        return cls(wo, wi, half / np.maximum(np.linalg.norm(half, axis=-1, keepdims=True), _NO_LENGTH), tangent)


class Shape(NamedTuple):
    """The shape of a lobe for each viewing direction; arrays that broadcast to (...).

    Attributes
    ----------
    roughness, tilt, anisotropy : FloatArray
        As the nodes have them, the roughness from 0 to 1 and the anisotropy from -1 to 1.
    """

    roughness: FloatArray
    tilt: FloatArray
    anisotropy: FloatArray


def evaluate(kind: Kind, shape: Shape, pairs: Pairs) -> FloatArray:
    """Reflected radiance, the value of the closure with a white colour: (..., n), 0 below the horizon of the lobe.

    Examples
    --------
    At normal incidence and reflection a GGX lobe is 1 / (4 pi alpha^2):

    >>> up = np.array([[0.0, 0.0, 1.0]])
    >>> pairs = Pairs.of(up, up[:, None], np.array([[1.0, 0.0, 0.0]]))
    >>> flat = Shape(np.array([0.5]), np.array([0.0]), np.array([0.0]))
    >>> round(float(evaluate("GGX", flat, pairs)[0, 0]), 6), round(1 / (4 * np.pi * 0.5 ** 4), 6)
    (1.27324, 1.27324)
    """
    if kind == "sheen":
        return _sheen(shape.roughness, pairs)
    normal = normals(shape.tilt, pairs.wo)
    if kind == "diffuse":
        return np.asarray(np.maximum((pairs.wi @ normal[..., None])[..., 0], 0) / np.pi)
    return _facets(kind, shape, normal, pairs)


def normals(tilt: FloatArray, wo: FloatArray) -> FloatArray:
    """The normals of lobes, unit vectors: tilts that broadcast to (...), and (..., 3), to (..., 3)."""
    normal = np.asarray(tilt)[..., None] * wo
    normal[..., 2] += 1 - np.asarray(tilt)
    return np.asarray(normal / np.maximum(np.linalg.norm(normal, axis=-1, keepdims=True), _NO_LENGTH))


def widths(shape: Shape) -> tuple[FloatArray, FloatArray]:
    """The widths of a microfacet lobe along its tangent and across it."""
    alpha, narrower = shape.roughness ** 2, 1 - np.abs(shape.anisotropy)
    along = np.where(shape.anisotropy < 0, alpha / narrower, alpha * narrower)
    across = np.where(shape.anisotropy < 0, alpha * narrower, alpha / narrower)
    return np.minimum(along, 1), np.minimum(across, 1)


def density(kind: Kind, shape: Shape, pairs: Pairs) -> FloatArray:
    """The density, per solid angle of wi, with which the shader samples a lobe: (..., n).

    Of a microfacet lobe, that of half vectors about its normal, as many as there are microfacets; those that face away
    from the viewer reflect too, as if they were turned round. Of a diffuse lobe, the cosine; of sheen, all directions
    above the horizon evenly.
    """
    if kind == "sheen":
        return np.full(pairs.wi.shape[:-1], 1 / (2 * np.pi))
    normal = normals(shape.tilt, pairs.wo)
    if kind == "diffuse":
        return np.asarray(np.maximum((pairs.wi @ normal[..., None])[..., 0], 0) / np.pi)
    cosine = np.maximum((pairs.half * pairs.wi).sum(axis=-1), _NO_LENGTH)
    distribution, h = _distribution(kind, shape, _frame(normal, pairs.tangent), pairs)
    return np.asarray(distribution * np.abs(h[..., 2]) / (4 * cosine))


def _frame(normal: FloatArray, tangent: FloatArray) -> FloatArray:
    """The axes of lobes as columns: (..., 3, 3)."""
    across = np.cross(normal, tangent)
    across = across / np.maximum(np.linalg.norm(across, axis=-1, keepdims=True), _NO_LENGTH)
    return np.stack([np.cross(across, normal), across, normal], axis=-1)


def _distribution(kind: Kind, shape: Shape, frame: FloatArray, pairs: Pairs) -> tuple[FloatArray, FloatArray]:
    """The density of microfacets at half vectors or, where these are below the horizon of the lobe, at their opposites,
    per solid angle of these, (..., n), and these in the frame of the lobe, (..., n, 3)."""
    h = pairs.half @ frame
    along, across = (width[..., None] for width in widths(shape))
    cosine2 = np.maximum(np.abs(h[..., 2]), LEAST_COSINE) ** 2
    slope2 = ((h[..., 0] / along) ** 2 + (h[..., 1] / across) ** 2) / cosine2
    facets = np.exp(-np.minimum(slope2, STEEPEST_FACET)) if kind == "Beckmann" else 1 / (1 + slope2) ** 2
    return facets / (np.pi * along * across * cosine2 ** 2), h


def _facets(kind: Kind, shape: Shape, normal: FloatArray, pairs: Pairs) -> FloatArray:
    frame = _frame(normal, pairs.tangent)
    distribution, _ = _distribution(kind, shape, frame, pairs)
    i, o = pairs.wi @ frame, (pairs.wo[..., None, :] @ frame)
    along, beside = (width[..., None] for width in widths(shape))

    def slopes2(w: FloatArray) -> FloatArray:
        height = np.maximum(w[..., 2], LEAST_COSINE)
        return np.asarray(((w[..., 0] * along) ** 2 + (w[..., 1] * beside) ** 2) / height ** 2)

    smith = _smith_beckmann if kind == "Beckmann" else _smith_ggx
    masking = 1 + smith(slopes2(i)) + smith(slopes2(o))
    value = distribution / (4 * np.maximum(o[..., 2], LEAST_COSINE) * masking)
    return np.where((i[..., 2] > LEAST_COSINE) & (o[..., 2] > 0), value, 0)


def _smith_ggx(slope2: FloatArray) -> FloatArray:
    """Smith's Lambda, from the squared tangent of a direction times the width."""
    return np.asarray((np.sqrt(1 + slope2) - 1) / 2)


def _smith_beckmann(slope2: FloatArray) -> FloatArray:
    """The same for Beckmann's distribution, by Walter's rational approximation, which Cycles has."""
    a = 1 / np.sqrt(np.maximum(slope2, _NO_LENGTH))
    return np.where(a < 1.6, (1 - 1.259 * a + 0.396 * a * a) / (3.535 * a + 2.181 * a * a), 0)


def _sheen(roughness: FloatArray, pairs: Pairs) -> FloatArray:
    sigma2 = np.maximum(roughness, 0.01)[..., None] ** 2
    cos_i, cos_o, cos_h = pairs.wi[..., 2], np.maximum(pairs.wo[..., None, 2], LEAST_COSINE), pairs.half[..., 2]
    cos_d = np.maximum((pairs.half * pairs.wi).sum(axis=-1), _NO_LENGTH)
    masking = np.minimum(1, 2 * np.maximum(cos_h / cos_d, 1e-5) * np.minimum(cos_o, np.maximum(cos_i, 0)))
    sine2 = np.maximum(1 - cos_h ** 2, _NO_LENGTH)
    density = np.exp(-np.minimum(cos_h ** 2 / (sine2 * sigma2), STEEPEST_FACET)) / (np.pi * sigma2 * sine2 ** 2)
    return np.where(cos_i > 0, 0.25 * density * masking / cos_o, 0)

"""The lobes of Blender's closure nodes, as Cycles evaluates them.

A lobe stands on a normal of its own: with n the surface's normal and wo the direction of the viewer, that of a tilt s
is (1 - s) n + s wo, made a unit vector. So s = 1 makes a lobe that looks back, and a negative s turns it toward the
horizon on the mirror side.

- *diffuse*: a Diffuse BSDF, the cosine over pi.
- *GGX*, *Beckmann*: a Glossy BSDF of that distribution, with height-correlated masking and no Fresnel term (B. Walter
  et al.: Microfacet Models for Refraction through Rough Surfaces, EGSR 2007; E. Heitz: Understanding the
  Masking-Shadowing Function in Microfacet-Based BRDFs, JCGT 3(2), 2014). Its widths along the tangent and across it are
  alpha (1 - a) and alpha / (1 - a) for an anisotropy a that is not negative, and alpha / (1 + a) and alpha (1 + a)
  otherwise, at most 1; alpha is the square of the roughness.
- *sheen*: a Sheen BSDF of M. Ashikhmin, S. Premoze, P. Shirley (A Microfacet-Based BRDF Generator, SIGGRAPH 2000), on
  the surface's normal.
"""

from collections.abc import Sequence
from typing import Literal, NamedTuple

import numpy as np

from ..arrays import RealArray
from ..shader_constants import LEAST_COSINE, STEEPEST_FACET

Kind = Literal["diffuse", "GGX", "Beckmann", "sheen"]
FACETS: tuple[Kind, ...] = ("GGX", "Beckmann")
_NO_LENGTH = 1e-9


class Pairs(NamedTuple):
    """Pairs of a viewing and many incident directions, unit vectors where z is the normal."""

    wo: RealArray           # (..., 3)
    wi: RealArray           # (..., n, 3)
    half: RealArray         # their half vectors, (..., n, 3)
    tangent: RealArray      # of the lobes, (..., 3); it need not be perpendicular to their normals

    @classmethod
    def make(cls, wo: RealArray, wi: RealArray, tangent: RealArray) -> "Pairs":
        """Pairs with their half vectors. Each component of many vectors is contiguous in memory."""
        wi = _components_first(wi)
        return cls(wo, wi, _components_first(_unit(wi + wo[..., None, :])), tangent)

    def to_single(self) -> "Pairs":
        """The same in single precision."""
        return Pairs(*(_components_first(each.astype(np.float32)) for each in self))

    def select(self, views: slice, directions: slice) -> "Pairs":
        """Some of the viewing directions, and of the incident ones of each."""
        return Pairs(self.wo[views], _components_first(self.wi[views, ..., directions, :]),
                     _components_first(self.half[views, ..., directions, :]), self.tangent[views])


def _components_first(vectors: RealArray) -> RealArray:
    return np.asarray(np.moveaxis(np.ascontiguousarray(np.moveaxis(vectors, -1, 0)), 0, -1))


def _dot(vectors: RealArray, others: RealArray) -> RealArray:
    """Products of vectors that broadcast: (..., 3) to (...)."""
    total = vectors[..., 0] * others[..., 0]
    total += vectors[..., 1] * others[..., 1]
    total += vectors[..., 2] * others[..., 2]
    return np.asarray(total)


def _cross(vectors: RealArray, others: RealArray) -> RealArray:
    """Cross products, as `numpy.cross` has them for any axis, which takes its time: (..., 3)."""
    x, y, z = (vectors[..., a] * others[..., b] - vectors[..., b] * others[..., a] for a, b in ((1, 2), (2, 0), (0, 1)))
    return np.stack([x, y, z], axis=-1)


def _length(vectors: RealArray) -> RealArray:
    return np.maximum(np.sqrt(_dot(vectors, vectors)), _NO_LENGTH)[..., None]


def _unit(vectors: RealArray) -> RealArray:
    return np.asarray(vectors / _length(vectors))


class Shape(NamedTuple):
    """The shape of a lobe for each viewing direction, as the nodes have it; arrays that broadcast to (...)."""

    roughness: RealArray        # 0 to 1
    normal_offset: RealArray    # the tilt
    anisotropy: RealArray       # -1 to 1


def evaluate(kind: Kind, shape: Shape, pairs: Pairs) -> RealArray:
    """Reflected radiance, the value of the closure with a white colour: (..., n), 0 below the horizon of the lobe."""
    if kind == "sheen":
        return _sheen(shape.roughness, pairs)[0]
    if kind == "diffuse":
        return _cosine_lobe(shape.normal_offset, pairs)
    return _facets(kind, shape, pairs).value


def gradient(kind: Kind, shape: Shape, pairs: Pairs) -> RealArray:
    """The derivatives of `evaluate`: (3, ..., n), by the logarithm of the roughness, by the tilt, and by minus the
    logarithm of 1 less the anisotropy's size, with its sign."""
    if kind == "sheen":
        of_roughness = _sheen(shape.roughness, pairs)[1]
        return np.stack([of_roughness, 0 * of_roughness, 0 * of_roughness])
    if kind == "diffuse":
        normal, moved = normals(shape.normal_offset, pairs.wo), _normals_by_tilt(shape.normal_offset, pairs.wo)
        lit = _dot(pairs.wi, normal[..., None, :]) > 0
        of_tilt = np.where(lit, _dot(pairs.wi, moved[..., None, :]) / np.pi, 0)
        return np.stack([0 * of_tilt, of_tilt, 0 * of_tilt])
    return _gradient_of_facets(_facets(kind, shape, pairs), shape, pairs)


def normals(tilt: RealArray, wo: RealArray) -> RealArray:
    """The normals of lobes, unit vectors: tilts that broadcast to (...), and (..., 3), to (..., 3)."""
    normal = np.asarray(tilt)[..., None] * wo
    normal[..., 2] += 1 - np.asarray(tilt)
    return _unit(normal)


def _normals_by_tilt(tilt: RealArray, wo: RealArray) -> RealArray:
    """The derivatives of `normals` by the tilt: (..., 3)."""
    whole, moved = tilt[..., None] * wo, np.array(wo)
    whole[..., 2] += 1 - tilt
    moved[..., 2] -= 1
    return _unit_vector_derivative(whole, moved)


def _unit_vector_derivative(vector: RealArray, moved: RealArray) -> RealArray:
    """The derivative of a vector made a unit vector, from that of the vector: (..., 3)."""
    length, unit = _length(vector), _unit(vector)
    return np.asarray((moved - unit * _dot(unit, moved)[..., None]) / length)


def widths(shape: Shape) -> tuple[RealArray, RealArray]:
    """The widths of a microfacet lobe along its tangent and across it."""
    alpha, narrower = shape.roughness ** 2, 1 - np.abs(shape.anisotropy)
    along = np.where(shape.anisotropy < 0, alpha / narrower, alpha * narrower)
    across = np.where(shape.anisotropy < 0, alpha * narrower, alpha / narrower)
    return np.minimum(along, 1), np.minimum(across, 1)


def pdf(kind: Kind, shape: Shape, pairs: Pairs) -> RealArray:
    """The pdf, per solid angle of wi, with which the shader samples a lobe: (..., n). Of a microfacet lobe, that of
    half vectors about its normal, as many as there are microfacets (those that face away from the viewer reflect too);
    of a diffuse lobe, the cosine; of sheen, an even one above the horizon."""
    if kind == "sheen":
        return np.full(pairs.wi.shape[:-1], 1 / (2 * np.pi))
    if kind == "diffuse":
        return _cosine_lobe(shape.normal_offset, pairs)
    facets, cosine = _facets(kind, shape, pairs), np.maximum(_dot(pairs.half, pairs.wi), _NO_LENGTH)
    return np.asarray(facets.distribution * np.abs(facets.h[2]) / (4 * cosine))


def _cosine_lobe(tilt: RealArray, pairs: Pairs) -> RealArray:
    return np.asarray(np.maximum(_dot(pairs.wi, normals(tilt, pairs.wo)[..., None, :]), 0) / np.pi)


def _frame(normal: RealArray, tangent: RealArray) -> RealArray:
    """The axes of lobes as columns: (..., 3, 3)."""
    across = _unit(_cross(normal, tangent))
    return np.stack([_cross(across, normal), across, normal], axis=-1)


def _frame_by_normal(normal: RealArray, moved: RealArray, tangent: RealArray) -> RealArray:
    """The derivative of `_frame`, from that of the normal: (..., 3, 3)."""
    across = _cross(normal, tangent)
    unit, unit_moved = _unit(across), _unit_vector_derivative(across, _cross(moved, tangent))
    return np.stack([_cross(unit_moved, normal) + _cross(unit, moved), unit_moved, moved], axis=-1)


class _Facets(NamedTuple):
    """A microfacet lobe, and what it is made of; vectors are three arrays (..., n), in the frame of the lobe."""

    kind: Kind
    frame: RealArray                    # (..., 3, 3)
    h: tuple[RealArray, ...]            # half vectors
    i: tuple[RealArray, ...]            # incident directions
    o: tuple[RealArray, ...]            # viewing directions, (..., 1)
    squares: tuple[RealArray, ...]      # of the components of h along and across, in widths of the lobe
    height2: RealArray                  # of h
    distribution: RealArray             # the density of microfacets at h, or at -h below the horizon of the lobe
    masking: RealArray                  # 1 + Lambda of both directions
    value: RealArray


def _facets(kind: Kind, shape: Shape, pairs: Pairs) -> _Facets:
    frame = _frame(normals(shape.normal_offset, pairs.wo), pairs.tangent)
    h, i, o = (tuple(_dot(vectors, frame[..., None, :, axis]) for axis in range(3))
               for vectors in (pairs.half, pairs.wi, pairs.wo[..., None, :]))
    along, across = (width[..., None] for width in widths(shape))
    squares = (h[0] / along) ** 2, (h[1] / across) ** 2
    height2 = np.maximum(np.abs(h[2]), LEAST_COSINE) ** 2
    if kind == "Beckmann":
        distribution = np.exp(-np.minimum((squares[0] + squares[1]) / height2, STEEPEST_FACET)) / height2 ** 2
    else:
        distribution = 1 / (height2 + squares[0] + squares[1]) ** 2
    distribution /= np.pi * along * across
    smith = _smith_beckmann if kind == "Beckmann" else _smith_ggx
    masking = smith(_slope2(i, along, across)) + (1 + smith(_slope2(o, along, across)))
    value = distribution / (4 * np.maximum(o[2], LEAST_COSINE) * masking)
    seen = (i[2] > LEAST_COSINE) & (o[2] > 0)
    return _Facets(kind, frame, h, i, o, squares, height2, distribution, masking, value * seen)


def _slope2(w: Sequence[RealArray], along: RealArray, across: RealArray) -> RealArray:
    """The squared tangents of directions, times the widths."""
    return np.asarray(((w[0] * along) ** 2 + (w[1] * across) ** 2) / np.maximum(w[2], LEAST_COSINE) ** 2)


def _gradient_of_facets(facets: _Facets, shape: Shape, pairs: Pairs) -> RealArray:
    """`gradient`, by the logarithms of the two widths and by a rotation of the frame."""
    normal, moved = facets.frame[..., 2], _normals_by_tilt(shape.normal_offset, pairs.wo)
    rotation = np.swapaxes(facets.frame, -1, -2) @ _frame_by_normal(normal, moved, pairs.tangent)
    # the half vector, and its derivative as the frame rotates
    sizes = [width[..., None] for width in widths(shape)]
    h, h_moved = facets.h, _rotate_components(facets.h, rotation)
    leaned = h[0] * h_moved[0] / sizes[0] ** 2 + h[1] * h_moved[1] / sizes[1] ** 2
    raised = np.where(np.abs(h[2]) > LEAST_COSINE, h[2] * h_moved[2], 0)
    steepness = facets.squares[0] + facets.squares[1]
    if facets.kind == "Beckmann":       # the derivatives of the logarithm of the distribution
        slope2 = steepness / facets.height2
        shallow = slope2 < STEEPEST_FACET
        of_widths = [2 * shallow * square / facets.height2 - 1 for square in facets.squares]
        of_tilt = (shallow * (2 * slope2 * raised - 2 * leaned) - 4 * raised) / facets.height2
        smith = _smith_beckmann_slope
    else:
        whole = 4 / (facets.height2 + steepness)
        of_widths = [whole * square - 1 for square in facets.squares]
        of_tilt = -whole * (leaned + raised)
        smith = _smith_ggx_slope
    for w in (facets.i, facets.o):      # and of that of the masking
        w_moved, height = _rotate_components(w, rotation), np.maximum(w[2], LEAST_COSINE)
        tangent2 = _slope2(w, *sizes)
        by_slope2 = smith(tangent2) / facets.masking
        factor = 2 * by_slope2 / height ** 2
        along, across = ((w[axis] * size) ** 2 for axis, size in enumerate(sizes))
        of_widths = [each - factor * square for each, square in zip(of_widths, (along, across), strict=True)]
        of_tilt = of_tilt - factor * (w[0] * w_moved[0] * sizes[0] ** 2 + w[1] * w_moved[1] * sizes[1] ** 2)
        of_height = np.where(w[2] > LEAST_COSINE, w_moved[2] / height, 0)
        of_tilt = of_tilt + 2 * by_slope2 * tangent2 * of_height
    of_tilt = of_tilt - of_height
    along, across = (each * (size < 1) for each, size in zip(of_widths, sizes, strict=True))
    return np.stack([facets.value * each for each in (2 * (along + across), of_tilt, across - along)])


def _rotate_components(w: Sequence[RealArray], rotation: RealArray) -> tuple[RealArray, ...]:
    """The derivatives of components in a frame, from those of its axes in these axes: (..., 3, 3), antisymmetric."""
    xy, xz, yz = (rotation[..., None, row, column] for row, column in ((0, 1), (0, 2), (1, 2)))
    return -xy * w[1] - xz * w[2], xy * w[0] - yz * w[2], xz * w[0] + yz * w[1]


def _smith_ggx(slope2: RealArray) -> RealArray:
    """Smith's Lambda, from the squared tangent of a direction times the width."""
    return np.asarray((np.sqrt(1 + slope2) - 1) / 2)


def _smith_ggx_slope(slope2: RealArray) -> RealArray:
    return np.asarray(0.25 / np.sqrt(1 + slope2))


def _smith_beckmann(slope2: RealArray) -> RealArray:
    """The same for Beckmann's distribution, by Walter's rational approximation, which Cycles has."""
    a = 1 / np.sqrt(np.maximum(slope2, _NO_LENGTH))
    return np.where(a < 1.6, (1 - 1.259 * a + 0.396 * a * a) / (3.535 * a + 2.181 * a * a), 0)


def _smith_beckmann_slope(slope2: RealArray) -> RealArray:
    a = 1 / np.sqrt(np.maximum(slope2, _NO_LENGTH))
    above, below = 1 - 1.259 * a + 0.396 * a * a, 3.535 * a + 2.181 * a * a
    by_a = ((0.792 * a - 1.259) * below - above * (3.535 + 4.362 * a)) / below ** 2
    return np.where(a < 1.6, -0.5 * a ** 3 * by_a, 0)


def _sheen(roughness: RealArray, pairs: Pairs) -> tuple[RealArray, RealArray]:
    """The value of sheen, and its derivative by the logarithm of the roughness."""
    sigma2 = np.maximum(roughness, 0.01)[..., None] ** 2
    cos_i, cos_o, cos_h = pairs.wi[..., 2], np.maximum(pairs.wo[..., None, 2], LEAST_COSINE), pairs.half[..., 2]
    cos_d = np.maximum(_dot(pairs.half, pairs.wi), _NO_LENGTH)
    masking = np.minimum(1, 2 * np.maximum(cos_h / cos_d, 1e-5) * np.minimum(cos_o, np.maximum(cos_i, 0)))
    sine2 = np.maximum(1 - cos_h ** 2, _NO_LENGTH)
    steepness = cos_h ** 2 / (sine2 * sigma2)
    density = np.exp(-np.minimum(steepness, STEEPEST_FACET)) / (np.pi * sigma2 * sine2 ** 2)
    value = np.where(cos_i > 0, 0.25 * density * masking / cos_o, 0)
    return value, value * (2 * steepness * (steepness < STEEPEST_FACET) - 2)

"""One microfacet lobe with the GGX distribution over a Lambertian: what most renderers and most researchers start from.

B. Walter, S. R. Marschner, H. Li, K. E. Torrance: Microfacet Models for Refraction through Rough Surfaces, EGSR 2007,
with the height-correlated visibility of E. Heitz: Understanding the Masking-Shadowing Function in Microfacet-Based
BRDFs, JCGT 3(2), 2014, and the Fresnel term of C. Schlick: An Inexpensive BRDF Model for Physically-based Rendering,
1994. Each channel has a diffuse reflectance kd and a reflectance F0 at normal incidence; all share a width alpha ::

    f = kd + D(theta_h) F(theta_d) V(theta_i, theta_o),    D = alpha^2 / (pi ((alpha^2 - 1) cos^2 theta_h + 1)^2)
    V = 1 / (2 (cos theta_o L(theta_i) + cos theta_i L(theta_o))),    L = sqrt(alpha^2 + (1 - alpha^2) cos^2 theta)

Fitted to the cube root of cosine-weighted reflectance by SciPy's least squares from several starts. Widths that differ
by channel predict held-out samples no better.
"""

from dataclasses import dataclass
from itertools import product

import numpy as np
from scipy.optimize import least_squares

from fitter.arrays import ArrayLike, FloatArray
from fitter.model.microfacet import Geometry, geometry
from fitter.model.transform import LEAST_OFFSET
from fitter.quality.cross_validation import cube_root
from fitter.samples import LARGEST_VALUE, Samples

from . import ceiling

_STARTS = tuple(product((0.02, 0.08, 0.25, 0.6), (0.04, 0.5)))      # alpha, F0
_NARROWEST = 1e-3                                                   # alpha
_LEAST, _MOST = 1e-9, 2.0    # kd over the largest sample; the least F0, and the least that V divides by
_ITERATIONS = 200


@dataclass(frozen=True)
class GGX:
    """A fitted model.

    Examples
    --------
    At normal incidence and reflection D is 1 / (pi alpha^2), F is F0 and V is 1/4.

    >>> glossy = GGX(np.array([0.1]), np.array([0.04]), 0.2)
    >>> float(glossy.evaluate(0, 0, 0, 0)[0]), 0.1 + 0.04 / (4 * np.pi * 0.2 ** 2)
    (0.179577, 0.179577)
    """

    kd: FloatArray          # (channels,), diffuse reflectance, 1/sr
    f0: FloatArray          # (channels,), Fresnel reflectance of the lobe at normal incidence, 0 to 1
    alpha: float            # width of the lobe, as a slope
    ceiling: FloatArray | float = LARGEST_VALUE         # (channels,), the largest value, 1/sr

    @property
    def coefficient_count(self) -> int:
        """Parameters a channel."""
        return 3

    @property
    def nbytes(self) -> int:
        """Bytes of all channels in single precision."""
        return 4 * (2 * len(self.kd) + 1 + np.size(self.ceiling))

    def evaluate(self, theta_i: ArrayLike, phi_i: ArrayLike, theta_o: ArrayLike, phi_o: ArrayLike) -> FloatArray:
        """The BRDF, 1/sr: angles broadcast to (...), radians, to (..., channels) float64."""
        at = geometry(theta_i, phi_i, theta_o, phi_o)
        return np.minimum(_reflectance(_by_channel(at), self.kd, self.f0, self.alpha), self.ceiling)


def fit(samples: Samples) -> GGX:
    """Least squares of cube roots from several starts, of which the best at the samples is taken."""
    at = _by_channel(geometry(*samples.directions))
    target = cube_root(samples.theta_o, samples.values)
    channels = samples.values.shape[1]
    largest = np.maximum(samples.values.max(axis=0), LEAST_OFFSET)

    def unpack(parameters: FloatArray) -> tuple[FloatArray, FloatArray, float]:
        kd, f0, alpha = np.split(np.exp(parameters), (channels, 2 * channels))
        return kd * largest, f0, float(alpha[0])

    def residuals(parameters: FloatArray) -> FloatArray:
        return (cube_root(samples.theta_o, _reflectance(at, *unpack(parameters))) - target).ravel()

    def pack(kd: ArrayLike, f0: float, alpha: float) -> FloatArray:
        return np.log(np.concatenate([np.broadcast_to(kd, channels), np.full(channels, f0), [alpha]]))

    kd = np.clip(np.quantile(samples.values, 0.3, axis=0) / largest, 1e-4, 1)
    bounds = pack(_LEAST, _LEAST, _NARROWEST), pack(_MOST, 1, 1)
    found = [least_squares(residuals, pack(kd, f0, alpha), bounds=bounds, max_nfev=_ITERATIONS)
             for alpha, f0 in _STARTS]
    return GGX(*unpack(min(found, key=lambda result: result.cost).x), ceiling(samples.values))


def _by_channel(at: Geometry) -> Geometry:
    """A geometry (...) with an axis for the channels, (..., 1)."""
    return Geometry(*(part[..., None] for part in np.broadcast_arrays(*at)))


def _reflectance(at: Geometry, kd: FloatArray, f0: FloatArray, alpha: float) -> FloatArray:
    """The model without its ceiling: a geometry (..., 1) to (..., channels)."""
    a2 = alpha ** 2
    # D in terms of tan^2 theta_h keeps its precision at narrow peaks
    distribution = (1 + at.tan2_h) ** 2 / (np.pi * a2 * (1 + at.tan2_h / a2) ** 2)
    fresnel = f0 + (1 - f0) * (1 - at.cos_d) ** 5
    visibility = 0.5 / (at.cos_o * np.sqrt(a2 + (1 - a2) * at.cos_i ** 2)
                        + at.cos_i * np.sqrt(a2 + (1 - a2) * at.cos_o ** 2) + _LEAST)
    return kd + distribution * fresnel * visibility

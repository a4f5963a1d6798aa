"""A rough metal, from optical constants: microfacets of GGX with the exact Fresnel reflectance of a conductor.

    f = F(theta_d) D(h) G2(i, o) / (4 cos theta_i cos theta_o) + M (1 - E(i)) (1 - E(o)) / (pi (1 - E_avg))

D and G2 have a width along the tangent and one across it (`model.ggx`). The second term is light of several bounces (C.
Kulla, A. Conty: Revisiting Physically Based Shading at Imageworks, SIGGRAPH 2017): E is what the first term reflects
where F is 1, E_avg its mean, and M = F_avg^2 E_avg / (1 - F_avg (1 - E_avg)), so that a metal without losses reflects
all light.

F is that of unpolarised light, of a spectrum of n and k, under D65 in linear Rec.709. A colour outside that gamut (the
red of gold) is cut to 1: more light than arrives is reflected by nothing.
"""

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from ..arrays import ArrayLike, ComplexArray, FloatArray, unit_vectors
from .ggx import reflect_at_visible_normals
from .microfacet import Microfacet, geometry, surface_components

_COSINES = np.linspace(0, 1, 513)       # at which F is tabulated: errors between them are below 1e-5
_QUADRATURE = 48                        # midpoints of either random number that E is integrated over
_TABLE_ANGLES, _PHI = np.linspace(0, np.pi / 2, 46), np.linspace(0, np.pi / 2, 10)    # at which E is tabulated
# of these polar angles in a mean over cosines
_COSINE_WEIGHT = np.sin(2 * _TABLE_ANGLES) / np.sin(2 * _TABLE_ANGLES).sum()
_LEAST = 1e-9                           # the least that is divided by


@dataclass(frozen=True, eq=False)
class Conductor:
    """A metal of a finish."""

    n: FloatArray           # refractive index, (bands,),
    k: FloatArray           # and extinction coefficient
    weights: FloatArray     # (3, bands): convert a reflectance spectrum of these bands to linear Rec.709
    alpha: float            # width of the lobe along the tangent, as a slope,
    across: float           # and across it

    @property
    def isotropic(self) -> bool:
        """Whether the lobe has one width."""
        return self.alpha == self.across

    def log_falloff(self, theta_h: FloatArray) -> FloatArray:
        """By how much the logarithm of the lobe is lower than at its peak, at half angles of (n,) radians."""
        return 2 * np.log1p(np.tan(theta_h) ** 2 / min(self.alpha, self.across) ** 2)

    @property
    def width(self) -> float:
        """The half angle within which the lobe is level, radians."""
        return 0.05 * min(self.alpha, self.across)

    @property
    def lobes(self) -> Microfacet:
        """The model with F as at normal incidence, and of the light of several bounces its mean over the hemisphere."""
        f0 = self._fresnel[-1]
        across, turn = ((np.zeros(0),) * 2 if self.isotropic else (np.array([self.across]), np.zeros(1)))
        diffuse = self._multiple_scattering * float((_COSINE_WEIGHT @ (1 - self._albedo).mean(axis=1)) ** 2)
        strength = f0[None] / (np.pi * self.alpha * self.across)
        return Microfacet(diffuse, strength, np.array([self.alpha]), np.full(1, 2.0), np.ones(1), across=across,
                          turn=turn)

    def fresnel(self, cosine: FloatArray) -> FloatArray:
        """F at angles of incidence of these cosines: (...) to (..., 3)."""
        return np.stack([np.interp(cosine, _COSINES, channel) for channel in self._fresnel.T], axis=-1)

    def evaluate(self, theta_i: ArrayLike, phi_i: ArrayLike, theta_o: ArrayLike, phi_o: ArrayLike) -> FloatArray:
        """The BRDF, 1/sr: angles broadcast to (...), radians, to (..., 3) float64."""
        directions = theta_i, phi_i, theta_o, phi_o
        at, along = geometry(*directions), surface_components(*directions)
        slope2 = (along.slope.real / self.alpha) ** 2 + (along.slope.imag / self.across) ** 2
        density = (1 + at.tan2_h) ** 2 / (np.pi * self.alpha * self.across * (1 + slope2) ** 2)
        long_i, long_o = (self._length(cosine, part) for cosine, part in ((at.cos_i, along.incident),
                                                                          (at.cos_o, along.outgoing)))
        visibility = 0.5 / np.maximum(at.cos_o * long_i + at.cos_i * long_o, _LEAST)
        single = self.fresnel(at.cos_d) * (density * visibility)[..., None]
        lost = self._lost_share(theta_i, phi_i) * self._lost_share(theta_o, phi_o)
        return np.asarray(single + self._multiple_scattering * lost[..., None])

    def _length(self, cosine: FloatArray, part: ComplexArray) -> FloatArray:
        """Of a direction, sqrt(cos^2 + (alpha_x x)^2 + (alpha_y y)^2), for Smith's G2."""
        return np.sqrt(cosine ** 2 + (self.alpha * part.real) ** 2 + (self.across * part.imag) ** 2)

    @cached_property
    def _fresnel(self) -> FloatArray:
        """F at `_COSINES`, (513, 3)."""
        spectrum = conductor_fresnel(self.n, self.k, _COSINES[:, None])
        return np.clip(spectrum @ self.weights.T, 0, 1)

    @cached_property
    def _multiple_scattering(self) -> FloatArray:
        """The factor of what two directions lose, of several bounces: (3,), 1/sr."""
        mean_e = float(_COSINE_WEIGHT @ self._albedo.mean(axis=1))
        of_f = 2 * _COSINES * np.gradient(_COSINES)
        mean_f = of_f @ self._fresnel / of_f.sum()
        return np.asarray(mean_f ** 2 * mean_e / (1 - mean_f * (1 - mean_e)) / (np.pi * max(1 - mean_e, _LEAST)))

    def _lost_share(self, theta: ArrayLike, phi: ArrayLike) -> FloatArray:
        """1 - E of directions: angles broadcast to (...), radians."""
        theta, phi = np.broadcast_arrays(np.asarray(theta, dtype=float), np.asarray(phi, dtype=float))
        folded = np.abs((phi + np.pi / 2) % np.pi - np.pi / 2)
        rows, columns = theta / _TABLE_ANGLES[1], folded / _PHI[1]
        row, column = (np.clip(at.astype(int), 0, size - 2) for at, size in ((rows, len(_TABLE_ANGLES)),
                                                                             (columns, len(_PHI))))
        down, right, e = rows - row, columns - column, 1 - self._albedo
        return np.asarray((1 - down) * ((1 - right) * e[row, column] + right * e[row, column + 1])
                          + down * ((1 - right) * e[row + 1, column] + right * e[row + 1, column + 1]))

    @cached_property
    def _albedo(self) -> FloatArray:
        """E at `_TABLE_ANGLES` and `_PHI`: (46, 10)."""
        theta, phi = np.minimum(_TABLE_ANGLES, np.pi / 2 - 1e-6), _PHI[:1] if self.isotropic else _PHI
        sums = [[reflect_at_visible_normals(view, self.alpha, self.across, _QUADRATURE)[0].sum() for view in views]
                for views in unit_vectors(theta[:, None], phi)]
        return np.broadcast_to(np.array(sums) / _QUADRATURE ** 2, (len(_TABLE_ANGLES), len(_PHI)))


def conductor_fresnel(n: FloatArray, k: FloatArray, cosine: FloatArray) -> FloatArray:
    """The unpolarised reflectance of a conductor of index n + i k at a cosine of incidence; arrays broadcast."""
    index = n + 1j * k
    inside = np.sqrt(index ** 2 - 1 + cosine ** 2)         # index times the cosine inside
    s = (cosine - inside) / (cosine + inside)
    p = (index ** 2 * cosine - inside) / (index ** 2 * cosine + inside)
    return np.asarray((np.abs(s) ** 2 + np.abs(p) ** 2) / 2)

"""Blender's Principled BSDF as a reflectance: what its inputs mean, so that they can be fitted.

As Cycles of Blender 4 and 5 evaluates the node: a sheen (T. Zeltner, B. Burley, M. J.-Y. Chiang: Practical
Multiple-Scattering Sheen Using Linearly Transformed Cosines, SIGGRAPH Talks 2022) over a coat over a metal mixed with a
dielectric over a Lambertian. Coat, metal and dielectric are GGX; what metal and dielectric lose between microfacets is
added in proportion (C. Kulla, A. Conty: Revisiting Physically Based Shading at Imageworks, SIGGRAPH Course 2017). Each
layer lets through what the largest channel of its albedo leaves. Other inputs have the values of a new node; the index
of refraction is 1.5.
"""

import functools
from dataclasses import dataclass, field

import numpy as np

from ..arrays import ArrayLike, FloatArray, broadcast_directions, unit_vectors
from ..model import microfacet
from ..model.ggx import ggx, reflect_at_visible_normals
from ..model.microfacet import Geometry
from ..optics.fresnel import fresnel, reflectance_to_index

DIELECTRIC = 0.04           # reflectance at normal incidence of the index of refraction 1.5: a specular level of 0.5
_COAT_IOR = 1.5

# A sheen's transformation of a cosine lobe, the entries a and b, and its albedo, at a roughness (rows) and a cosine of
# the viewing angle (columns). Measured on spheres that Cycles 5.0 rendered
_SHEEN_ROUGHNESS = np.array([0.2, 0.3, 0.4, 0.5, 0.6, 0.8, 1.0])
_SHEEN_COSINE = np.array([0.05, 0.12, 0.25, 0.4, 0.55, 0.7, 0.85, 0.97])
_SHEEN_A = np.array([
    (.090, .121, .145, .170, .200, .241, .297, .361),
    (.141, .195, .247, .275, .297, .324, .362, .411),
    (.205, .261, .328, .366, .391, .415, .447, .482),
    (.280, .337, .408, .453, .481, .506, .533, .560),
    (.367, .426, .497, .546, .577, .601, .623, .641),
    (.577, .632, .689, .723, .745, .761, .775, .784),
    (.759, .796, .833, .854, .865, .872, .876, .879)])
_SHEEN_B = np.array([
    (-.060, -.013, -.011, -.020, -.033, -.040, -.040, -.021),
    (-.129, -.051, -.021, -.021, -.029, -.038, -.044, -.025),
    (-.162, -.113, -.047, -.034, -.034, -.037, -.039, -.022),
    (-.170, -.142, -.094, -.057, -.046, -.042, -.038, -.020),
    (-.162, -.147, -.114, -.086, -.065, -.050, -.039, -.018),
    (-.108, -.103, -.090, -.077, -.066, -.053, -.038, -.015),
    (.000, .000, .000, .000, .000, .000, .000, .000)])
_SHEEN_ALBEDO = np.array([
    (.485, .242, .042, .005, .001, .000, .000, .000),
    (.567, .390, .165, .049, .014, .005, .002, .001),
    (.604, .473, .280, .133, .058, .025, .011, .006),
    (.625, .525, .367, .223, .127, .069, .037, .022),
    (.642, .564, .435, .304, .204, .132, .084, .056),
    (.679, .628, .540, .441, .354, .282, .223, .185),
    (.725, .688, .620, .544, .478, .423, .379, .349)])
SHEEN_ROUGHNESS = float(_SHEEN_ROUGHNESS[0]), float(_SHEEN_ROUGHNESS[-1])      # that the table covers


@dataclass(frozen=True)
class Principled:
    """Inputs of a Principled BSDF; colours are linear, in the colour space of what it was fitted to."""

    base_color: FloatArray
    roughness: float
    metallic: float
    specular_level: float       # 0.5 for a reflectance of 4 % at normal incidence
    # times the weight, which is 1, or 0 without sheen: exporters to glTF write the tint alone
    sheen_tint: FloatArray = field(default_factory=lambda: np.zeros(3))
    sheen_roughness: float = 0.5
    coat_weight: float = 0.0
    coat_roughness: float = 0.03

    @property
    def sheen_weight(self) -> float:
        """1 with sheen, else 0."""
        return float((self.sheen_tint > 0).any())

    def evaluate(self, theta_i: ArrayLike, phi_i: ArrayLike, theta_o: ArrayLike, phi_o: ArrayLike) -> FloatArray:
        """The BRDF, 1/sr, without the cosine: angles broadcast to (...), radians, to (..., 3) float64.

        Like Cycles' it is not reciprocal: layers are weighted by what they reflect to the viewer, direction o.
        """
        directions = broadcast_directions(theta_i, phi_i, theta_o, phi_o)
        at = microfacet.geometry(*(each.ravel() for each in directions))
        toward = np.sin(directions[0]) * np.cos(directions[1] - directions[3])
        return self.evaluate_geometry(at, toward.ravel()).reshape(*directions[0].shape, 3)

    def evaluate_geometry(self, at: Geometry, toward: FloatArray) -> FloatArray:
        """The BRDF, 1/sr: (n, 3); `toward`, (n,), is the light's component along the surface, toward the viewer."""
        through = np.ones(len(at.cos_i))
        total = np.zeros((len(at.cos_i), 3))
        if self.sheen_weight:
            value, albedo = _sheen(self.sheen_roughness, at, toward)
            total += value[:, None] * self.sheen_tint
            through = through * (1 - albedo * self.sheen_tint.max())
        if self.coat_weight > 0:
            f0 = ((_COAT_IOR - 1) / (_COAT_IOR + 1)) ** 2
            total += (through * self.coat_weight * _lobe(self.coat_roughness, at) * _fresnel(at.cos_d, f0))[:, None]
            through = through * (1 - self.coat_weight * _fresnel(at.cos_o, f0))
        if self.metallic > 0:
            total += (through * self.metallic)[:, None] * self._metal(at)
        if self.metallic < 1:
            total += (through * (1 - self.metallic))[:, None] * self._dielectric(at)
        return total

    def _metal(self, at: Geometry) -> FloatArray:
        fresnel = self.base_color + (1 - self.base_color) * ((1 - at.cos_d) ** 5)[:, None]
        gain = _multiple_scattering_gain(self.roughness, at.cos_o, self.base_color + (1 - self.base_color) / 21)
        return _lobe(self.roughness, at)[:, None] * fresnel * gain

    def _dielectric(self, at: Geometry) -> FloatArray:
        f0 = 2 * DIELECTRIC * self.specular_level
        whole, grazing, _ = _microfacet_albedo(self.roughness, at.cos_o)
        mean_fresnel = np.array([f0 + (1 - f0) / 21])
        gain = _multiple_scattering_gain(self.roughness, at.cos_o, mean_fresnel)[:, 0] if f0 > 0 else 1.0
        lobe = _lobe(self.roughness, at) * _fresnel(at.cos_d, f0) * gain
        left = 1 - gain * (f0 * whole + (1 - f0) * grazing) if f0 > 0 else np.ones(len(at.cos_o))
        return lobe[:, None] + left[:, None] * self.base_color / np.pi


def _lobe(roughness: float, at: Geometry) -> FloatArray:
    return ggx(at, max(roughness, 1e-2) ** 2)


def _fresnel(cosine: FloatArray, f0: float) -> FloatArray:
    """Fresnel's reflectance of a dielectric that has f0 at normal incidence."""
    if f0 <= 0:
        return np.zeros_like(cosine)
    return fresnel(float(reflectance_to_index(np.array(f0))), cosine)


def _multiple_scattering_gain(roughness: float, cos_o: FloatArray, fresnel: FloatArray) -> FloatArray:
    """By how much light reflected repeatedly brightens microfacets of a mean Fresnel term: (n, channels)."""
    whole, _, mean = _microfacet_albedo(roughness, cos_o)
    again = fresnel * mean / (1 - fresnel * (1 - mean))
    return np.asarray(1 + ((1 - whole) / whole)[:, None] * again)


def _microfacet_albedo(roughness: float, cos_o: FloatArray) -> tuple[FloatArray, FloatArray, float]:
    """Albedo of microfacets with a Fresnel term of 1 and of (1 - cos theta_d)^5, (n,) each; the mean of the first."""
    rows, cosines, whole, grazing = _microfacet_albedo_table()
    k, t = _locate_row(roughness, rows)
    row, row_grazing = ((1 - t) * table[k] + t * table[k + 1] for table in (whole, grazing))
    mean = 2 * float((row * cosines).mean())
    return np.interp(cos_o, cosines, row), np.interp(cos_o, cosines, row_grazing), mean


@functools.cache
def _microfacet_albedo_table() -> tuple[FloatArray, FloatArray, FloatArray, FloatArray]:
    """Roughnesses (r,), cosines (c,), and the albedos of `_microfacet_albedo`, (r, c)."""
    rows, cosines = np.linspace(0, 1, 15), (np.arange(16) + 0.5) / 16
    found = []
    for alpha in np.maximum(rows, 0.05) ** 2:
        for view in unit_vectors(np.arccos(cosines), 0.0):
            kept, cos_d = reflect_at_visible_normals(view, alpha, alpha, 24)
            found.append((kept.sum(), (kept * (1 - np.clip(cos_d, 0, 1)) ** 5).sum()))
    return rows, cosines, *np.array(found).T.reshape(2, len(rows), -1) / 24 ** 2


def _sheen(roughness: float, at: Geometry, toward: FloatArray) -> tuple[FloatArray, FloatArray]:
    """A white sheen, 1/sr, and its albedo: (n,) and (n,)."""
    k, t = _locate_row(roughness, _SHEEN_ROUGHNESS)
    a, b, albedo = (np.interp(at.cos_o, _SHEEN_COSINE, (1 - t) * table[k] + t * table[k + 1])
                    for table in (_SHEEN_A, _SHEEN_B, _SHEEN_ALBEDO))
    sin2 = 1 - at.cos_i ** 2
    length2 = a ** 2 * sin2 + 2 * a * b * toward * at.cos_i + (1 + b ** 2) * at.cos_i ** 2
    return albedo / np.pi * (a / length2) ** 2, albedo


def _locate_row(value: float, rows: FloatArray) -> tuple[int, float]:
    """The row before a value, and the share of the next."""
    k = int(np.clip(np.searchsorted(rows, value) - 1, 0, len(rows) - 2))
    return k, float(np.clip((value - rows[k]) / (rows[k + 1] - rows[k]), 0, 1))

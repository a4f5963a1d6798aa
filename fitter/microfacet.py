"""The prior: what a reflectance is likely to be where nothing was measured.

A Lambertian and up to two lobes of microfacets, each with a generalised Trowbridge-Reitz distribution (B. Burley 2012)
the height-correlated Smith visibility (E. Heitz 2014) and a Fresnel term of Schlick's ::

    b = kd + sum_k ks_k D_k(theta_h) F_k(theta_d) V_k(theta_i, theta_o),     D = (1 + tan^2 theta_h / alpha^2)^-gamma

At most 15 numbers for a material of three channels. It knows what a table of samples does not: that a peak which was
not sampled is as high as its neighbours at other angles say, and how it grows toward grazing incidence.
"""

from dataclasses import dataclass, replace

import numpy as np

from .shader_constants import DENSEST, LEAST_HEIGHT_2

MAX_LOBES = 2
_START_WIDTHS = ((0.05,), (0.2,), (0.6,), (0.01, 0.3), (0.05, 0.2), (0.05, 0.6), (0.2, 0.6))
_ITERATIONS = 60
_NARROWEST, _STEEPEST_TAIL = 1e-3, 32.0     # of alpha, and of gamma - 1: beyond, single precision shows
RANGES = {"alpha": (_NARROWEST, _STEEPEST_TAIL), "gamma": (1 + _NARROWEST, 1 + _STEEPEST_TAIL), "f0": (0.0, 1.0)}
_CLIP = 25.0                # bound of every parameter as searched: a logarithm, or the logit of F0


@dataclass(frozen=True)
class Microfacet:
    """A Lambertian and some lobes.

    Attributes
    ----------
    kd : (channels,) float64
        1/sr.
    ks : (lobes, channels) float64
        1/sr.
    alpha, gamma, f0 : (lobes,) float64
        Width of a lobe as a slope; how fast its tail falls; reflectance at normal incidence, relative to grazing.
    """

    kd: np.ndarray
    ks: np.ndarray
    alpha: np.ndarray
    gamma: np.ndarray
    f0: np.ndarray

    @property
    def nbytes(self):
        """Bytes of the parameters of all channels in single precision."""
        return 4 * (self.kd.size + self.ks.size + self.alpha.size + self.gamma.size + self.f0.size)

    def evaluate(self, theta_i, phi_i, theta_o, phi_o):
        """The model, 1/sr: angles (n,) in radians to (n, channels) float64."""
        return self._at(_geometry(theta_i, phi_i, theta_o, phi_o))

    def _at(self, geometry):
        cos_i, cos_o, tan2_h, cos_d = geometry
        grazing = (1 - cos_d) ** 5
        total = np.broadcast_to(self.kd, (*np.shape(tan2_h), len(self.kd)))
        for ks, alpha, gamma, f0 in zip(self.ks, self.alpha, self.gamma, self.f0, strict=True):
            distribution = (1 + tan2_h / alpha ** 2) ** -gamma
            m2 = min(alpha, 1.0) ** 2
            visibility = 0.5 / (cos_o * np.sqrt(cos_i ** 2 * (1 - m2) + m2)
                                + cos_i * np.sqrt(cos_o ** 2 * (1 - m2) + m2) + DENSEST)
            total = total + ks * (distribution * (f0 + (1 - f0) * grazing) * visibility)[..., None]
        return total


def lambertian(values):
    """The prior that knows of no lobe: the median of each channel, (n, channels) to Microfacet."""
    kd = np.maximum(np.median(values, axis=0), 0)
    return Microfacet(kd, np.zeros((0, len(kd))), np.zeros(0), np.zeros(0), np.zeros(0))


def fit(samples, offset):
    """Fit by least squares of log(f + offset), so that dark directions count as much as the peak.

    Levenberg-Marquardt from several widths of lobe.

    Parameters
    ----------
    samples : Samples
    offset : float
        1/sr.

    Returns
    -------
    Microfacet
    """
    geometry = _geometry(*samples.directions)
    values = samples.values / offset
    target = compress(values, 1.0)
    channels = values.shape[1]
    kd = np.maximum(np.quantile(values, 0.3, axis=0), 1e-4)
    starts = [_pack(Microfacet(kd, np.stack([2 * kd, 0.3 * kd])[:len(widths)], np.array(widths),
                               np.full(len(widths), 2.0), np.full(len(widths), 0.076))) for widths in _START_WIDTHS]

    def residuals(p):
        return (compress(_unpack(p, channels)._at(geometry), 1.0) - target).ravel()

    best = min((_levenberg_marquardt(residuals, p) for p in starts), key=lambda found: found[1])[0]
    model = _unpack(best, channels)
    return replace(model, kd=model.kd * offset, ks=model.ks * offset)


def compress(values, offset):
    """log(f + offset), bounded where f falls below -offset: (n, channels) 1/sr to (n, channels)."""
    return np.log(np.maximum(values + offset, 0.05 * offset))


def _geometry(theta_i, phi_i, theta_o, phi_o):
    """cos theta_i, cos theta_o, tan^2 of the half angle, and cosine of the difference angle."""
    theta_i, theta_o = np.asarray(theta_i, dtype=float), np.asarray(theta_o, dtype=float)
    cos_i, cos_o = np.cos(theta_i), np.cos(theta_o)
    sin_i, sin_o = np.sin(theta_i), np.sin(theta_o)
    across2 = np.maximum(
        sin_i ** 2 + sin_o ** 2 + 2 * sin_i * sin_o * np.cos(np.asarray(phi_o, dtype=float) - phi_i), 0)
    up2 = np.maximum((cos_i + cos_o) ** 2, LEAST_HEIGHT_2)
    return cos_i, cos_o, across2 / up2, np.minimum(np.sqrt(across2 + up2) / 2, 1)


def _pack(model):
    """The parameters as searched: logits of F0, and logarithms."""
    f0 = np.clip(model.f0, 1e-9, 1 - 1e-9)
    positive = np.concatenate([model.alpha, model.gamma - 1, model.kd, model.ks.ravel()])
    return np.concatenate([np.log(f0 / (1 - f0)), np.log(np.maximum(positive, 1e-9))])


def _unpack(p, channels):
    p = np.clip(p, -_CLIP, _CLIP)
    lobes = (len(p) - channels) // (3 + channels)
    alpha, gamma = np.clip(np.exp(p[lobes:3 * lobes]), _NARROWEST, _STEEPEST_TAIL).reshape(2, lobes)
    strength = np.exp(p[3 * lobes:])
    return Microfacet(strength[:channels], strength[channels:].reshape(lobes, channels), alpha, 1 + gamma,
                      1 / (1 + np.exp(-p[:lobes])))


def _levenberg_marquardt(residuals, p):
    """The nearest minimum, and the sum of squares there; derivatives by differences."""
    # a weak pull to the start keeps parameters that the data say nothing of where they are
    start = p

    def all_residuals(p):
        return np.concatenate([residuals(p), 1e-2 * (p - start)])

    r = all_residuals(p)
    cost, damping = r @ r, 1e-2
    for _ in range(_ITERATIONS):
        jacobian = np.stack([(all_residuals(p + step) - r) / 1e-5 for step in 1e-5 * np.eye(len(p))], axis=1)
        normal, slope = jacobian.T @ jacobian, jacobian.T @ r
        for _ in range(8):
            trial = p - np.linalg.solve(normal + damping * np.diag(np.diag(normal) + 1e-9), slope)
            r_trial = all_residuals(trial)
            if r_trial @ r_trial < cost:
                break
            damping *= 4
        else:
            break
        gain = cost - r_trial @ r_trial
        p, r, cost, damping = trial, r_trial, cost - gain, damping / 4
        if gain < 1e-6 * cost:
            break
    return p, cost

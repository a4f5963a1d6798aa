"""The prior: what a reflectance is likely to be where nothing was measured.

A Lambertian and a lobe of microfacets, with one or two generalised Trowbridge-Reitz distributions (B. Burley 2012),
Schlick's Fresnel term and the height-correlated Smith visibility (E. Heitz 2014) ::

    b = kd + ks D(theta_h) F(theta_d) V(theta_i, theta_o),      D = sum_k w_k (1 + tan^2 theta_h / alpha_k^2)^-gamma_k

At most 13 numbers for a material of three channels. It knows what a table of samples does not: that a peak which was not
sampled is as high as its neighbours at other angles say, and how it grows toward grazing incidence.
"""

from dataclasses import dataclass

import numpy as np

_DENSEST = 1e-3             # keeps the visibility finite where both directions graze
_START_WIDTHS = ((0.05,), (0.2,), (0.6,), (0.05, 0.2), (0.05, 0.6), (0.2, 0.6))
_ITERATIONS = 60
_CLIP = 25.0                # bound of every parameter as searched: a logarithm, or the logit of F0


@dataclass(frozen=True)
class Microfacet:
    """A Lambertian and a lobe.

    Attributes
    ----------
    kd, ks : (channels,) float64
        1/sr.
    weight, alpha, gamma : (1,) or (2,) float64
        Of each distribution: its share, the first 1; its width as a slope; how fast its tail falls.
    f0 : float
        Reflectance at normal incidence, relative to grazing.
    """

    kd: np.ndarray
    ks: np.ndarray
    weight: np.ndarray
    alpha: np.ndarray
    gamma: np.ndarray
    f0: float

    @property
    def nbytes(self):
        """Bytes of the parameters of all channels in single precision."""
        return 4 * (2 * len(self.kd) + 3 * len(self.alpha))

    def evaluate(self, theta_i, phi_i, theta_o, phi_o):
        """The model, 1/sr: angles (n,) in radians to (n, channels) float64."""
        return self._at(_geometry(theta_i, phi_i, theta_o, phi_o))

    def _at(self, geometry):
        cos_i, cos_o, tan2_h, cos_d = geometry
        distribution = sum(weight * (1 + tan2_h / alpha ** 2) ** -gamma
                           for weight, alpha, gamma in zip(self.weight, self.alpha, self.gamma, strict=True))
        fresnel = self.f0 + (1 - self.f0) * (1 - cos_d) ** 5
        m2 = min(self.alpha[0], 1.0) ** 2
        visibility = 0.5 / (cos_o * np.sqrt(cos_i ** 2 * (1 - m2) + m2) + cos_i * np.sqrt(cos_o ** 2 * (1 - m2) + m2)
                            + _DENSEST)
        return self.kd + self.ks * (distribution * fresnel * visibility)[..., None]


def lambertian(values):
    """The prior that knows of no lobe: the median of each channel, (n, channels) to Microfacet."""
    kd = np.median(values, axis=0)
    return Microfacet(np.maximum(kd, 0), np.zeros_like(kd), np.ones(1), np.ones(1), np.ones(1), 1.0)


def fit(samples, offset, start=None):
    """Fit by least squares of log(f + offset), so that dark directions count as much as the peak.

    Levenberg-Marquardt from several widths of lobe, or from `start` alone.

    Parameters
    ----------
    samples : Samples
    offset : float
        1/sr.
    start : Microfacet, optional

    Returns
    -------
    Microfacet
    """
    geometry = _geometry(*samples.directions)
    target = compress(samples.values, offset)
    channels = samples.values.shape[1]
    if start is not None:
        starts = [_pack(start)]
    else:
        kd = np.maximum(np.quantile(samples.values, 0.3, axis=0), 1e-4)
        starts = [_pack(Microfacet(kd, 2 * kd, np.array([1.0, 0.14])[:len(widths)], np.array(widths),
                                   np.full(len(widths), 2.0), 0.076)) for widths in _START_WIDTHS]

    def residuals(p):
        return (compress(_unpack(p, channels)._at(geometry), offset) - target).ravel()

    best = min((_levenberg_marquardt(residuals, p) for p in starts), key=lambda found: found[1])[0]
    return _unpack(best, channels)


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
    up2 = np.maximum((cos_i + cos_o) ** 2, 1e-12)
    return cos_i, cos_o, across2 / up2, np.minimum(np.sqrt(across2 + up2) / 2, 1)


def _pack(model):
    """The parameters as searched: logarithms, and the logit of F0; the weight of the first distribution is 1."""
    f0 = np.clip(model.f0, 1e-9, 1 - 1e-9)
    positive = np.concatenate([model.kd, model.ks, model.alpha, model.gamma - 1 + 1e-9, model.weight[1:]])
    return np.append(np.log(np.maximum(positive, 1e-10)), np.log(f0 / (1 - f0)))


def _unpack(p, channels):
    positive, f0 = np.exp(np.clip(p[:-1], -_CLIP, _CLIP)), 1 / (1 + np.exp(-np.clip(p[-1], -_CLIP, _CLIP)))
    kd, ks, shape = positive[:channels], positive[channels:2 * channels], np.clip(positive[2 * channels:], 1e-3, 1e3)
    lobes = (len(shape) + 1) // 3
    return Microfacet(kd, ks, np.append(1.0, shape[2 * lobes:]), shape[:lobes], 1 + shape[lobes:2 * lobes], float(f0))


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

"""Fitting a microfacet model to samples: the prior of `regression_kriging`.

The model knows what a table of samples does not: how high a peak is that no sample hit, by its neighbours at other
angles, and how a lobe grows toward grazing incidence.
"""

from collections.abc import Callable
from dataclasses import replace

import numpy as np

from ..arrays import FloatArray
from ..model.microfacet import NARROWEST, STEEPEST_TAIL, Microfacet, geometry
from ..model.transform import bounded_log
from ..samples import Samples

_START_WIDTHS = ((0.05,), (0.2,), (0.6,), (0.01, 0.3), (0.05, 0.2), (0.05, 0.6), (0.2, 0.6))
_ITERATIONS = 60
_CLIP = 25.0                # bound of every parameter as searched: a logarithm, or the logit of F0


def lambertian(values: FloatArray) -> Microfacet:
    """The model without lobes: the median of each channel of (n, channels), 1/sr."""
    kd = np.maximum(np.median(values, axis=0), 0)
    return Microfacet(kd, np.zeros((0, len(kd))), np.zeros(0), np.zeros(0), np.zeros(0))


def fit(samples: Samples, offset: float) -> Microfacet:
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
    at = geometry(*samples.directions)
    values = samples.values / offset
    target = bounded_log(values, 1.0)
    channels = values.shape[1]
    kd = np.maximum(np.quantile(values, 0.3, axis=0), 1e-4)
    starts = [_pack(Microfacet(kd, np.stack([2 * kd, 0.3 * kd])[:len(widths)], np.array(widths),
                               np.full(len(widths), 2.0), np.full(len(widths), 0.076))) for widths in _START_WIDTHS]

    def residuals(p: FloatArray) -> FloatArray:
        return (bounded_log(_unpack(p, channels).at(at), 1.0) - target).ravel()

    best = min((_levenberg_marquardt(residuals, p) for p in starts), key=lambda found: found[1])[0]
    model = _unpack(best, channels)
    return replace(model, kd=model.kd * offset, ks=model.ks * offset)


def _pack(model: Microfacet) -> FloatArray:
    """The parameters as searched: logits of F0, and logarithms."""
    f0 = np.clip(model.f0, 1e-9, 1 - 1e-9)
    positive = np.concatenate([model.alpha, model.gamma - 1, model.kd, model.ks.ravel()])
    return np.concatenate([np.log(f0 / (1 - f0)), np.log(np.maximum(positive, 1e-9))])


def _unpack(p: FloatArray, channels: int) -> Microfacet:
    """The model of parameters as searched."""
    p = np.clip(p, -_CLIP, _CLIP)
    lobes = (len(p) - channels) // (3 + channels)
    alpha, gamma = np.clip(np.exp(p[lobes:3 * lobes]), NARROWEST, STEEPEST_TAIL).reshape(2, lobes)
    strength = np.exp(p[3 * lobes:])
    return Microfacet(strength[:channels], strength[channels:].reshape(lobes, channels), alpha, 1 + gamma,
                      1 / (1 + np.exp(-p[:lobes])))


def _levenberg_marquardt(residuals: Callable[[FloatArray], FloatArray], p: FloatArray) -> tuple[FloatArray, float]:
    """The nearest minimum, and the sum of squares there; derivatives by differences."""
    # a weak pull to the start keeps parameters that the data say nothing of where they are
    start = p

    def all_residuals(p: FloatArray) -> FloatArray:
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

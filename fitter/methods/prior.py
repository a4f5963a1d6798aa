"""Fitting a microfacet model to samples: the prior of `regression_kriging`.

The model adds what the samples alone do not tell: the height of a peak that no sample hit, and the growth of a lobe
toward grazing incidence. It is fitted by the algorithm of D. W. Marquardt: An Algorithm for Least-Squares Estimation of
Nonlinear Parameters, 1963.
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
_CLIP = 25.0                # bound of every parameter of the search: logarithms, and logits of F0


def lambertian(values: FloatArray) -> Microfacet:
    """The model without lobes: the median of each channel of values (n, channels), 1/sr.

    Examples
    --------
    >>> lambertian(np.array([[0.1], [0.2], [9.0]])).evaluate(0.3, 0, 0.2, 1).tolist()
    [0.2]
    """
    kd = np.maximum(np.median(values, axis=0), 0)
    return Microfacet(kd, np.zeros((0, len(kd))), np.zeros(0), np.zeros(0), np.zeros(0))


def fit(samples: Samples, offset: float) -> Microfacet:
    """Fit a model with one or two lobes.

    Least squares of log(f + offset), so that dark directions count as much as the peak, by Levenberg-Marquardt from
    several widths of the lobes.

    Parameters
    ----------
    samples : Samples
    offset : float
        1/sr, positive.

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
    """The parameters of the search: logits of F0, logarithms of the others."""
    f0 = np.clip(model.f0, 1e-9, 1 - 1e-9)
    positive = np.concatenate([model.alpha, model.gamma - 1, model.kd, model.ks.ravel()])
    return np.concatenate([np.log(f0 / (1 - f0)), np.log(np.maximum(positive, 1e-9))])


def _unpack(p: FloatArray, channels: int) -> Microfacet:
    """The model of parameters that `_pack` made."""
    p = np.clip(p, -_CLIP, _CLIP)
    lobes = (len(p) - channels) // (3 + channels)
    alpha, gamma = np.clip(np.exp(p[lobes:3 * lobes]), NARROWEST, STEEPEST_TAIL).reshape(2, lobes)
    strength = np.exp(p[3 * lobes:])
    return Microfacet(strength[:channels], strength[channels:].reshape(lobes, channels), alpha, 1 + gamma,
                      1 / (1 + np.exp(-p[:lobes])))


def _levenberg_marquardt(residuals: Callable[[FloatArray], FloatArray], p: FloatArray) -> tuple[FloatArray, float]:
    """A local minimum of the sum of squares, and its value; derivatives by finite differences."""
    # a weak pull toward the start holds the parameters that the data do not determine
    start = p

    def all_residuals(p: FloatArray) -> FloatArray:
        return np.concatenate([residuals(p), 1e-2 * (p - start)])

    r = all_residuals(p)
    cost, damping = float(r @ r), 1e-2
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
        p, r, cost, damping = trial, r_trial, float(cost - gain), damping / 4
        if gain < 1e-6 * cost:
            break
    return p, cost

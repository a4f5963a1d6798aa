"""What else predicts photographs of a flat sample: its mean picture, and texels of which each is for itself.

A Lambertian normal and albedo (R. Woodham: Photometric Method for Determining Surface Orientation from Multiple Images,
Optical Engineering 19(1), 1980), polynomial texture maps (T. Malzbender, D. Gelb, H. Wolters, SIGGRAPH 2001) and
hemispherical harmonics (P. Gautron, J. Krivanek, S. Pattanaik, K. Bouatouch, EGSR 2004), with 9 and 16 terms. They
share nothing with `fitter.photographs`.
"""

import numpy as np
from scipy.special import eval_legendre, lpmv


def mean_picture(used, other):
    """The mean of the used photographs, scaled to each of the others: an oracle, since it is told how bright these are.

    `used` and `other` are light (p, 3), values (p, n, c) and good (p, n); returns values (p', n, c).
    """
    _, values, good = used
    mean = (values * good[..., None]).sum(axis=0) / np.maximum(good.sum(axis=0), 1)[:, None]
    _, there, seen = other
    scale = (mean * there * seen[..., None]).sum(axis=(1, 2)) / np.maximum(
        ((mean ** 2) * seen[..., None]).sum(axis=(1, 2)), 1e-12)
    return scale[:, None, None] * mean


def lambertian(used, other):
    """A normal by the mean over channels, and an albedo of each channel, of each texel."""
    light, values, good = used
    pointing = _solved(light, values.mean(axis=2, keepdims=True), good)[..., 0]
    normal = pointing / np.maximum(np.linalg.norm(pointing, axis=1, keepdims=True), 1e-12)
    cosine, there = (np.maximum(each @ normal.T, 0) for each in (light, other[0]))
    albedo = np.einsum("pn,pnc->nc", cosine * good, values) / np.maximum(
        (cosine ** 2 * good).sum(axis=0), 1e-12)[:, None]
    return there[..., None] * albedo


def ptm(used, other):
    """A polynomial of second degree in the direction: 6 terms."""
    return _predicted(lambda d: np.stack([d[:, 0] ** 2, d[:, 1] ** 2, d[:, 0] * d[:, 1], d[:, 0], d[:, 1],
                                          np.ones(len(d))], axis=1), used, other)


def hsh(order):
    """Hemispherical harmonics of all degrees below an order: order^2 terms."""
    def basis(light):
        x, azimuth = np.clip(2 * light[:, 2] - 1, -1, 1), np.arctan2(light[:, 1], light[:, 0])
        terms = []
        for degree in range(order):
            terms.append(eval_legendre(degree, x))
            for m in range(1, degree + 1):
                terms += [lpmv(m, degree, x) * turn(m * azimuth) for turn in (np.cos, np.sin)]
        return np.stack(terms, axis=1)
    return lambda used, other: _predicted(basis, used, other)


def _predicted(basis, used, other):
    return np.maximum(np.einsum("pk,nkc->pnc", basis(other[0]), _solved(basis(used[0]), *used[1:])), 0)


def _solved(basis, values, good):
    """Least squares of each texel, nearly without a ridge: (n, k, c)."""
    gram = np.einsum("pk,pl,pn->nkl", basis, basis, good.astype(float))
    gram += (1e-6 * np.trace(gram, axis1=1, axis2=2) + 1e-12)[:, None, None] * np.eye(gram.shape[1])
    return np.linalg.solve(gram, np.einsum("pk,pnc,pn->nkc", basis, values, good.astype(float)))

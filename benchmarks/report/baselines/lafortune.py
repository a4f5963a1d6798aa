"""Lafortune's model: a Lambertian and generalised cosine lobes.

E. P. F. Lafortune, S. C. Foo, K. E. Torrance, D. P. Greenberg: Non-Linear Approximation of Reflectance Functions,
SIGGRAPH 1997. For an isotropic reflectance, with unit vectors i and o whose z is the normal, ::

    f = rho / pi + sum_k max(Cxy_k (i_x o_x + i_y o_y) + Cz_k i_z o_z, 0) ^ n_k

The second baseline of Kameya and Lewis 2002, with three lobes, fitted channel by channel by Levenberg-Marquardt from
several starts. A lobe with Cxy^2 > 1 or Cz > 1 grows without bound where no sample holds it, so that a fit is clipped.
"""

from dataclasses import dataclass

import numpy as np
from scipy.optimize import least_squares

from fitter.arrays import ArrayLike, FloatArray
from fitter.samples import LARGEST_VALUE, Samples

from . import ceiling

LOBES = 3
# (Cxy, Cz) of the lobes at which a search starts
_SHAPES = {"mirror": (-1.0, 1.0), "retro": (0.8, 0.8), "grazing": (-1.05, 0.6), "broad": (-0.5, 0.5)}
_STARTS = (
    (("mirror", 10), ("grazing", 40), ("retro", 5)),
    (("mirror", 30), ("grazing", 100), ("broad", 2)),
    (("mirror", 100), ("mirror", 20), ("grazing", 60)),
    (("mirror", 300), ("mirror", 60), ("mirror", 10)),
    (("grazing", 20), ("retro", 10), ("broad", 1)),
    (("mirror", 1000), ("grazing", 300), ("mirror", 50)),
)


@dataclass(frozen=True)
class Lafortune:
    """A fitted model.

    Examples
    --------
    A mirror-like lobe, Cxy = -1 and Cz = 1, is the n-th power of the cosine between o and the mirror direction of i.

    >>> lobe = Lafortune(np.zeros(1), np.array([[[-1.0], [1.0], [20.0]]]))
    >>> lobe.evaluate(0.5, 0, [0.5, 0.8], np.pi)[:, 0].tolist(), float(np.cos(0.3) ** 20)
    ([1.0, 0.400984], 0.400984)
    """

    rho: FloatArray         # (channels,), diffuse albedo
    lobes: FloatArray       # (lobes, 3, channels): Cxy, Cz and n of each
    ceiling: FloatArray | float = LARGEST_VALUE         # (channels,), the largest value, 1/sr

    @property
    def coefficient_count(self) -> int:
        """Parameters a channel."""
        return 1 + 3 * len(self.lobes)

    @property
    def nbytes(self) -> int:
        """Bytes of all channels in single precision."""
        return 4 * (self.coefficient_count * len(self.rho) + np.size(self.ceiling))

    def evaluate(self, theta_i: ArrayLike, phi_i: ArrayLike, theta_o: ArrayLike, phi_o: ArrayLike) -> FloatArray:
        """The BRDF, 1/sr: angles broadcast to (...), radians, to (..., channels) float64."""
        xy, z = (product[..., None] for product in _products(theta_i, phi_i, theta_o, phi_o))
        with np.errstate(over="ignore"):        # far from the samples a lobe may overflow
            lobes = sum(np.maximum(c_xy * xy + c_z * z, 0) ** n for c_xy, c_z, n in self.lobes)
        return np.clip(self.rho / np.pi + lobes, 0, self.ceiling)


def fit(samples: Samples, lobes: int = LOBES) -> Lafortune:
    """Each channel by Levenberg-Marquardt from several starts, with 1 to 3 lobes; the fit of the smallest RMSE."""
    xy, z = _products(*samples.directions)
    best = np.stack([_fit_channel(xy, z, values, lobes) for values in samples.values.T], axis=-1)
    return Lafortune(best[0] * np.pi, _unpack(best[1:]), ceiling(samples.values))


def _products(theta_i: ArrayLike, phi_i: ArrayLike, theta_o: ArrayLike,
              phi_o: ArrayLike) -> tuple[FloatArray, FloatArray]:
    """i_x o_x + i_y o_y, and i_z o_z."""
    theta_i, theta_o = np.asarray(theta_i, dtype=float), np.asarray(theta_o, dtype=float)
    in_plane = np.sin(theta_i) * np.sin(theta_o) * np.cos(np.asarray(phi_o, dtype=float) - phi_i)
    xy, z = np.broadcast_arrays(in_plane, np.cos(theta_i) * np.cos(theta_o))
    return xy, z


def _unpack(parameters: FloatArray) -> FloatArray:
    """Parameters of the search, (3 lobes, ...) with log n, to (lobes, 3, ...) with n."""
    lobes = parameters.reshape(-1, 3, *parameters.shape[1:]).copy()
    lobes[:, 2] = np.exp(lobes[:, 2])
    return lobes


def _fit_channel(xy: FloatArray, z: FloatArray, values: FloatArray, lobes: int) -> FloatArray:
    """The best parameters of all starts: rho / pi, then Cxy, Cz, log n of each lobe."""
    def residuals(parameters: FloatArray) -> FloatArray:
        value = parameters[0] + sum(_lobe(xy, z, *lobe)[0] for lobe in parameters[1:].reshape(-1, 3))
        return value - values

    def jacobian(parameters: FloatArray) -> FloatArray:
        columns = [np.ones_like(values)]
        for lobe in parameters[1:].reshape(-1, 3):
            value, base, n = _lobe(xy, z, *lobe)
            slope = np.divide(n * value, base, out=np.zeros_like(base), where=base > 0)
            columns += [slope * xy, slope * z, value * n * np.log(np.maximum(base, 1e-300))]
        return np.stack(columns, axis=1)

    found = [least_squares(residuals, _start(start[:lobes], xy, z, values), jacobian, method="lm", max_nfev=400)
             for start in _STARTS]
    return min(found, key=lambda result: result.cost).x


def _lobe(xy: FloatArray, z: FloatArray, c_xy: float, c_z: float,
          log_n: float) -> tuple[FloatArray, FloatArray, float]:
    """Values of one lobe, its base and its exponent; clipped, so that all trials of the search are finite."""
    base = np.maximum(c_xy * xy + c_z * z, 0)
    n = np.exp(np.clip(log_n, -5, 12))
    with np.errstate(divide="ignore", over="ignore"):
        value = np.exp(np.clip(n * np.log(base), None, 100))
    return value, base, n


def _start(start: tuple[tuple[str, int], ...], xy: FloatArray, z: FloatArray, values: FloatArray) -> FloatArray:
    """Initial parameters; the peak of each lobe is as high as the nearest samples."""
    floor = np.quantile(values, 0.3)
    parameters = [floor]
    for shape, n in start:
        c_xy, c_z = _SHAPES[shape]
        base = np.maximum(c_xy * xy + c_z * z, 1e-6)
        near = np.argsort(base)[-5:]
        height = max(float(np.mean(values[near] - floor)), 1e-3 * float(np.ptp(values)) + 1e-9)
        scale = (height / len(start)) ** (1 / n) / base[near].mean()
        parameters += [c_xy * scale, c_z * scale, np.log(n)]
    return np.array(parameters)

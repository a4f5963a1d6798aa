"""A neural BRDF: a network of 675 weights that takes the half and the difference vector.

A. Sztrajman, G. Rainer, T. Ritschel, T. Weyrich: Neural BRDF Representation and Importance Sampling, Computer Graphics
Forum 40(6), 2021: f = max(exp(W3 r(W2 r(W1 (h, d) + b1) + b2) + b3) - 1, 0) of hidden layers of 21 units, r(x) = max(x,
0). It is trained as theirs by Adam (D. P. Kingma, J. Ba: Adam: A Method for Stochastic Optimization, ICLR 2015). They
have the million samples of a MERL
material; here are few. Hence several networks are trained from random weights, and what is kept is the network, and the
moment of its training, with the least error of `cube_root` at a tenth of the samples, which training does not see.
"""

import itertools
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from fitter.arrays import ArrayLike, FloatArray, IntArray, SingleArray
from fitter.quality.cross_validation import cube_root, folds
from fitter.samples import LARGEST_VALUE, Samples

from . import ceiling

HIDDEN = 21
PUBLISHED = (6, HIDDEN), (HIDDEN, HIDDEN), (HIDDEN, 3)      # weights of the layers
STARTS = 3
STEPS = 6000
BATCH = 256
RATE = 0.02                 # of the first step; it falls to 0 as a cosine. .002 to .05 tried on CURET's odd samples
INNER_FOLDS = 10            # one of them chooses the network and the moment
_CHECK = 100                # steps between two looks at that fold
_SEED = 2021
_BETA_1, _BETA_2, _EPSILON = 0.9, 0.999, 1e-8           # of Adam
_LEAST = 1e-3               # of 1 + f cos theta_i: in training f may be below 0, where its gradient leads back
_STEEPEST = 60.0            # largest exponent
_TILTED = 1e-4              # sin theta_h, below which d has no azimuth and is given that of the plane of incidence


@dataclass(frozen=True)
class Neural:
    """A fitted model.

    Examples
    --------
    With three channels there are 675 weights. A network of zeros reflects exp(b3) - 1 everywhere.

    >>> shapes = ((6, 21), (21, 21), (21, 3))
    >>> biases = np.zeros(21), np.zeros(21), np.log1p([0.1, 0.2, 0.3])
    >>> flat = Neural(tuple(map(np.zeros, shapes)), biases)
    >>> flat.coefficient_count, flat.evaluate(0.3, 0, 1.1, 2).round(9).tolist()
    (675, [0.1, 0.2, 0.3])
    """

    weights: tuple[SingleArray, ...]                # (inputs, outputs) of each layer
    biases: tuple[SingleArray, ...]                 # (outputs,)
    ceiling: FloatArray | float = LARGEST_VALUE     # (channels,), the largest value, 1/sr

    @property
    def coefficient_count(self) -> int:
        """Weights and biases; the channels share all but those of the last layer."""
        return sum(array.size for array in (*self.weights, *self.biases))

    @property
    def nbytes(self) -> int:
        """Bytes of all channels in single precision."""
        return 4 * (self.coefficient_count + (self.ceiling.size if isinstance(self.ceiling, np.ndarray) else 0))

    def evaluate(self, theta_i: ArrayLike, phi_i: ArrayLike, theta_o: ArrayLike, phi_o: ArrayLike) -> FloatArray:
        """The BRDF, 1/sr: angles broadcast to (...), radians, to (..., channels) float64."""
        x = half_and_difference(theta_i, phi_i, theta_o, phi_o)
        return np.clip(_reflectance(_forward(self.weights, self.biases, x)[-1]), 0, self.ceiling)


def fit(samples: Samples) -> Neural:
    """Train networks on samples, all of them at once, and keep the best."""
    random = np.random.default_rng(_SEED)
    unseen = folds(len(samples), INNER_FOLDS, _SEED)[0]
    seen = np.setdiff1d(np.arange(len(samples)), unseen)
    if not len(seen):                       # a single sample
        seen = unseen
    x = half_and_difference(*samples.directions).astype(np.float32)
    cos_i = np.cos(samples.theta_i)[:, None].astype(np.float32)
    target = np.log(np.maximum(1 + samples.values * cos_i, _LEAST)).astype(np.float32)
    parameters = _start(random, samples.values)
    top = ceiling(samples.values)
    adam = _Adam(parameters)
    batches = _batches(random, seen)
    wanted = cube_root(samples.theta_o[unseen], samples.values[unseen])
    least = np.full(STARTS, np.inf)
    kept = [array.copy() for array in parameters]
    for step in range(1, STEPS + 1):
        batch = next(batches)
        rate = RATE * (1 + np.cos(np.pi * step / STEPS)) / 2
        adam.move(gradient(parameters, x[batch], cos_i[batch], target[batch]), rate)
        if step % _CHECK == 0:
            found = np.clip(_reflectance(_forward(parameters[::2], parameters[1::2], x[unseen])[-1]), 0, top)
            errors = np.array([np.mean((cube_root(samples.theta_o[unseen], one) - wanted) ** 2) for one in found])
            better = errors < least
            least[better] = errors[better]
            for copy, array in zip(kept, parameters, strict=True):
                copy[better] = array[better]
    best = int(np.argmin(least))
    return Neural(tuple(array[best] for array in kept[::2]), tuple(array[best, 0] for array in kept[1::2]), top)


def published(path: str | Path, name: str) -> Neural:
    """One of the networks that the authors published, for the materials of MERL and of RGL: without a ceiling.

    The file is an .npz of `names` (n,) and `weights` (n, 675): for each layer its weights, row by row, and its biases.
    Raises ValueError if there is no network of this name.
    """
    with np.load(path) as networks:
        names = [str(each) for each in networks["names"]]
        if name not in names:
            raise ValueError(f"no network {name!r} in {path}; expected one of {', '.join(names)}")
        flat = networks["weights"][names.index(name)]
    sizes = [count for rows, columns in PUBLISHED for count in (rows * columns, columns)]
    parts = np.split(flat, np.cumsum(sizes)[:-1])
    return Neural(tuple(part.reshape(shape) for part, shape in zip(parts[::2], PUBLISHED, strict=True)),
                  tuple(parts[1::2]))


def half_and_difference(theta_i: ArrayLike, phi_i: ArrayLike, theta_o: ArrayLike, phi_o: ArrayLike) -> FloatArray:
    """The half and the difference vector, turned to azimuth 0 of h; of two mirror images that with d_y >= 0.

    Angles broadcast to (...), radians, to h and d, (..., 6) float64.

    Examples
    --------
    At retro-reflection h is the direction itself, and d the normal.

    >>> half_and_difference(0.3, 1, 0.3, 1).round(6).tolist(), float(np.sin(0.3)), float(np.cos(0.3))
    ([0.29552, 0.0, 0.955336, 0.0, 0.0, 1.0], 0.29552, 0.955336)
    """
    theta_i, theta_o, delta = np.broadcast_arrays(*(np.asarray(angle, dtype=float) for angle in (
        theta_i, theta_o, np.subtract(phi_o, phi_i))))
    sin_i, cos_i, sin_o, cos_o = np.sin(theta_i), np.cos(theta_i), np.sin(theta_o), np.cos(theta_o)
    # h in the frame where i has azimuth 0
    half = np.stack([sin_i + sin_o * np.cos(delta), sin_o * np.sin(delta), cos_i + cos_o])
    half /= np.maximum(np.linalg.norm(half, axis=0), 1e-12)
    sin_h, cos_h = np.hypot(half[0], half[1]), half[2]
    tilted = sin_h > _TILTED
    length = np.where(tilted, sin_h, 1)
    cos_phi, sin_phi = np.where(tilted, half[0] / length, 1), np.where(tilted, half[1] / length, 0)
    # d is i, turned by -phi_h about the normal, and then by -theta_h about y
    difference = [sin_i * cos_phi * cos_h - cos_i * sin_h, np.abs(sin_i * sin_phi),
                  sin_i * cos_phi * sin_h + cos_i * cos_h]
    return np.stack([sin_h, 0 * sin_h, cos_h, *difference], axis=-1)


def gradient(parameters: list[SingleArray], x: SingleArray, cos_i: SingleArray,
             target: SingleArray) -> list[SingleArray]:
    """The gradient of the loss of each network: the mean absolute difference of log(1 + f cos theta_i).

    Parameters are weights, (networks, inputs, outputs), and biases, (networks, 1, outputs), of the layers in turn; x,
    (n, 6), is of `half_and_difference`, cos_i is (n, 1), and the target log(1 + f cos theta_i) of the samples,
    (n, channels).
    """
    weights, biases = parameters[::2], parameters[1::2]
    *inputs, last = _forward(weights, biases, x)
    inner = 1 + _reflectance(last) * cos_i
    floored = np.maximum(inner, _LEAST)
    outer = np.sign(np.log(floored) - target) * cos_i * np.exp(np.minimum(last, _STEEPEST)) / floored
    outer /= target.size
    found: list[SingleArray] = []
    for layer in reversed(range(len(weights))):
        found = [inputs[layer].swapaxes(-1, -2) @ outer, outer.sum(axis=-2, keepdims=True), *found]
        if layer:
            outer = (outer @ weights[layer].swapaxes(-1, -2)) * (inputs[layer] > 0)
    return found


class _Adam:
    """The state of Adam, which moves arrays in place."""

    def __init__(self, parameters: list[SingleArray]) -> None:
        self.parameters, self.step = parameters, 0
        self.means, self.squares = ([np.zeros_like(array) for array in parameters] for _ in range(2))

    def move(self, gradients: list[SingleArray], rate: float) -> None:
        self.step += 1
        rate *= np.sqrt(1 - _BETA_2 ** self.step) / (1 - _BETA_1 ** self.step)
        for array, mean, square, slope in zip(self.parameters, self.means, self.squares, gradients, strict=True):
            mean += (1 - _BETA_1) * (slope - mean)
            square += (1 - _BETA_2) * (slope * slope - square)
            array -= np.float32(rate) * mean / (np.sqrt(square) + np.float32(_EPSILON))


def _forward(weights: Sequence[SingleArray], biases: Sequence[SingleArray], x: FloatArray | SingleArray) -> list[Any]:
    """The input of each layer, and the output of the last before the exponential."""
    passed: list[Any] = [x]
    for layer, (weight, bias) in enumerate(zip(weights, biases, strict=True)):
        sums = passed[-1] @ weight + bias
        passed.append(np.maximum(sums, 0) if layer + 1 < len(weights) else sums)
    return passed


def _reflectance(last: Any) -> Any:
    """exp(last) - 1, finite."""
    return np.expm1(np.minimum(last, _STEEPEST))


def _start(random: np.random.Generator, values: FloatArray) -> list[SingleArray]:
    """Random weights of `STARTS` networks, whose outputs start near the median of the samples."""
    sizes = (6, HIDDEN, HIDDEN, values.shape[1])
    parameters = []
    for inputs, outputs in itertools.pairwise(sizes):
        bound = np.sqrt(6 / inputs)         # K. He et al.: Delving Deep into Rectifiers, ICCV 2015
        parameters += [random.uniform(-bound, bound, (STARTS, inputs, outputs)).astype(np.float32),
                       np.zeros((STARTS, 1, outputs), np.float32)]
    parameters[-1] += np.log1p(np.maximum(np.median(values, axis=0), 1e-4)).astype(np.float32)
    return parameters


def _batches(random: np.random.Generator, indices: IntArray) -> Iterator[IntArray]:
    """Batches of at most `BATCH` indices, without end; each index once before any again, but for the rests."""
    while True:
        shuffled = random.permutation(indices)
        size = min(BATCH, len(indices))
        yield from (shuffled[first:first + size] for first in range(0, len(shuffled) - size + 1, size))

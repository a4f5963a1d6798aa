"""The table of a closure mixture, and how a view of it is written; `shader_constants` describes the rows."""

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from ..shader_constants import ALBEDO_SCALE, GGX, KNOTS, LOBES, ROW, WEIGHTS
from .nonnegative import shares

_PROBABILITY = 6.0              # REMAINDER_PROBABILITY per share of the light that the mixture misplaces ...
_PROBABILITIES = (0.2, 1.0)     # ... and its bounds
_ALBEDOS = (0.95, 1.05)         # bounds of the sum of the weights, in albedos, where microfacet lobes fix a part ...
_LEAST_FREE = 1.02              # ... and the least sum, in weights that are fixed
_LEAST_COLOUR = 0.02            # of a lobe in a channel, in the largest of them: no channel is lost
_MOST_PICKED = 0.5              # probability of following a sampled direction, where there is one
_ALBEDO_SCALES = (0.7, 1.5)     # bounds of the factor that gives the mixture the albedo of the fit
LAST_SHOWN = np.radians(80)     # the last view whose error the panel states
DIM = 0.1                       # share of the target that the sampled directions are prepared to carry anywhere
UNIFORM_REFLECTED = 0.02        # share of that table that is spread evenly
UNIFORM = 0.05                  # share of the table that is spread evenly


class Principal(NamedTuple):
    """The axes of an anisotropic surface.

    Attributes
    ----------
    turn : float
        Azimuth of the first, radians: that along which highlights are longest.
    stretch : float
        By which slopes along it are divided, and across it multiplied, so that highlights become round.
    half_turn : bool
        Whether half a turn of the surface changes nothing.
    """

    turn: float
    stretch: float
    half_turn: bool


class Mixture(NamedTuple):
    """The mixture for every tabulated view: of an isotropic fit VIEWS, and else as many as `half_vector_grid.views`
    has.

    Attributes
    ----------
    table : (views, ROW, channels)
        Rows as `shader_constants` describes them. The knots of a ramp are divided by its weight.
    numbers : (views, NUMBERS), or (views, NUMBERS + 3 LOBES) where it is anisotropic
        What is equal in all channels, as `shader_constants` describes it.
    missing : (views, cells, channels)
        The reflected radiance of the fit less the mixture, in the middle of each cell of `direction_grid` or of
        `half_vector_grid`.
    remainder, reflected : (views, cells) float32
        The sampling tables: of the remainder, and of directions that stand in for the mixture and carry all of the
        reflected radiance.
    error, worst : float
        Of Fast: the fraction of the reflected light that it puts in the wrong direction, in the mean over the views and
        in the worst of them up to 80 degrees.
    principal : Principal, or None
        None for an isotropic fit.
    """

    table: NDArray[np.float64]
    numbers: NDArray[np.float64]
    missing: NDArray[np.float64]
    remainder: NDArray[np.float32]
    reflected: NDArray[np.float32]
    error: float
    worst: float
    principal: Principal | None = None


def hats(x: NDArray[np.float64]) -> NDArray[np.float64]:
    """Piecewise linear basis on KNOTS knots over [0, 1]: (...) to (..., KNOTS)."""
    return np.maximum(0, 1 - np.abs(np.clip(x, 0, 1)[..., None] * (KNOTS - 1) - np.arange(KNOTS)))


def albedo_scale(target: NDArray[np.float64], mixture: NDArray[np.float64],
                 solid_angle: NDArray[np.float64]) -> NDArray[np.float64]:
    """The factor that gives a mixture, (n, channels), the albedo of the fit: (channels,)."""
    albedo, reflected = solid_angle @ target, solid_angle @ mixture
    return np.clip(np.where(reflected > 0, albedo / np.where(reflected > 0, reflected, 1), 1.0), *_ALBEDO_SCALES)


def remainder_numbers(share: float) -> list[float]:
    """REMAINDER_PROBABILITY and REMAINDER_WEIGHT, by the share of the light that the mixture misplaces."""
    probability = float(np.clip(_PROBABILITY * share, *_PROBABILITIES))
    return [probability, min(share / (1 + share) / probability, _MOST_PICKED)]


def row(kinds: list[int], basis: NDArray[np.float64], coefficients: NDArray[np.float64],
        scale: NDArray[np.float64], density: NDArray[np.float64],
        solid_angle: NDArray[np.float64]) -> NDArray[np.float64]:
    """A row of the table: (ROW, channels).

    Parameters
    ----------
    kinds : list of int
        Of the lobes.
    basis : (n, columns)
        KNOTS columns for a ramp, the diffuse one first, and one for a microfacet lobe.
    coefficients : (columns, channels)
    scale : (channels,)
        ALBEDO_SCALE.
    density : (LOBES + 1, n)
        With which Cycles samples the ramp and each lobe, per solid angle.
    solid_angle : (n,)
    """
    table = np.zeros((ROW, coefficients.shape[1]))
    mixture = basis @ coefficients
    albedo = float((solid_angle @ mixture).mean())
    best = shares(mixture, density, solid_angle)
    # the coefficient of a microfacet lobe is its weight; the others follow from the best shares
    fixed = [k for k, kind in enumerate(kinds, 1) if kind == GGX]
    free = [k for k in range(LOBES + 1) if k not in fixed]
    columns, start = [], 0
    for k in range(LOBES + 1):
        columns.append(slice(start, start + (1 if k in fixed else KNOTS)))
        start = columns[-1].stop
    taken = sum(float(coefficients[columns[k]].mean()) for k in fixed)
    total = max(albedo, 1e-6)
    if taken > 0:
        least, most = (bound * albedo for bound in _ALBEDOS)
        total = float(np.clip(taken / best[fixed].sum(), least, most))
    total = max(total, _LEAST_FREE * taken)
    for k in fixed:
        table[WEIGHTS + k] = coefficients[columns[k]][0]
    for k in free:
        part = coefficients[columns[k]]
        mean = best[k] / best[free].sum() * (total - taken)
        table[WEIGHTS + k] = mean * _colours(solid_angle @ (basis[:, columns[k]] @ part))
        table[k * KNOTS:(k + 1) * KNOTS] = part / table[WEIGHTS + k]
    table[ALBEDO_SCALE] = scale
    return table


def _colours(reflected: NDArray[np.float64]) -> NDArray[np.float64]:
    """What a lobe reflects, (channels,), scaled to a colour of mean 1."""
    reflected = np.maximum(reflected, _LEAST_COLOUR * reflected.max()) + 1e-9
    return np.asarray(reflected / reflected.mean())


def coefficients_of(table: NDArray[np.float64], kinds: list[int]) -> NDArray[np.float64]:
    """The coefficients of the basis functions of a row, (ROW, channels): (columns, channels)."""
    ramps = table[:WEIGHTS].reshape(LOBES + 1, KNOTS, -1) * table[WEIGHTS:WEIGHTS + LOBES + 1, None]
    return np.concatenate([ramps[0], *(table[WEIGHTS + k][None] if kind == GGX else ramps[k]
                                       for k, kind in enumerate(kinds, 1))])


def rounded(values: NDArray[np.float64]) -> NDArray[np.float64]:
    """Values to four digits, which keeps the shader's source short."""
    unit = 10.0 ** (np.floor(np.log10(np.abs(values) + 1e-30)) - 3)
    return np.asarray(np.round(values / unit) * unit)

"""The share of light that measurements reflect, estimated from the samples alone, and what would explain one that no
surface has: percent, a factor of pi, a cosine, degrees.

The estimate is the integral of f cos(theta_o) for light from three of the measured angles. In each direction f is that
of the sample that is nearest in the half vector first, and then in the angle between the light and it (S. M.
Rusinkiewicz: A New Change of Variables for Efficient BRDF Representation, 1998). The brightest tenth of the directions
counts as the next: narrow highlights are measured too coarsely for an integral.
"""

from collections.abc import Iterator
from dataclasses import dataclass, replace

import numpy as np

from ..arrays import FloatArray
from ..samples import HORIZON, Samples, subsample

PLAUSIBLE = 1.3             # estimates of real surfaces are up to 1.1
DARKEST_SURFACE = 0.002     # with the brightest directions: Aeroglaze's black paint has .016, of published fits the
                            # darkest .0035; what is divided by MERL's scale once too often has a 1500th of what it had
_MOST = 3000                # samples
_ALBEDO_CELLS = 20          # of the integral, along radius and azimuth
_FROM = (0.1, 0.5, 0.9)     # quantiles of theta_i
_STEEPEST = np.radians(75)
_BRIGHTEST = 0.9            # the quantile that brighter directions count as
_ALL_AT_NORMAL = np.radians(1.6)    # pi/2, read as degrees
_LEAST_EXPLAINED = 0.03     # an explanation leaves at least so much
_PERCENT = 10.0             # times the light that arrives, from which it may be percent
_SCALES_DOWN = (            # by what notes of reading say
    ("Multiplied by MERL's scale", 1500 / 1.66, "values in 1/sr, which MERL's scale has divided by 1500? (Store MERL's "
     "numbers, 1500 times as much)"),
    *((note, times, "not in percent? (Values: brdf, or reflectance_factor)") for note, times in (
        ("In percent", 100.0), ("Reflectance factors in percent", 100 * np.pi), ("Multiplied by 0.01,", 100.0),
        ("Multiplied by 0.003183,", 100 * np.pi))))
_WEIGHTS = np.array([2.0, 2.0, 1.0, 0.3, 0.3])


@dataclass(frozen=True)
class Albedo:
    """What measurements reflect, and why it may be too much."""

    share: float                # of the channel and the angle with the largest, without the brightest directions
    # questions that would explain a share above `PLAUSIBLE`, or of next to nothing, or angles all at the normal
    reasons: tuple[str, ...] = ()
    is_dark: bool = False       # whether the share is below `DARKEST_SURFACE` with the brightest directions, too

    @property
    def is_doubtful(self) -> bool:
        """Whether no surface is like this, or its angles are none of a measurement."""
        return self.share > PLAUSIBLE or self.is_dark or bool(self.reasons)

    def text(self) -> str:
        """The share, and what would explain it."""
        what = f"{self.share:.2g} or more"
        if not self.is_doubtful:
            return what
        if self.share > PLAUSIBLE:
            what = f"{self.share:,.3g} times the light that arrives"
        elif self.is_dark:
            what = f"{self.share:.2g} of the light that arrives, less than the blackest paints"
        return f"{what}: {' or '.join(self.reasons) or 'in which units?'}"


def estimate(samples: Samples) -> Albedo:
    """Estimate what measurements reflect."""
    share, whole = _share(samples), _share(samples, brightest=1.0)
    reasons, is_dark = [], whole < DARKEST_SURFACE
    if max(samples.theta_i.max(), samples.theta_o.max()) < _ALL_AT_NORMAL and len(samples) > 1:
        reasons.append("angles in radians? (Angles: radians)")
    elif share > PLAUSIBLE:
        reasons += _reasons(samples, share)
    elif is_dark:
        reasons += [question for note, times, question in _SCALES_DOWN if _LEAST_EXPLAINED < whole * times < PLAUSIBLE
                    and any(each.startswith(note) for each in samples.notes)]
    return Albedo(share, tuple(reasons), is_dark)


def implausibility_message(samples: Samples) -> str:
    """The message about measurements that no surface has; empty for others."""
    found = estimate(samples)
    return f"{samples.name} reflects {found.text()}" if found.is_doubtful else ""


def _reasons(samples: Samples, share: float) -> Iterator[str]:
    """What would make a share plausible."""
    scales = ((np.pi, "reflectance factors? (Values: reflectance_factor)", 0.0),
              (100, "in percent? (Values: brdf_percent)", _PERCENT),
              (100 * np.pi, "reflectance factors in percent? (Values: reflectance_percent)", _PERCENT))
    for times, question, least in scales:
        if share > least and _LEAST_EXPLAINED < share / times < PLAUSIBLE:
            yield question
    for name in ("theta_i", "theta_o"):
        if any(note.startswith(f"Divided by the cosine of {name}") for note in samples.notes):
            without = samples.values * np.cos(getattr(samples, name))[:, None]
            if _share(replace(samples, values=without)) < PLAUSIBLE:
                yield "the BRDF, without a cosine? (Values: brdf)"


def _share(samples: Samples, brightest: float = _BRIGHTEST) -> float:
    """The largest share of light that is reflected, of any channel; directions brighter than a quantile count as it."""
    fewer = subsample(samples, _MOST)
    known = _features(*fewer.directions, fewer.isotropic)
    squares = (known ** 2).sum(axis=1)
    radius = np.sqrt((np.arange(_ALBEDO_CELLS) + 0.5) / _ALBEDO_CELLS)
    azimuth = np.pi * (2 * np.arange(_ALBEDO_CELLS) + 1) / _ALBEDO_CELLS
    radii, turns = (grid.ravel() for grid in np.meshgrid(radius, azimuth))
    shares = [0.0]
    for quantile in _FROM:
        k = int(np.argsort(fewer.theta_i, kind="stable")[int(quantile * (len(fewer) - 1))])
        theta, turn = min(float(fewer.theta_i[k]), _STEEPEST), float(fewer.phi_i[k])
        wanted = _features(np.full(len(radii), theta), np.full(len(radii), turn), np.arcsin(radii), turns + turn,
                           fewer.isotropic)
        nearest = (squares - 2 * wanted @ known.T).argmin(axis=1)
        values = np.maximum(fewer.values[nearest], 0)
        values = np.minimum(values, np.quantile(values, brightest, axis=0))
        shares.append(float(np.pi * values.mean(axis=0).max()))
    return max(shares)


def _features(theta_i: FloatArray, phi_i: FloatArray, theta_o: FloatArray, phi_o: FloatArray,
              isotropic: bool) -> FloatArray:
    """What makes values alike, (n, 5): the half vector, the angle between it and the light, and where the detector is.

    The half vector of an isotropic material has no azimuth.
    """
    apart = phi_o - phi_i
    x, y = np.sin(theta_i) + np.sin(theta_o) * np.cos(apart), np.sin(theta_o) * np.sin(apart)
    z = np.cos(theta_i) + np.cos(theta_o)
    steep = np.sqrt(np.arctan2(np.hypot(x, y), z) / HORIZON)       # finer near the mirror direction
    azimuth = np.zeros(len(x)) if isotropic else np.arctan2(y, x) + phi_i
    half = np.arctan2(np.hypot(np.hypot(x, y), z), np.sqrt(np.maximum(4 - x * x - y * y - z * z, 0)))
    return np.stack([steep * np.cos(azimuth), steep * np.sin(azimuth), half, np.sin(theta_o) * np.abs(np.sin(apart)),
                     np.sin(theta_o) * np.cos(apart)], axis=1) * _WEIGHTS

"""The colour of a highlight that lies between samples: a mean of theirs by inverse distances (D. Shepard: A
Two-Dimensional Interpolation Function for Irregularly-Spaced Data, 23rd ACM National Conference, 1968), as
docs/fitting.md has it (step 4).

A Gaussian process takes the handful of samples in a highlight for noise amid the many around it, each channel for
itself: a grey highlight on a paint of saturated colours gets one of these, or one that no sample has. Brightness, the
sum over channels of the reflectance, stays the process's: of the field a channel that is as good as black would have as
large a part as any other. One sample that is much brighter than the others does not decide alone.
"""

from dataclasses import dataclass, replace

import numpy as np

from ..arrays import Directions, FloatArray, IntArray, select_directions
from ..coordinates import Coordinates
from ..model.microfacet import Microfacet
from ..model.transform import LogRelative
from ..samples import Samples

_WIDEST = 0.05              # a lobe, as a slope; samples resolve wider ones
_POWER = 3.0                # of inverse squared distances
_COINCIDENT = 1e-6          # squared distance of samples that are taken as one
_LEAST_SHARE = 0.01         # up to which a direction is outside of the highlight
_FAILED_NOISE = 1.0         # noise, relative to the field's variance, above which a sample says nothing


@dataclass(frozen=True)
class HighlightColour:
    """What samples say of a highlight's colour."""

    transform: LogRelative
    coordinates: Coordinates    # those in which distances are measured
    mu: FloatArray              # the samples' coordinates, 2 x - 1, (n, axes)
    colours: FloatArray         # the samples' values, less their mean over channels, (n, channels)
    weights: FloatArray         # what samples weigh at equal distances, (n,): their share of the highlight

    def blend(self, directions: Directions, continued: FloatArray, left_out: bool = False) -> FloatArray:
        """The log of relative reflectance that a Gaussian process predicts at directions, `continued`, (n, channels),
        with the colour of the samples' weighted mean in highlights, at the same brightness. With `left_out`, the
        directions are the samples', of which none is to know its own value."""
        share = highlight_share(self.transform, directions)
        which = np.flatnonzero(share > _LEAST_SHARE)
        blended = continued.copy()
        if len(which):
            at = select_directions(directions, which)
            colours = continued[which] - continued[which].mean(axis=1, keepdims=True)
            means = self._weighted_means(at, which if left_out else None)
            recoloured = continued[which] + share[which, None] * (means - colours)
            bright = self.transform.prior.evaluate(*at) + self.transform.offset
            before, after = ((bright * np.exp(each)).sum(axis=1, keepdims=True)
                             for each in (continued[which], recoloured))
            blended[which] = recoloured + np.log(before / after)
        return blended

    def _weighted_means(self, directions: Directions, own: IntArray | None) -> FloatArray:
        """The samples' means by inverse distances, without those of the numbers `own` where these are given."""
        mu = 2 * self.coordinates.encode(*directions) - 1
        # the nearer of a sample and its reciprocal
        apart = np.minimum(*(((mu[:, None] - exchanged * self.mu) ** 2).sum(axis=2)
                             for exchanged in np.array([[1, 1, 1], [1, -1, 1]])))
        weights = self.weights / (apart + _COINCIDENT) ** _POWER
        if own is not None:
            weights[np.arange(len(own)), own] = 0
        return np.asarray(weights @ self.colours / weights.sum(axis=1, keepdims=True))


def highlight_share(transform: LogRelative, directions: Directions) -> FloatArray:
    """The squared share that the narrowest mirror lobe has in a prior, 0 of wide ones: (n,)."""
    prior = transform.prior
    mirrors = [number for number, kind in enumerate(prior.kinds) if kind == "mirror" and prior.alpha[number] < _WIDEST]
    if not mirrors:
        return np.zeros(len(directions[0]))
    own = [min(mirrors, key=lambda number: prior.alpha[number])]
    lobe = Microfacet(0 * prior.kd, prior.ks[own], prior.alpha[own], prior.gamma[own], prior.f0[own])
    part, whole = (each.evaluate(*directions).mean(axis=1) for each in (lobe, prior))
    return np.asarray((part / (whole + transform.offset)) ** 2)


def find(samples: Samples, transform: LogRelative, coordinates: Coordinates, known: FloatArray, left_out: FloatArray,
         ) -> tuple[HighlightColour | None, FloatArray]:
    """The highlight of samples, or None where the process predicts these better; and how they are predicted, (n,
    channels). `known`, (n,), is the variance of each sample's noise, relative to that of the field; `left_out`, (n,
    channels), each sample's field as the process of the others has it."""
    share = np.where(known < _FAILED_NOISE, highlight_share(transform, samples.directions), 0.0)
    if np.count_nonzero(share) < 2 or left_out.shape[1] == 1:
        return None, left_out
    field = transform.field(samples.values, *samples.directions)
    found = HighlightColour(transform, coordinates, 2 * coordinates.encode(*samples.directions) - 1,
                            field - field.mean(axis=1, keepdims=True), share)
    blended = found.blend(samples.directions, left_out, left_out=True)
    wanted, bounded = np.cbrt(np.maximum(samples.values, 0)), replace(transform, floor=0.0)
    before, after = (((np.cbrt(bounded.reflectance(each, *samples.directions)) - wanted) ** 2).sum(axis=1)
                     for each in (left_out, blended))
    better = after.sum() < before.sum() and np.count_nonzero(after < before) >= np.count_nonzero(after > before)
    return (found, blended) if better else (None, left_out)

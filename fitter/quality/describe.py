"""What a table of measurements holds, said before anything is fitted to it: coverage, holes, and doubtful values."""

from dataclasses import dataclass

import numpy as np

from .coverage import widest_hole

WIDE_GAP = 25.0             # degrees: a fit across a wider gap is a guess


@dataclass(frozen=True)
class Description:
    """What a table of measurements holds; angles in degrees.

    Attributes
    ----------
    name : str
    channels : tuple of str
    count : int
        Direction pairs.
    theta_i, theta_o : (float, float)
        Smallest and largest incident and outgoing polar angle.
    gap : float
        The widest hole: no sample, nor its reciprocal, has both its directions nearer than this to those of `gap_at`.
    gap_at : (float, float, float)
        Incident and outgoing polar angle and the azimuth between them.
    negative : int
        Values below 0, over all channels.
    saturated : int
        Values that share their channel's maximum, as those of an overflowing detector do, or that were marked as such.
    lowest, mean, highest : (channels,) tuple of float
        1/sr.
    """

    name: str
    channels: tuple
    count: int
    theta_i: tuple
    theta_o: tuple
    gap: float
    gap_at: tuple
    negative: int
    saturated: int
    lowest: tuple
    mean: tuple
    highest: tuple

    def rows(self):
        """The description in words: a list of (label, text, whether it is a reason to worry)."""
        values = len(self.channels) * self.count
        at = "{:.0f}° in, {:.0f}° out, {:.0f}° around".format(*self.gap_at)
        rows = [("Samples", f"{self.count:,} direction pairs, {' '.join(self.channels)}", False),
                ("Incident", "{:.1f}° to {:.1f}°".format(*self.theta_i), False),
                ("Outgoing", "{:.1f}° to {:.1f}°".format(*self.theta_o), False),
                ("Widest hole", f"{self.gap:.0f}° at {at}", self.gap > WIDE_GAP),
                ("Negative", f"{self.negative:,} of {values:,} values", self.negative > 0),
                ("Saturated", f"{self.saturated:,} of {values:,} values", self.saturated > 0)]
        rows += [(f"Range {channel}", f"{low:.4g} to {high:.4g} / sr, mean {mean:.4g}", False)
                 for channel, low, mean, high in zip(self.channels, self.lowest, self.mean, self.highest, strict=True)]
        return rows


def describe(samples, overflowed=None):
    """Describe measurements.

    Parameters
    ----------
    samples : Samples
    overflowed : (n,) bool array, optional
        Samples that are known to be saturated.

    Returns
    -------
    Description
    """
    values = samples.values
    gap, at = widest_hole(samples)
    return Description(samples.name, samples.channels, len(samples), _range(samples.theta_i), _range(samples.theta_o),
                       gap, at, int(np.count_nonzero(values < 0)), _saturated(values, overflowed),
                       *(tuple(map(float, column)) for column in (values.min(0), values.mean(0), values.max(0))))


def _range(theta):
    return float(np.degrees(theta.min())), float(np.degrees(theta.max()))


def _saturated(values, overflowed):
    plateau = (values == values.max(axis=0)) & (values > 0)
    plateau &= plateau.sum(axis=0) > 1
    if overflowed is not None:
        plateau |= np.asarray(overflowed)[:, None]
    return int(np.count_nonzero(plateau))

"""What a table of measurements holds, said before anything is fitted to it: coverage, holes, and doubtful values."""

from dataclasses import dataclass

import numpy as np

_PROBE_THETA = np.radians(np.arange(10, 81, 10))            # nearer to the horizon few instruments measure
_PROBE_AZIMUTH = np.radians(np.arange(0, 181, 15))
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
    gap, at = _widest_gap(samples)
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


def _widest_gap(samples):
    """The probed pair of directions that is farthest from every sample: degrees, and its angles."""
    theta_i, theta_o = (np.concatenate(pair) for pair in ((samples.theta_i, samples.theta_o),
                                                          (samples.theta_o, samples.theta_i)))
    azimuth = np.tile(samples.phi_o - samples.phi_i, 2)
    outgoing = _vectors(theta_o, azimuth)
    probe_o, probe_azimuth = (grid.ravel() for grid in np.meshgrid(_PROBE_THETA, _PROBE_AZIMUTH, indexing="ij"))
    between_outgoing = np.arccos(np.clip(_vectors(probe_o, probe_azimuth) @ outgoing.T, -1, 1))
    widest, at = -1.0, None
    for probe_i in _PROBE_THETA:
        distance = np.maximum(np.abs(theta_i - probe_i), between_outgoing).min(axis=1)
        k = distance.argmax()
        if distance[k] > widest:
            widest, at = distance[k], (probe_i, probe_o[k], probe_azimuth[k])
    return float(np.degrees(widest)), tuple(float(angle) for angle in np.degrees(at))


def _vectors(theta, azimuth):
    """Unit vectors in the frame of the incident direction, folded into its one half: (n,) and (n,) to (n, 3)."""
    sin = np.sin(theta)
    return np.stack([sin * np.cos(azimuth), sin * np.abs(np.sin(azimuth)), np.cos(theta)], axis=1)

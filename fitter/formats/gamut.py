"""Samples in another colour space, and how far they lie outside of it."""

from dataclasses import replace

import numpy as np

from ..colours import DEFAULT_COLOURS, conversion, luminance
from ..samples import RGB, Samples, freeze_new_arrays


def convert_samples(samples: Samples, colours: str) -> Samples:
    """Samples in linear Rec.709 as those of another of `colours.COLOURS`, with notes. Grey ones stay as they are.

    A colour outside of a space has a channel below 0 there. It stays so: a wider space holds it.
    """
    if samples.channels != RGB:
        return samples
    notes: tuple[str, ...] = ()
    if colours != DEFAULT_COLOURS:
        values = samples.values @ conversion(DEFAULT_COLOURS, colours).T
        freeze_new_arrays(values)
        samples, notes = replace(samples, values=values, colours=colours), (f"Colours in {colours}",)
        if (below := samples.subsurface) is not None:
            albedo = np.clip(conversion(DEFAULT_COLOURS, colours) @ below.albedo, 0, 1)
            samples = replace(samples, subsurface=replace(below, albedo=albedo))
    notes += _outside(samples)
    return replace(samples, notes=(*samples.notes, *notes)) if notes else samples


def _outside(samples: Samples) -> tuple[str, ...]:
    """A note of how many samples lie outside of their space, and how far; none where all lie inside.

    Samples of no or negative luminance, which are noise, do not count.
    """
    outside = (samples.values.min(axis=1) < 0) & (luminance(samples.values, samples.colours) > 0)
    count = int(np.count_nonzero(outside))
    if not count:
        return ()
    below = -samples.values[outside].min()
    mean = luminance(samples.values.mean(axis=0, keepdims=True), samples.colours)[0]
    percent = 100 * below / mean if mean > 0 else 0
    size = (f"{below:.2g} / sr" if mean <= 0 else
            f"{percent:.2g} % of the mean luminance" if percent < 10 else f"{percent:,.0f} % of the mean luminance")
    return (f"Outside of {samples.colours}: {count:,} of {len(samples):,} samples, by up to {size}",)

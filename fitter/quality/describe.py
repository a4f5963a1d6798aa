"""A description of measurements for users, before they fit them: coverage, holes, and doubtful values."""

from dataclasses import dataclass

import numpy as np

from ..arrays import FloatArray
from ..samples import Rotations, Samples, rotations
from ..shader_constants import GRAZING
from . import albedo, conventions
from .coverage import widest_gap

WIDE_GAP = 25.0             # degrees: no fit is reliable across a wider hole


@dataclass(frozen=True)
class Description:
    """A description of measurements; angles in degrees, values in 1/sr."""

    name: str
    channels: tuple[str, ...]
    count: int                                  # direction pairs
    theta_i: tuple[float, float]                # smallest and largest polar angle
    theta_o: tuple[float, float]
    gap: float  # the widest hole: the distance from `gap_at` to the nearest sample (see `coverage`)
    gap_at: tuple[float, ...]                   # as `widest_gap` returns it
    negative: int                               # values below 0, over all channels
    saturated: int  # values at their channel's maximum, as a saturated detector has them, or of `Samples.saturated`
    lowest: tuple[float, ...]                   # of each channel
    mean: tuple[float, ...]
    highest: tuple[float, ...]
    albedo: albedo.Albedo
    notes: tuple[str, ...] = ()                 # what reading made of the file
    # of an anisotropic material: measured, or by symmetry or the file's interpolation
    rotations: Rotations | None = None
    questions: tuple[str, ...] = ()             # what is to be asked of its directions (`conventions`),
    value_questions: tuple[str, ...] = ()       # and of its values

    @property
    def largest_angle(self) -> float:
        """The largest measured angle, degrees: what a fit is beyond it is a guess."""
        return max(self.theta_i[1], self.theta_o[1])

    def rows(self) -> list[tuple[str, str, bool]]:
        """The description in words: a list of (label, text, whether the user should be warned)."""
        values = len(self.channels) * self.count
        at = "{:.0f}° in, {:.0f}° out, {:.0f}° around".format(*self.gap_at[:3])
        kind = "isotropic"
        if self.rotations is not None:
            kind = (f"anisotropic, given at {self.rotations.count:,} rotation{'s' * (self.rotations.count > 1)} from "
                    f"{self.rotations.first:g}° to {self.rotations.last:g}°")
            at += f", turned by {self.gap_at[3]:.0f}°"
        rows = [("Samples", f"{self.count:,} direction pairs, {' '.join(self.channels)}", False),
                ("Material", kind, False),
                ("Incident", "{:.1f}° to {:.1f}°".format(*self.theta_i), False),
                ("Outgoing", "{:.1f}° to {:.1f}°".format(*self.theta_o), False),
                ("Widest hole", f"{self.gap:.0f}° at {at}", self.gap > WIDE_GAP),
                ("Negative", f"{self.negative:,} of {values:,} values", self.negative > 0),
                ("Saturated", f"{self.saturated:,} of {values:,} values", self.saturated > 0),
                ("Albedo", self.albedo.text(), self.albedo.is_doubtful)]
        if self.largest_angle < np.degrees(GRAZING):
            rows.insert(4, ("Guessed", f"beyond {self.largest_angle:.0f}°, where nothing was measured", False))
        rows += [(f"Range {channel}", f"{low:.4g} to {high:.4g} / sr, mean {mean:.4g}", False)
                 for channel, low, mean, high in zip(self.channels, self.lowest, self.mean, self.highest, strict=True)]
        rows += [("Values", question, True) for question in self.value_questions]
        rows += [("Angles", question, True) for question in self.questions]
        return rows + [("Read", note, _is_question(note)) for note in self.notes]


def describe(samples: Samples) -> Description:
    """Describe measurements."""
    values = samples.values
    gap, at = widest_gap(samples)
    return Description(samples.name, samples.channels, len(samples), _range(samples.theta_i), _range(samples.theta_o),
                       gap, at, int(np.count_nonzero(values < 0)), _count_saturated(samples),
                       _floats(values.min(0)), _floats(values.mean(0)), _floats(values.max(0)),
                       albedo.estimate(samples), samples.notes,
                       None if samples.isotropic else rotations(samples.theta_i, samples.phi_i),
                       conventions.questions(samples), _value_questions(samples))


def open_questions(samples: Samples) -> tuple[str, ...]:
    """What is to be asked about measurements before a fit of them is believed, each with their name: of the light that
    they reflect (`albedo`), of their values and directions (`conventions`), and what reading them asked."""
    asked = (*_value_questions(samples), *conventions.questions(samples), *filter(_is_question, samples.notes))
    return tuple(filter(None, (albedo.implausibility_message(samples), *(f"{samples.name}: {each}" for each in asked))))


def _value_questions(samples: Samples) -> tuple[str, ...]:
    lowest, highest = samples.values.min(axis=0), samples.values.max(axis=0)
    dark = [name for name, most in zip(samples.channels, highest, strict=True) if most <= 0]
    found = [f"No value of {' and '.join(dark)} is above 0: was it measured?"] if dark else []
    if -lowest.min() > highest.max():       # noise around 0 goes as far up
        found.append(f"Values down to {lowest.min():.4g} / sr, farther below 0 than any is above: do they mark what "
                     "was not measured?")
    return tuple(found)


def _is_question(note: str) -> bool:
    return note.endswith("?")


def _floats(values: FloatArray) -> tuple[float, ...]:
    return tuple(map(float, values))


def _range(theta: FloatArray) -> tuple[float, float]:
    """Smallest and largest angle, radians to degrees."""
    return float(np.degrees(theta.min())), float(np.degrees(theta.max()))


def _count_saturated(samples: Samples) -> int:
    """The number of values at their channel's maximum, if several are, or of saturated samples."""
    plateau = (samples.values == samples.values.max(axis=0)) & (samples.values > 0)
    plateau &= plateau.sum(axis=0) > 1
    if samples.saturated is not None:
        plateau |= samples.saturated[:, None]
    return int(np.count_nonzero(plateau))

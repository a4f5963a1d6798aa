"""What the report compares: ways to make a model of samples, by name."""

from .. import fit
from ..presets import PRESETS
from .baselines import koenderink, lafortune

BASELINES = ("Koenderink 8", "Lafortune 3")


def preset(name):
    """The fit that a preset asks for: samples to Fit."""
    return lambda samples: fit(samples, **PRESETS[name])


def levels(*choice):
    """The paper's fit at (D, S, C), or at D alone for plain MBA: samples to Fit."""
    return lambda samples: fit(samples, *(choice if len(choice) > 1 else (*choice, None)))


# each returns something with `evaluate`, `nbytes` and `coefficient_count`
METHODS = {"level 6": levels(6), "Paper": preset("Paper"), "Standard": preset("Standard"),
           BASELINES[0]: koenderink.fit, BASELINES[1]: lafortune.fit}

"""The models that the report compares, by name."""

from .. import fit
from ..presets import PRESETS
from .baselines import koenderink, lafortune
from .rows import MakeModel

BASELINES = ("Koenderink 8", "Lafortune 3")


def preset(name: str) -> MakeModel:
    """A function that fits samples with a preset."""
    return lambda samples: fit(samples, **PRESETS[name])


def levels(diffuse: int, specular: int | None = None, compression: float = 95.0) -> MakeModel:
    """A function that fits samples by the paper's method at (D, S, C), or at D alone for plain MBA."""
    return lambda samples: fit(samples, diffuse, specular, compression)


METHODS: dict[str, MakeModel] = {"level 6": levels(6), "Paper": preset("Paper"), "Standard": preset("Standard"),
           BASELINES[0]: koenderink.fit, BASELINES[1]: lafortune.fit}

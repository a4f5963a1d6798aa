"""The models that the report compares, by name."""

from fitter import fit
from fitter.methods.presets import PRESETS

from .baselines import ggx, koenderink, lafortune, neural, thin_plate
from .rows import MakeModel

BASELINES = ("Koenderink 8", "Lafortune 3")
"""Those of the paper, which its claims are about."""
RIVALS = ("GGX", "Thin plate", "Neural")
"""What a researcher would try first today."""


def preset(name: str) -> MakeModel:
    """A function that fits samples with a preset."""
    return lambda samples: fit(samples, **PRESETS[name])


def levels(diffuse: int, specular: int | None = None, compression: float = 95.0) -> MakeModel:
    """A function that fits samples by the paper's method at (D, S, C), or at D alone for plain MBA."""
    return lambda samples: fit(samples, diffuse, specular, compression)


METHODS: dict[str, MakeModel] = {"level 6": levels(6), "Paper": preset("Paper"), "Standard": preset("Standard"),
           BASELINES[0]: koenderink.fit, BASELINES[1]: lafortune.fit,
           RIVALS[0]: ggx.fit, RIVALS[1]: thin_plate.fit, RIVALS[2]: neural.fit}

"""The models that the report compares, by name."""

from collections.abc import Callable
from typing import Protocol

from fitter import fit
from fitter.methods.presets import PRESETS
from fitter.model import Reflectance
from fitter.samples import Samples

from .baselines import ggx, koenderink, lafortune, neural, thin_plate

BASELINES = ("Koenderink 8", "Lafortune 3")
"""Those of the paper, which its claims are about."""
RIVALS = ("GGX", "Thin plate", "Neural")
"""What a researcher would try first today."""


class Model(Reflectance, Protocol):
    """A BRDF that was fitted to samples, and what it takes to store it."""

    @property
    def coefficient_count(self) -> int:
        """Coefficients stored, counted once whatever the number of channels."""
        ...

    @property
    def nbytes(self) -> int:
        """Bytes that must be stored to evaluate all channels, in single precision."""
        ...


MakeModel = Callable[[Samples], Model]


def preset(name: str) -> MakeModel:
    return lambda samples: fit(samples, **PRESETS[name])


def levels(diffuse: int, specular: int | None = None, compression: float = 95.0) -> MakeModel:
    """Fits by the paper's method at (D, S, C), or at D alone for plain MBA."""
    return lambda samples: fit(samples, diffuse, specular, compression)


METHODS: dict[str, MakeModel] = {"level 6": levels(6), "Paper": preset("Paper"), "Standard": preset("Standard"),
           BASELINES[0]: koenderink.fit, BASELINES[1]: lafortune.fit,
           RIVALS[0]: ggx.fit, RIVALS[1]: thin_plate.fit, RIVALS[2]: neural.fit}

"""What a fitting method is."""

from typing import Any, Literal, Protocol

from ..model.fit import Fit
from ..samples import Samples
from .levels import Levels

MethodName = Literal["mba", "kriging"]
"""The keys of `METHODS`."""


class Method(Protocol):
    """A function that makes a `Fit` of `Samples`; each has a module of its own, named after the method."""

    def __call__(self, samples: Samples, levels: Levels, plausible: bool, *args: Any, **options: Any) -> Fit:
        """Fit samples with lattices of the given levels.

        Parameters
        ----------
        samples : Samples
            No two channels are equal.
        plausible : bool
            Make the fit physically plausible, where the method can.
        *args, **options
            Of the method.

        Returns
        -------
        Fit
            With the samples' channels, name and source.
        """
        ...

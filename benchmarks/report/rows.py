"""Types of the report's data."""

from collections.abc import Callable
from typing import Any, Protocol

from fitter.model import Reflectance
from fitter.samples import Samples

Row = dict[str, Any]
"""A row of a table, by column: numbers and text, as JSON takes them."""
Results = dict[str, Any]
"""What results.json holds: tables, which are lists of rows, and facts about the run."""


class Model(Reflectance, Protocol):
    """A BRDF that was fitted to samples, and what it takes to store it: `Fit`, `Koenderink`, `Lafortune`."""

    @property
    def coefficient_count(self) -> int:
        """Coefficients stored, counted once whatever the number of channels."""
        ...

    @property
    def nbytes(self) -> int:
        """Bytes that must be stored to evaluate all channels."""
        ...


MakeModel = Callable[[Samples], Model]
"""Fits samples."""

"""Types of the report's data."""

from collections.abc import Callable
from typing import Any

from ..model import Model
from ..samples import Samples

Row = dict[str, Any]
"""A row of a table, by column: numbers and text, as JSON takes them."""
Results = dict[str, Any]
"""What results.json holds: tables, which are lists of rows, and facts about the run."""
MakeModel = Callable[[Samples], Model]
"""Fits samples."""

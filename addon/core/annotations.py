"""Names for types that annotations share, and what all rooms make of them. Nothing here imports bpy."""

import json
from typing import TYPE_CHECKING, Any, TypeVar, cast

if TYPE_CHECKING:
    import bpy
    from bpy.stub_internal.rna_enums import OperatorReturnItems  # only Blender's type stubs have it

    OperatorResult = set[OperatorReturnItems]
    OperatorMixIn = bpy.types.Operator      # lets a mix-in use what its operator has
else:
    OperatorResult = set
    OperatorMixIn = object

Arguments = dict[str, Any]
"""Keyword arguments of `fitter.fit`, or ``{"tolerance": RMSE}``."""
Vector3 = tuple[float, float, float]
_T = TypeVar("_T")


def as_text(arguments: Arguments) -> str:
    """Arguments as text, which a material remembers, and which is part of keys."""
    return json.dumps(arguments, sort_keys=True)


def not_none(value: _T | None) -> _T:
    """A value that Blender's type stubs call optional, and that is never None where this is called."""
    return cast(_T, value)

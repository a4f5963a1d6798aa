"""What is to be said of photographs that were measured."""

from collections.abc import Callable, Sequence
from typing import NamedTuple, TypeVar

from ...quality.verdict import UNPREDICTED, Judgement, prediction_message
from .photograph import Photograph

_Photograph = TypeVar("_Photograph", bound=Photograph)


class MeasurementReport(NamedTuple):
    """What is to be said of what was measured: lines, and those of them that say that something is wrong."""

    lines: tuple[str, ...]
    doubts: tuple[str, ...]


def judge_left_out(photographs: Sequence[_Photograph], number: int,
                   error: Callable[[list[_Photograph], _Photograph], float]) -> Judgement:
    """How far one of photographs is from what the others say of it, of its root mean square, in words."""
    others, shot = [*photographs[:number], *photographs[number + 1:]], photographs[number]
    return UNPREDICTED if len(others) < 2 else prediction_message(shot.name, error(others, shot))

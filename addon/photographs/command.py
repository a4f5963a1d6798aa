"""The command by which another Blender renders the ball beside a photograph, for the operator Compare."""

from pathlib import Path
from typing import Any

from ..work import tasks
from ..work.command import quiet, report_of
from . import comparison


def add(commands: Any) -> None:
    """Add the command to the parsers of all."""
    photograph = commands.add_parser("photograph")      # for the operator Compare with Photograph
    photograph.add_argument("folder")
    photograph.set_defaults(run=_compare)


def _compare(options: Any) -> int:
    report = report_of(options)
    with quiet():
        comparison.answer(Path(options.folder), report.progress if report else tasks.silent)
    if report:
        report.result({})
    return 0

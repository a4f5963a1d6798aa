"""The command by which another Blender renders materials for the operator Render Measured Material."""

from pathlib import Path
from typing import Any

from ..core import look
from ..work import tasks
from ..work.command import quiet, report_of


def add(commands: Any) -> None:
    """Add the command to the parsers of all."""
    looked_at = commands.add_parser("look")     # for the operator Render Measured Material
    looked_at.add_argument("folder")
    looked_at.set_defaults(run=_look)


def _look(options: Any) -> int:
    report = report_of(options)
    with quiet():
        look.answer(Path(options.folder), report.progress if report else tasks.silent)
    if report:
        report.result({})
    return 0

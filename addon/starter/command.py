"""The command that writes the starter library."""

from typing import Any

from ...fitter import cli
from ...fitter.storage.files import real_path
from ..work.command import get_report, quiet
from . import starter


def add(commands: Any) -> None:
    """Add the command to the parsers of all."""
    library = commands.add_parser("starter", help="write the starter library, an asset library of published fits")
    library.add_argument("-o", "--out", required=True, help="the folder to write")
    library.add_argument("--only-ready", action="store_true", help="only the materials whose fits have been made")
    library.set_defaults(run=_starter, opens_files=True)


def _starter(options: Any) -> int:
    out = real_path(options.out)
    out.mkdir(parents=True, exist_ok=True)
    report = get_report(options)
    with quiet():
        for fraction, doing in starter.build(out, options.only_ready):
            if report:
                report.progress(fraction, doing)
            else:
                cli.show_progress(round(100 * fraction), 100, doing)
    if report:
        report.result({"path": str(out), "rows": []})
    return 0

"""The command line: ``blender --command measured_brdf COMMAND``; with the bpy module, ``python -m``.

Slices add their commands.
"""

import argparse
import contextlib
import sys
from collections.abc import Callable, Generator, Iterable, Iterator, Sequence
from pathlib import Path
from typing import Any, NamedTuple, TypeVar

import bpy

from ...fitter import cli, interrupts, progress
from ..core.storage.reading import scene_colours
from .blender_process import Command, CommandError, Report

_Result = TypeVar("_Result")

commands: list[Callable[[Any], None]] = []
"""Functions that add a command to what `add_subparsers` returns. It has `run`, which takes the options and returns the
exit code, and `opens_files` where it closes the open file."""
DONE = ("fitted", "up to date", "rendered", "saved")       # the statuses of rows without a failure


class Row(NamedTuple):
    """The result for one material, for the summary; `doubts` are the words for what is bad of it."""

    name: str
    status: str
    coefficients: int = 0
    nbytes: int = 0
    rmse: float = float("nan")
    doubts: Sequence[str] = ()


def main(arguments: Sequence[str] | None = None) -> int:
    """Run one command. The exit code is as of `summary`, or `interrupts.CANCELLED`."""
    options = argparse.Namespace(report_to=None)
    try:
        cli.prepare_terminal()
        options = build_parser().parse_args(arguments)
        if options.opens_files and bpy.data.filepath and options.report_to is None:
            # in another Blender, so that the open file stays open
            given = sys.argv[1:] if arguments is None else arguments
            for_this_file = ["--colours", scene_colours()] if getattr(options, "colours", "") is None else []
            result = Command(*given, *filter(None, for_this_file)).run()
            return summary([Row(*row) for row in result["rows"]], result["path"])
        exit_code: int = options.run(options)
        return exit_code
    except (OSError, ValueError, CommandError) as error:
        message = f"{error.filename}: {error.strerror}" if getattr(error, "filename", None) else str(error)
        cli.say(f"error: {message}", file=sys.stderr)
        if options.report_to is not None:
            Report(options.report_to).result({"error": message})
        return 1
    except KeyboardInterrupt:
        cli.say(interrupts.SAID, file=sys.stderr)
        return interrupts.CANCELLED


def build_parser() -> argparse.ArgumentParser:
    parser = argparse.ArgumentParser(prog="measured_brdf", description="Make materials of measured reflectance.")
    parser.add_argument("--report-to", help=argparse.SUPPRESS)      # the folder of a `blender_process`
    parser.set_defaults(opens_files=False)
    subparsers = parser.add_subparsers(required=True, metavar="COMMAND")
    for add in commands:
        add(subparsers)
    return parser


def get_report(options: argparse.Namespace) -> Report | None:
    """Where a command tells its progress and its result, if another Blender has started it."""
    return None if options.report_to is None else Report(options.report_to)


def run_steps(steps: Generator[tuple[float, str], None, _Result], report: Report | None, total: int) -> _Result:
    """The result of work in steps, each of which tells (fraction, doing): to the Blender that waits for it, else to the
    terminal, as a number of all `total`."""
    while True:
        try:
            fraction, doing = next(steps)
        except StopIteration as end:
            result: _Result = end.value
            return result
        if report:
            report.progress(fraction, doing)
        else:
            cli.show_progress(round(total * fraction), max(total, 1), doing)


def answering(name: str, answer: Callable[[Path], None]) -> Callable[[Any], None]:
    """What adds a command by which another Blender answers a request: `answer` takes the folder of both."""
    def run(options: argparse.Namespace) -> int:
        report = Report(options.report_to)
        with quiet(), progress.listen(report.progress):
            answer(Path(options.folder))
        report.result({})
        return 0

    def add(subparsers: Any) -> None:
        parser = subparsers.add_parser(name)
        parser.add_argument("folder")
        parser.set_defaults(run=run)

    return add


def summary(rows: Iterable[Row], out: str | Path, may_be_empty: bool = False) -> int:
    """Print the result for each material: the exit code, 1 if one failed or there was none, `cli.BAD` if one is bad."""
    rows = sorted(rows)
    failed = sum(row.status.startswith("failed") for row in rows)
    for row in rows:
        numbers = f"{row.coefficients:10,} {row.nbytes / 1000:8,.0f} KB  RMSE {row.rmse:<9.3g}"
        cli.say(f"{row.name:28.28} {numbers if row.coefficients else '':42} {row.status}")
        for doubt in row.doubts:
            cli.say(f"  {doubt}  (!)")
    done = sum(row.status in DONE for row in rows)
    cli.say(f"{out}: {done} done, {failed} failed")
    if failed > 0 or not (rows or may_be_empty):
        return 1
    return cli.BAD if any(row.doubts for row in rows) else 0


@contextlib.contextmanager
def quiet() -> Iterator[None]:
    """Send the reports of Blender's operators to standard error."""
    with contextlib.redirect_stdout(sys.stderr):
        yield


_handle: Any = None         # of the command, to unregister it


def register() -> None:
    global _handle
    _handle = bpy.utils.register_cli_command("measured_brdf", main)


def unregister() -> None:
    bpy.utils.unregister_cli_command(_handle)

"""The command line: ``python -m fitter info|fit|bake|photographs|flat|report``."""

import argparse
import io
import sys
import time
from collections.abc import Sequence
from typing import Any, TextIO

from . import (
    PRESETS,
    DatasetError,
    Fit,
    channel_metrics,
    error_metrics,
    fit_within,
    interrupts,
    load,
    maps_from_flat,
    report,
)
from . import fit as fit_samples
from .colours import COLOURS, DEFAULT_COLOURS
from .cycles.bake import bake
from .errors import printable
from .formats import KNOWN_FILES, list_files, list_samples, reading, saved_samples
from .methods import METHODS
from .model.published import parse_virtual_path
from .photographs.ball.measuring import measure_ball
from .photographs.description.capture_setup import list_files as list_described_files
from .photographs.description.parsing import read
from .photographs.flat import map_files
from .photographs.flat.maps import check_materials
from .photographs.flat.reading import read_sample
from .photographs.flat.tiling import cut_tile, tile_size
from .photographs.report import report_ball, report_sample
from .quality import verdict
from .quality.describe import describe, open_questions
from .storage.files import check_not_read, replace_file

BAD = 3                     # the result is written, and judged bad in words; 2 is argparse's, for wrong arguments


def main(arguments: Sequence[str] | None = None) -> int:
    """Run one command, by default that of the process. The exit code is 0, or 1 with a message on standard error;
    `BAD`; or `interrupts.CANCELLED`."""
    try:
        prepare_terminal()
        options = build_parser().parse_args(arguments)
        is_good = options.run(options)
        return BAD if is_good is False else 0
    except (DatasetError, ImportError, ValueError) as error:
        say(f"error: {error}", file=sys.stderr)
        return 1
    except BrokenPipeError:     # the reader has closed the pipe: write no more
        sys.stdout = None       # print then does nothing
    except KeyboardInterrupt:
        say(interrupts.SAID, file=sys.stderr)
        return interrupts.CANCELLED
    except OSError as error:
        say(f"error: {error.filename}: {error.strerror or error}", file=sys.stderr)
        return 1
    return 0


def build_parser() -> argparse.ArgumentParser:
    """The arguments of every command."""
    parser = argparse.ArgumentParser(prog="python -m fitter", description="Fit measured reflectance with B-splines.")
    commands = parser.add_subparsers(required=True, metavar="COMMAND")

    info = commands.add_parser("info", help="describe a file of measurements, or a saved fit")
    info.add_argument("file", help=f"{KNOWN_FILES}, or a fit (.npz)")
    info.add_argument("--sample", help="which of several samples in a file, by number or name")
    add_reading(info)
    info.set_defaults(run=_info)

    fit = commands.add_parser("fit", help="fit measurements and save the fit")
    fit.add_argument("file", help="measurements")
    fit.add_argument("--sample", help="which of several samples in a file, by number or name")
    add_reading(fit)
    add_fitting(fit)
    fit.add_argument("--method", choices=METHODS, help="instead of the preset's")
    fit.add_argument("--held-out", action="store_true", help="judge --tolerance by samples that were not fitted")
    fit.add_argument("-o", "--out", required=True, help="where to save the fit (.npz)")
    fit.set_defaults(run=_fit)

    bake_fit = commands.add_parser("bake", help="write a saved fit as an OSL shader")
    bake_fit.add_argument("file", help="a fit (.npz)")
    bake_fit.add_argument("-o", "--out", required=True, help="where to write the shader (.osl)")
    bake_fit.set_defaults(run=_bake)

    photographs = commands.add_parser("photographs", help="make samples of photographs of a ball (needs OpenImageIO)")
    photographs.add_argument("file", metavar="SETUP.toml",
                             help="describes camera, ball, lamps and files: see the manual, Measure your own")
    photographs.add_argument("-o", "--out", required=True,
                             help="where to save the samples (.npz); info describes them, fit fits them")
    photographs.set_defaults(run=_photographs)

    flat = commands.add_parser("flat", help="make maps of photographs of a flat sample (needs OpenImageIO)")
    flat.add_argument("file", metavar="SETUP.toml",
                      help="describes camera, sample, lamps and files: see the manual, Measure your own")
    flat.add_argument("-o", "--out", required=True, metavar="FOLDER",
                      help="where to write masks and normal map (.png), fits (.npz) and a report")
    flat.add_argument("--tile", action="store_true", help="cut a part of it that can be repeated")
    flat.set_defaults(run=_flat)

    compare = commands.add_parser("report", help="compare presets on measurements: size, errors, seconds")
    compare.add_argument("files", nargs="+", metavar="FILE",
                         help="measurements; all samples of a file that holds several")
    add_reading(compare)
    compare.add_argument("--levels", type=int, nargs="+", default=(), metavar="LEVEL",
                         help="plain MBA of these levels beside them")
    compare.add_argument("--out", default="report", help="folder to write, default: %(default)s")
    compare.set_defaults(run=_report)
    return parser


def add_fitting(parser: argparse.ArgumentParser) -> None:
    """Add what a fit is chosen by, of which `level_arguments` returns the levels, to a command."""
    parser.add_argument("--preset", choices=PRESETS, default="Standard", help="default: %(default)s")
    parser.add_argument("--diffuse-level", type=int, metavar="D", default=argparse.SUPPRESS,
                        help="level of the dense lattice, 0 to 8")
    parser.add_argument("--specular-level", type=_level_or_none, metavar="S", default=argparse.SUPPRESS,
                        help="level of the sparse lattice, 0 to 8, or 'none' for plain MBA")
    parser.add_argument("--compression", type=float, metavar="C", default=argparse.SUPPRESS,
                        help="percentage of the sparse lattice to drop")
    parser.add_argument("--tolerance", type=float, metavar="T",
                        help="the smallest fit with at most this RMSE (1/sr), instead of a preset and levels")


def level_arguments(options: argparse.Namespace) -> dict[str, Any]:
    """The keyword arguments of a fit that were given beside its preset."""
    return {name: value for name, value in vars(options).items()
            if name in ("diffuse_level", "specular_level", "compression")}


def add_reading(parser: argparse.ArgumentParser, colours: str | None = DEFAULT_COLOURS) -> None:
    """Add the options of reading, keyword arguments of `load`, to a command; `colours` is the default of that one."""
    for name, option in reading.OPTIONS.items():
        values: dict[str, Any] = {"choices": option.values or None, "metavar": None if option.values else "NAMES"}
        if True in option.values:
            values = {"type": _yes_or_no, "nargs": "?", "const": True, "metavar": "yes|no"}
        parser.add_argument(f"--{name.replace('_', '-')}", default=option.default, help=option.help, **values)
    parser.add_argument("--colours", choices=COLOURS, default=colours,
                        help=f"the linear colour space of the values, default: {colours or 'that of the open file'}")


def reading_arguments(options: argparse.Namespace) -> dict[str, Any]:
    """The keyword arguments of `load` that `add_reading` asked for."""
    return {name: getattr(options, name) for name in (*reading.OPTIONS, "colours")}


def _yes_or_no(text: str) -> bool:
    if text.lower() not in ("yes", "no", "true", "false"):
        raise argparse.ArgumentTypeError(f"{text!r}: expected yes or no")
    return text.lower() in ("yes", "true")


def _level_or_none(text: str) -> int | None:
    return None if text.lower() == "none" else int(text)


def _info(options: argparse.Namespace) -> None:
    if parse_virtual_path(options.file) is None and saved_samples.is_another(options.file):
        _describe_fit(Fit.load(options.file))
        return
    samples = list_samples(options.file, options.columns)
    if samples and options.sample is None:
        say(f"{options.file}: {len(samples)} samples; describe one with --sample")
        for number, name in samples:
            say(f"{number:4d}  {name}")
        return
    described = load(options.file, options.sample, **reading_arguments(options))
    say(described.name)
    for label, text, warning in describe(described).rows():
        say(f"  {label:12} {text}{'  (!)' if warning else ''}")


def _describe_fit(fit: Fit) -> None:
    transform = "identity" if fit.transform is None else fit.transform.name
    form = f"{transform} in {fit.coordinates.name} coordinates".replace("_", "-")
    say(f"{fit.name}: {fit.notation}, {form}, channels {' '.join(fit.channels)}, "
          f"{fit.coefficient_count:,} coefficients, {fit.nbytes:,} bytes")


def _fit(options: argparse.Namespace) -> bool:
    check_not_read(options.out, list_files(options.file))
    arguments: dict[str, Any] = {**PRESETS[options.preset], **level_arguments(options)}
    if options.method is not None:
        arguments["method"] = options.method
    samples = load(options.file, options.sample, **reading_arguments(options))
    start = time.perf_counter()
    fit = (fit_samples(samples, **arguments) if options.tolerance is None
           else fit_within(samples, options.tolerance, options.held_out))
    seconds = time.perf_counter() - start
    fit.save(options.out)
    _describe_fit(fit)
    if options.sample is None and (several := list_samples(options.file, options.columns)):
        say(f"  the first of {len(several)} samples in the file; --sample chooses another")
    for change in fit.changes:
        say(f"  {change}")
    say(f"  fitted in {seconds:.3f} s")
    fitted = fit.evaluate(*samples.directions)
    rows = [("all", error_metrics(samples.values, fitted))]
    if len(samples.channels) > 1:
        rows += zip(samples.channels, channel_metrics(samples.values, fitted), strict=True)
    for name, errors in rows:
        say(f"  {name:5s} RMSE {errors.rmse:.6g}  MAE {errors.mae:.6g}  MRE {errors.mre:.6g}")
    judged, doubts = verdict.judge(samples, fit), open_questions(samples)
    line = verdict.line(judged)
    return _print_messages([line, *doubts], (line, *doubts) if verdict.match_message(judged).is_bad else doubts, "  ")


def _print_messages(lines: Sequence[str], doubts: Sequence[str], indent: str = "") -> bool:
    """Print lines, those that are doubts with a mark, as `info` does: whether none is."""
    for line in lines:
        say(f"{indent}{line}{'  (!)' if line in doubts else ''}")
    return not doubts


def _bake(options: argparse.Namespace) -> None:
    check_not_read(options.out, [options.file])
    source = bake(Fit.load(options.file))
    with replace_file(options.out, "w") as stream:
        stream.write(source)
    say(f"{options.out}: {len(source):,} bytes of OSL")


def _photographs(options: argparse.Namespace) -> bool:
    setup = read(options.file)
    check_not_read(options.out, list_described_files(setup))
    measured = measure_ball(setup)
    saved_samples.write(measured.samples, options.out)
    say(measured.samples.name)
    is_good = _print_messages(*report_ball(measured), "  ")
    say(f"{options.out}: {len(measured.samples):,} samples; python -m fitter fit {options.out} -o FIT.npz fits them")
    return is_good


def _flat(options: argparse.Namespace) -> bool:
    setup = read(options.file)
    map_files.check_folder(options.out)
    sample = read_sample(setup)
    fits: list[Fit] | int | None = sample.number
    if sample.materials:
        materials = [Fit.load(path) if saved_samples.is_another(path) else load(path) for path in sample.materials]
        check_materials(materials, sample.photographs[0].radiance.shape[2])     # before those are fitted
        fits = [each if isinstance(each, Fit) else fit_samples(each, **PRESETS["Standard"]) for each in materials]
    maps = maps_from_flat(sample.photographs, sample.corners, sample.shape, fits)
    report = report_sample(maps, sample.photographs, sample.albedo)
    lines, doubts = [sample.name, *sample.notes, *sample.doubts, *report.lines], (*sample.doubts, *report.doubts)
    if options.tile:
        maps = cut_tile(maps)
        lines.append(tile_size(maps))
    written = map_files.write(maps, lines, options.out)
    is_good = _print_messages(lines, doubts)
    say(f"{options.out}: {', '.join(written)}")
    return is_good


def _report(options: argparse.Namespace) -> bool:
    found, fits = [], report.ways(options.levels)
    samples = list(report.materials(options.files, **reading_arguments(options)))
    for number, each in enumerate(samples):
        show_progress(number, len(samples), each.name)
        found += report.rows(each, fits)
    show_progress(len(samples), len(samples), "")
    report.write(found, options.out)
    for line in report.markdown(found).splitlines():
        say(line)
    asked = [question for each in samples for question in open_questions(each)]
    return _print_messages(asked, asked)


def prepare_terminal() -> None:
    """Let a command print names that its terminal has no letters for, and be interrupted."""
    interrupts.raise_again()
    for stream in (sys.stdout, sys.stderr):
        if isinstance(stream, io.TextIOWrapper):
            stream.reconfigure(errors="backslashreplace")


def say(line: str, file: TextIO | None = None) -> None:
    """Print a line, in which there may be names of files, which may hold anything."""
    print(printable(line), file=file)


def show_progress(done: int, total: int, name: str) -> None:
    """Draw a progress bar on standard error, if that is a terminal."""
    if sys.stderr.isatty():
        bar = "#" * (30 * done // total)
        end = "\n" if done == total else ""
        print(f"\r[{bar:30}] {done}/{total} {printable(name):24.24}", end=end, file=sys.stderr, flush=True)

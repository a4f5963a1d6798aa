"""Commands for measurements in folders: an asset library of them, and renders of them."""

import argparse
import sys
from collections.abc import Iterable
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import bpy

from ...fitter import cli
from ...fitter.colours import DEFAULT_COLOURS
from ...fitter.storage.files import real_path
from ..core.blender import osl_support
from ..core.libraries import assets, library_file
from ..core.shading import look
from ..core.shading import material as materials
from ..core.storage import properties
from ..core.storage.reading import load_arguments, scene_colours, use_reading
from ..work import tasks
from ..work.command import Row, get_report, quiet, run_steps, summary
from ..work.discovery import Failure, Source, passed_over, sources_in
from . import batch

_DEFAULT_TOLERANCE = 0.05   # where it is not used


def add(commands: Any) -> None:
    convert = commands.add_parser("convert", help="make an asset library of all measurements in folders")
    _add_inputs(convert)
    convert.add_argument("-o", "--out", required=True, help="the .blend to write; fits are saved beside it, and "
                                                            "up-to-date materials are kept")
    convert.add_argument("--prune", action="store_true",
                         help="remove unused materials of an earlier run whose measurements are no longer in PATH")
    convert.add_argument("--processes", type=_count, default=batch.PROCESSES, metavar="N", help="default: %(default)s")
    convert.add_argument("--shard", type=_shard, default=(1, 1), metavar="I/N",
                         help="make only the I-th of N parts, in a .blend of its own")
    convert.add_argument("--force", action="store_true",
                         help="if a file with that name is not a library, rename it to NAME.blend.kept1 and continue")
    convert.set_defaults(run=_convert, opens_files=True)

    render = commands.add_parser("render", help="render a sphere of each material with Cycles")
    _add_inputs(render)
    render.add_argument("-o", "--out", required=True, help="the folder to write pictures into")
    render.add_argument("--size", type=int, default=512, help="in pixels, default: %(default)s")
    render.add_argument("--samples", type=int, default=256, help="per pixel, default: %(default)s")
    render.set_defaults(run=_render)

    save = commands.add_parser("save")          # for the operator Save to Asset Library
    save.add_argument("source")
    save.add_argument("out")
    save.add_argument("--force", action="store_true")
    save.set_defaults(run=_save, opens_files=True)


def _add_inputs(parser: argparse.ArgumentParser) -> None:
    parser.add_argument("paths", nargs="+", metavar="PATH", help="files or folders of measurements")
    cli.add_fitting(parser)
    parser.add_argument("--rendering", choices=[key for key, *_ in properties.RENDERINGS], default=properties.AUTOMATIC,
                        help="how materials are rendered: exactly where Cycles has OSL, by closure nodes, or AUTO: "
                             "exactly where Cycles has OSL and by nodes elsewhere; default: %(default)s")
    cli.add_reading(parser, None)


def _count(text: str) -> int:
    if int(text) < 1:
        raise argparse.ArgumentTypeError(f"{text}: expected at least 1")
    return int(text)


def _shard(text: str) -> tuple[int, int]:
    part, parts = map(int, text.split("/"))
    if not 1 <= part <= parts:
        raise argparse.ArgumentTypeError(f"{text}: expected I/N with I from 1 to N")
    return part, parts


def _choices(options: argparse.Namespace) -> properties.Choices:
    choices = SimpleNamespace(**dict.fromkeys(properties.CHOICES))
    properties.use_preset(choices, options.preset)
    for name, value in cli.level_arguments(options).items():
        setattr(choices, name, properties.NO_SPECULAR_LEVEL if value is None else value)
    choices.use_tolerance = options.tolerance is not None
    choices.tolerance = options.tolerance if choices.use_tolerance else _DEFAULT_TOLERANCE
    choices.rendering = options.rendering
    use_reading(choices, cli.reading_arguments(options))
    return choices


def _convert(options: argparse.Namespace) -> int:
    sources, failures = _sources(options)
    part, parts = options.shard
    out = real_path(options.out)
    may_be_empty = parts > 1 and len(sources) > 0
    if parts > 1:       # all failures stay known to each part: it may hold older materials of those files
        sources = _share(sources, failures, part, parts)
        out = out.with_name(f"{out.stem}-{part}of{parts}.blend")
    report = get_report(options)
    with quiet():
        steps = batch.convert(bpy.context, sources, failures, _choices(options), out, options.processes, options.force,
                              options.prune, options.colours or scene_colours() or DEFAULT_COLOURS)
        rows = run_steps(steps, report, len(sources))
    if report:
        report.result({"rows": rows, "path": str(out)})
    return summary(rows, out, may_be_empty)


def _share(sources: Iterable[Source], failures: Iterable[Failure], part: int, parts: int) -> list[Source]:
    """The sources of one shard. Unreadable files are counted, so that the others stay in their shards."""
    places = sorted([*sources, *failures], key=lambda place: place.path)[part - 1::parts]
    return [place for place in places if isinstance(place, Source)]


def _save(options: argparse.Namespace) -> int:
    with quiet():
        names = library_file.merge(options.source, real_path(options.out), options.force)
    if report := get_report(options):
        rows = [Row(name, "saved") for name in names]
        report.result({"path": str(options.out), "rows": rows})
    return 0


def _render(options: argparse.Namespace) -> int:
    sources, failures = _sources(options)
    choices, out = _choices(options), Path(options.out)
    how = {**load_arguments(choices), **({"colours": options.colours} if options.colours else {})}
    out.mkdir(parents=True, exist_ok=True)
    rows = [Row(Path(name).name, f"failed: {error}") for name, _, error in failures]
    scene = look.scene_for(look.SPHERE, look.STUDIO, None, options.size, options.samples)
    for number, (path, sample) in enumerate(sources):
        cli.show_progress(number, len(sources), sample or Path(path).name)
        choices.filepath, choices.sample = path, sample
        try:
            with quiet():
                made = tasks.outcome(path, sample, properties.fit_arguments(choices), how=how)
                item = materials.create(made, choices, bpy.context)
                look.render(scene, item, real_path(out) / f"{assets.file_name(item.name)}.png")
        except (ValueError, RuntimeError) as error:
            rows.append(Row(f"{Path(path).name} {sample}".strip(), f"failed: {error}"))
        else:
            rows.append(batch.row(item, "rendered", made.questions))
            materials.remove(item)
    cli.show_progress(len(sources), max(len(sources), 1), "")
    return summary(rows, out)


def _sources(options: argparse.Namespace) -> tuple[list[Source], list[Failure]]:
    """The measurements that are given, after notes of what these do not hold and this Blender has not."""
    for line in filter(None, (osl_support.reason_unavailable(), *passed_over(options.paths, options.columns))):
        cli.say(f"note: {line}", file=sys.stderr)
    return sources_in(options.paths, options.columns)

"""The starter library as an asset library: a .blend of materials with thumbnails, descriptions and tags.

They are as a Blender without OSL makes them: closure nodes and the fit, and no bytecode; `compiling` adds that when one
is used. The library is built for the zip, by `python . starter`, or by a second Blender into the user's folder where
there is none, or where this Blender is too old to read it.
"""

import json
from collections.abc import Generator
from pathlib import Path
from typing import Any

import bpy

from ...fitter.colours import DEFAULT_COLOURS
from ...fitter.imaging.pictures import thumbnail
from ...fitter.library import ready
from ...fitter.model import published
from ...fitter.storage.files import real_path, replace_file
from ..core.annotations import not_none
from ..core.blender import previews
from ..core.libraries import assets, library_file
from ..core.shading import material as materials
from ..core.shading.compiler import Shader
from ..core.storage.properties import FIT_LEVELS, Choices, default_choices, use_preset
from ..work.command import get_report, quiet, run_steps
from . import shelf, thumbnails, work

LIBRARY_NAME = "Measured BRDF Starter Library"
SHIPPED = ready.FOLDER.parent
FILE = "starter.blend"
LICENSE = "CC0-1.0"         # of the assets; the figures are facts, whose source each asset names
_VERSION_FILE = "version.json"  # which Blender wrote the library, and of which version of the table
_REVISION = 7               # a new one makes users' libraries anew
_STARTER_CATALOGUE = f"{assets.CATALOGUE}/Starter"
_STEP = 4                   # of 255: colours of thumbnails are rounded to it, so that they compress well


def folder() -> Path | None:
    """The folder of the library that this Blender can read: the shipped one or the user's; None if there is none."""
    return next((each for each in (SHIPPED, own_folder()) if _is_readable(each)), None)


def own_folder() -> Path:
    return shelf.user_folder("starter_library")


def is_offered(context: bpy.types.Context) -> bool:
    """Whether the library is among the asset libraries of the preferences; reads no file."""
    return any(known.name == LIBRARY_NAME and Path(bpy.path.abspath(known.path)) in (SHIPPED, own_folder())
               for known in context.preferences.filepaths.asset_libraries)


def offer(context: bpy.types.Context, path: Path) -> None:
    """Add the library to the asset libraries of the preferences, or correct how they have it."""
    libraries = context.preferences.filepaths.asset_libraries
    known = next((each for each in libraries if each.name == LIBRARY_NAME), None)
    if known is None:
        known = libraries.new(name=LIBRARY_NAME, directory=str(path))
    known.path = str(path)
    known.import_method = "APPEND"          # what is linked or packed cannot be adjusted, nor rendered with OSL


def build(out: Path, only_ready: bool = False) -> Generator[tuple[float, str], None, None]:
    """Write the library into a folder, in this Blender, which must have no other file open: yields (fraction, doing).

    With `only_ready` it holds those materials alone whose fits have been made beforehand.

    Raises LibraryError or OSError if it cannot be written, or another file has its name.
    """
    everything = [each for each in published.list_offered() if ready.is_there(each.name) or not only_ready]
    if not everything:
        raise library_file.LibraryError(f"{ready.FOLDER} holds no fit of the library. python -m tools.ready_fits makes "
                                        "them.")
    path = out / FILE
    with library_file.writing(path, force=False):
        opened = library_file.open_part(path) if path.exists() else None
        library_file.close()
        for number, wanted in enumerate(everything):
            yield number / len(everything), wanted.label
            _mark(_create(wanted), wanted)
        yield 1.0, "Writing the library"
        library_file.save_part(path, opened)
        kinds = {_catalogue(each.tags[0]) for each in everything}
        assets.write_catalogue(out, [assets.CATALOGUE, _STARTER_CATALOGUE, *sorted(kinds)])
        with replace_file(out / _VERSION_FILE, "w") as stream:
            json.dump({"blender": bpy.app.version[:2], "revision": _REVISION}, stream)


def add_command(commands: Any) -> None:
    library = commands.add_parser("starter", help="write the starter library, an asset library of published fits")
    library.add_argument("-o", "--out", required=True, help="the folder to write")
    library.add_argument("--only-ready", action="store_true", help="only the materials whose fits have been made")
    library.set_defaults(run=_run_command, opens_files=True)


def _run_command(options: Any) -> int:
    out = real_path(options.out)
    out.mkdir(parents=True, exist_ok=True)
    report = get_report(options)
    with quiet():
        run_steps(build(out, options.only_ready), report, 100)
    if report:
        report.result({"path": str(out), "rows": []})
    return 0


def starter_choices(wanted: published.PublishedMaterial) -> Choices:
    choices = default_choices(wanted.path)
    use_preset(choices, ready.PRESET)
    for level in FIT_LEVELS:
        setattr(choices, level, ready.ARGUMENTS[level])
    return choices


def _create(wanted: published.PublishedMaterial) -> bpy.types.Material:
    outcome = work.import_result(wanted.name, {"colours": DEFAULT_COLOURS})
    surface = outcome.surface
    uncompiled = Shader(surface.source, "", surface.nodes, surface.kept)
    return materials.create(outcome, starter_choices(wanted), bpy.context, uncompiled)


def _mark(material: bpy.types.Material, wanted: published.PublishedMaterial) -> None:
    material.asset_mark()
    data = not_none(material.asset_data)
    data.description = wanted.description
    data.author, data.license = wanted.source, LICENSE
    data.catalog_id = str(assets.catalogue_id(_catalogue(wanted.tags[0])))
    others = wanted.words.split() if wanted.is_computed else ["published fit", "MERL"]
    for tag in (*wanted.tags, *others, wanted.name):
        data.tags.new(tag, skip_if_exists=True)
    picture = thumbnail(wanted, thumbnails.SIZE)
    step = _STEP / 255
    picture[..., :3] = (picture[..., :3] / step).round() * step
    previews.fill(not_none(material.preview_ensure()), picture)


def _catalogue(kind: str) -> str:
    return f"{_STARTER_CATALOGUE}/{kind.capitalize()}"


def _is_readable(where: Path) -> bool:
    """Whether a folder holds the library, of this revision, and no newer Blender wrote it."""
    try:
        written = json.loads((where / _VERSION_FILE).read_text("utf-8"))
        return (written["revision"] == _REVISION and tuple(written["blender"]) <= bpy.app.version[:2]
                and (where / FILE).is_file())
    except (OSError, ValueError, KeyError, TypeError):
        return False

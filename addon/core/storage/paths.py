"""The files that a .blend names: relative to it (`//`), where it is saved and both share a folder of their own.

They become relative when the file is saved, and stay right when it is saved elsewhere, or a material is appended to
another file (since Blender 4.3). Blender itself looks after the paths of images.
"""

import os
import re
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import bpy
from bpy.app.handlers import persistent

from ....fitter.formats import is_there
from ....fitter.model.published import parse_virtual_path
from ..blender.active_material import can_change

Place = tuple[Any, str]     # what holds a path, and the name of the property

_KNOWN = bpy.types.Property.bl_rna.properties.keys()
RELATIVE_PATHS = {"PATH_SUPPORTS_BLEND_RELATIVE"} if "is_path_supports_blend_relative" in _KNOWN else set()
"""Options of a property that may hold a relative path; Blender 4.2 knows none."""
scene_places: list[Callable[[bpy.types.Scene], Iterator[Place]]] = []
"""Functions of slices: what else a scene names."""
_BLEND = "//"


def absolute(material: bpy.types.Material) -> str:
    """Where the measurements of a material are, also of a linked or overridden one."""
    of_other = material.override_library
    library = material.library if of_other is None else of_other.reference.library
    return _whole(material.measured_brdf.filepath, bpy.data.filepath if library is None
                  else bpy.path.abspath(library.filepath))


def relative(path: str, folder: str) -> str:
    """A path as it is told from a folder; whole where both share no folder but that of all users, or the disk."""
    if path.startswith(_BLEND) or not os.path.isabs(path):
        return path
    try:
        shared = Path(os.path.commonpath([folder, path]))
    except ValueError:                      # another drive
        return path
    if shared in Path(os.path.expanduser("~")).parents:
        return path
    return _BLEND + os.path.relpath(path, folder).replace("\\", "/")


def forget(path: str) -> str:
    """A path without its folders: the file's name, beside the .blend."""
    return path if not path or parse_virtual_path(path) is not None else _BLEND + re.split(r"[/\\]", path)[-1]


def stored_paths() -> Iterator[Place]:
    """The paths that the open file keeps, and may change."""
    for item in (*bpy.data.materials, *bpy.data.scenes):
        yield from _paths_of_item(item)


def _paths_of_item(item: bpy.types.ID) -> Iterator[Place]:
    if not can_change(item):
        return
    if isinstance(item, bpy.types.Material):
        yield item.measured_brdf, "filepath"
    if isinstance(item, bpy.types.Scene):
        for places in scene_places:
            yield from places(item)


def _whole(path: str, at: str) -> str:
    """The absolute path of what a .blend names that lies there; empty: of one that was never saved."""
    if not path.startswith(_BLEND):
        return os.path.abspath(path) if os.path.isfile(path) else path
    return os.path.normpath(os.path.join(os.path.dirname(at), path[len(_BLEND):]))


def _move(before: str, after: str) -> None:
    """Have the paths of the open file, which lay at `before`, be those of one at `after`; empty: of one nowhere."""
    for owner, name in stored_paths():
        if isinstance(owner, bpy.types.Image):
            continue
        path = getattr(owner, name)
        whole = _whole(path, before)
        # what was forgotten is beside the file wherever that is
        is_forgotten = path == forget(path) and not is_there(whole)
        if not path or (path.startswith(_BLEND) and (not before or is_forgotten)):
            continue
        moved = relative(whole, os.path.dirname(after)) if after else whole
        if moved != path:                   # else materials would be rendered anew
            setattr(owner, name, moved)


@persistent
def _on_saving(path: str, *_: object) -> None:
    _move(bpy.data.filepath, path)         # empty: of the startup file, whose paths are told from nowhere


@persistent
def _on_saved(path: str, *_: object) -> None:
    """Of a copy, and where it failed: the open file is where it was."""
    if path != bpy.data.filepath:
        _move(path, bpy.data.filepath)


@persistent
def _on_import(context: Any) -> None:
    """What is appended comes from where its library was."""
    for imported in context.import_items:
        if imported.id is None or imported.source_library is None:
            continue
        for owner, name in _paths_of_item(imported.id):
            path = getattr(owner, name)
            whole = _whole(path, bpy.path.abspath(imported.source_library.filepath))
            if path.startswith(_BLEND) and is_there(whole):
                setattr(owner, name, whole)


handlers = {"save_pre": _on_saving, "save_post": _on_saved, "save_post_fail": _on_saved,
            "blend_import_post": _on_import}

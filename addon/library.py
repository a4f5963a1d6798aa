"""Asset libraries on disk: .blend files that this extension wrote, recognised by what is in them.

Libraries are changed in place by a Blender that has no other file open (`blender_process`): one is opened, its measured
materials are replaced or joined by others, and it is saved beside itself and renamed. What users put into it stays.
"""

import json
import os
import re
from collections import Counter
from contextlib import contextmanager, suppress
from pathlib import Path

import bpy

from ..fitter.files import locked
from . import assets, lamps, node_group, versions
from . import material as materials

MATERIALS_PER_FILE = 100            # of a library: its Blender needs 3 MB of memory for each
_MARKER = "Measured BRDF Library"   # a text in every library: JSON of format and version
_FORMAT = "measured-brdf-library"
_NUMBERED = re.compile(r"(.*?)(\.\d{3,})?")


class LibraryError(ValueError):
    """A file may not be replaced by a library; the message says why."""


def refusal(path):
    """Why a file may not be replaced by a library, in words; an empty string where it may, or is not there."""
    path = Path(path)
    if not path.exists():
        return ""
    if bpy.data.filepath and path.samefile(bpy.data.filepath):
        return f"{path} is the file that is open"
    names = _names(path)
    if names is None:
        return f"{path} exists and is not a .blend file"
    if _MARKER in names.get("texts", ()) or _is_of_first_version(names):
        return ""
    held = ", ".join(f"{len(of_kind)} {kind.replace('_', ' ')}" for kind, of_kind in sorted(names.items()) if of_kind)
    return f"{path} exists and is not a library that Measured BRDF wrote: it holds {held or 'nothing'}"


def _names(path):
    """What a .blend holds: {kind: names}; None for any other file. Nothing is loaded."""
    try:
        with bpy.data.libraries.load(str(path), link=False) as (source, _):
            found = {kind: getattr(source, kind) for kind in dir(source)}
            return {kind: of_kind for kind, of_kind in found.items() if isinstance(of_kind, list)}
    except OSError:
        return None


def _is_of_first_version(names):
    """Whether a .blend holds what 0.1.0, which left no marker, put into a library: nothing but measured materials."""
    expected = {"materials", "node_groups", "texts"}
    if any(of_kind for kind, of_kind in names.items() if kind not in expected):
        return False
    groups = Counter(_NUMBERED.fullmatch(name)[1] for name in names["node_groups"])
    texts = Counter(_NUMBERED.fullmatch(name)[1] for name in names["texts"])
    count = len(names["materials"])
    return count > 0 and groups.keys() <= {node_group.NAME, "Measured BRDF Lamps"} and (
        groups[node_group.NAME] == count and texts == {f"{node_group.NAME}.osl": count})


def parts(path):
    """The files of a library, the first at `path`, numbered ones beside it, as far as they follow on each other."""
    path = Path(path)
    yield path
    number = 2
    while (part := path.with_name(f"{path.stem}-{number:03d}{path.suffix}")).exists():
        yield part
        number += 1


def next_part(path, used):
    """The path of the part that follows on `used` parts."""
    path = Path(path)
    return path if used == 0 else path.with_name(f"{path.stem}-{used + 1:03d}{path.suffix}")


@contextmanager
def writing(path, force):
    """Be the only one who writes a library, and be allowed to: what is neither is an error.

    Parameters
    ----------
    path : path-like
    force : bool
        Put a file that is not a library aside (`kept_name`), instead of refusing to replace it.

    Raises
    ------
    LibraryError, OSError
    """
    path = Path(path)
    path.parent.mkdir(parents=True, exist_ok=True)
    with locked(path):
        for part in list(parts(path)):
            reason = refusal(part)
            if reason and not force:
                raise LibraryError(f"{reason}. Choose another name, or --force to put it aside as {kept_name(part)}")
            if reason:
                part.rename(part.with_name(kept_name(part)))
        yield


def kept_name(path):
    """The name under which a file is put aside: none that is taken, and not X.blend1, which Blender writes over."""
    path, number = Path(path), 1
    while path.with_name(f"{path.name}.kept{number}").exists():
        number += 1
    return f"{path.name}.kept{number}"


def open_part(path):
    """Open a part of a library in this Blender, or begin an empty one."""
    if Path(path).exists():
        bpy.ops.wm.open_mainfile(filepath=str(path), load_ui=False, use_scripts=False)
    else:
        bpy.ops.wm.read_homefile(use_empty=True, use_factory_startup=True, load_ui=False)


def save_part(path):
    """Save what is open as a part of a library: it is replaced once the new file is whole."""
    path = Path(path)
    marker = bpy.data.texts.get(_MARKER) or bpy.data.texts.new(_MARKER)
    marker.from_string(json.dumps({"format": _FORMAT, "version": versions.CURRENT}))
    marker.use_fake_user = True
    beside = path.with_name(f".{path.stem}.part.blend")
    try:
        bpy.ops.wm.save_as_mainfile(filepath=str(beside), copy=True, compress=True, check_existing=False)
        with open(beside, "rb+") as stream:
            os.fsync(stream.fileno())
        os.replace(beside, path)
    except RuntimeError as error:           # what an operator reports
        raise OSError(0, str(error).strip().removeprefix("Error: "), str(path)) from error
    finally:
        with suppress(OSError):
            beside.unlink()
    assets.write_catalogue(path.parent)


def merge(source, path, force):
    """Take the measured materials of another .blend into a library, in this Blender: a list of their names.

    One that the library has already, of the same measurements, is replaced; what users did to it as an asset stays.
    """
    with writing(path, force):
        open_part(path)
        before = measured()
        with bpy.data.libraries.load(str(source), link=False) as (names, target):
            target.materials = names.materials
        lamps.update(bpy.context.evaluated_depsgraph_get())
        for item in target.materials:
            old = next((other for other in before if identity(other) == identity(item)), None)
            if old is not None:
                before.remove(old)
                assets.inherit(item, old)
                old.user_remap(item)
                name = old.name
                materials.remove(old)
                item.name = name
        save_part(path)
        return [item.name for item in target.materials]


def measured():
    """The measured materials of the open file."""
    return [item for item in bpy.data.materials if item.library is None and materials.is_measured(item)]


def identity(material):
    """Tells whether two materials were made from the same measurements, whatever the fit."""
    settings = material.measured_brdf
    return settings.name_of_data, Path(settings.filepath).name, settings.sample

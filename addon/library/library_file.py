"""Asset libraries on disk: .blend files that this extension wrote, recognised by what is in them.

Libraries are changed in place by a Blender that has no other file open (`blender_process`): one is opened, its measured
materials are replaced or joined by others, and it is saved beside itself and renamed. What users put into it stays.
"""

import errno
import glob
import json
import os
import re
import shutil
import stat
from collections import Counter
from contextlib import contextmanager, suppress
from pathlib import Path

import bpy

from ...fitter.files import locked
from .. import versions
from ..materials import material as materials
from ..materials import node_group
from ..scene import lamps
from . import assets

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
    if not path.is_file():
        return f"{path} is not a file"
    with suppress(OSError):                 # the open file may have been deleted
        if bpy.data.filepath and path.samefile(bpy.data.filepath):
            return f"{path} is the file that is open"
    names = _names(path)
    if names is None:
        return f"{path} exists and is not a .blend file that Blender {bpy.app.version_string} can read"
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
    return count > 0 and groups.keys() <= {node_group.NAME, lamps.NAME} and (
        groups[node_group.NAME] == count and texts == {f"{node_group.NAME}.osl": count})


def parts(path):
    """The files of a library that are there: `path`, and numbered ones beside it that belong to it."""
    path = Path(path)
    return [part for part in (path, *_numbered(path)) if part.exists() and not refusal(part)]


def _numbered(path):
    return sorted(path.parent.glob(f"{glob.escape(path.stem)}-[0-9][0-9][0-9]{path.suffix}"))


def _beside(part):
    """The file in which a part is written before it is renamed."""
    return part.with_name(f".{part.stem}.part.blend")


def next_part(path):
    """The first path of a library's parts that no file has."""
    path, number = Path(path), 2
    part = path
    while part.exists() and (part != path or not refusal(part)):
        part = path.with_name(f"{path.stem}-{number:03d}{path.suffix}")
        number += 1
    return part


@contextmanager
def writing(path, force):
    """Be the only one who writes a library, and be allowed to: what is neither is an error.

    Parameters
    ----------
    path : path-like
    force : bool
        Put a file that is not a library aside (`kept_name`) when a library is written, instead of refusing to.

    Raises
    ------
    LibraryError, OSError
    """
    path = Path(path)
    if path.suffix != ".blend":
        raise LibraryError(f"{path}: expected a name that ends in .blend")
    path.parent.mkdir(parents=True, exist_ok=True)
    with locked(path):
        reason = refusal(path)
        if reason and (not force or not path.is_file()):
            raise LibraryError(f"{reason}. Choose another name" + (
                f", or --force to put it aside as {kept_name(path)}" if path.is_file() else ""))
        for part in (path, *_numbered(path)):
            for left in (_beside(part), _beside(part).with_suffix(".blend@")):      # by a process that was killed
                left.unlink(missing_ok=True)
        yield


def kept_name(path):
    """The name under which a file is put aside: none that is taken, and not X.blend1, which Blender writes over."""
    path, number = Path(path), 1
    while path.with_name(f"{path.name}.kept{number}").exists():
        number += 1
    return f"{path.name}.kept{number}"


def open_part(path):
    """Open a part of a library that is there in this Blender: what `save_part` takes of it."""
    before = _version_on_disk(path)
    bpy.ops.wm.open_mainfile(filepath=str(path), use_scripts=False)
    if bpy.data.version[:2] > bpy.app.version[:2]:
        raise LibraryError(f"{path} was saved by Blender {'.'.join(map(str, bpy.data.version))}; this is "
                           f"{bpy.app.version_string}, which would lose what it does not know")
    return before


def close():
    """Have no file open in this Blender; or begin one that is empty."""
    bpy.ops.wm.read_homefile(use_empty=True, use_factory_startup=True, load_ui=False)


def save_part(path, opened):
    """Save what is open as a part of a library, and close it: the file is replaced once the new one is whole.

    Parameters
    ----------
    path : path-like
    opened
        What `open_part` returned; None for a part that was begun (`close`).

    Raises
    ------
    OSError
        If it cannot be written, is write-protected, or was saved by somebody else meanwhile.
    """
    path = Path(path)
    marker = bpy.data.texts.get(_MARKER) or bpy.data.texts.new(_MARKER)
    marker.from_string(json.dumps({"format": _FORMAT, "version": versions.CURRENT}))
    marker.use_fake_user = True
    beside = _beside(path)
    try:
        bpy.ops.wm.save_as_mainfile(filepath=str(beside), copy=True, compress=True, check_existing=False)
        with open(beside, "rb+") as stream:
            os.fsync(stream.fileno())
        if opened is not None and _version_on_disk(path) != opened:
            raise OSError(errno.EBUSY, "it was saved by somebody else meanwhile; nothing was written, run this again",
                          str(path))
        if opened is not None:
            if not path.stat().st_mode & stat.S_IWUSR:
                raise OSError(errno.EACCES, "write-protected", str(path))
            shutil.copymode(path, beside)
        elif path.exists():
            path.rename(path.with_name(kept_name(path)))
        os.replace(beside, path)
    except RuntimeError as error:           # what an operator reports
        raise OSError(errno.EIO, str(error).strip().removeprefix("Error: "), str(path)) from error
    finally:
        with suppress(OSError):
            beside.unlink()
        close()


def _version_on_disk(path):
    """Changes whenever somebody saves a file."""
    found = path.stat()
    return found.st_mtime_ns, found.st_size, found.st_ino


def merge(source, path, force):
    """Take the measured materials of another .blend into a library, in this Blender: a list of their names.

    One that the library has already, of the same measurements, is replaced; what users did to it as an asset stays.
    """
    path = Path(path)
    with writing(path, force):
        close()
        opened = open_part(path) if path.exists() and not refusal(path) else None
        before = measured()
        with bpy.data.libraries.load(str(source), link=False) as (names, target):
            wanted = list(names.materials)
            target.materials = wanted
        names_before = dict(zip(target.materials, wanted, strict=True))         # appending may have numbered them
        lamps.update(bpy.context.evaluated_depsgraph_get())
        for item in target.materials:
            same = [other for other in before if identity(other) == identity(item)]
            # of several, copies that users made among them, the one of that name
            old = same[0] if len(same) == 1 else next(
                (other for other in same if other.name == names_before[item]), None)
            if old is not None:
                before.remove(old)
                assets.inherit(item, old)
                old.user_remap(item)
                name = old.name
                materials.remove(old)
                item.name = name
        names = [item.name for item in target.materials]
        save_part(path, opened)
        assets.write_catalogue(path.parent)
        return names


def measured():
    """The measured materials of the open file."""
    return [item for item in bpy.data.materials if item.library is None and materials.is_measured(item)]


def identity(material):
    """Tells whether two materials were made from the same measurements, whatever the fit."""
    settings = material.measured_brdf
    return settings.name_of_data, Path(settings.filepath).name, settings.sample

"""Asset libraries on disk: .blend files that this extension wrote, recognised by their content.

A Blender without another open file (`blender_process`) opens a library, replaces measured materials or adds new ones,
saves to a temporary file, and renames that. Other data that users put into it stay.
"""

import errno
import glob
import json
import os
import shutil
import stat
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from itertools import count
from pathlib import Path

import bpy

from ....fitter.storage.files import hold_lock
from .. import versions
from ..blender import followers
from ..shading import material as materials
from . import assets

MATERIALS_PER_FILE = 100            # Blender needs 3 MB of memory for each
_MARKER = "Measured BRDF Library"   # a text in every library: JSON of format and version
_FORMAT = "measured-brdf-library"
_DiskVersion = tuple[int, int, int]


class LibraryError(ValueError):
    """A file may not be replaced by a library; the message says why."""


def refusal(path: str | Path) -> str:
    """Why a library may not replace a file; empty if it may, or if there is no file."""
    path = Path(path)
    if not path.exists():
        return ""
    if not path.is_file():
        return f"{path} is not a file"
    with suppress(OSError):                 # raised if the open file has been deleted
        if bpy.data.filepath and path.samefile(bpy.data.filepath):
            return f"{path} is the file that is open"
    names = _names(path)
    if names is None:
        return f"{path} exists and is not a .blend file that Blender {bpy.app.version_string} can read"
    if _MARKER in names.get("texts", ()):
        return ""
    held = ", ".join(f"{len(of_kind)} {kind.replace('_', ' ')}" for kind, of_kind in sorted(names.items()) if of_kind)
    return f"{path} exists and is not a library that Measured BRDF wrote: it holds {held or 'nothing'}"


def _names(path: Path) -> dict[str, list[str]] | None:
    """The names of the data-blocks in a .blend, by kind; None for any other file. Nothing is loaded."""
    try:
        with bpy.data.libraries.load(str(path), link=False) as (source, _):
            lists = {kind: getattr(source, kind) for kind in dir(source)}
            return {kind: of_kind for kind, of_kind in lists.items() if isinstance(of_kind, list)}
    except OSError:
        return None


def parts(path: str | Path) -> list[Path]:
    """The existing files of a library: `path`, and the numbered ones beside it."""
    path = Path(path)
    return [part for part in (path, *_further_parts(path)) if part.exists() and not refusal(part)]


def _further_parts(path: Path) -> list[Path]:
    return sorted(path.parent.glob(f"{glob.escape(path.stem)}-[0-9][0-9][0-9]{path.suffix}"))


def _temporary(part: Path) -> Path:
    return part.with_name(f".{part.stem}.part.blend")


def next_part(path: str | Path) -> Path:
    path = Path(path)
    further = (path.with_name(f"{path.stem}-{number:03d}{path.suffix}") for number in count(2))
    return path if not path.exists() or refusal(path) else next(part for part in further if not part.exists())


@contextmanager
def writing(path: str | Path, force: bool) -> Iterator[None]:
    """Lock a library for writing, and check that it may be written, where anything may with `force`: it is kept under
    another name (`kept_name`). Raises LibraryError or OSError."""
    path = Path(path)
    if path.suffix != ".blend":
        raise LibraryError(f"{path}: expected a name that ends in .blend")
    path.parent.mkdir(parents=True, exist_ok=True)
    with hold_lock(path):
        reason = refusal(path)
        if reason and (not force or not path.is_file()):
            raise LibraryError(f"{reason}. Choose another name" + (
                f", or use --force to keep it as {kept_name(path)}" if path.is_file() else ""))
        for part in (path, *_further_parts(path)):
            for left in (_temporary(part), _temporary(part).with_suffix(".blend@")):      # of a process that was killed
                left.unlink(missing_ok=True)
        yield


def kept_name(path: str | Path) -> str:
    """A free name under which to keep a file; not X.blend1, which Blender overwrites."""
    path = Path(path)
    return next(name for number in count(1) if not path.with_name(name := f"{path.name}.kept{number}").exists())


def open_part(path: Path) -> _DiskVersion:
    """Open an existing part of a library in this Blender: what `save_part` needs to know of it."""
    before = _version_on_disk(path)
    bpy.ops.wm.open_mainfile(filepath=str(path), use_scripts=False)
    if bpy.data.version[:2] > bpy.app.version[:2]:
        raise LibraryError(f"{path} was saved by Blender {'.'.join(map(str, bpy.data.version))}; this is "
                           f"{bpy.app.version_string}, which would lose data of the newer version")
    return before


def close() -> None:
    bpy.ops.wm.read_homefile(use_empty=True, use_factory_startup=True, load_ui=False)


def save_part(path: str | Path, opened: _DiskVersion | None) -> None:
    """Save the open file as a part of a library, whole or not at all, and close it. `opened` is what `open_part`
    returned; None for a new part. Raises OSError, also if another process has saved it meanwhile."""
    path = Path(path)
    marker = bpy.data.texts.get(_MARKER) or bpy.data.texts.new(_MARKER)
    marker.from_string(json.dumps({"format": _FORMAT, "version": versions.CURRENT}))
    marker.use_fake_user = True
    temporary = _temporary(path)
    try:
        bpy.ops.wm.save_as_mainfile(filepath=str(temporary), copy=True, compress=True, check_existing=False)
        with open(temporary, "rb+") as stream:
            os.fsync(stream.fileno())
        if _names(temporary) is None:       # Blender does not tell
            raise OSError(errno.EIO, "it could not be written whole; the disk may be full", str(path))
        if opened is not None and _version_on_disk(path) != opened:
            raise OSError(errno.EBUSY, "another process has saved it meanwhile; nothing was written, try again",
                          str(path))
        if opened is not None:
            if not path.stat().st_mode & stat.S_IWUSR:
                raise OSError(errno.EACCES, "write-protected", str(path))
            shutil.copymode(path, temporary)
        elif path.exists():
            path.rename(path.with_name(kept_name(path)))
        os.replace(temporary, path)
    except RuntimeError as error:           # an operator's report
        raise OSError(errno.EIO, str(error).strip().removeprefix("Error: "), str(path)) from error
    finally:
        with suppress(OSError):
            temporary.unlink()
        close()


def _version_on_disk(path: Path) -> _DiskVersion:
    """Changes whenever the file is saved."""
    status = path.stat()
    return status.st_mtime_ns, status.st_size, status.st_ino


def merge(source: str | Path, path: str | Path, force: bool) -> list[str]:
    """Append the materials of another .blend to a library, in this Blender, in the place of those of the same
    measurements, of which asset data that users changed stay: their names."""
    path = Path(path)
    with writing(path, force):
        close()
        opened = open_part(path) if path.exists() and not refusal(path) else None
        before = [item for item in bpy.data.materials if item.library is None and materials.is_shown(item)]
        with bpy.data.libraries.load(str(source), link=False) as (names, target):
            wanted = list(names.materials)
            target.materials = [*wanted]        # Blender puts the materials into the list that it is given
        # appending may add numbers to the names
        names_before: dict[bpy.types.Material, str] = dict(zip(target.materials, wanted, strict=True))
        followers.tell(bpy.context)
        for item in target.materials:
            same = [other for other in before if identity(other) == identity(item)]
            # users may have made copies: take the one of the same name; mixes have nothing else
            old = same[0] if len(same) == 1 and materials.is_measured(item) else next(
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


def list_measured() -> list[bpy.types.Material]:
    return [item for item in bpy.data.materials if item.library is None and materials.is_measured(item)]


def identity(material: bpy.types.Material) -> tuple[str, str, str]:
    """Equal for materials of the same measurements, whatever the fit."""
    settings = material.measured_brdf
    return settings.name_of_data, Path(settings.filepath).name, settings.sample

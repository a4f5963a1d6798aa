"""Pictures of the starter library and of measurements in a folder, and what the folder holds: work for a worker.

Nothing here imports bpy. Pictures of measurements are cached on disk, by the files that they were made of, the options
of reading and the version of the extension.
"""

import hashlib
import os
from collections.abc import Callable, Sequence
from contextlib import suppress
from pathlib import Path
from typing import NamedTuple

import numpy as np

from ... import fitter
from ...fitter.arrays import SingleArray
from ...fitter.formats import EXTENSIONS, PLAIN, time_and_size
from ...fitter.imaging.pictures import lit_sphere, thumbnail
from ...fitter.model import published
from ...fitter.storage.files import replace_file
from ..core import versions
from ..core.annotations import Arguments, as_text
from ..work import discovery, shared
from ..work.recent import Recent

SIZE = 128
LARGEST_FITTED = 8 << 20    # bytes: larger files get no thumbnail, their fit would take longer than people look
MOST = 400                  # measurements that a folder shows
_QUICK_FIT: Arguments = {**fitter.PRESETS["Draft"]}
_KEPT_PICTURES = 1500       # pictures on disk
# what files hold, by path and stamp
_known: 'Recent[tuple[Path, tuple[int, int]], list["FolderEntry"]]' = Recent(1 << 16)


class FolderEntry(NamedTuple):
    """A measurement in a folder, or a file that cannot be read."""

    path: str
    sample: str
    stamp: tuple[int, int]      # its `formats.time_and_size`
    error: str = ""             # why it cannot be read

    @property
    def label(self) -> str:
        """The name of the sample, or of the file, as text that Blender takes: names of files may be any bytes."""
        return _as_unicode(self.sample or Path(self.path).name)

    @property
    def has_picture(self) -> bool:
        return not self.error and self.stamp[1] <= LARGEST_FITTED


def scan(folder: str) -> list[FolderEntry]:
    """The measurements in a folder and in those below it, in the order of `discovery.files_below`.

    Files are read only where they have changed since the last scan. A file that cannot be read is listed with its
    error. Plain text and .bin are listed where they are recognised. Raises OSError if the folder cannot be read.
    """
    paths = [Path(entry.path) for entry in discovery.files_below(folder)
             if Path(entry.name).suffix.lower() in EXTENSIONS and os.path.isfile(entry.path)]
    others = set(paths)
    found: list[FolderEntry] = []
    for path in paths:
        stamp = time_and_size(path)
        if stamp is None or discovery.is_read_with_another(path, others):      # removed meanwhile, or a part
            continue
        if (path, stamp) not in _known:
            _known[path, stamp] = _found_in(path, stamp)
        found += _known[path, stamp]
        if len(found) >= MOST:
            break
    return found[:MOST]


def _found_in(path: Path, stamp: tuple[int, int]) -> list[FolderEntry]:
    if stamp[1] > LARGEST_FITTED:                       # one sample: no CURET file is that large
        return [] if path.suffix.lower() in PLAIN else [FolderEntry(str(path), "", stamp)]
    if path.suffix.lower() in PLAIN and not discovery.is_recognised(path):
        return []
    try:
        samples = discovery.list_samples(path)
        if not samples:
            fitter.load(path)
    except fitter.UnitsUnknownError:                    # the import asks for them
        return [FolderEntry(str(path), "", stamp)]
    except ValueError as error:
        return [FolderEntry(str(path), "", stamp, _as_unicode(str(error)))]
    return [FolderEntry(str(path), name, stamp) for _, name in samples] or [FolderEntry(str(path), "", stamp)]


def _as_unicode(text: str) -> str:
    return text.encode("utf-8", "replace").decode("utf-8")


def library_pictures(names: Sequence[str]) -> dict[str, SingleArray]:
    """The pictures of materials of the starter library by name: (SIZE, SIZE, 4) float32 each. Raises DatasetError."""
    return {name: thumbnail(published.find(name), SIZE) for name in names}


def measurement_picture(found: FolderEntry, cache: str, how: Arguments) -> SingleArray:
    """The picture of a quick fit of a measurement: (SIZE, SIZE, 4) float32. Raises DatasetError, ValueError."""

    def draw() -> SingleArray:
        samples = fitter.load(found.path, found.sample or None, **how)
        return lit_sphere(fitter.fit(samples, **_QUICK_FIT), SIZE, colours=samples.colours)

    return _cached_picture(Path(cache), (*found, as_text(how), as_text(_QUICK_FIT)), draw)


def _cached_picture(folder: Path, key: tuple[object, ...], draw: Callable[[], SingleArray]) -> SingleArray:
    name = hashlib.sha256(repr((versions.CURRENT, SIZE, *key)).encode()).hexdigest()[:24]
    path = folder / f"{name}.npy"
    with suppress(OSError, ValueError, EOFError):       # not there yet, or damaged
        stored = np.load(path, allow_pickle=False)
        if stored.shape == (SIZE, SIZE, 4) and stored.dtype == np.uint8:
            return (stored / 255).astype(np.float32)
    picture = np.round(np.clip(draw(), 0, 1) * 255).astype(np.uint8)
    with suppress(OSError):                             # without a cache it is drawn again the next time
        folder.mkdir(parents=True, exist_ok=True)
        with replace_file(path) as stream:
            np.save(stream, picture, allow_pickle=False)
        shared.forget_oldest(folder, "*.npy", _KEPT_PICTURES)
    return (picture / 255).astype(np.float32)

"""What the panels offer to begin with: the starter library and the watched folder, with their thumbnails.

Everything is asked of workers (`work.queue`); what is drawn meanwhile is what is known.
"""

from collections.abc import Sequence
from contextlib import suppress
from functools import cache, partial
from pathlib import Path

import bpy
import numpy as np

from ...fitter.arrays import SingleArray
from ...fitter.colours import DEFAULT_COLOURS
from ...fitter.formats import time_and_size
from ...fitter.library.matching import Match
from ...fitter.model import published
from ..core import preferences
from ..core.annotations import Arguments, as_text, not_none
from ..work import icons, queue
from ..work.job import Job
from ..work.recent import Recent
from . import thumbnails

ALL = "all"
_PACKAGE = __package__.rpartition(".addon")[0]
_RESCAN = 2.0               # s, after which a folder is scanned again
_TICK = 2.5                 # s, between two redraws of a panel that shows a folder
_KEPT_ICONS = 600           # icons
_PATIENCE = 300.0           # s, for which the icons of a list are wanted
_PLACEHOLDER_GREY = 0.3     # of the disc that stands for a picture
_AT_A_TIME = 14             # pictures of the library that are drawn in one go: half a second
_icons = icons.Icons(_KEPT_ICONS)
_coming: set[str] = set()   # published materials whose pictures are being drawn
_undrawn: set[icons.Key] = set()        # samples whose icons are discs
_failed: Recent[icons.Key, Exception] = Recent(_KEPT_ICONS)  # the queue forgets: they would be tried for ever
_was_drawn = False


def user_folder(name: str) -> Path:
    """A folder of the extension for files of this user, which updates keep; it need not exist."""
    with suppress(ValueError):                  # a checkout is no extension
        return Path(bpy.utils.extension_path_user(_PACKAGE, path=name))
    return Path(bpy.utils.user_resource("DATAFILES", path="measured_brdf")) / name


nearest: list[Match] = []
"""What the last photograph was matched with."""


def favourites() -> list[published.PublishedMaterial]:
    """The user's favourite materials, those chosen last first; names that this version does not know are left out."""
    names = preferences.get(bpy.context).favourites.split(",")
    return [published.materials()[name] for name in names if name in published.materials()]


def toggle_favourite(name: str) -> bool:
    """Make a material a favourite, or no longer one: whether it is one now. It is stored in the preferences.

    Raises DatasetError if there is none of this name, and ValueError where there are no preferences to store it in.
    """
    published.find(name)
    settings = preferences.get(bpy.context)
    names = [each for each in settings.favourites.split(",") if each]
    is_new = name not in names
    try:
        settings.favourites = ",".join([name, *names] if is_new else [each for each in names if each != name])
    except AttributeError as error:         # the defaults
        raise ValueError("Favourites are kept in the preferences of the installed extension, and it is not "
                         "installed") from error
    bpy.context.preferences.is_dirty = True         # so that Blender saves them
    return is_new


def tags() -> list[str]:
    used = {tag for each in published.list_offered() for tag in each.tags}
    return [tag for tag in published.TAGS if tag in used]


def find_offered(search: str, tag: str) -> list[published.PublishedMaterial]:
    """The published materials that have a tag (or `ALL`), and all words of a search in name, label or tags: metals
    in the order of their table, then the brightest first, since dark ones look alike."""
    words = search.lower().split()
    found = [each for each in published.list_offered() if tag in (ALL, *each.tags)
             and all(word in f"{each.name} {each.label} {' '.join(each.tags)} {each.words}".lower() for word in words)]
    return sorted(found, key=lambda each: -each.brightness)


def group_finishes(found: Sequence[published.PublishedMaterial]) -> list[list[published.PublishedMaterial]]:
    """Published materials, the finishes of a metal together."""
    groups: dict[str, list[published.PublishedMaterial]] = {}
    for each in found:
        groups.setdefault(each.substance if each.is_computed else each.name, []).append(each)
    return [*groups.values()]


def published_icon(name: str) -> int:
    """The icon of a published material: a grey disc until it has been drawn, with some others of its kind."""
    key = "published", name
    if key not in _icons:
        _icons.add(key, _disc())
        _coming.add(name)
    if name in _coming:
        together = next((each for each in _together() if name in each), (name,))
        queue.ask(("library", together), partial(thumbnails.library_pictures, together), "read", then=_keep_library)
    return _icons.find(key)


def coming() -> set[str]:
    """The published materials whose pictures were asked for and are not there yet. They are asked for again: a pop-up
    is laid out once, and the queue forgets what nobody asks."""
    for name in tuple(_coming):
        published_icon(name)
    return _coming


@cache
def _disc() -> SingleArray:
    y, x = (np.indices((thumbnails.SIZE, thumbnails.SIZE)) + 0.5) / thumbnails.SIZE * 2 - 1
    shade = np.array([*[_PLACEHOLDER_GREY] * 3, 1], np.float32)
    return np.where((x ** 2 + y ** 2 < 1)[..., None], shade, np.float32(0))


@cache
def _together() -> list[tuple[str, ...]]:
    """The names of materials whose pictures are drawn at a time: of a kind, in the order in which they are shown."""
    shown = [each for group in group_finishes(find_offered("", ALL)) for each in group]
    kinds = [[each.name for each in shown if each.tags[0] == tag] for tag in published.TAGS]
    return [tuple(names[first:first + _AT_A_TIME]) for names in kinds for first in range(0, len(names), _AT_A_TIME)]


def watch_folder(folder: str) -> Job[list[thumbnails.FolderEntry]]:
    """The job that lists the measurements in a folder; panels that show it notice changes within seconds."""
    global _was_drawn
    _was_drawn = True
    if not bpy.app.timers.is_registered(_tick):
        bpy.app.timers.register(_tick, first_interval=_TICK, persistent=True)
    return queue.ask(("watched", folder), partial(thumbnails.scan, folder), "read", max_age=_RESCAN)


def measurement_icon(measurement: thumbnails.FolderEntry, how: Arguments) -> tuple[int, Exception | None]:
    """The icon of a measurement, 0 until it has been drawn; and why it cannot be drawn, else None."""
    key: icons.Key = ("watched", *measurement, as_text(how))
    if key in _icons:
        return _icons.find(key), None
    if key in _failed:
        return 0, _failed[key]
    work = partial(thumbnails.measurement_picture, measurement, str(user_folder("thumbnails")), how)
    job = queue.ask(("thumbnail", *key), work, "slow", then=lambda done: _icons.add(key, not_none(done.result)))
    if isinstance(job.error, ValueError):       # of the file; that a worker was killed says nothing of it
        _failed[key] = job.error
    return _icons.find(key), job.error


def sample_icon(path: str, sample: str) -> int:
    """The small icon of a sample of a file: a grey disc until it has been drawn. The list that shows it asks once, and
    waits for as many as a file has."""
    stamp = time_and_size(path)
    if stamp is None:
        return 0
    found = thumbnails.FolderEntry(path, sample, stamp)
    key: icons.Key = ("sample", *found)
    if key not in _icons:
        _icons.add(key, _disc())
        _undrawn.add(key)
    if key in _undrawn:
        job = queue.ask(key, partial(thumbnails.measurement_picture, found, str(user_folder("thumbnails")),
                                     {"colours": DEFAULT_COLOURS}), "slow", then=partial(_keep_sample, key))
        job.asked += _PATIENCE
    return _icons.find(key)


def _keep_sample(key: icons.Key, job: Job[SingleArray]) -> None:
    _icons.add(key, not_none(job.result))
    _undrawn.discard(key)


def _keep_library(job: Job[dict[str, SingleArray]]) -> None:
    for name, picture in not_none(job.result).items():
        _icons.add(("published", name), picture)
        _coming.discard(name)
    search = bpy.context.window_manager.measured_brdf_shelf.path_resolve("search", False)
    bpy.msgbus.publish_rna(key=search)          # pop-ups that have it are drawn again, in the same layout


def _tick() -> float | None:
    """Redraw the panels for as long as one of them shows a folder: a timer."""
    global _was_drawn
    if not _was_drawn:
        return None
    _was_drawn = False          # until it is drawn again
    queue.redraw()
    return _TICK


register = _icons.register


def unregister() -> None:
    if bpy.app.timers.is_registered(_tick):
        bpy.app.timers.unregister(_tick)
    _icons.unregister()
    nearest.clear()
    _failed.clear()
    _coming.clear()
    _undrawn.clear()

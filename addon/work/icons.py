"""Icons for panels, made of pictures that workers draw."""

from collections.abc import Callable
from typing import Any

import bpy.utils.previews

from ...fitter.arrays import SingleArray
from ..core import previews
from ..core.annotations import Report, present
from . import queue
from .job import Job
from .recent import Recent

Key = tuple[Any, ...]
_Picture = SingleArray | tuple[SingleArray, Any]
_icon_ids: Recent[Key, int] = Recent(48, lambda key: present(_collection).__delitem__(repr(key)))
_collection: "bpy.utils.previews.ImagePreviewCollection | None" = None


def icon(key: Key, function: Callable[[Report], Any], lane: str = "fit",
         latest: bool = False) -> tuple[int, Job[Any]]:
    """The icon of a picture, which is drawn in the background when first asked for.

    Parameters
    ----------
    key : tuple
        What the picture shows: its kind, the measurements, and everything else that it depends on.
    function : callable
        As `Job` takes it; returns (size, size, 4) float32, or a tuple that begins with it.
    lane : str
        As `queue.ask` takes it.
    latest : bool
        Whether earlier pictures of this kind and these measurements that wait to be drawn are not wanted any more.

    Returns
    -------
    icon_id : int
        Until there is one, that of an earlier picture of this kind and these measurements, or 0.
    job : process.Job
    """
    if latest:
        queue.forget(lambda other: isinstance(other, tuple) and other[:2] == key[:2] and other != key)
    job = queue.ask(key, function, lane, then=lambda done: _make_icon(key, done))
    if key in _icon_ids:
        return _icon_ids[key], job
    return next((icon for other, icon in reversed(_icon_ids.items()) if other[:2] == key[:2]), 0), job


def at_once(key: Key, draw: Callable[[], SingleArray | None]) -> int:
    """The icon of a picture that takes no time to draw; 0 where there is none."""
    if key not in _icon_ids:
        _add(key, draw())
    return _icon_ids.get(key, 0)


def _make_icon(key: Key, job: Job[_Picture]) -> None:
    _add(key, job.result[0] if isinstance(job.result, tuple) else job.result)


def _add(key: Key, picture: SingleArray | None) -> None:
    if _collection is None or picture is None or key in _icon_ids:      # a forgotten question may be asked again
        return
    preview = _collection.new(repr(key))
    previews.fill(preview, picture)
    _icon_ids[key] = preview.icon_id


def register() -> None:
    global _collection
    _collection = bpy.utils.previews.new()


def unregister() -> None:
    global _collection
    _icon_ids.clear()
    bpy.utils.previews.remove(_collection)
    _collection = None

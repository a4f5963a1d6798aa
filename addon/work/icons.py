"""Icons for panels, made of pictures that workers draw."""

from collections.abc import Callable
from typing import Any

import bpy.utils.previews

from ...fitter.arrays import SingleArray
from ..core.annotations import not_none
from ..core.blender import previews
from . import queue
from .job import Job
from .recent import Recent

Key = tuple[Any, ...]
sample_icons: list[Callable[[str, str], int]] = []
"""Of a file and the name of a sample in it the small icon: added by the slice that draws measurements."""


class Icons:
    """Icons of pictures, by what they show; at most `most`, of which those used longest ago go first."""

    def __init__(self, most: int) -> None:
        self._ids: Recent[Key, int] = Recent(most, lambda key: not_none(self._previews).__delitem__(repr(key)))
        self._previews: bpy.utils.previews.ImagePreviewCollection | None = None

    def __contains__(self, key: Key) -> bool:
        return key in self._ids

    def find(self, key: Key) -> int:
        """The icon of a picture; 0 where there is none."""
        if key not in self._ids:
            return 0
        return self._ids[key]           # used last

    def earlier(self, key: Key) -> int:
        """The icon that was made last of the same kind and subject, the first two parts of a key; else 0."""
        return next((icon for other, icon in reversed(self._ids.items()) if other[:2] == key[:2]), 0)

    def add(self, key: Key, picture: SingleArray) -> None:
        """Make an icon; one that there is shows the new picture."""
        if self._previews is not None:
            preview = self._previews[repr(key)] if key in self._ids else self._previews.new(repr(key))
            previews.fill(preview, picture)
            previews.fill_small(preview, picture)
            self._ids[key] = preview.icon_id

    def register(self) -> None:
        self._previews = bpy.utils.previews.new()

    def unregister(self) -> None:
        self._ids.clear()
        if self._previews is not None:
            bpy.utils.previews.remove(self._previews)
        self._previews = None


_icons = Icons(48)
register, unregister = _icons.register, _icons.unregister


def icon(key: Key, function: Callable[[], Any], latest: bool = False) -> tuple[int, Job[Any]]:
    """The icon of a picture, which is drawn in the background when first asked for, and its job.

    Until then it is that of an earlier picture of this kind and subject, the first two parts of the key, or 0; with
    `latest`, those that wait to be drawn are dropped. The function returns a picture, or a tuple that begins with it.
    """
    def make(done: Job[Any]) -> None:
        picture: Any = done.result
        _icons.add(key, picture[0] if isinstance(picture, tuple) else picture)

    if latest:
        queue.forget(lambda other: isinstance(other, tuple) and other[:2] == key[:2] and other != key)
    job = queue.ask(key, function, then=make)
    return _icons.find(key) or _icons.earlier(key), job


def draw_at_once(key: Key, draw: Callable[[], SingleArray | None]) -> int:
    """The icon of a picture that takes no time to draw; 0 where there is none."""
    if key not in _icons and (picture := draw()) is not None:
        _icons.add(key, picture)
    return _icons.find(key)

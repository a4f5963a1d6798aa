"""Pictures for panels: arrays from the background made into icons."""

import bpy.utils.previews

from . import queue

_KEPT = 48
_icons = {}                 # question: icon id
_collection = None


def icon(key, function, lane="fit"):
    """The icon of a picture, drawn in the background on first demand.

    Parameters
    ----------
    key : tuple
        What is on the picture: its kind, the measurements, and all else that it depends on.
    function : callable
        Takes `Job.report`, returns (size, size, 4) float32, or a tuple that begins with it.
    lane : str
        As `queue.ask` takes it.

    Returns
    -------
    icon_id : int
        While there is none yet, that of the picture of this kind which was there before, or 0.
    job : background.Job
    """
    job = queue.ask(key, function, lane, then=lambda done: _take(key, done))
    if key in _icons:
        return _icons[key], job
    return next((icon for other, icon in reversed(_icons.items()) if other[:2] == key[:2]), 0), job


def fill(preview, picture):
    """Make an `ImagePreview` show a picture: (height, width, 4) float32."""
    preview.image_size = picture.shape[1::-1]
    preview.image_pixels_float.foreach_set(picture.ravel())


def _take(key, job):
    if _collection is None or job.result is None:
        return
    if len(_icons) >= _KEPT:
        _icons.clear()
        _collection.clear()
    picture = job.result[0] if isinstance(job.result, tuple) else job.result
    preview = _collection.new(repr(key))
    fill(preview, picture)
    _icons[key] = preview.icon_id


def register():
    global _collection
    _collection = bpy.utils.previews.new()


def unregister():
    global _collection
    _icons.clear()
    bpy.utils.previews.remove(_collection)
    _collection = None

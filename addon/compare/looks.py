"""Test renders of this session, each as the material was when it was rendered, until it is rendered again."""

from itertools import count
from typing import NamedTuple

import bpy

from ...fitter.arrays import SingleArray
from ..core.shading import comparison, look
from ..work.recent import Recent


class Key(NamedTuple):
    """What is rendered: the `session_uid` of the material, and one of `look.SHAPES` and `look.LIGHTINGS`."""

    material: int
    shape: str
    lighting: str


class Render(NamedTuple):
    """A picture, (size, size, 4), and its number, by which it is told from earlier ones."""

    picture: SingleArray
    number: int


_renders: Recent[Key, Render] = Recent(12)
_numbers = count()


def key(scene: bpy.types.Scene, material: bpy.types.Material) -> Key:
    """What a render of a material shows with the present choices of a scene."""
    chosen = comparison.get(scene)
    return Key(material.session_uid, chosen.shape or look.BALL, chosen.lighting or look.STUDIO)  # empty where damaged


def store(rendered: Key, picture: SingleArray) -> None:
    """Keep a picture: (size, size, 4)."""
    _renders[rendered] = Render(picture, next(_numbers))


def cached_render(rendered: Key) -> Render | None:
    """The last render, if it is kept."""
    return _renders.get(rendered)


def unregister() -> None:
    """Forget all renders."""
    _renders.clear()

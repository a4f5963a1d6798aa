"""Registers what belongs together with Blender and with the rest of the extension, and takes it back."""

from collections.abc import Callable, Mapping
from types import ModuleType
from typing import Any

import bpy


class Registration:
    """Modules and additions, which are registered in their order and unregistered in the opposite one.

    Modules have some of `classes`, `pointers` (type of Blender's, name and value of a property), `handlers`, `register`
    and `unregister`. Additions are (list, menu, or name of one of Blender's, what is appended to it).
    """

    def __init__(self, *modules: ModuleType, additions: tuple[tuple[Any, Any], ...] = ()) -> None:
        self._modules, self._additions = modules, additions

    def register(self) -> None:
        for module in self._modules:
            for cls in getattr(module, "classes", ()):
                bpy.utils.register_class(cls)
            for owner, name, pointer in getattr(module, "pointers", ()):
                setattr(owner, name, pointer)
            add_handlers(getattr(module, "handlers", {}))
            getattr(module, "register", lambda: None)()
        for place, item in self._additions:
            _find_list(place).append(item)

    def unregister(self) -> None:
        for place, item in reversed(self._additions):
            _find_list(place).remove(item)
        for module in reversed(self._modules):
            getattr(module, "unregister", lambda: None)()
            remove_handlers(getattr(module, "handlers", {}))
            for owner, name, _ in getattr(module, "pointers", ()):
                delattr(owner, name)
            for cls in reversed(getattr(module, "classes", ())):
                bpy.utils.unregister_class(cls)


def add_handlers(handlers: Mapping[str, Callable[..., None]]) -> None:
    """Have Blender call functions, by the names of the lists in `bpy.app.handlers`, as far as it has these."""
    for name, handler in handlers.items():
        getattr(bpy.app.handlers, name, []).append(handler)


def remove_handlers(handlers: Mapping[str, Callable[..., None]]) -> None:
    """Take `add_handlers` back; those that scripts have removed are not missed."""
    for name, handler in handlers.items():
        called = getattr(bpy.app.handlers, name, [])
        if handler in called:
            called.remove(handler)


def _find_list(place: Any) -> Any:
    return getattr(bpy.types, place) if isinstance(place, str) else place

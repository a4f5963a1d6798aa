"""The cache of what takes long to work out: the values that were used last, by key. Nothing here imports bpy."""

from collections.abc import Callable
from typing import TypeVar

_Key = TypeVar("_Key")
_Value = TypeVar("_Value")


class Recent(dict[_Key, _Value]):
    """At most `most` values; the one used longest ago goes first, and `forgotten` is called with its key. `get` and
    `in` are no use."""

    def __init__(self, most: int, forgotten: Callable[[_Key], object] = lambda _key: None) -> None:
        super().__init__()
        self._most, self._forgotten = most, forgotten

    def __getitem__(self, key: _Key) -> _Value:
        value = self.pop(key)
        super().__setitem__(key, value)
        return value

    def __setitem__(self, key: _Key, value: _Value) -> None:
        self.pop(key, None)
        super().__setitem__(key, value)
        if len(self) > self._most:
            oldest = next(iter(self))
            del self[oldest]
            self._forgotten(oldest)

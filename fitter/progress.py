"""How far long work is, told to whoever listens. What takes long calls `report` now and then, and divides its range
among its steps with `part`; functions need no parameter for it. Without a listener nothing happens."""

from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from contextvars import ContextVar
from typing import TypeVar

Listener = Callable[[float, str], object]
"""Takes the fraction done, from 0 to 1, and what is being done; empty: the same as before."""
_Item = TypeVar("_Item")
_listener: ContextVar[Listener | None] = ContextVar("listener", default=None)


def report(fraction: float, doing: str = "") -> None:
    """Tell the listener how far the present part is, from 0 to 1, and what is being done."""
    listener = _listener.get()
    if listener is not None:
        listener(fraction, doing)


@contextmanager
def part(begin: float, end: float, doing: str = "", about: str = "") -> Iterator[None]:
    """What is reported within goes from one fraction of the present part to another: with what is being done until
    something else is reported, and what stands before all that is being done within."""
    outer, now = _listener.get(), doing
    if outer is None:
        yield
        return

    def report_within(fraction: float, doing: str) -> None:
        nonlocal now
        now = doing or now
        outer(begin + (end - begin) * fraction, about + now if now else "")

    report_within(0.0, doing)
    with _replace_listener(report_within):
        yield


def each(items: Sequence[_Item]) -> Iterator[_Item]:
    """The items one after the other; each is an equal part."""
    for number, item in enumerate(items):
        with part(number / len(items), (number + 1) / len(items)):
            yield item


@contextmanager
def listen(listener: Listener) -> Iterator[None]:
    """Tell a listener what is reported within. The fractions that it is told never fall."""
    farthest, now = 0.0, ""

    def report_rising(fraction: float, doing: str) -> None:
        nonlocal farthest, now
        farthest, now = max(farthest, min(fraction, 1.0)), doing or now
        listener(farthest, now)

    with _replace_listener(report_rising):
        yield


@contextmanager
def listen_also(listener: Listener) -> Iterator[None]:
    """As `listen`, and whoever listens already is told as well."""
    outer = _listener.get()

    def report_both(fraction: float, doing: str) -> None:
        listener(fraction, doing)
        if outer is not None:
            outer(fraction, doing)

    with listen(report_both):
        yield


@contextmanager
def _replace_listener(listener: Listener) -> Iterator[None]:
    before = _listener.set(listener)
    try:
        yield
    finally:
        _listener.reset(before)

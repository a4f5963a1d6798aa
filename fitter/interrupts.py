"""Ctrl-C on the command line: one line and an exit status, also while modules are imported."""

import os
import signal
from types import FrameType
from typing import NoReturn

CANCELLED = 130             # the exit status, as shells have it for Ctrl-C
SAID = "cancelled"


def end_at_once() -> None:
    """Let an interrupt end the process, until `raise_again`: for a time in which nothing is written. What is imported
    then might catch a KeyboardInterrupt, or print it."""
    signal.signal(signal.SIGINT, _end_process)


def raise_again() -> None:
    """Let an interrupt be a KeyboardInterrupt, where `end_at_once` has made it another thing."""
    if getattr(signal.getsignal(signal.SIGINT), "__name__", "") == _end_process.__name__:       # of another copy, too
        signal.signal(signal.SIGINT, signal.default_int_handler)


def _end_process(_number: int, _frame: FrameType | None) -> NoReturn:
    os.write(2, f"{SAID}\n".encode())
    os._exit(CANCELLED)

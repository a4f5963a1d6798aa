"""What the registry knows of a file format."""

from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

from ..arrays import BoolArray
from ..samples import Samples

LARGEST_TEXT = 16 << 20     # bytes; the largest published text file has half a million


@dataclass(frozen=True)
class Format:
    """A file format of measurements. Each has a module of its own, which ends with its `FORMAT`.

    Attributes
    ----------
    name : str
        As menus and messages call it.
    files : str
        What its files are called, for messages: ``'CURET abrdf.dat'``.
    extensions : tuple of str
        In lower case, with the dot: what file browsers and folder conversion look for.
    recognises : callable
        Takes the content, returns whether it is in this format. It may be wrong about damaged files only.
    read : callable
        Takes path and content, and ``sample`` where there is a `list_samples`; returns `Samples` or raises
        `DatasetError`.
    is_text : bool
        Whether `recognises` and `read` take text: without a byte-order mark, refused where it has zero bytes.
    largest : int
        Bytes; larger files are refused.
    list_samples : callable, optional
        For files that hold several samples: takes path and content, returns a list of (number, name).
    overflowed : callable, optional
        Takes path, content and sample, returns which measurements are known to be saturated, (n,) bool, or None.
    read_with : callable, optional
        Takes the path of a file that is read together with another, and returns the path of that one, or None.
    """

    name: str
    files: str
    extensions: tuple[str, ...]
    recognises: Callable[[bytes], bool]
    read: Callable[..., Samples]
    is_text: bool = True
    largest: int = LARGEST_TEXT
    list_samples: Callable[[str | Path, bytes], list[tuple[int, str]]] | None = None
    overflowed: Callable[[str | Path, bytes, str | int | None], BoolArray | None] | None = None
    read_with: Callable[[Path], Path | None] | None = None

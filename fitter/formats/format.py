"""The description of a file format, of which the registry holds one for each."""

from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

from ..samples import Samples

LARGEST_TEXT = 16 << 20     # bytes; published text files have at most 1.6 million


@dataclass(frozen=True)
class Format:
    """A file format of measurements. Each has a module of its own, which ends with its `FORMAT`.

    Attributes
    ----------
    name : str
        For menus and messages.
    files : str
        What its files are called, for messages: ``'CURET abrdf.dat'``.
    extensions : tuple of str
        In lower case, with the dot, for file browsers and the conversion of folders.
    recognises : callable
        Takes the content; returns whether it is in this format. Exactly one format recognises an undamaged file.
    read : callable
        Takes path and content, the number ``sample`` if the format has `list_samples`, and ``reading`` if it has
        `options`; returns `Samples`, colours in linear Rec.709, or raises `DatasetError`.
    options : tuple of str
        The fields of `Reading` that matter to the format; of the others it has a definition of its own.
    is_text : bool
        Whether the format is text. Its functions then take content without a byte-order mark and zero bytes.
    largest : int
        Size limit in bytes; larger files are refused.
    list_samples : callable, optional
        For files with several samples: takes path and content; returns the (number, name) of each.
    read_with : callable, optional
        Takes the path of a file; returns the path of the file that it is read with as a part, or None.
    files_of : callable, optional
        Takes the path of a file with one of the `extensions`; returns those that are read with it, itself included,
        whether or not they are there.
    """

    name: str
    files: str
    extensions: tuple[str, ...]
    recognises: Callable[[bytes], bool]
    read: Callable[..., Samples]
    options: tuple[str, ...] = ()
    is_text: bool = True
    largest: int = LARGEST_TEXT
    list_samples: Callable[[str | Path, bytes], list[tuple[int, str]]] | None = None
    read_with: Callable[[Path], Path | None] | None = None
    files_of: Callable[[Path], list[Path]] | None = None

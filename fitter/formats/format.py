"""The description of a file format, of which the registry holds one for each."""

from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

from ..samples import Samples

LARGEST_TEXT = 16 << 20     # bytes; published text files have at most 1.6 million


@dataclass(frozen=True)
class Format:
    """A file format of measurements. Each has a module of its own, which ends with its `FORMAT`."""

    name: str                       # for menus and messages
    files: str                      # what its files are called, for messages: 'CURET abrdf.dat'
    extensions: tuple[str, ...]     # in lower case, with the dot, for file browsers and the conversion of folders
    # true for content in this format; exactly one format recognises an undamaged file
    recognises: Callable[[bytes], object]
    # takes content, `reading` if the format has `options`, the number `sample` if it has `list_samples`, and `path` if
    # others are read with it; returns samples, colours in linear Rec.709, or raises `DatasetError` with a line: of the
    # samples `load` says the source, and the name where a reader leaves it empty; of errors, the file
    read: Callable[..., Samples]
    options: tuple[str, ...] = ()   # the fields of `Reading` that matter; of the others it has a definition of its own
    is_text: bool = True            # its functions then take content without a byte-order mark and zero bytes
    largest: int = LARGEST_TEXT     # bytes; larger files are refused
    # of files with several samples, by content: the (number, name) of each
    list_samples: Callable[[bytes], list[tuple[int, str]]] | None = None
    # the files that are read with one that has one of the `extensions`, itself included, whether or not they are there:
    # first the one that stands for them
    list_parts: Callable[[Path], list[Path]] | None = None

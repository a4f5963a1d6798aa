"""File formats of measured reflectance. A file's format is recognised by its content, never by its name.

To add a format, write a module that ends with its `Format`, and enter it in `FORMATS`; CONTRIBUTING.md shows how.
"""

import difflib
from collections.abc import Collection, Iterator
from contextlib import contextmanager, suppress
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np

from ..colours import COLOURS, DEFAULT_COLOURS
from ..errors import DatasetError, SampleUnknownError, printable
from ..model import published
from ..samples import Samples
from ..storage import files
from . import (
    astm,
    coefficients,
    cornell_mat,
    curet,
    foreign,
    fred,
    isotropy,
    mbsdf,
    merl,
    pbrt_brdf,
    rgl,
    saved_samples,
    speos,
    table,
    table_layout,
    utia,
    zemax,
)
from .format import Format
from .gamut import convert_samples
from .reading import OPTIONS, Reading, check_choice
from .text import is_plain, name_file, parse_number, plain_text, read_bytes

# in the order of recognition: formats with a distinctive mark come before those recognised by their first line
FORMATS: tuple[Format, ...] = (rgl.FORMAT, merl.FORMAT, mbsdf.FORMAT, cornell_mat.FORMAT, saved_samples.FORMAT,
                               utia.FORMAT, fred.FORMAT, speos.FORMAT, zemax.FORMAT, astm.FORMAT, coefficients.FORMAT,
                               pbrt_brdf.FORMAT, table.FORMAT, curet.FORMAT)
_WITHOUT_MARK = (pbrt_brdf.FORMAT, table.FORMAT, curet.FORMAT)
EXTENSIONS = tuple(sorted({extension for known in FORMATS for extension in known.extensions}))
PLAIN = (".bin", ".npz", ".txt")      # extensions of which most files are no measurements
KNOWN_FILES = ", ".join(known.files for known in FORMATS[::-1])


def load(path: str | Path, sample: str | int | None = None, *, colours: str = DEFAULT_COLOURS,
         **options: Any) -> Samples:
    r"""Read a measured BRDF.

    Parameters
    ----------
    path : path-like
        A file in one of `FORMATS`, or ``published:NAME``, a material of `published.list_published`.
    sample : int or str, optional
        For files with several samples (CURET): the number or the name of one. The first one by default.
    colours : {"Rec.709", "Rec.2020", "ACEScg"}
        The linear colour space of the values. R, G and B of a file are taken to be linear Rec.709.
    **options
        The fields of `Reading`: `angles`, `quantity`, `illuminant`, `isotropic`, `symmetry`, `encoding`,
        `keep_unmeasured` and `columns`. Each has an `Option` in `OPTIONS`, with what it may be and what that means.

    Returns
    -------
    Samples
        Their `notes` say which options were followed, which had no effect, and how many samples lie outside of the
        colour space.

    Raises
    ------
    DatasetError
        If the file is not there, is in no known format, is malformed, or has no value above 0, or an option is none of
        these; the message says file, line and what was expected. `UnitsUnknownError` where `angles` or `quantity` is
        needed, `ColumnsUnknownError` where `columns` is.

    Examples
    --------
    >>> import tempfile
    >>> path = Path(tempfile.mkdtemp()) / "paint.astm"
    >>> _ = path.write_text("SAMPLE_NAME Blue paint\n"
    ...                     "VARS theta_i,phi_i,theta_s,phi_s,R,G,B\n"
    ...                     "0.5,0,0.5,3.141593,0.1,0.2,0.6\n")
    >>> samples = load(path)
    >>> samples.name, samples.channels, samples.values.tolist()
    ('Blue paint', ('R', 'G', 'B'), [[0.1, 0.2, 0.6]])
    """
    reading = Reading(**options)
    check_choice("colours", colours, COLOURS)
    if (name := published.parse_virtual_path(path)) is not None:
        _choose_sample(path, sample, [])
        samples = published.load_published(name)
        if reading.isotropic is not None:
            samples = isotropy.as_asked(samples, reading.isotropic)
        return convert_samples(_note_unused_options(reading, (), "published fits", samples), colours)
    known, content = _recognise(path, reading.columns)
    chosen: dict[str, Any] = {"reading": reading} if known.options else {}
    with _raise_dataset_errors(path):
        number = _choose_sample(path, sample, _list_samples(known, content))
        if number is not None:
            chosen["sample"] = number
        if known.list_parts is not None:
            chosen["path"] = Path(path)
        samples = known.read(content, **chosen)
        _check_content(samples)
    if reading.isotropic is not None and "isotropic" not in known.options:
        samples = isotropy.as_asked(samples, reading.isotropic)
    if reading.isotropic is None:
        samples = isotropy.note_sides(samples)
    samples = replace(samples, name=printable(samples.name or Path(path).stem), source=str(path),
                      notes=tuple(map(printable, samples.notes)), channels=tuple(map(printable, samples.channels)))
    return convert_samples(_note_unused_options(reading, known.options, f"{known.name} files", samples), colours)


def _check_content(samples: Samples) -> None:
    """Raise DatasetError where nothing is reflected: a fit of that would match perfectly. Single channels may be black,
    and noise makes values of dark ones negative."""
    values = samples.values
    if not (values > 0).any():
        found = "0 or below" if values.any() else "0"
        raise DatasetError(f"all {values.size:,} values are {found}, expected reflected light: some above 0")


def _note_unused_options(reading: Reading, options: tuple[str, ...], files: str, samples: Samples) -> Samples:
    """Samples with a note of the options that were chosen, and that do not matter to their format."""
    # `isotropic` matters to all
    ignored = [name for name, option in OPTIONS.items() if name not in (*options, "isotropic")
               and getattr(reading, name) != option.default]
    if not ignored:
        return samples
    return replace(samples, notes=(*samples.notes, f"Without effect on {files}: {', '.join(ignored)}"))


def _choose_sample(path: str | Path, sample: str | int | None, listed: list[tuple[int, str]]) -> int | None:
    """The number of the sample that a user names, by number or name; the first of the file without one. None of a file
    that lists none."""
    if sample in (None, ""):
        return listed[0][0] if listed else None
    if not listed:
        raise DatasetError(f"holds a single sample, so there is no sample {sample!r} to choose", path)
    text = str(sample).strip().lower()
    if text.isdecimal() or isinstance(sample, int | float):
        numbers = [number for number, _ in listed]
        if (number := parse_number(text.encode())) not in numbers:
            raise SampleUnknownError(f"no sample {text}, expected a number from {min(numbers)} to {max(numbers)} or a "
                                     "name", path)
        return int(number)
    names = [name.lower() for _, name in listed]
    if text not in names:
        near = difflib.get_close_matches(text, names, n=3) or [name for name in names if text in name][:3]
        hint = f"; did you mean {' or '.join(near)}?" if near else ""
        raise SampleUnknownError(f"no sample named '{text}'{hint}", path)
    return listed[names.index(text)][0]


def is_there(path: str | Path) -> bool:
    """Whether there is a file at a path, or it names a published material."""
    name = published.parse_virtual_path(path)
    if name is None:
        return Path(path).is_file()
    with suppress(DatasetError):
        return bool(published.find(name))
    return False


def open_choices(path: str | Path) -> frozenset[str]:
    """What a file may leave open, by its extension: fields of `Reading`, and "sample"; all of it for another extension.

    Examples
    --------
    >>> sorted(open_choices("abrdf.dat")), sorted(open_choices("gold.binary"))
    (['sample'], [])
    """
    if published.parse_virtual_path(path) is not None:
        return frozenset()
    suffix = Path(path).suffix.lower()
    return frozenset(name for known in FORMATS if suffix in known.extensions or suffix not in EXTENSIONS
                     for name in (*known.options, *(("sample",) if known.list_samples is not None else ())))


def list_samples(path: str | Path, columns: str | None = None) -> list[tuple[int, str]]:
    """The (number, name) of each sample in a file; empty if the format has one a file. `columns` as in `load`."""
    if (name := published.parse_virtual_path(path)) is not None:
        published.find(name)
        return []
    known, content = _recognise(path, columns)
    with _raise_dataset_errors(path):
        return _list_samples(known, content)


def _list_samples(known: Format, content: bytes) -> list[tuple[int, str]]:
    listed = [] if known.list_samples is None else known.list_samples(content)
    return [(number, printable(name)) for number, name in listed]


def preview(path: str | Path) -> tuple[list[str] | None, list[list[str]]]:
    """The names, if there are any, and the first rows of a table whose columns are not understood, as text.

    Raises DatasetError if the file cannot be read, or has no rows.
    """
    with _raise_dataset_errors(path):
        found = table_layout.preview(plain_text(read_bytes(path, table.FORMAT.largest)))
        if found is None:
            raise DatasetError("no rows of numbers found")
    return found


def is_recognised(path: str | Path, columns: str | None = None) -> bool:
    """Whether a file can be read, and is in one of `FORMATS`; or a path names a published material."""
    if published.parse_virtual_path(path) is not None:
        return is_there(path)
    with suppress(DatasetError):
        _recognise(path, columns)
        return True
    return False


def is_read_with_another(path: Path, files: Collection[Path]) -> bool:
    """Whether `load` reads this file as a part of another one of `files`."""
    first = _list_parts(path)[0]
    return first != path and first in files


def list_files(path: str | Path) -> list[Path]:
    """A file of measurements, and those that `load` reads with it."""
    path = Path(path)
    return [path, *(each for each in _list_parts(path) if each != path)]


def _list_parts(path: Path) -> list[Path]:
    """`Format.list_parts` of a file, by its extension."""
    return next((known.list_parts(path) for known in FORMATS
                 if known.list_parts is not None and path.suffix.lower() in known.extensions), [path])


def time_and_size(path: str | Path) -> tuple[int, int] | None:
    """Tells measurements from former ones in the same file: `files.time_and_size` of it and of all that `load` reads
    with it, the latest time and the sum of their bytes. None if it is not there.
    """
    own, *others = map(files.time_and_size, list_files(path))
    times, sizes = zip(*filter(None, (own, *others)), strict=True) if own else ((), ())
    return (max(times), sum(sizes)) if own else None


def _recognise(path: str | Path, columns: str | None = None) -> tuple[Format, bytes]:
    """The format of a file, and its content in the form that the format's functions take.

    Of a text whose columns are named by a user, only a distinctive mark says that it is no table.
    """
    content = read_bytes(path, max(known.largest for known in FORMATS))
    with _raise_dataset_errors(path):
        known = next((known for known in FORMATS if not known.is_text and known.recognises(content)), None)
        if known is None:
            largest = max(known.largest for known in FORMATS if known.is_text)
            text = plain_text(content) if len(content) <= largest and is_plain(content) else b""
            known = next((known for known in FORMATS if known.is_text and not (columns and known in _WITHOUT_MARK)
                          and known.recognises(text)), None)
            if known is None and columns and table_layout.find(text, columns) is not None:
                known = table.FORMAT
            if known is None:
                raise _unknown_format(path, content, text, largest, columns)
            content = text
        if len(content) > known.largest:
            raise DatasetError(f"{len(content):,} bytes, expected at most {known.largest:,}")
        return known, content


def _unknown_format(path: str | Path, content: bytes, text: bytes, largest: int, columns: str | None) -> DatasetError:
    """What to say of a file in no known format."""
    if (what := foreign.describe(content)) is not None:
        return DatasetError(what)
    if len(content) > largest:          # not searched for the marks of text formats
        return DatasetError(f"{len(content):,} bytes, expected at most {largest:,} for text")
    if (error := table.unknown_columns(text)) is not None:
        return error if not columns else DatasetError(f"no row of numbers for the columns {columns[:80]} found")
    if (what := foreign.describe_by_name(path)) is not None:
        return DatasetError(what)
    plain_text(content)                 # raises where it is binary
    return DatasetError(f"in no known format; expected one of: {KNOWN_FILES}")


@contextmanager
def _raise_dataset_errors(path: str | Path) -> Iterator[None]:
    """Make whatever a reader raises an error of its file: the work on other files goes on. What NumPy would warn of is
    found by the checks of what was read."""
    try:
        with np.errstate(all="ignore"), name_file(path):
            yield
    except DatasetError:
        raise
    except MemoryError as error:
        raise DatasetError("not enough memory to read it", path) from error
    except Exception as error:
        raise DatasetError(f"cannot be read: {type(error).__name__}: {error}", path) from error

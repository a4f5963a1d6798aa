"""Finds the measurements in files and folders."""

import os
from collections import Counter
from collections.abc import Iterable, Iterator
from contextlib import suppress
from pathlib import Path
from typing import NamedTuple

from ...fitter import DatasetError
from ...fitter.formats import EXTENSIONS, PLAIN, is_read_with_another, is_recognised, list_samples
from ...fitter.model.published import parse_virtual_path

GLOB = ";".join(f"*{extension}" for extension in EXTENSIONS)
_MOST = 20_000              # files and folders that are looked at: in a large tree, those nearest to its root
_NAMED_FOLDERS = 4          # folders, in a message


class Source(NamedTuple):
    """A measurement: its file, and the name of the sample in a file with several."""

    path: str
    sample: str


class Failure(NamedTuple):
    """A file that could not be read."""

    path: str
    sample: str
    error: ValueError


def files_in(paths: Iterable[str | Path], columns: str | None = None) -> list[Path]:
    """The files and virtual paths given, and those in the folders given whose names have the extension of a format; of
    plain text and .bin, only what is recognised, as tables with these `columns` too."""
    files: list[Path] = []
    for path in map(Path, paths):
        if parse_virtual_path(path) is not None or not path.is_dir():
            files.append(path)
        else:
            files += sorted(item for item in path.iterdir() if _is_measurement(item, columns))
    return files


def _is_measurement(file: Path, columns: str | None) -> bool:
    suffix = file.suffix.lower()
    return suffix in EXTENSIONS and (suffix not in PLAIN or is_recognised(file, columns))


def passed_over(paths: Iterable[str | Path], columns: str | None = None) -> list[str]:
    """A line for each of these folders below which there are files of measurements that `files_in` does not find."""
    folders = [path for path in map(Path, paths) if parse_virtual_path(path) is None and path.is_dir()]
    given = {os.path.realpath(folder) for folder in folders}
    lines = []
    for folder in folders:
        below = Counter(os.path.dirname(entry.path) for entry in files_below(str(folder))
                        if os.path.realpath(os.path.dirname(entry.path)) not in given
                        and _is_measurement(Path(entry.path), columns))
        if below:
            names = [os.path.relpath(place, folder) for place in below]
            lines.append(f"{folder}: folders in it are not read, though {below.total():,} of their files may hold "
                         f"measurements: give them too ({', '.join(names[:_NAMED_FOLDERS])}"
                         f"{' ...' * (len(names) > _NAMED_FOLDERS)})")
    return lines


def files_below(folder: str) -> Iterator["os.DirEntry[str]"]:
    """The files in a folder, by name, then those in its folders, and so on; each folder once, wherever links lead.

    Hidden folders, and those that cannot be read, are passed over. Raises OSError if the first cannot be read.
    """
    folders, seen, left = [folder], set(), _MOST
    for number, place in enumerate(folders):
        try:
            status = os.stat(place)
            if (status.st_dev, status.st_ino) in seen:
                continue
            seen.add((status.st_dev, status.st_ino))
            with os.scandir(place) as stream:
                entries = sorted(stream, key=lambda entry: entry.name)
        except OSError:
            if number == 0:
                raise
            continue
        for entry in entries[:left]:
            with suppress(OSError):                     # a loop of links
                if not entry.is_dir():
                    yield entry
                elif not entry.name.startswith("."):
                    folders.append(entry.path)
        left = max(left - len(entries), 0)


def sources_in(paths: Iterable[str | Path], columns: str | None = None) -> tuple[list[Source], list[Failure]]:
    """The measurements in files and folders, of tables with these `columns`, and those that could not be read.

    A CURET file has one for each sample; red, green and blue files side by side are one.
    """
    files = files_in(paths, columns)
    sources: list[Source] = []
    failures: list[Failure] = []
    for file in files:
        if is_read_with_another(file, files):
            continue
        try:
            samples = list_samples(file, columns)
        except DatasetError as error:
            failures.append(Failure(str(file), "", error))
            continue
        sources += [Source(str(file), name) for _, name in samples] or [Source(str(file), "")]
    return sources, failures

"""Which measurements there are in files and folders."""

from pathlib import Path

from ...fitter import DatasetError
from ...fitter.formats import EXTENSIONS, is_read_with_another, list_samples

GLOB = ";".join(f"*{extension}" for extension in EXTENSIONS)


def files_in(paths):
    """The files given, and those in folders given that may hold measurements, by their names."""
    files = []
    for path in map(Path, paths):
        files += sorted(item for item in path.iterdir()
                        if item.suffix.lower() in EXTENSIONS) if path.is_dir() else [path]
    return files


def sources_in(paths):
    """The measurements in files and folders.

    Returns
    -------
    sources : list of (path, sample)
        A CURET file counts as many as it has samples; of red, green and blue files side by side only one is taken.
    failures : list of (path, sample, DatasetError)
        Files that cannot be read.
    """
    files = files_in(paths)
    sources, failures = [], []
    for file in files:
        if is_read_with_another(file, files):
            continue
        try:
            samples = list_samples(file)
        except DatasetError as error:
            failures.append((str(file), "", error))
            continue
        sources += [(str(file), name) for _, name in samples] or [(str(file), "")]
    return sources, failures

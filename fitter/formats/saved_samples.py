"""Samples that Measured BRDF itself has written, such as those of photographs of a ball: NumPy's .npz, in single
precision (docs/layouts.md, Saved samples)."""

import json
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..arrays import map_directions
from ..errors import DatasetError
from ..samples import Samples
from ..storage import files, npz
from .format import Format

_FORMAT, _SAMPLES_VERSION = "measured-brdf-samples", 1
_ENTRIES = {"samples", "directions", "values"}, {"samples", "directions", "values", "deviation"}
_BEGINS = b"PK\3\4", b"samples.npy"     # a zip archive, and after 26 bytes the name of its first member
_MOST_COMPRESSED = 50       # times the file that its arrays may have: of noisy values they have twice, and
_SMALL_ARRAYS = 16 << 20    # up to so many bytes as much as they like, as an even grid of one value does, 300 times
LARGEST = 64 << 20          # bytes; of 200,000 samples of a ball a tenth


def write(samples: Samples, path: str | Path) -> None:
    """Write samples, in linear Rec.709 or grey, to an .npz file.

    Raises OSError if the file cannot be written; a file at `path` then stays as it was.
    """
    header = {"format": _FORMAT, "version": _SAMPLES_VERSION, "name": samples.name,
              "source": files.strip_folders(samples.source), "notes": list(samples.notes),
              "channels": list(samples.channels), "isotropic": samples.isotropic}
    arrays: dict[str, NDArray[Any]] = {"samples": np.array(json.dumps(header)),
                                       "directions": np.stack(samples.directions).astype(np.float32),
                                       "values": samples.values.astype(np.float32)}
    if samples.deviation is not None:
        arrays["deviation"] = samples.deviation.astype(np.float32)
    with files.replace_file(path) as stream:
        stream.write(npz.to_bytes(arrays))


def recognises(content: bytes) -> bool:
    """Whether the first member of an archive is that of samples."""
    return content.startswith(_BEGINS[0]) and content[30:30 + len(_BEGINS[1])] == _BEGINS[1]


def is_another(path: str | Path) -> bool:
    """Whether a file is an archive like those of samples, of something else: a saved fit."""
    if not Path(path).is_file():
        return False
    with open(path, "rb") as stream:
        beginning = stream.read(64)
    return beginning.startswith(b"PK") and not recognises(beginning)


def read(content: bytes) -> Samples:
    """Read what `write` wrote. Raises DatasetError if it is damaged, or of another version."""
    try:
        entries = npz.read(content, max(_MOST_COMPRESSED * len(content), _SMALL_ARRAYS))
        header = json.loads(str(entries["samples"]))
        if header["format"] != _FORMAT or set(entries) not in _ENTRIES:
            raise ValueError("other entries than those of samples")
        if header["version"] != _SAMPLES_VERSION:
            raise DatasetError(f"samples of version {header['version']!r}, expected {_SAMPLES_VERSION}")
        channels, notes = header["channels"], header["notes"]
        if not all(isinstance(text, str) for text in (*channels, *notes)):
            raise ValueError("channels and notes are not texts")
        directions, values = entries["directions"], entries["values"]
        if directions.ndim != 2 or len(directions) != 4 or values.ndim != 2:
            raise ValueError(f"directions are {directions.shape} and values {values.shape}, expected (4, n) and (n, "
                             f"channels)")
        numbers = {name: array.astype(float) for name, array in entries.items() if name != "samples"}
    except (ValueError, KeyError, TypeError, RecursionError) as error:
        if isinstance(error, DatasetError):
            raise
        raise DatasetError(f"damaged samples: {error}") from error
    return Samples(*map_directions(np.asarray, numbers["directions"]), numbers["values"], tuple(channels),
                   str(header["name"]), notes=tuple(notes), deviation=numbers.get("deviation"),
                   isotropic=bool(header["isotropic"]))


FORMAT = Format("Saved samples", "samples saved by Measured BRDF (.npz)", (".npz",), recognises, read, is_text=False,
                largest=LARGEST)

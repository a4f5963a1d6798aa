"""Files of measured reflectance. The format is recognised from the content, never from the file's name."""

from ..errors import DatasetError
from . import astm, cornell_mat, curet, pbrt_brdf
from .text import plain_text, read_bytes

FORMATS = "CURET abrdf.dat, Cornell ASTM (.astm), pbrt-v2 .brdf, Cornell paint.reformat.mat"


def load(path, sample=None):
    """Read a measured BRDF.

    Parameters
    ----------
    path : path-like
        CURET `abrdf.dat` (or `rbrdf.dat`, `gbrdf.dat`, `bbrdf.dat`), a Cornell ASTM file, a pbrt-v2 `.brdf`, or
        Cornell's `paint.reformat.mat`. Spectra become linear sRGB under D65.
    sample : int or str, optional
        Which sample of a CURET file: its number, or its name. The first one where it is not given.

    Returns
    -------
    Samples

    Raises
    ------
    DatasetError
        If the file is not there, is in no known format, or is malformed: with file, line and what was expected.
    """
    dataset, content = _recognise(path)
    if dataset is curet:
        return curet.read(path, content, sample)
    if sample not in (None, ""):
        raise DatasetError(f"holds a single sample, so there is no sample {sample!r} to choose", path)
    return dataset.read(path, content)


def list_samples(path):
    """The samples that a CURET file holds: a list of (number, name); empty for a file with just one."""
    dataset, content = _recognise(path)
    return curet.list_samples(path, content) if dataset is curet else []


def overflowed(path, sample=None):
    """Which measurements of a CURET sample overflowed the camera: (205,) bool, or None where no file tells."""
    dataset, content = _recognise(path)
    return curet.overflowed(path, content, sample) if dataset is curet else None


def _recognise(path):
    """The module that reads this file, and the file's content as that module takes it."""
    content = read_bytes(path)
    if cornell_mat.recognises(content):
        return cornell_mat, content
    content = plain_text(content, path)
    for dataset in (astm, pbrt_brdf, curet):
        if dataset.recognises(content):
            return dataset, content
    raise DatasetError(f"in no known format; expected one of: {FORMATS}", path)

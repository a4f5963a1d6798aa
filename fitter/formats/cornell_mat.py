"""Cornell's house paint measurements: paint.reformat.mat, a MATLAB 5 file."""

from pathlib import Path

import numpy as np

from ..errors import DatasetError
from ..samples import RGB, Samples
from . import mat5
from .format import Format
from .spectra import to_linear_srgb
from .text import check_thetas

_ARRAYS = ("dir_in", "dir_out", "fr", "wavelength")


def recognises(content):
    """Whether the file begins as MATLAB's do."""
    return content.startswith(mat5.MAGIC)


def read(path, content):
    """Read the paint file: dir_in and dir_out (n vectors, z is the normal), fr (n, bands), wavelength (bands,) in nm.

    Returns
    -------
    Samples
    """
    arrays = mat5.read(content, path, _ARRAYS)
    missing = [name for name in _ARRAYS if name not in arrays]
    if missing:
        raise DatasetError(f"no array {', '.join(missing)}; expected {', '.join(_ARRAYS)}", path)
    wavelength = arrays["wavelength"].ravel()
    fr = _oriented(arrays["fr"], len(wavelength), "fr", path)
    theta_i, phi_i = _angles(arrays["dir_in"], len(fr), "dir_in", path)
    theta_o, phi_o = _angles(arrays["dir_out"], len(fr), "dir_out", path)
    if not np.isfinite(fr).all():
        raise DatasetError("fr holds numbers that are not finite", path)
    check_thetas(np.stack([theta_i, theta_o], axis=1), lambda row: None, path)
    return Samples(theta_i, phi_i, theta_o, phi_o, to_linear_srgb(wavelength, fr, path), RGB, Path(path).stem,
                   str(path))


def _oriented(array, columns, name, path):
    """A matrix with so many columns, transposed if need be."""
    if array.ndim == 2 and array.shape[1] == columns:
        return array
    if array.ndim == 2 and array.shape[0] == columns:
        return array.T
    raise DatasetError(f"{name} has the shape {array.shape}, expected {columns} columns", path)


def _angles(vectors, count, name, path):
    vectors = _oriented(vectors, 3, name, path)
    if len(vectors) != count:
        raise DatasetError(f"{name} has {len(vectors)} vectors, expected {count} as in fr", path)
    length = np.linalg.norm(vectors, axis=1)
    if not np.isfinite(length).all() or not length.all():
        raise DatasetError(f"{name} holds a vector that is not a direction", path)
    x, y, z = (vectors / length[:, None]).T
    return np.arccos(np.clip(z, -1, 1)), np.arctan2(y, x)


FORMAT = Format("Cornell", "Cornell paint.reformat.mat", (".mat",), recognises, read, is_text=False)

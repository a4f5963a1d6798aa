"""MERL files made for tests, of few cells or of the nets that stand for the real ones."""

import importlib.util
import struct

import numpy as np

from support.checkout import measurements

SCALE = np.array([1.0, 1.15, 1.66]) / 1500


def pack(values, kind="<f8"):
    """The bytes of a file: values (n_h, n_d, n_p, 3), 1/sr, of three channels."""
    stored = np.moveaxis(np.asarray(values) / SCALE, -1, 0)
    return struct.pack("<3i", *stored.shape[1:]) + stored.astype(kind).tobytes()


def random_cells(size, seed):
    """Values of n, n, 2n cells; some are not measured."""
    values = np.random.default_rng(seed).random((size, size, 2 * size, 3))
    values[values[..., 0] > 0.9] = -1
    return values


def nets():
    """The module that writes files from nets trained on the real ones, or None where it is not at hand."""
    path = measurements().parent / "tools" / "merl_binary.py"
    if not path.is_file() or not (measurements() / "merl" / "nbrdf_nets.npz").is_file():
        return None
    spec = importlib.util.spec_from_file_location("merl_binary", path)
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module

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


def of_model(model, size=90):
    """The bytes of a file of size, size, 2 size cells with a model's values; cells below the horizon are negative."""
    theta_h = (np.arange(size) / size) ** 2 * np.pi / 2
    theta_d, phi_d = (np.arange(count) / size * np.pi / 2 for count in (size, 2 * size))
    values = np.empty((size, size, 2 * size, 3))
    for plane, half in zip(values, theta_h, strict=True):           # one at a time, to save memory
        x, y = (np.sin(theta_d)[:, None] * of(phi_d) for of in (np.cos, np.sin))
        z = np.broadcast_to(np.cos(theta_d)[:, None], x.shape)
        angles = []
        for sign in (1, -1):                # the light, and the other side of the half vector
            across, up = z * np.sin(half) + sign * x * np.cos(half), z * np.cos(half) - sign * x * np.sin(half)
            angles += [np.arctan2(np.hypot(across, y), up), np.arctan2(sign * y, across)]
        above = (np.maximum(angles[0], angles[2]) < np.pi / 2).ravel()
        plane[...] = -SCALE
        plane.reshape(-1, 3)[above] = model.evaluate(*(angle.ravel()[above] for angle in angles))
    return pack(values)

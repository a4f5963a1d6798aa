"""Files of measurements, written and read."""

import numpy as np
import pytest

import fitter
from support import tensor_files


@pytest.fixture
def load(request, tmp_path):
    """Read content, text or bytes, as a file: load(content, name=None, **options). Its name is FILE of the module."""
    def load(content, name=None, **options):
        path = tmp_path / (name or request.module.FILE)
        path.write_bytes(content if isinstance(content, bytes) else content.encode())
        return fitter.load(path, **options)
    return load


@pytest.fixture
def written(tmp_path):
    """Write arrays as RGL's container: written(arrays, name="made.bsdf")."""
    def written(arrays, name="made.bsdf"):
        path = tmp_path / name
        path.write_bytes(tensor_files.pack(arrays))
        return path
    return written


@pytest.fixture
def projected():
    """Outgoing directions on the disk, folded at the plane of incidence, azimuth 0 the light's or at a turn: (n, 2)."""
    def projected(samples, turn=0.0):
        apart = samples.phi_o - samples.phi_i + turn
        return np.sin(samples.theta_o)[:, None] * np.stack([np.cos(apart), np.abs(np.sin(apart))], axis=1)
    return projected

"""Directions for the coordinate systems."""

import numpy as np
import pytest


@pytest.fixture
def pairs(random):
    theta_i, theta_o = np.arccos(random.random((2, 500)))
    phi_i, phi_o = random.random((2, 500)) * 2 * np.pi
    return theta_i, phi_i, theta_o, phi_o

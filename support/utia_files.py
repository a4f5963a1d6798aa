"""UTIA files made for tests, of analytic materials."""

import numpy as np

DEGREES = np.arange(6) * 15.0, np.arange(48) * 7.5


def pack(values):
    """The bytes of a file: values (theta_i, phi_i, theta_o, phi_o, 3), as they are stored."""
    return np.moveaxis(values, -1, 0).reshape(3, 288, 288).astype("<f8").tobytes()


def values_of(truth):
    """The values of a function of four angles, (n,) radians each to (n, 3), on the grid of a file."""
    theta, phi = map(np.radians, DEGREES)
    grid = np.meshgrid(theta, phi, theta, phi, indexing="ij")
    return truth(*(angle.ravel() for angle in grid)).reshape(*grid[0].shape, 3)

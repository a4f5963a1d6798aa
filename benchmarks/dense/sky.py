"""An image of a clear sky with a sun, over ground, and directions sampled by its luminance.

The sky is that of A. J. Preetham, P. Shirley, B. Smits: A Practical Analytic Model for Daylight, SIGGRAPH 1999, at
turbidity 3 (its appendix A.2). The sun is widened to a disk of 2.5 degrees' radius, of 5 times the sky's illuminance on
the ground where it falls upright: about a clear day's. Below the horizon is grey-brown ground that both light. The
radiance is constant in each pixel, so that sampling by pixels is exact. Directions are unit vectors with y up; values
are linear sRGB, relative.
"""

from dataclasses import dataclass
from functools import cache

import numpy as np

TURBIDITY = 3.0
SUN = np.array([-0.55, 0.75, 0.6]) / np.linalg.norm([-0.55, 0.75, 0.6])         # from behind the viewer's left shoulder
SUN_RADIUS = np.radians(2.5)
SUN_SHARE = 5.0             # its illuminance where it falls upright, over that of the sky on the ground
SUN_COLOUR = np.array([1.0, 0.94, 0.82])
GROUND = np.array([0.24, 0.2, 0.16])        # albedo
ROWS = 180                  # pixels of a degree; row 0 is about the zenith
LUMINANCE = np.array([0.2126, 0.7152, 0.0722])
_SRGB = np.array([[3.2406, -1.5372, -0.4986], [-0.9689, 1.8758, 0.0415], [0.0557, -0.2040, 1.0570]])     # of XYZ
# A to E of the distribution, slope and offset in the turbidity
_PEREZ = {"Y": ((0.1787, -1.4630), (-0.3554, 0.4275), (-0.0227, 5.3251), (0.1206, -2.5771), (-0.0670, 0.3703)),
          "x": ((-0.0193, -0.2592), (-0.0665, 0.0008), (-0.0004, 0.2125), (-0.0641, -0.8989), (-0.0033, 0.0452)),
          "y": ((-0.0167, -0.2608), (-0.0950, 0.0092), (-0.0079, 0.2102), (-0.0441, -1.6537), (-0.0109, 0.0529))}
# the zenith's chromaticity: powers of the turbidity by powers of the sun's angle, both falling
_ZENITH = {"x": ((0.00166, -0.00375, 0.00209, 0), (-0.02903, 0.06377, -0.03202, 0.00394),
                 (0.11693, -0.21196, 0.06052, 0.25886)),
           "y": ((0.00275, -0.00610, 0.00317, 0), (-0.04214, 0.08970, -0.04153, 0.00516),
                 (0.15346, -0.26756, 0.06670, 0.26688))}
_LOWEST = 0.01              # cosine from the zenith: the model ends at the horizon


@dataclass(frozen=True, eq=False)
class Sky:
    """An image of all directions, (rows, 2 rows, 3): rows from the zenith to the nadir, even in the polar angle, and
    columns even in the azimuth from x towards z."""

    radiance: np.ndarray

    def at(self, directions):
        """The radiance from directions (n, 3): (n, 3)."""
        return self.radiance[_pixels(directions, len(self.radiance))]

    def density(self, directions):
        """With which `sampled` chooses directions (n, 3): (n,), 1/sr."""
        chance, area = _chances(self.radiance)
        row, column = _pixels(directions, len(self.radiance))
        return chance[row, column] / area[row]

    def sampled(self, u):
        """Directions (n, 3) by luminance, of even numbers u (n, 2) from 0 to 1."""
        chance, _ = _chances(self.radiance)
        rows, columns = chance.shape
        of_row = chance.sum(axis=1)
        row, across = _inverse(np.cumsum(of_row), u[:, 0])
        within = np.cumsum(chance, axis=1) / np.maximum(of_row, 1e-300)[:, None] + np.arange(rows)[:, None]
        column, along = _inverse(within.ravel(), np.minimum(u[:, 1], 1 - 1e-12) + row)
        edges = np.cos(np.pi * np.arange(rows + 1) / rows)
        y = edges[row] + across * (edges[row + 1] - edges[row])
        azimuth = 2 * np.pi * ((column % columns) + along) / columns
        sine = np.sqrt(np.maximum(1 - y ** 2, 0))
        return np.stack([sine * np.cos(azimuth), y, sine * np.sin(azimuth)], axis=1)


@cache
def clear():
    """The sky that the module describes."""
    centre = directions(ROWS)
    _, area = _chances(np.ones((ROWS, 2 * ROWS, 3)))
    up = np.maximum(centre[..., 1], 0) * area[:, None]
    dome = np.where(centre[..., 1:2] > 0, preetham(centre, SUN, TURBIDITY), 0)
    diffuse = np.einsum("ij,ijc->c", up, dome)
    cosine = np.clip(centre @ SUN, -1, 1)
    disk = (cosine > np.cos(SUN_RADIUS)) * area[:, None]
    direct = SUN_SHARE * (diffuse @ LUMINANCE) * SUN_COLOUR / (SUN_COLOUR @ LUMINANCE)
    dome += np.where(cosine[..., None] > np.cos(SUN_RADIUS), direct / disk.sum(), 0)
    ground = GROUND / np.pi * (diffuse + direct * SUN[1])
    return Sky(np.where(centre[..., 1:2] > 0, dome, ground))


def directions(rows):
    """The centres of the pixels of an image: (rows, 2 rows, 3)."""
    theta = np.pi * (np.arange(rows) + 0.5) / rows
    azimuth = np.pi * (np.arange(2 * rows) + 0.5) / rows
    theta, azimuth = np.meshgrid(theta, azimuth, indexing="ij")
    return np.stack([np.sin(theta) * np.cos(azimuth), np.cos(theta), np.sin(theta) * np.sin(azimuth)], axis=-1)


def preetham(toward, sun, turbidity):
    """The model of Preetham and others, of unit vectors (..., 3): linear sRGB (..., 3), kcd/m^2, not negative."""
    theta_s = np.arccos(sun[1])
    cosine = np.maximum(toward[..., 1], _LOWEST)
    gamma = np.arccos(np.clip(toward @ sun, -1, 1))
    chi = (4 / 9 - turbidity / 120) * (np.pi - 2 * theta_s)
    zenith = {"Y": (4.0453 * turbidity - 4.9710) * np.tan(chi) - 0.2155 * turbidity + 2.4192}
    zenith |= {name: turbidity ** np.arange(2, -1, -1) @ np.array(table) @ theta_s ** np.arange(3, -1, -1)
               for name, table in _ZENITH.items()}
    luminance, x, y = (zenith[name] * _perez(name, turbidity, cosine, gamma)
                       / _perez(name, turbidity, 1.0, theta_s) for name in ("Y", "x", "y"))
    xyz = np.stack([x / y * luminance, luminance, (1 - x - y) / y * luminance], axis=-1)
    return np.maximum(xyz @ _SRGB.T, 0)


def _perez(name, turbidity, cosine, gamma):
    """The distribution F(theta, gamma) of luminance Y or chromaticity x, y."""
    a, b, c, d, e = (slope * turbidity + offset for slope, offset in _PEREZ[name])
    return (1 + a * np.exp(b / cosine)) * (1 + c * np.exp(d * gamma) + e * np.cos(gamma) ** 2)


def _chances(radiance):
    """The share of each pixel in the whole by luminance and solid angle (rows, columns), and the latter (rows,)."""
    rows, columns = radiance.shape[:2]
    area = 2 * np.pi / columns * -np.diff(np.cos(np.pi * np.arange(rows + 1) / rows))
    weight = (radiance @ LUMINANCE) * area[:, None]
    return weight / weight.sum(), area


def _pixels(toward, rows):
    """The row and the column of the pixel that directions (n, 3) are in."""
    row = np.arccos(np.clip(toward[:, 1], -1, 1)) / np.pi * rows
    column = np.arctan2(toward[:, 2], toward[:, 0]) % (2 * np.pi) / np.pi * rows
    return np.minimum(row.astype(int), rows - 1), np.minimum(column.astype(int), 2 * rows - 1)


def _inverse(cumulative, u):
    """Where a rising sum passes u: the index of the step, and how far through it, 0 to 1."""
    index = np.minimum(np.searchsorted(cumulative, u, side="right"), len(cumulative) - 1)
    before = np.where(index > 0, cumulative[index - 1], 0)
    return index, np.clip((u - before) / np.maximum(cumulative[index] - before, 1e-300), 0, 1)

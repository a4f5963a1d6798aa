"""A sphere under a row of small lamps: a clear coat shows a line of dots, and beads where highlights fade between.

The lamps lie on an arc from behind the sphere on its left, over the viewer, to behind it on its right, so that the dots
lie on a diameter of the sphere: lamp k is mirrored where the angle of incidence is INCIDENCES[k]. With 5 degrees from
lamp to lamp, every second dot is between the incidences that instruments measure. Each lamp is a disk of half a degree,
far away, of the same power; the picture is the sum over the lamps of f cos theta_i.
"""

import numpy as np

from fitter.pictures import reflected, sphere

COUNT = 32
INCIDENCES = np.radians(5 * np.arange(COUNT) - 80)     # negative on the left
SIZE = 400                  # pixels
_RADIUS = np.radians(0.25)  # of a disk
_TILT = np.radians(12)      # of the row, so that it does not lie along the pixels
_NEAR = np.cos(np.radians(6))           # closer than this to its normal a half vector may be in a highlight
# a disk's centre and six points around it integrate polynomials of the fifth degree (R. Cools's "S2: 5-1")
_RING = np.sqrt(2 / 3)
_WEIGHTS = np.array([0.25, *[0.125] * 6])


def row_of_lamps(model, size=SIZE):
    """The radiance of a sphere under the lamps, each of irradiance 1.

    Returns
    -------
    (size, size, 3) float32
        The bottom row first; 0 outside.
    """
    normal, inside, _ = sphere(size)
    radiance = np.zeros((len(normal), 3))
    for incidence in INCIDENCES:
        points = disk(incidence)
        half = points[0] + (0, 0, 1)
        near = normal @ (half / np.linalg.norm(half)) > _NEAR
        radiance[~near] += reflected(model, normal[~near], points[0])
        for point, weight in zip(points, _WEIGHTS, strict=True):
            radiance[near] += weight * reflected(model, normal[near], point)
    picture = np.zeros((size, size, 3), dtype=np.float32)
    picture[inside] = radiance
    return picture


def disk(incidence):
    """Directions to the centre of a lamp, and to six points around it: (7, 3)."""
    angle = 2 * incidence                   # from the view
    side = np.array([np.cos(_TILT), np.sin(_TILT), 0])
    centre = np.sin(angle) * side + np.cos(angle) * np.array([0, 0, 1])
    across = np.cross(side, (0, 0, 1))
    along = np.cross(across, centre)
    turn = np.arange(6) * np.pi / 3
    ring = np.tan(_RING * _RADIUS) * (np.cos(turn)[:, None] * across + np.sin(turn)[:, None] * along)
    points = centre + np.concatenate([np.zeros((1, 3)), ring])
    return points / np.linalg.norm(points, axis=1, keepdims=True)

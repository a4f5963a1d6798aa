"""Spheres under lamps far away, in orthographic view from (0, 0, 1). A lamp is the direction to it, and its irradiance
over pi."""

import numpy as np

from fitter.imaging.pictures import draw_sphere, sphere, srgb

from .spheres import reflected_on

LAMPS = ((-0.5, 0.6, 0.62), 1.0), ((0.9, -0.1, 0.42), 0.25)


def reflected_by_lamps(fit, normals, lamps):
    """What a surface with normals (n, 3) reflects to the viewer, (n, 3); its tangents go around the vertical axis."""
    tangents = np.cross([0.0, 1.0, 0.0], normals)
    radiance = np.zeros((len(normals), 3))
    for direction, strength in lamps:
        radiance += np.pi * strength * reflected_on(fit, normals, tangents, direction / np.linalg.norm(direction))
    return radiance


def lamp_sphere(fit, size, lamps):
    """The picture of a sphere whose colours are in Rec.709: (size, size, 4) float32."""
    return draw_sphere(srgb(reflected_by_lamps(fit, sphere(size)[0], lamps)), size)
